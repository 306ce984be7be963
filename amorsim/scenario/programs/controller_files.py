"""Components in files of the user: ``"my_controller.py:Wander"``, a component, a plain class or a function."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import os
import sys
import traceback
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from amorsim.core.error_text import RAISED, error_in_words, in_words
from amorsim.core.errors import ControllerError, did_you_mean
from amorsim.core.files.reading import no_such_file, read_bytes, reason
from amorsim.core.unknown_names import no_such
from amorsim.core.user_code import go_back, present_folder
from amorsim.scenario.programs.local_imports import files_beside, make_importable

__all__ = [
    "FORMS",
    "Form",
    "check_arguments",
    "is_controller_file",
    "load_controller",
    "load_program",
    "no_such_name",
    "not_a_component",
    "read_program",
    "reference_of_class",
    "reference_to",
    "split_reference",
    "tables_of_programs",
]

_MODULE = "amorsim_controller_"  # begins the names of the modules that files are loaded as


class Form(NamedTuple):
    """How code of a kind may be written without a component's class: its arguments besides its options."""

    function: tuple[str, ...]
    """The arguments of a function before its options; empty if no function will do."""
    made_with: tuple[str, ...] = ()
    """Further keyword arguments with which each object of a class is made."""


FORMS = {
    "controller": Form(("readings", "estimate", "clock")),
    "motion": Form(("obstacle",)),
    "estimator": Form((), ("start",)),
    "planner": None,
    "recorder": None,
    "metric": None,
}
"""The kinds of component that a file may have; None where only a component will do."""


def is_controller_file(use: str) -> bool:
    """Whether a component's name is that of a file, not of a registered component."""
    return ".py:" in use or use.endswith(".py")


def tables_of_programs(value: Any) -> Iterator[dict[str, Any]]:
    """The tables within a table, however deep, that name a component in a file under ``use``."""
    if isinstance(value, dict):
        if is_controller_file(str(value.get("use", ""))):
            yield value
        value = list(value.values())
    for item in value if isinstance(value, list) else ():
        yield from tables_of_programs(item)


def split_reference(use: str, folder: Path) -> tuple[Path, str]:
    """File and name in ``"file.py:name"``; a relative file is in `folder`."""
    file, colon, name = use.rpartition(":")
    if not colon or not file.endswith(".py"):
        raise ControllerError(f"expected 'FILE.py:NAME', the name of a function or class in the file, got {use!r}")
    if not name.isidentifier():
        raise ControllerError(f"expected the name of a function or class after the colon, got {name!r}")
    return Path(os.path.abspath(folder / file)), name  # noqa: PTH100 - a link keeps the name that it was given


def reference_of_class(cls: type) -> str:
    """``"FILE.py:NAME"`` of a component's class, if a file can name it; else empty.

    It stands at the top of a file that does not belong to a package; a script is not one, for it would run again.
    """
    return "" if "." in cls.__module__ or cls.__module__ == "__main__" else reference_to(cls)


def reference_to(thing: Any) -> str:
    """``"FILE.py:NAME"`` of a function or class at the top of a Python file; empty for any other."""
    module = sys.modules.get(getattr(thing, "__module__", None) or "")
    name = getattr(thing, "__qualname__", "")
    file = getattr(module, "__file__", None) or ""
    if module is None or not file.endswith(".py") or vars(module).get(name) is not thing:
        return ""
    return f"{Path(file).absolute()}:{name}"


def load_controller(path: Path, name: str, options: Mapping[str, Any], kind: str = "controller") -> Any:
    """The function or plain class called `name` in a Python file, which must take `options` as keyword arguments.

    Raises
    ------
    ControllerError
        As `load_program` does, or if it does not take the options.
    """
    found = load_program(path, name)
    try:
        signature = inspect.signature(found)
    except (TypeError, ValueError):  # written in C: nothing to check against
        return found
    check_arguments(path, name, signature, inspect.isclass(found), options, kind)
    return found


def load_program(path: Path, name: str) -> Any:
    """The function or class called `name` in a Python file.

    The file is run as a module of its own; one with the same content is run once in a process. It may import
    what lies next to it.

    Raises
    ------
    ControllerError
        If the file is not there, is not Python, raises when it is run, or has no such function or class; the line is
        named where there is one.
    """
    module = _load_module(path)
    found = vars(module).get(name)
    if found is None:
        raise no_such_name(path, name, [key for key, value in vars(module).items() if callable(value)])
    if not callable(found):
        raise ControllerError(f"{name!r} in {path} is neither a function nor a class, but {in_words(found)}")
    return found


def no_such_name(path: Path, name: str, there: Iterable[str]) -> ControllerError:
    """The error for a file without a function or class of a name; it lists the others."""
    own = [key for key in there if not key.startswith("_")]
    return ControllerError(f"{path}: {no_such('definition', name, own)}")


def read_program(path: Path) -> bytes:
    """The content of a Python file; raises `ControllerError`."""
    try:
        return read_bytes(path)
    except (OSError, ValueError) as error:
        is_missing = isinstance(error, FileNotFoundError)
        problem = no_such_file(path) if is_missing else f"cannot be read: {reason(error)}"
        raise ControllerError(f"{path}: {problem}") from error


def _load_module(path: Path) -> ModuleType:
    data = read_program(path)
    beside = files_beside(path, data)
    parts = [data, *(part for name, file in beside.items() for part in (name.encode(), file.read_bytes()))]
    digest = hashlib.blake2b(b"\0".join([str(path).encode(), *parts]), digest_size=8).hexdigest()
    # Named after its content: an edited file is another module; pickled objects of the old one stay whole.
    module_name = f"{_MODULE}{digest}"
    if module_name in sys.modules:
        return sys.modules[module_name]
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None:
        raise ControllerError(f"{path}: Python knows no way to load this file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    here = present_folder()
    try:
        # Compiled here: a loader would leave a cache next to the user's file, and may trust a stale one.
        make_importable(beside)
        exec(compile(data, str(path), "exec", dont_inherit=True), vars(module))
    except RAISED as error:
        del sys.modules[module_name]
        raise ControllerError(f"{path}{_line(error, path)}: {_text(error)}") from error
    finally:
        go_back(here, str(path))
    return module


def _line(error: BaseException, path: Path) -> str:
    if isinstance(error, SyntaxError):
        return f", line {error.lineno}" if error.lineno else ""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    return f", line {lines[-1]}" if lines else ""


def _text(error: BaseException) -> str:
    return f"{type(error).__name__}: {error.msg}" if isinstance(error, SyntaxError) else error_in_words(error)


def not_a_component(path: Path, name: str, kind: str) -> ControllerError:
    """The error for code that is not a component, of a kind that must be one."""
    return ControllerError(
        f"{path}: {name}: expected a subclass of am.{kind.capitalize()}, a {kind} in a file has no simpler form"
    )


def check_arguments(
    path: Path, name: str, signature: inspect.Signature, is_class: bool, options: Mapping[str, Any], kind: str
) -> None:
    """Raise `ControllerError` unless a function or a plain class of this signature takes the options."""
    form = FORMS[kind]
    if form is None:
        raise not_a_component(path, name, kind)
    if not is_class and not form.function:
        raise ControllerError(f"{path}: {name}: expected a class, as an {kind} remembers; got a function")
    # A class is made with keyword arguments alone, a function called with the options after its arguments.
    leading = () if is_class else (None,) * len(form.function)
    own = dict.fromkeys(form.made_with) if is_class else {}
    try:
        signature.bind(*leading, **own, **options)
    except TypeError as error:
        known = [parameter.name for parameter in list(signature.parameters.values())[len(leading) :]]
        unknown = [option for option in options if option not in known]
        hint = did_you_mean(unknown[0], known) if unknown else ""
        of_class = dict.fromkeys([*form.made_with, *known])
        call = f"{name}({', '.join(form.function)}, **options)" if leading else f"{name}({', '.join(of_class)})"
        raise ControllerError(f"{path}: {name}{signature} cannot be called as {call}: {error}.{hint}") from error
