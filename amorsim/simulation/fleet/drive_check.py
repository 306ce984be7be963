"""Checks of what a drive returns for joints at rest, before a group steps; later it is taken as it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from amorsim.contracts import Drive
from amorsim.core.error_text import RAISED
from amorsim.core.rows import take
from amorsim.simulation.error_context import ErrorContext, array_problem

__all__ = ["check_drive"]

_MOST = 2  # rows that are asked: as many as show an answer that is for one robot alone


def check_drive(drive: Drive, rows: int, whose: ErrorContext) -> None:
    """Raise a `ComponentError` if a drive of `rows` robots answers with other than numbers of the contract's shapes.

    A method that raises is passed over here: its error is reported when it is called, if it ever is.
    """
    count = min(rows, _MOST)
    some: Any = take(drive, np.arange(count))
    rest = np.zeros((count, len(drive.joints)))
    rolling = sum(joint.rolls for joint in drive.joints)
    one = np.ones((count, 1))
    asked: dict[str, tuple[Callable[[], Any], int]] = {
        "twist()": (lambda: some.twist(rest, rest), 3),
        "displacement()": (lambda: some.displacement(rest, rest, one), 3),
        "travel()": (lambda: some.travel(rest, rest), 2),
        "command_for()": (lambda: some.command_for(np.zeros((count, 3)), rest), len(drive.channels)),
    }
    if rolling:  # else it need not know how many rows it is
        asked["rolling_radius()"] = (lambda: some.rolling_radius(), rolling)
    for method, (ask, width) in asked.items():
        try:
            found = ask()
        except RAISED:
            continue
        if not isinstance(found, np.ndarray) or found.shape != (count, width):
            problem = array_problem(found, "numbers", (count, width), method)
            raise whose.wrong("drive", drive, problem)
