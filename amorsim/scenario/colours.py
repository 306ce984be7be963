"""The colours of robots: of several each has its own, the same in the window, in pictures and in plots."""

from __future__ import annotations

from collections.abc import Sequence

from amorsim.scenario.spec import Robot

__all__ = ["robot_colours"]

# None of them is near the green, orange and blue of what is true, measured and estimated, nor the red of collisions.
_COLOURS = ("#8e5bc4", "#e0b400", "#1fb5c9", "#d6559e", "#8a6a3c", "#94bf2e", "#5a6b8c", "#f0a58c")


def robot_colours(robots: Sequence[Robot]) -> dict[str, str | None]:
    """Each robot's colour by name: its own, or else the next of a series where there are several; None for one."""
    turns = iter(_COLOURS[i % len(_COLOURS)] for i in range(len(robots)))
    several = len(robots) > 1
    return {robot.name: robot.colour or (next(turns) if several else None) for robot in robots}
