"""What a thread's stack shows: whether kernels are being compiled, and which robot's controller runs."""

from __future__ import annotations

import traceback
from pathlib import Path
from types import FrameType

import numba

__all__ = ["is_compiling", "robot_of"]

_COMPILER = Path(numba.__file__).parent


def is_compiling(stack: traceback.StackSummary, *, reading_counts: bool = True) -> bool:
    """Whether a stack is in the compiler of kernels; reading one from its cache counts or not."""
    files = (Path(frame.filename) for frame in stack)
    return any(
        file.is_relative_to(_COMPILER) and (reading_counts or file.stem.startswith("compiler")) for file in files
    )


def robot_of(frame: FrameType | None) -> str:
    """The robot whose controller runs in a stack, if `UserController` is in it."""
    from amorsim.controllers.user import UserController

    while frame is not None:
        if frame.f_code is UserController.ask_robots.__code__:
            row, names = frame.f_locals.get("row"), frame.f_locals["robot"].names
            return str(names[row]) if names and row is not None else ""
        frame = frame.f_back
    return ""
