"""Compile ahead, in several processes, what nearly every run asks for: the list of it, and how they share it.

This shortens the wait after installing. A run asks for kernels one after the other, and a caller for its callees; two
processes that follow it wait for each other half of the time. The list (`ahead.jsonl`, written by
``tools/list_kernels.py`` from a run of the demo) has a line for each function and the types of its arguments, in the
alphabet's order, so that changes of kernels that know nothing of each other merge. Callees are taken before callers
and, where the order is free, that first after which the most is to be done. Each process takes the first function that
nobody has taken and whose callees are there.
A list that has grown old costs time and nothing else: what it lacks is compiled when it is asked for.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
from numba.core import types as numba_types
from numba.core.registry import CPUDispatcher, cpu_target

from amorsim.kernels.beside import begin
from amorsim.kernels.cache import no_garbage_collected, take_turns
from amorsim.kernels.claims import PAUSE
from amorsim.kernels.folder import cache_folder, is_cold, mark_warm

__all__ = [
    "LIST",
    "Task",
    "begin_ahead",
    "compile_ahead",
    "compile_at_first",
    "compile_together",
    "describe",
    "in_order",
    "read_list",
    "type_of",
]

LIST = Path(__file__).with_name("ahead.jsonl")
types: Any = numba_types  # its names are made when it is imported, so that type checkers know none of them
_SCALARS = ("boolean", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float32", "float64")


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
    """

    module: str
    name: str
    is_part: bool
    signature: tuple[Any, ...]

    def dispatcher(self) -> Any:
        """What compiles it; raises `AttributeError` or `ImportError` where there is none of that name."""
        found = getattr(importlib.import_module(self.module), self.name)
        return found._part if self.is_part else found


def describe(type_: Any, tuples: dict[str, list[Any]] | None = None) -> Any:
    """A type of an argument, for JSON; raises `ValueError` for one that the list cannot hold.

    What a named tuple holds is left to `tuples`, by the tuple's name, if that is given and has nothing else there.
    """
    if isinstance(type_, types.Array) and type_.aligned:
        return ["array" if type_.mutable else "constant", describe(type_.dtype), type_.ndim, type_.layout]
    if isinstance(type_, types.BaseNamedTuple):
        name = f"{type_.instance_class.__module__}:{type_.instance_class.__qualname__}"
        members = [describe(each, tuples) for each in type_]
        is_left = tuples is not None and tuples.setdefault(name, members) == members
        return ["named", name] if is_left else ["named", name, members]
    if isinstance(type_, types.BaseTuple):
        return ["tuple", [describe(each, tuples) for each in type_]]
    for name in _SCALARS:
        if type_ == getattr(types, name):
            return name
    raise ValueError(f"no name for the type {type_}")


def type_of(described: Any, tuples: Mapping[str, list[Any]]) -> Any:
    """The type that `describe` described."""
    if isinstance(described, str):
        return getattr(types, described)
    kind, *rest = described
    if kind in ("array", "constant"):
        dtype, ndim, layout = rest
        return types.Array(type_of(dtype, tuples), ndim, layout, readonly=kind == "constant")
    if kind == "tuple":
        return types.BaseTuple.from_types([type_of(each, tuples) for each in rest[0]])
    module, name = rest[0].split(":")
    members = rest[1] if len(rest) > 1 else tuples[rest[0]]
    cls = getattr(importlib.import_module(module), name)
    return types.BaseTuple.from_types([type_of(each, tuples) for each in members], cls)


def read_list(path: Path = LIST) -> list[Task]:
    """The tasks of the list, in its order."""
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    tuples = {row[1]: row[2] for row in rows if row[0] == "tuple"}
    tasks = []
    for row in rows:
        if row[0] != "tuple":
            module, name, way, *described = row
            with contextlib.suppress(AttributeError, ImportError):  # a named tuple that is no more
                tasks.append(Task(module, name, way == "part", tuple(type_of(each, tuples) for each in described)))
    return tasks


def in_order(tasks: Iterable[Task]) -> list[tuple[Task, Any, list[int]]]:
    """The tasks that there are functions for, callees first: each with what compiles it and its callees' places here.

    How long compiling takes is guessed from the byte code, for seconds in the list would differ at each writing: what
    is to be done after a function, from its beginning to the end of the last that needs it, goes by that. Of 22 kernels
    that Python calls and 139 parts the guesses and what was measured correlate by 0.98 and 0.81.
    """
    todo: list[tuple[Task, Any]] = []
    for task in tasks:
        with contextlib.suppress(AttributeError, ImportError):  # a function of that name is no more
            todo.append((task, task.dispatcher()))
    parts: dict[Any, list[int]] = {}
    for number, (task, maker) in enumerate(todo):
        if task.is_part:
            parts.setdefault(maker.py_func, []).append(number)
    callees = [[n for f in _called_by(maker.py_func) for n in parts.get(f, ())] for _, maker in todo]
    callers: list[list[int]] = [[] for _ in todo]
    for number, each in enumerate(callees):
        for callee in each:
            callers[callee].append(number)
    ranks: dict[int, int] = {}

    def rank(number: int) -> int:
        if number not in ranks:
            own = 100 + size(number)
            if not todo[number][0].is_part:  # all that it calls is optimised with it
                own = 1000 + sum(size(each) for each in reached(number)) // 2
            ranks[number] = own + max((rank(caller) for caller in callers[number]), default=0)
        return ranks[number]

    def size(number: int) -> int:
        return len(todo[number][1].py_func.__code__.co_code)

    def reached(number: int) -> set[int]:
        return {number}.union(*(reached(callee) for callee in callees[number]))

    order = sorted(range(len(todo)), key=lambda number: (-rank(number), number))
    places = {number: place for place, number in enumerate(order)}
    return [(*todo[number], sorted(places[callee] for callee in callees[number])) for number in order]


def _called_by(function: Any) -> list[Any]:
    """The functions, by their names in the byte code, that it calls and that are compiled as it is."""
    found = (function.__globals__.get(name) for name in dict.fromkeys(function.__code__.co_names))
    return [one.py_func for one in found if isinstance(one, CPUDispatcher) and one.py_func is not function]


def begin_ahead() -> None:
    """Have it begun in a process beside this one, if no process has done so yet; nobody waits for it here."""
    if begin():
        take_turns()


def compile_at_first() -> None:
    """Compile what is listed, if no process has done so yet."""
    if is_cold():
        compile_together()


def compile_together() -> None:
    """Compile what is listed, in this process and the one beside it, and leave word that it is."""
    begin()
    take_turns()
    compile_ahead()
    mark_warm()


def compile_ahead(tasks: Sequence[Task] | None = None) -> None:
    """Compile those of the tasks (without: of the list) that neither the cache holds nor another process compiles.

    It returns when all of them are in the cache, or where there is no cache at once.
    """
    if cache_folder() is None:
        return
    with no_garbage_collected():
        # Which takes a while, and would be done holding the claim on the first function.
        cpu_target.typing_context.refresh()
        cpu_target.target_context.refresh()
        _share(dict(enumerate(in_order(read_list() if tasks is None else tasks))))
        gc.freeze()  # or all that was made would be looked through now, for half a second


def _share(todo: dict[int, tuple[Task, Any, list[int]]]) -> None:
    taken: set[int] = set()
    while todo:
        for number in [number for number in taken if todo[number][1]._cache.holds(todo[number][0].signature)]:
            taken.remove(number)
            del todo[number]
        number = _next(todo, taken)
        if number >= 0:
            task, maker, _ = todo.pop(number)
            try:
                maker.compile(task.signature)
            except Exception:  # it takes other arguments now, and numba says so in several ways
                maker._cache.let_go(task.signature)
        elif taken:
            time.sleep(PAUSE)
            taken = {number for number in taken if todo[number][1]._cache.is_taken(todo[number][0].signature)}


def _next(todo: dict[int, tuple[Task, Any, list[int]]], taken: set[int]) -> int:
    """The first task that nobody has taken, of those whose callees are there; or -1. Those that are done go."""
    for number, (task, maker, callees) in list(todo.items()):
        if number in taken or any(callee in todo for callee in callees):
            continue
        cache = maker._cache
        if cache.holds(task.signature):
            del todo[number]
        elif cache.is_taken(task.signature):
            taken.add(number)
        else:
            return number
    return -1
