"""Steering along a line of points by looking ahead: pure pursuit, and following a leader's trail."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from amorsim.array_types import Array, Ints
from amorsim.kernels.behaviours.go_to_pose import approach
from amorsim.kernels.compile import kernel

__all__ = ["Course", "Pace", "follow_trail", "pursue"]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

_BEHIND = 1.0  # [rad] farther off its heading a robot that can turns in place
_SETTLED = 0.05  # [rad] until it is right by this much


class Course(NamedTuple):
    """The paths of N robots."""

    path: Array
    """Points of each, (N, p, 2) [m]; no two in turn are the same."""
    along: Array
    """Their distances along the path, (N, p) [m]."""
    stops: Ints
    """The point at which a robot on each leg stops next, (N, p - 1): it turns about there, or the path ends; -1 for
    none."""
    loops: bool
    """Whether the last point leads on to the second."""


class Pace(NamedTuple):
    """The top speeds and turn rates of N robots: the wanted ones and those of their drives."""

    speed: Column
    """(N, 1) [m/s]"""
    turn_rate: Column
    """(N, 1) [rad/s]"""
    limits: Array
    """Of the drive, (N, 4)."""
    curvature_max: Array
    """(N, 1) [1/m]; inf for one that turns in place."""


@kernel
def _advance(path: Array, along: Array, s: float, most: float, loops: bool, x: float, y: float) -> float:
    """How far along the path the place nearest to (x, y) is, from `s` on and `most` farther at most."""
    last = along.shape[0] - 1
    if loops:  # once round is all there is, however far it looks
        most = min(most, along[last] - along[1] + max(along[1] - s, 0.0))
    best = math.inf
    found = s
    i = 0
    while i < last - 1 and along[i + 1] <= s:
        i += 1
    gone = 0.0  # from s to the start of what is looked at
    at = s
    while gone <= most:
        length = along[i + 1] - along[i]
        low = at - along[i]
        high = min(length, low + most - gone)
        ux = (path[i + 1, 0] - path[i, 0]) / length
        uy = (path[i + 1, 1] - path[i, 1]) / length
        t = min(max((x - path[i, 0]) * ux + (y - path[i, 1]) * uy, low), high)
        dx = path[i, 0] + t * ux - x
        dy = path[i, 1] + t * uy - y
        if dx * dx + dy * dy < best:
            best = dx * dx + dy * dy
            found = along[i] + t
        gone += length - low
        i += 1
        if i == last:
            if not loops:
                break
            i = 1
        at = along[i]
    return found


@kernel
def _place(path: Array, along: Array, s: float, loops: bool) -> tuple[float, float]:
    """The place `s` along the path; beyond its end straight on, or round again."""
    last = along.shape[0] - 1
    if loops and s > along[last]:
        s = along[1] + (s - along[last]) % (along[last] - along[1])
    i = 0
    while i < last - 1 and along[i + 1] <= s:
        i += 1
    t = (s - along[i]) / (along[i + 1] - along[i])
    return path[i, 0] + t * (path[i + 1, 0] - path[i, 0]), path[i, 1] + t * (path[i + 1, 1] - path[i, 1])


@kernel
def _leg(along: Array, s: float, loops: bool) -> int:
    """The leg of the path at `s`, by the number of its first point."""
    last = along.shape[0] - 1
    if loops and s >= along[last]:
        return 1
    i = 0
    while i < last - 1 and along[i + 1] <= s:
        i += 1
    return i


@kernel
def _until(along: Array, stop: int, s: float) -> float:
    """The distance from `s` to the next stop of the path, inf if there is none."""
    if stop < 0:
        return math.inf
    where: float = along[stop]
    if where >= s:
        return where - s
    once_round: float = along[along.shape[0] - 1] - along[1]
    return where - s + once_round


@kernel
def _beyond(path: Array, stop: int, way: float) -> tuple[float, float]:
    """The place so far beyond the stop, straight on along the leg that leads there."""
    dx = path[stop, 0] - path[stop - 1, 0]
    dy = path[stop, 1] - path[stop - 1, 1]
    part = way / math.sqrt(dx * dx + dy * dy)
    return path[stop, 0] + part * dx, path[stop, 1] + part * dy


@kernel
def _steer(
    pose: Array,
    x: float,
    y: float,
    way: float,
    left: float,
    fastest: float,
    turn_rate: float,
    limits: Array,
    curvature_max: float,
    dt: float,
    moving: Array,
    out: Array,
) -> None:
    """A twist towards a place, with `left` metres to drive: along the circle that leads there.

    `way` is 1, or -1 for driving backwards, where ahead and behind are exchanged. `moving` is the speed by the robot's
    own reckoning, and whether it is turning in place.
    """
    c = math.cos(pose[2])
    s = math.sin(pose[2])
    ahead = way * (c * (x - pose[0]) + s * (y - pose[1]))
    aside = way * (c * (y - pose[1]) - s * (x - pose[0]))
    square = ahead * ahead + aside * aside
    bearing = math.atan2(aside, ahead)
    braking = limits[2] * dt
    v = 0.0
    w = 0.0
    in_place = math.isinf(curvature_max) and abs(bearing) > (_SETTLED if moving[1] == 1.0 else _BEHIND)
    moving[1] = 1.0 if in_place else 0.0
    if in_place:
        if moving[0] == 0.0 or math.isinf(braking):
            w = approach(bearing, min(turn_rate, limits[1]), limits[3], dt)
    elif square > 0.0:
        bend = 2.0 * aside / square
        if ahead < 0.0:
            bend = math.copysign(math.inf, aside)
        bend = min(max(bend, -curvature_max), curvature_max)
        v = approach(left, min(fastest, limits[0]), limits[2], dt)
        if not math.isinf(braking):
            v = min(v, moving[0] + 0.5 * braking)
        if bend != 0.0:
            v = min(v, min(turn_rate, limits[1]) / abs(bend))
        w = v * bend
    moving[0] = min(max(v, moving[0] - braking), moving[0] + braking)
    out[0] = way * v
    out[1] = 0.0
    out[2] = w


@kernel
def pursue(
    pose: Array,
    course: Course,
    lookahead: Column,
    tolerance: Column,
    pace: Pace,
    dt: float,
    progress: Array,
    way: Array,
    moving: Array,
    out: Array,
) -> None:
    """Twists along paths, into `out` (N, 3).

    Parameters
    ----------
    pose
        Where the robots believe to be, (N, 3).
    course
        The paths.
    lookahead
        How far ahead on the path the place lies that is steered for, (N, 1) [m].
    tolerance
        How near to a stop it stops [m], (N, 1).
    pace
        How fast.
    progress, way, moving
        How far they have come, (N, 1), whether they drive on (1) or back (-1), (N, 1), and what they do, (N, 2);
        changed.
    """
    path, along, stops, loops = course.path, course.along, course.stops, course.loops
    for i in range(pose.shape[0]):
        last = along.shape[1] - 1
        s = progress[i, 0]
        ahead = lookahead[i, 0]
        stop = stops[i, _leg(along[i], s, loops)]
        ends = stop == last and not loops
        # Beyond a place where it turns about lies nothing that it could be near to already.
        most = ahead if stop < 0 or ends else min(ahead, _until(along[i], stop, s))
        s = _advance(path[i], along[i], s, most, loops, pose[i, 0], pose[i, 1])
        left = _until(along[i], stop, s)
        progress[i, 0] = s
        if left <= tolerance[i, 0]:
            out[i, 0] = 0.0
            out[i, 1] = 0.0
            out[i, 2] = 0.0
            moving[i, 0] = 0.0
            if not ends:
                progress[i, 0] = along[i, 1] if stop == last else along[i, stop]
                way[i, 0] = -way[i, 0]
            continue
        if ahead <= left or ends:
            x, y = _place(path[i], along[i], s + ahead, loops)
        else:
            x, y = _beyond(path[i], stop, ahead - left)
        _steer(
            pose[i],
            x,
            y,
            way[i, 0],
            left,
            pace.speed[i, 0],
            pace.turn_rate[i, 0],
            pace.limits[i],
            pace.curvature_max[i, 0],
            dt,
            moving[i],
            out[i],
        )


@kernel
def follow_trail(
    pose: Array,
    seen: Array,
    gap: Column,
    gain: Column,
    lookahead: Column,
    pace: Pace,
    patience: Column,
    spacing: float,
    dt: float,
    trail: Array,
    memory: Array,
    moving: Array,
    out: Array,
) -> None:
    """Twists along the places where a leader was seen, into `out` (N, 3).

    Parameters
    ----------
    pose
        Where the followers believe to be, (N, 3).
    seen
        Where they see the leader, in their own world, (N, 2) [m]; nan where they do not.
    gap, gain
        How far behind it they keep [m], and how much faster [m/s] they go for each metre more [1/s], each (N, 1).
    lookahead, pace
        As in `pursue`.
    patience
        How long they go on without seeing it [s], (N, 1).
    spacing
        Between places of the trail [m].
    trail
        A ring of places, (N, m, 2); changed.
    memory
        How many places were written, the first that still lies ahead, and for how long [s] it was not seen, (N, 3);
        changed.
    moving
        As in `pursue`; changed.
    """
    room = trail.shape[1]
    for i in range(pose.shape[0]):
        out[i, 0] = 0.0
        out[i, 1] = 0.0
        out[i, 2] = 0.0
        memory[i, 2] += dt
        written = int(memory[i, 0])
        if not math.isnan(seen[i, 0]):
            memory[i, 2] = 0.0
            back = trail[i, (written - 1) % room]
            away = math.sqrt((seen[i, 0] - back[0]) ** 2 + (seen[i, 1] - back[1]) ** 2)
            if written == 0 or away > spacing:
                trail[i, written % room, 0] = seen[i, 0]
                trail[i, written % room, 1] = seen[i, 1]
                written += 1
                memory[i, 0] = written
        if written == 0 or memory[i, 2] > patience[i, 0]:
            moving[i, 0] = 0.0
            continue
        # Of the trail, what is nearer than the lookahead is done with.
        first = max(int(memory[i, 1]), written - room)
        distance = 0.0
        while True:
            x = trail[i, first % room, 0]
            y = trail[i, first % room, 1]
            distance = math.sqrt((x - pose[i, 0]) ** 2 + (y - pose[i, 1]) ** 2)
            if distance >= lookahead[i, 0] or first == written - 1:
                break
            first += 1
        memory[i, 1] = first
        leader_x = trail[i, (written - 1) % room, 0]
        leader_y = trail[i, (written - 1) % room, 1]
        keep = 0.0  # out of sight, it goes where the leader was seen last
        if memory[i, 2] == 0.0:
            leader_x = seen[i, 0]
            leader_y = seen[i, 1]
            keep = gap[i, 0]
        behind = math.sqrt((leader_x - pose[i, 0]) ** 2 + (leader_y - pose[i, 1]) ** 2) - keep
        wanted = min(max(gain[i, 0] * behind, 0.0), pace.speed[i, 0])
        if wanted == 0.0:
            moving[i, 0] = max(moving[i, 0] - pace.limits[i, 2] * dt, 0.0)
            continue
        _steer(
            pose[i],
            x,
            y,
            1.0,
            behind,
            wanted,
            pace.turn_rate[i, 0],
            pace.limits[i],
            pace.curvature_max[i, 0],
            dt,
            moving[i],
            out[i],
        )
