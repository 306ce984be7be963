"""Calls of a run's recorders; an error names the recorder."""

from __future__ import annotations

from typing import Any

from amorsim.contracts import Recorder
from amorsim.core.error_text import RAISED, error_in_words, in_words
from amorsim.core.errors import AmorsimError, ComponentError

__all__ = ["ask", "fresh"]


def ask(recorder: Recorder, method: str, *given: Any) -> Any:
    """The result of a recorder's method.

    Raises
    ------
    ComponentError
        If it raises anything but an error of amorsim.
    """
    try:
        return getattr(recorder, method)(*given)
    except AmorsimError:
        raise
    except RAISED as error:
        raise ComponentError(
            f"recorder {type(recorder).__name__}: {method}() raised {error_in_words(error)}"
        ) from error


def fresh(recorder: Recorder) -> Recorder:
    """A recorder for one run; raises as `ask`, and if it is not a recorder."""
    found = ask(recorder, "fresh")
    if not isinstance(found, Recorder):
        raise ComponentError(f"recorder {type(recorder).__name__}: fresh() gave {in_words(found)}; expected a recorder")
    return found
