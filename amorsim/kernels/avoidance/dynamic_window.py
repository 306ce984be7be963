"""The dynamic window: of the twists that a drive can have next, the best one from which it can still brake."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.kernels.avoidance.arcs import Box, distance_to_box, free_time, keep_room
from amorsim.kernels.avoidance.guide import Guide, ahead_on, find_leg, to_go
from amorsim.kernels.behaviours.free_space import Sight, see_points
from amorsim.kernels.compile import kernel, part

__all__ = [
    "Abilities",
    "Scene",
    "Weights",
    "braking_time",
    "choose_twists",
    "field_of_view",
    "is_in_view",
    "keep_behind",
    "moved_on",
    "slowed",
]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

_FORWARD_LEAST = 0.05  # [m] near the goal it is the base point that is to come there
_FAR = 3.0  # [m] along its path within which a robot looks for where it is


_LEAST_ROOM = 1e-3  # [m] less than their distance is kept from places that are known from before
_HELD = 10.0  # [s] for which what is out of sight is kept
_BESIDE = 0.8  # [m] from the base point within which it is kept
_APART = 0.02  # [m] between points that are kept
_EDGE = 0.01  # [rad] beyond the outermost beams that is still seen


class Scene(NamedTuple):
    """What N robots see and what they passed."""

    sight: Sight
    """What range finders read."""
    age: Array
    """[s] of these readings, (N, 1)."""
    behind: Array
    """(N, E, 3) places x, y [m] in the world near the robot's way, and when each was seen [s]."""
    time: Array
    """[s] now, (N, 1)."""


class Abilities(NamedTuple):
    """The limits of N robots."""

    speed: Column
    """(N, 1) [m/s] ahead."""
    back: Column
    """(N, 1) [m/s] backwards."""
    turn_rate: Column
    """(N, 1) [rad/s]"""
    limits: Array
    """Of the drive, (N, 4): speed, turn, and how fast each changes. Both share the same motors."""
    curvature_max: Array
    """(N, 1) [1/m]; inf for one that turns in place."""
    lag: Array
    """(N, 1) [s] of its motors."""


class Weights(NamedTuple):
    """The weights by which N robots compare twists, each (N, 1)."""

    margin: Column
    """[m] kept around the footprint."""
    horizon: Column
    """[s] for which a twist is thought to go on."""
    forward_distance: Column
    """[m] ahead of the base point: the place whose way to the goal counts."""
    path_weight: Column
    """How many metres along the path a metre off it counts."""
    obstacle_weight: Column
    """[m] that a twist may cost which meets something at once; less, the longer it may go on."""
    turn_weight: Column
    """[m] that the largest change of turning costs."""


@part
def braking_time(v: float, w: float, limits: Array) -> float:
    """The time [s] in which a drive can stop from a twist along the same arc."""
    time: float = abs(v) / limits[2] + abs(w) / limits[3]
    return time


@part
def slowed(v: float, w: float, limits: Array, dt: float) -> float:
    """The part of a twist that is left after `dt` [s] of braking along the same arc."""
    time = braking_time(v, w, limits)
    return 1.0 - dt / time if time > dt else 0.0


@part
def moved_on(points: Array, v: float, w: float, age: float) -> None:
    """Move points (3, p) to where they are in the body's frame after it moved with a twist for `age` [s]."""
    if age <= 0.0 or (v == 0.0 and w == 0.0):
        return
    turn = w * age
    c = math.cos(turn)
    s = math.sin(turn)
    dx = v * age
    dy = 0.0
    if abs(turn) > 1e-9:
        dx = v / w * s
        dy = v / w * (1.0 - c)
    for n in range(points.shape[1]):
        x = points[0, n] - dx
        y = points[1, n] - dy
        if abs(x) < math.inf and abs(y) < math.inf:
            points[0, n] = c * x + s * y
            points[1, n] = c * y - s * x


@kernel
def keep_behind(scene: Scene, pose: Array, moving: Array, first: int, end: int) -> None:
    """Keep the places that robots at `pose` (N, 3) see next to them in `scene.behind`, in place of the oldest there."""
    sight, behind = scene.sight, scene.behind
    points = np.empty((3, sight.ranges.shape[1] * sight.samples))
    room = behind.shape[1]
    for i in range(first, end):
        see_points(sight.ranges[i], sight.beams[i], sight.half_angle[i, 0], points)
        moved_on(points, moving[i, 0], moving[i, 1], scene.age[i, 0])
        c = math.cos(pose[i, 2])
        s = math.sin(pose[i, 2])
        for n in range(points.shape[1]):
            px, py = points[0, n], points[1, n]
            # What is ahead will be seen again.
            if not (abs(px) < math.inf and abs(py) < math.inf) or px > 0.5 * abs(py):
                continue
            if px * px + py * py > _BESIDE * _BESIDE:
                continue
            x = pose[i, 0] + c * px - s * py
            y = pose[i, 1] + s * px + c * py
            oldest = 0
            found = -1
            for k in range(room):
                dx, dy = behind[i, k, 0] - x, behind[i, k, 1] - y
                if dx * dx + dy * dy < _APART * _APART:
                    found = k
                    break
                if behind[i, k, 2] < behind[i, oldest, 2]:
                    oldest = k
            if found < 0:
                found = oldest
                behind[i, found, 0] = x
                behind[i, found, 1] = y
            behind[i, found, 2] = scene.time[i, 0]


@part
def field_of_view(beams: Array) -> tuple[float, float]:
    """The least and the largest direction [rad] of a range finder's values, `beams` (5, k)."""
    low, high = math.inf, -math.inf
    for j in range(beams.shape[1]):
        low = min(low, beams[2, j])
        high = max(high, beams[2, j])
    return low, high


@part
def is_in_view(beams: Array, low: float, high: float, x: float, y: float) -> bool:
    """Whether a place in the body's frame lies between the outermost directions of `field_of_view`."""
    bearing = math.atan2(y - beams[1, 0], x - beams[0, 0])
    return low - _EDGE <= bearing <= high + _EDGE


@part
def _add_behind(
    behind: Array, beams: Array, pose: Array, since: float, box: Box, room: float, count: int, out: Array
) -> int:
    """Add what is out of sight (E, 3) to `count` points of `keep_room`; returns their number."""
    low, high = field_of_view(beams)
    c = math.cos(pose[2])
    s = math.sin(pose[2])
    for k in range(behind.shape[0]):
        if behind[k, 2] < since or count >= out.shape[1]:
            continue
        dx, dy = behind[k, 0] - pose[0], behind[k, 1] - pose[1]
        x = c * dx + s * dy
        y = c * dy - s * dx
        if x * x + y * y > 2.0 * _BESIDE * _BESIDE:
            continue
        if is_in_view(beams, low, high, x, y):
            continue
        gap = distance_to_box(x, y, box)
        if gap <= 0.0:  # where the robot itself stands, there is nothing
            continue
        out[0, count] = x
        out[1, count] = y
        out[2, count] = max(0.0, min(room, gap - _LEAST_ROOM))
        count += 1
    return count


@kernel
def choose_twists(
    scene: Scene,
    pose: Array,
    box: Box,
    guide: Guide,
    able: Abilities,
    weights: Weights,
    active: Bools,
    dt: float,
    moving: Array,
    first: int,
    end: int,
    arcs: Array,
    out: Array,
) -> None:
    """Twists along a path that touch nothing seen, into `out` (N, 3), for the rows from `first` to `end`.

    A twist is admissible if the robot can drive on with it for a step and then brake along the same arc before its
    rounded box meets a point that it saw. Of these it takes the one after which the way to the goal is shortest. If
    there is none, it brakes along its present arc, which was admissible before.

    Parameters
    ----------
    scene
        What they see, and what they passed.
    pose
        The estimated poses (N, 3), with the heading in which they go.
    box
        Their footprint, but for the margin.
    guide
        Their paths.
    able, weights
        What their drives can do, and what a twist costs.
    active
        (N, 1); the others brake.
    moving
        Their twists (v, w) by their own reckoning, (N, 2); changed.
    arcs
        (N, V, W, 3) v, w and cost of each twist that was looked at; nan for the cost of one not admissible.
    """
    sight, age = scene.sight, scene.age
    points = np.empty((3, sight.ranges.shape[1] * sight.samples))
    kept = np.empty((3, points.shape[1] + scene.behind.shape[1]))
    near = np.empty((3, kept.shape[1]))
    speeds = arcs.shape[1]
    turns = arcs.shape[2]
    half = turns // 2
    long = max(abs(box.front), abs(box.rear))
    wide = max(abs(box.left), abs(box.right))
    reach = min(math.sqrt(long * long + wide * wide), box.reach)
    for i in range(first, end):
        v0 = moving[i, 0]
        w0 = moving[i, 1]
        limits = able.limits[i]
        left = slowed(v0, w0, limits, dt)
        best_v = v0 * left
        best_w = w0 * left
        if active[i, 0]:
            path = guide.path[i]
            along = guide.along[i]
            count = guide.size[i]
            x, y, heading = pose[i, 0], pose[i, 1], pose[i, 2]
            c0 = math.cos(heading)
            s0 = math.sin(heading)
            leg, here = find_leg(path, along, count, guide.leg[i], _FAR, x, y)
            guide.leg[i] = leg
            horizon = weights.horizon[i, 0]
            margin = weights.margin[i, 0]
            left_to_go = to_go(path, along, count, leg, here + _FAR, 1.0, x, y)
            forward = max(
                min(weights.forward_distance[i, 0], left_to_go - weights.forward_distance[i, 0]), _FORWARD_LEAST
            )
            fastest = min(able.speed[i, 0], limits[0])
            # On the last metre it thinks no farther than the goal, or it would creep up to it.
            coming = max(left_to_go / fastest, math.sqrt(2.0 * left_to_go / limits[2]), 2.0 * dt)
            horizon = min(horizon, coming)
            until = here + fastest * horizon + forward + 0.5
            see_points(sight.ranges[i], sight.beams[i], sight.half_angle[i, 0], points)
            moved_on(points, v0, w0, age[i, 0])
            lag = able.lag[i, 0]
            most = max(horizon, dt + lag + braking_time(fastest, min(able.turn_rate[i, 0], limits[1]), limits))
            kept_count = keep_room(points, box, margin, margin + fastest * most + 2.0 * reach, kept)
            kept_count = _add_behind(
                scene.behind[i], sight.beams[i], pose[i], scene.time[i, 0] - _HELD, box, margin, kept_count, kept
            )
            gain = limits[2] * dt
            low = max(v0 - gain, -min(able.back[i, 0], limits[0]))
            high = max(min(v0 + gain, fastest), low)
            step = (high - low) / max(speeds - 1, 1)
            look = max(0.4, abs(v0) * 0.5)
            aim_x, aim_y = ahead_on(path, along, count, leg, here + look)
            ahead = c0 * (aim_x - x) + s0 * (aim_y - y)
            aside = c0 * (aim_y - y) - s0 * (aim_x - x)
            aim = math.atan2(aside, ahead)
            best = math.inf
            for a in range(speeds):
                v = low + step * a
                if abs(v) <= 0.5 * step:
                    v = 0.0
                share = 1.0 if math.isinf(gain) else max(1.0 - abs(v - v0) / gain, 0.0)
                span = limits[3] * dt * share if share > 0.0 else 0.0
                # The motors that drive also turn.
                free = 1.0 if math.isinf(limits[0]) else max(1.0 - abs(v) / limits[0], 0.0)
                most_turn = min(able.turn_rate[i, 0], limits[1] * free) if free > 0.0 else 0.0
                if math.isfinite(able.curvature_max[i, 0]):
                    most_turn = min(most_turn, able.curvature_max[i, 0] * abs(v))
                least_w = max(w0 - span, -most_turn)
                most_w = min(w0 + span, most_turn)
                square = ahead * ahead + aside * aside
                middle = 2.0 * aim
                if v != 0.0 and square > 0.0 and ahead > 0.0:
                    middle = v * 2.0 * aside / square
                middle = min(max(middle, least_w), most_w)
                near_count = 0
                if least_w <= most_w:
                    for n in range(kept_count):
                        far = margin + abs(v) * most + 2.0 * reach
                        if kept[0, n] * kept[0, n] + kept[1, n] * kept[1, n] <= far * far:
                            near[0, near_count] = kept[0, n]
                            near[1, near_count] = kept[1, n]
                            near[2, near_count] = kept[2, n]
                            near_count += 1
                for b in range(turns):
                    part_of = (b - half) / max(half, 1)
                    w = middle + part_of * abs(part_of) * (most_w - middle if part_of > 0.0 else middle - least_w)
                    arcs[i, a, b, 0] = v
                    arcs[i, a, b, 1] = w
                    arcs[i, a, b, 2] = math.nan
                    if least_w > most_w:
                        continue
                    braking = braking_time(v, w, limits)
                    needed = dt + lag + 0.5 * braking
                    free_for = free_time(near, near_count, v, w, box, max(needed, horizon), needed)
                    if free_for < needed:
                        continue
                    time = min(horizon, free_for)
                    turn = w * time
                    c = math.cos(turn)
                    s = math.sin(turn)
                    ex = v * time
                    ey = 0.0
                    if abs(turn) > 1e-9:
                        ex = v / w * s
                        ey = v / w * (1.0 - c)
                    ex += forward * c
                    ey += forward * s
                    cost = to_go(
                        path,
                        along,
                        count,
                        leg,
                        until,
                        weights.path_weight[i, 0],
                        x + c0 * ex - s0 * ey,
                        y + s0 * ex + c0 * ey,
                    )
                    cost += weights.obstacle_weight[i, 0] * (1.0 - min(free_for, horizon) / horizon)
                    if most_turn > 0.0:
                        cost += weights.turn_weight[i, 0] * abs(w - w0) / (2.0 * most_turn)
                    arcs[i, a, b, 2] = cost
                    if cost < best:
                        best = cost
                        best_v = v
                        best_w = w
        else:
            for a in range(speeds):
                for b in range(turns):
                    arcs[i, a, b, 0] = math.nan
                    arcs[i, a, b, 1] = math.nan
                    arcs[i, a, b, 2] = math.nan
        moving[i, 0] = best_v
        moving[i, 1] = best_w
        out[i, 0] = best_v
        out[i, 1] = 0.0
        out[i, 2] = best_w
