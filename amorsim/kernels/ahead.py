"""Compile ahead, in two processes, what nearly every run asks for: the list of it, and how they share it.

On a machine of two cores this shortens the wait after installing. A run asks for kernels one after the other, and a
caller for its callees; two processes that follow it wait for each other half of the time. The list (`ahead.json`,
written by ``tools/list_kernels.py`` from a run of the demo) has callees before callers and, where the order is free,
that first after which the most is to be done. Each process takes from it the first function that nobody has taken and
whose callees are there.
A list that has grown old costs time and nothing else: what it lacks is compiled when it is asked for.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
from numba.core import types as numba_types

from amorsim.kernels.cache import cache_folder, take_turns
from amorsim.kernels.claims import PAUSE

__all__ = ["LIST", "Task", "compile_ahead", "compile_together", "deadline", "describe", "main", "read_list"]

LIST = Path(__file__).with_name("ahead.json")
types: Any = numba_types  # its names are made when it is imported, so that type checkers know none of them
_SCALARS = ("boolean", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float32", "float64")
_LONGEST = 120.0  # [s]
_beside: list[subprocess.Popen[bytes]] = []


@attrs.frozen
class Task:
    """A function to compile.

    Attributes
    ----------
    module, name
        Where it is.
    is_part
        Whether it is compiled for kernels that call it, or for Python.
    signature
        The types of its arguments.
    callees
        The tasks that come before it, by their places in the list.
    """

    module: str
    name: str
    is_part: bool
    signature: tuple[Any, ...]
    callees: tuple[int, ...] = ()

    def dispatcher(self) -> Any:
        """What compiles it; raises `AttributeError` or `ImportError` where there is none of that name."""
        found = getattr(importlib.import_module(self.module), self.name)
        return found._part if self.is_part else found


def describe(type_: Any) -> Any:
    """A type of an argument, for JSON; raises `ValueError` for one that the list cannot hold."""
    if isinstance(type_, types.Array) and type_.aligned:
        return ["array" if type_.mutable else "constant", describe(type_.dtype), type_.ndim, type_.layout]
    if isinstance(type_, types.BaseNamedTuple):
        cls = type_.instance_class
        return ["named", f"{cls.__module__}:{cls.__qualname__}", [describe(each) for each in type_]]
    if isinstance(type_, types.BaseTuple):
        return ["tuple", [describe(each) for each in type_]]
    for name in _SCALARS:
        if type_ == getattr(types, name):
            return name
    raise ValueError(f"no name for the type {type_}")


def _type_of(described: Any) -> Any:
    """The type that `describe` described."""
    if isinstance(described, str):
        return getattr(types, described)
    kind, *rest = described
    if kind in ("array", "constant"):
        dtype, ndim, layout = rest
        return types.Array(_type_of(dtype), ndim, layout, readonly=kind == "constant")
    if kind == "tuple":
        return types.BaseTuple.from_types([_type_of(each) for each in rest[0]])
    place, members = rest
    module, name = place.split(":")
    cls = getattr(importlib.import_module(module), name)
    return types.BaseTuple.from_types([_type_of(each) for each in members], cls)


def read_list(path: Path = LIST) -> list[Task]:
    """The tasks of the list, in its order."""
    rows = json.loads(path.read_text(encoding="utf-8"))
    return [
        Task(
            module=row["module"],
            name=row["name"],
            is_part=row["part"],
            signature=tuple(_type_of(each) for each in row["types"]),
            callees=tuple(row["callees"]),
        )
        for row in rows
    ]


def compile_together() -> None:
    """Compile what is listed, in this process and another one that is started for it."""
    if (os.cpu_count() or 1) > 1:
        with contextlib.suppress(OSError):  # it only saves time
            # Held, for nobody waits for it, and one that is let go while it runs is warned about.
            _beside.append(
                subprocess.Popen(
                    [sys.executable, "-c", f"from {__name__} import main; main()"],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                )
            )
    take_turns()
    compile_ahead()


def main() -> None:
    """Compile what is listed, with whoever started this process."""
    last = deadline()
    take_turns()
    compile_ahead()
    last.cancel()


def deadline() -> threading.Timer:
    """Let this process end by itself after a while, for nobody waits for it; until it is cancelled."""
    last = threading.Timer(_LONGEST, os._exit, (1,))
    last.daemon = True
    last.start()
    return last


def compile_ahead(tasks: Sequence[Task] | None = None) -> None:
    """Compile those of the tasks (without: of the list) that neither the cache holds nor another process compiles.

    It returns when all of them are in the cache, or where there is no cache at once.
    """
    if cache_folder() is None:
        return
    todo: dict[int, Task] = {}
    makers: dict[int, Any] = {}
    for number, task in enumerate(read_list() if tasks is None else tasks):
        with contextlib.suppress(AttributeError, ImportError):  # a function of that name is no more
            makers[number] = task.dispatcher()
            todo[number] = task
    taken: set[int] = set()
    while todo:
        for number in [number for number in taken if makers[number]._cache.holds(todo[number].signature)]:
            taken.remove(number)
            del todo[number]
        number = _next(todo, makers, taken)
        if number >= 0:
            signature = todo.pop(number).signature
            try:
                makers[number].compile(signature)
            except Exception:  # it takes other arguments now, and numba says so in several ways
                makers[number]._cache.let_go(signature)
        elif taken:
            time.sleep(PAUSE)
            taken = {number for number in taken if makers[number]._cache.is_taken(todo[number].signature)}


def _next(todo: dict[int, Task], makers: dict[int, Any], taken: set[int]) -> int:
    """The first task that nobody has taken, of those whose callees are there; or -1. Those that are done go."""
    for number, task in list(todo.items()):
        if number in taken or any(callee in todo for callee in task.callees):
            continue
        cache = makers[number]._cache
        if cache.holds(task.signature):
            del todo[number]
        elif cache.is_taken(task.signature):
            taken.add(number)
        else:
            return number
    return -1
