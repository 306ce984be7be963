"""What a robot saw around itself lately: a window of cells that moves with it, in the world of its estimate.

Cell (column, row) of the world is at ``[row mod S, column mod S]`` of the window's S x S cells, so that nothing is
copied as the window moves.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.avoidance.arcs import Box, distance_to_box, free_time, keep_room
from amorsim.kernels.avoidance.dynamic_window import braking_time, field_of_view, is_in_view, moved_on, slowed
from amorsim.kernels.avoidance.guide import find_leg
from amorsim.kernels.behaviours.free_space import Sight, see_points
from amorsim.kernels.compile import kernel, part

__all__ = ["Window", "guard", "look_along", "remember"]

Column = Any

_NEVER = -1e30  # [s]
_PARTS = 256  # of a cell's side


class Window(NamedTuple):
    """The windows of N robots."""

    seen: npt.NDArray[np.float32]
    """(N, S, S) [s] when something was last seen in each cell."""
    corner: Ints
    """(N, 2) column and row of the lowest cell of each window."""
    side: float
    """Of a cell [m]."""
    place: npt.NDArray[np.int8]
    """(N, S, S, 2) where in each cell it was seen, x and y, in parts of 1/256 of its side from the middle."""


@part
def _move(seen: npt.NDArray[np.float32], corner: Ints, col: int, row: int) -> None:
    """Move a window, and clear the cells that come in."""
    size = seen.shape[0]
    if abs(col - corner[0]) >= size or abs(row - corner[1]) >= size:
        seen[:, :] = _NEVER
    else:
        for c in range(min(col, corner[0]), max(col, corner[0])):
            seen[:, c % size] = _NEVER
        for r in range(min(row, corner[1]), max(row, corner[1])):
            seen[r % size, :] = _NEVER
    corner[0] = col
    corner[1] = row


@kernel
def remember(sight: Sight, pose: Array, time: Array, fresh: Ints, window: Window, first: int, end: int) -> None:
    """Note the cells in which robots at `pose` (N, 3) see something, at `time` (N, 1), where `fresh` (N,) is not 0."""
    points = np.empty((3, sight.ranges.shape[1] * sight.samples))
    size = window.seen.shape[1]
    for i in range(first, end):
        col = math.floor(pose[i, 0] / window.side) - size // 2
        row = math.floor(pose[i, 1] / window.side) - size // 2
        _move(window.seen[i], window.corner[i], col, row)
        if fresh[i] == 0:
            continue
        see_points(sight.ranges[i], sight.beams[i], sight.half_angle[i, 0], points)
        c = math.cos(pose[i, 2])
        s = math.sin(pose[i, 2])
        now = np.float32(time[i, 0])
        for n in range(points.shape[1]):
            px = points[0, n]
            py = points[1, n]
            if not (abs(px) < math.inf and abs(py) < math.inf):
                continue
            x = (pose[i, 0] + c * px - s * py) / window.side
            y = (pose[i, 1] + s * px + c * py) / window.side
            across, up = math.floor(x), math.floor(y)
            if 0 <= across - col < size and 0 <= up - row < size:
                window.seen[i, up % size, across % size] = now
                place = window.place[i, up % size, across % size]
                place[0] = min(math.floor((x - across) * _PARTS), _PARTS - 1) - _PARTS // 2
                place[1] = min(math.floor((y - up) * _PARTS), _PARTS - 1) - _PARTS // 2


@part
def _is_near(
    seen: npt.NDArray[np.float32], corner: Ints, side: float, x: float, y: float, room: float, since: float
) -> bool:
    """Whether something was seen since a time within `room` [m] of a place."""
    size = seen.shape[0]
    col0 = max(math.floor((x - room) / side), corner[0])
    col1 = min(math.floor((x + room) / side), corner[0] + size - 1)
    row0 = max(math.floor((y - room) / side), corner[1])
    row1 = min(math.floor((y + room) / side), corner[1] + size - 1)
    for row in range(row0, row1 + 1):
        for col in range(col0, col1 + 1):
            if seen[row % size, col % size] >= since:
                dx = (col + 0.5) * side - x
                dy = (row + 0.5) * side - y
                if dx * dx + dy * dy < room * room:
                    return True
    return False


@kernel
def look_along(
    pose: Array,
    path: Array,
    along: Array,
    count: Ints,
    leg: Ints,
    window: Window,
    since: Array,
    room: Array,
    far: Column,
    out: Array,
) -> None:
    """How far along its path each robot is, how much is left, and where it first leads past something: (N, 3) [m].

    That is the way from the robot to the first place nearer than `room` (N, 1) to something seen since `since` (N, 1),
    inf if there is none within `far` (N, 1).
    """
    for i in range(pose.shape[0]):
        found, here = find_leg(path[i], along[i], count[i], leg[i], 3.0, pose[i, 0], pose[i, 1])
        out[i, 0] = here
        out[i, 1] = along[i, count[i] - 1] - here
        out[i, 2] = math.inf
        step = window.side
        j = found
        s = here
        while s <= here + far[i, 0] and j < count[i] - 1:
            while j < count[i] - 1 and along[i, j + 1] < s:
                j += 1
            if j >= count[i] - 1:
                break
            length = along[i, j + 1] - along[i, j]
            t = (s - along[i, j]) / length if length > 0.0 else 0.0
            x = path[i, j, 0] + t * (path[i, j + 1, 0] - path[i, j, 0])
            y = path[i, j, 1] + t * (path[i, j + 1, 1] - path[i, j, 1])
            if _is_near(window.seen[i], window.corner[i], window.side, x, y, room[i, 0], since[i, 0]):
                out[i, 2] = s - here
                break
            s += step


@kernel
def guard(
    sight: Sight,
    age: Array,
    pose: Array,
    box: Box,
    margin: Array,
    limits: Array,
    window: Window,
    since: Array,
    wanted: Array,
    active: Bools,
    dt: float,
    moving: Array,
    out: Array,
) -> None:
    """Twists as `wanted` (N, 2), v and w, where the robots can brake from them; else they brake. Into `out` (N, 3).

    What is seen counts, and what was seen before and is out of sight now. In sight, the present reading is nearer to
    the truth than memory, which drifts with the estimate. Where the robot itself stands, memory is wrong. Rows that
    are not `active` (N, 1) are left as they are.
    """
    size = window.seen.shape[1]
    seen_now = np.empty((3, sight.ranges.shape[1] * sight.samples))
    points = np.empty((3, seen_now.shape[1] + 4096))
    kept = np.empty((3, points.shape[1]))
    for i in range(pose.shape[0]):
        if not active[i, 0]:
            continue
        v0 = moving[i, 0]
        w0 = moving[i, 1]
        see_points(sight.ranges[i], sight.beams[i], sight.half_angle[i, 0], seen_now)
        moved_on(seen_now, v0, w0, age[i, 0])
        count = seen_now.shape[1]
        points[0, :count] = seen_now[0]
        points[1, :count] = seen_now[1]
        c = math.cos(pose[i, 2])
        s = math.sin(pose[i, 2])
        col0 = math.floor((pose[i, 0] - 1.0) / window.side)
        row0 = math.floor((pose[i, 1] - 1.0) / window.side)
        cells = int(2.0 / window.side) + 1
        low, high = field_of_view(sight.beams[i])
        sees_all = sight.samples == 1  # between its values; a ring of cones has gaps
        for row in range(max(row0, window.corner[i, 1]), min(row0 + cells, window.corner[i, 1] + size)):
            for col in range(max(col0, window.corner[i, 0]), min(col0 + cells, window.corner[i, 0] + size)):
                if window.seen[i, row % size, col % size] >= since[i, 0] and count < points.shape[1]:
                    place = window.place[i, row % size, col % size]
                    dx = (col + 0.5 + (place[0] + 0.5) / _PARTS) * window.side - pose[i, 0]
                    dy = (row + 0.5 + (place[1] + 0.5) / _PARTS) * window.side - pose[i, 1]
                    px, py = c * dx + s * dy, c * dy - s * dx
                    if sees_all and is_in_view(sight.beams[i], low, high, px, py):
                        continue
                    if distance_to_box(px, py, box) <= 0.0:
                        continue
                    points[0, count] = px
                    points[1, count] = py
                    count += 1
        kept_count = keep_room(points[:, :count], box, margin[i, 0], 2.0, kept)
        gain = limits[i, 2] * dt
        spin = limits[i, 3] * dt
        v = min(max(wanted[i, 0], v0 - 0.5 * gain), v0 + 0.5 * gain)
        w = min(max(wanted[i, 1], w0 - 0.5 * spin), w0 + 0.5 * spin)
        needed = dt + 0.5 * braking_time(v, w, limits[i])
        if free_time(kept, kept_count, v, w, box, needed + dt, needed) < needed:
            left = slowed(v0, w0, limits[i], dt)
            v = v0 * left
            w = w0 * left
        moving[i, 0] = v
        moving[i, 1] = w
        out[i, 0] = v
        out[i, 1] = 0.0
        out[i, 2] = w
