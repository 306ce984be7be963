"""The rolling joints on which an element of a drive's `ground` acts."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context
from amorsim.core.errors import ComponentError, did_you_mean

__all__ = ["chosen"]


def chosen(element: str, joint: str, context: Context) -> Array:
    """1 for each rolling joint `(N, r)` named `joint`, 0 for others; an empty name means all.

    Raises
    ------
    ComponentError
        If no rolling joint has that name.
    """
    found = np.ones((context.rows, context.size))
    if joint:
        rolling = [other.name for other in context.robot.drive.joints if other.rolls]
        if joint not in rolling:
            raise ComponentError(
                f"{element}: joint: expected one of {', '.join(rolling)} or nothing, got {joint!r}."
                f"{did_you_mean(joint, rolling)}"
            )
        found[:] = [float(name == joint) for name in rolling]
    return found
