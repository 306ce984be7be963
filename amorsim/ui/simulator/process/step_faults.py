"""Faults of a step."""

from __future__ import annotations

import attrs

from amorsim.core.error_text import error_in_words, explain
from amorsim.core.errors import AmorsimError, ControllerError

__all__ = ["Fault", "fault_of"]


@attrs.frozen(kw_only=True)
class Fault:
    """A fault in a step: whose controller caused it, if one did, and the lines that led to it."""

    robots: tuple[str, ...]
    text: str
    stack: str


def fault_of(error: BaseException) -> Fault:
    """The fault that an error in a step is."""
    robot = error.robot if isinstance(error, ControllerError) else ""
    text = str(error) if isinstance(error, AmorsimError) else error_in_words(error)
    return Fault(robots=(robot,) if robot else (), text=text, stack=explain(error))
