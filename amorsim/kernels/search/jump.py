"""Jump point search: shortest paths over eight neighbours that expand only cells where a path may turn.

After D. Harabor and A. Grastien, "Online graph pruning for pathfinding on grid maps", AAAI 2011, in the form that cuts
no corner: of equally short paths, the one whose diagonal steps come first is followed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.search.frontier import Search, take
from amorsim.kernels.search.octile import DIAGONAL, FOUND, GOING_ON, NONE_LEFT, reach

__all__ = ["expand_jumps"]


@part
def _is_turn(free: NDArray[np.uint8], cell: int, step: int, side: int) -> bool:
    """Whether a straight path may have to turn to this side: the cell there is free, and the one before is not."""
    return bool(free[cell + side] != 0 and free[cell + side - step] == 0)


@part
def _jump_straight(free: NDArray[np.uint8], goal: int, cell: int, step: int, side: int) -> int:
    """The first cell straight ahead that is the goal or where a path may have to turn; 0 if a wall comes first."""
    cell += step
    while free[cell]:
        if cell == goal or _is_turn(free, cell, step, side) or _is_turn(free, cell, step, -side):
            return cell
        cell += step
    return 0


@part
def _jump_diagonal(free: NDArray[np.uint8], width: int, goal: int, cell: int, across: int, up: int) -> int:
    """The first cell diagonally ahead that is the goal or from which a straight jump ends; 0 if a wall comes first."""
    while free[cell + across] and free[cell + up] and free[cell + across + up]:
        cell += across + up
        if (
            cell == goal
            or _jump_straight(free, goal, cell, across, width) != 0
            or _jump_straight(free, goal, cell, up, 1) != 0
        ):
            return cell
    return 0


@part
def _reach_straight(search: Search, width: int, goal: int, cell: int, step: int) -> None:
    """Reach the jump point straight ahead of a cell, if there is one; `step` is -1 or 1, or a line up or down."""
    side = width if abs(step) == 1 else 1
    other = _jump_straight(search.free, goal, cell, step, side)
    if other != 0:
        reach(search, width, goal, 1.0, cell, other, float(abs(other - cell) // abs(step)))


@part
def _reach_diagonal(search: Search, width: int, goal: int, cell: int, across: int, up: int) -> None:
    """Reach the jump point diagonally ahead of a cell, if there is one."""
    other = _jump_diagonal(search.free, width, goal, cell, across, up)
    if other != 0:
        reach(search, width, goal, 1.0, cell, other, DIAGONAL * (abs(other - cell) // abs(across + up)))


@kernel
def expand_jumps(search: Search, width: int, goal: int, most: int) -> int:
    """Expand jump points until the goal is one of them, none is left, or `most` are expanded; returns which."""
    for _ in range(most):
        if search.used[0] == 0:
            return NONE_LEFT
        cell = take(search)
        if cell == goal:
            return FOUND
        parent = search.parent[cell]
        rise, run = cell // width - parent // width, cell % width - parent % width
        up = width if rise > 0 else (-width if rise < 0 else 0)
        across = 1 if run > 0 else (-1 if run < 0 else 0)
        if up == 0 and across == 0:  # the start
            for step in (1, -1, width, -width):
                _reach_straight(search, width, goal, cell, step)
            for step in (width, -width):
                _reach_diagonal(search, width, goal, cell, 1, step)
                _reach_diagonal(search, width, goal, cell, -1, step)
        elif up != 0 and across != 0:
            _reach_straight(search, width, goal, cell, across)
            _reach_straight(search, width, goal, cell, up)
            _reach_diagonal(search, width, goal, cell, across, up)
        else:
            step = up + across
            side = width if up == 0 else 1
            _reach_straight(search, width, goal, cell, step)
            for turn in (side, -side):
                if _is_turn(search.free, cell, step, turn):
                    _reach_straight(search, width, goal, cell, turn)
                    if up == 0:
                        _reach_diagonal(search, width, goal, cell, step, turn)
                    else:
                        _reach_diagonal(search, width, goal, cell, turn, step)
    return GOING_ON if search.used[0] > 0 else NONE_LEFT
