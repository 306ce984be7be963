"""Errors as users see them: the message, and the lines of their own code that led to it."""

from __future__ import annotations

import sysconfig
import traceback
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError

__all__ = ["RAISED", "error_in_words", "explain", "in_words", "users_lines"]

_OURS = Path(__file__).resolve().parents[1]
_PYTHONS = Path(sysconfig.get_path("stdlib"))
_INSTALLED = "site-packages"
# That amorsim calls.
_LIBRARIES = ("distributed", "joblib", "llvmlite", "matplotlib", "numba", "numpy", "PIL", "pyarrow", "scipy", "shapely")
_COMPILED = (".pyx", ".pxi")  # sources of compiled libraries
_LONGEST = 200  # characters of a value

RAISED = (Exception, SystemExit)
"""The exceptions caught from a user's code; Ctrl-C is not one."""


def explain(error: BaseException) -> str:
    """The error's message, with notes, and with the lines of a user's controller or plugin that raised it."""
    is_ours = isinstance(error, AmorsimError)
    cause = error.__cause__ if is_ours else error
    lines = [str(error) if is_ours else error_in_words(error)]
    if isinstance(cause, SyntaxError):
        lines += [part.rstrip("\n") for part in traceback.format_exception_only(cause)]
    elif cause is not None:
        lines += users_lines(traceback.extract_tb(cause.__traceback__))
    return "\n".join([*lines, *getattr(error, "__notes__", ())])


def error_in_words(error: BaseException) -> str:
    """The error's class and text, even if making its text fails."""
    name = type(error).__name__
    try:
        return f"{name}: {error}"
    except RAISED as second:
        return f"{name} (its text cannot be shown: {type(second).__name__})"


def in_words(value: Any) -> str:
    """A value for messages: shortened to a readable length, even if its `repr` fails."""
    try:
        text = repr(value)
    except RAISED as error:
        return f"a {type(value).__name__} (which cannot be shown: {type(error).__name__})"
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def users_lines(stack: traceback.StackSummary) -> list[str]:
    """The user's own lines of a stack as text, outermost first; empty if there are none."""
    users = [i for i, frame in enumerate(stack) if _is_users(frame.filename)]
    # Calls from amorsim to a library are not the user's; calls from their code are.
    first = next((i for i in users if not _is_librarys(stack[i].filename)), None)
    if first is None:
        return []
    # Frames before are amorsim's, frames after are Python's.
    return [part.rstrip("\n") for part in traceback.format_list(stack[first : users[-1] + 1])]


def _is_users(file: str) -> bool:
    if file.startswith("<"):  # of the interpreter's own
        return False
    path = Path(file)
    if path.suffix in _COMPILED:
        return False
    is_installed = _INSTALLED in path.parts
    return not path.is_relative_to(_OURS) and (is_installed or not path.is_relative_to(_PYTHONS))


def _is_librarys(file: str) -> bool:
    parts = Path(file).parts
    return _INSTALLED in parts and parts[parts.index(_INSTALLED) + 1] in _LIBRARIES
