"""The behaviour of a wandering robot, row by row: look, turn in place, drive straight, back out."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.kernels.behaviours.free_space import (
    choose_direction,
    directions_within,
    find_opening,
    free_way,
    nearest_distance,
    nearest_side,
    see_points,
)
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.random.philox import pairs

__all__ = ["BODY_COLUMNS", "MEMORY_COLUMNS", "Chance", "Wish", "wander"]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

# What the robot is doing.
_LOOK = 0  # standing, until a scan is there that was taken standing
_DRIVE = 1
_TURN = 2
_BACK = 3  # out of a tight place, the way it came
_CREEP = 4  # out of a tight place, ahead
_AVOID = 5  # as _LOOK, but then it turns even if the way ahead looks free

# Columns of the memory of a row.
_MODE = 0
_ANGLE = 1  # [rad] still to turn
_SPEED = 2  # [m/s] at which it drives now, by its own reckoning
_RATE = 3  # [rad/s] at which it turns now
_TRACE = 4  # [m] that it has come straight on, and could go back
_SINCE = 5  # [m] since it last weighed other directions
_SIDE = 6  # which way it turns round in a dead end, 0 before it is in one
_STILL = 7  # [s] for which it has been standing
_VISITS = 8  # places written on its trail
_BESIDE = 9  # [m] of room to the right and to the left when it last looked aside, two columns
_PHASE = 11  # [rad] of its swaying
_WARY = 12  # [m] that it drove without turning aside, since it was in a tight place
MEMORY_COLUMNS = 13

# Columns of what a row knows of its own body.
_SWING = 0  # [m] reach of the footprint from the base point
_HALF_WIDTH = 1  # [m] of the footprint
_SPEED_MAX = 2  # [m/s]
_RATE_MAX = 3  # [rad/s]
_BRAKING = 4  # [m/s^2]
_SPIN_BRAKING = 5  # [rad/s^2]
_VIEW = 6  # [rad] least and greatest bearing that it sees, two columns
_SWAY = 8  # [rad] by which it sways to either side as it drives
BODY_COLUMNS = 9

_GO = 0.2  # [m] a way ahead as long as this is driven
_STOP = 0.08  # [m] a way ahead no longer than this is not driven on
_WEIGH = 0.15  # [m] after which it looks aside again
_SHUT = 1.2  # [m] where there was less room at its side ...
_OPEN = 2.2  # [m] ... and now there is more, a door may have come abeam,
_CURIOUS = 0.7  # which it takes with this probability
_RESTLESS = 0.3  # probability that it weighs all other directions when it looks aside
_BETTER = 2.5  # times the promise of the way ahead that another must have to be taken instead
_PLACE = 0.7  # [m] between places on the trail
_SLOW = 0.15  # [m/s] in tight places
_CREEP_RADIUS = 1.5  # [m] of the arc by which it leaves a wall next to it: its tail swings out by 1 cm or two
_AWAY = 0.6  # [m] to be driven from a tight place, which may lie where it does not see, before it turns aside
_DRIFT = 0.06  # of the way ahead, that the robot may get off it before it has stopped
_TRACE_MAX = 0.6  # [m] farther back the way need not be straight
_STRAIGHT = math.radians(1.5)  # a smaller turn is not worth stopping for
_SWAY_RATE = 3.0  # [rad/s] of phase
_TIME_TO_STOP = 0.8  # [s] the way ahead is never driven faster than in this time


@part
def _choose(
    points: Array,
    weights: Array,
    body: Array,
    clearance: float,
    pose: Array,
    trail: Array,
    draws: Array,
    bar: float,
    memory: Array,
) -> int:
    """Choose a direction; returns the next action, with the angle to turn in the memory."""
    swing = body[_SWING] + clearance
    if nearest_distance(points) < body[_SWING] + 0.4 * clearance:
        # Something stands where the robot would sweep: a thin thing seen late, or so it was put there.
        if memory[_TRACE] > 0.05:
            memory[_TRACE] = min(memory[_TRACE], _TRACE_MAX)
            return _BACK
        if free_way(points, 0.0, body[_HALF_WIDTH] + 0.2 * clearance, 0.0) > _STOP:
            return _CREEP
    bearing = choose_direction(points, weights, body[_VIEW:], swing, pose, trail, int(memory[_VISITS]), draws[0], bar)
    if math.isnan(bearing):
        if bar > 0.0:
            return _DRIVE
        if memory[_SIDE] == 0.0:
            memory[_SIDE] = 1.0 if draws[1] < 0.5 else -1.0
        bearing = memory[_SIDE] * (1.7 + draws[0])
    elif bar > 0.0 and abs(bearing) < _STRAIGHT:
        return _DRIVE
    memory[_ANGLE] = bearing
    return _TURN


@part
def _looks_in(points: Array, body: Array, clearance: float, draw: float, memory: Array) -> bool:
    """Whether a door seems to be abeam that the robot takes; the angle is then in the memory."""
    looks = False
    for n in range(2):
        room, bearing = find_opening(points, body[_VIEW:], body[_SWING] + clearance, 2.0 * n - 1.0)
        if memory[_BESIDE + n] < _SHUT and room > _OPEN and draw < _CURIOUS:
            memory[_ANGLE] = bearing
            looks = True
        memory[_BESIDE + n] = room
    return looks


@part
def _decide(
    points: Array,
    weights: Array,
    age: float,
    pose: Array,
    body: Array,
    clearance: float,
    speed_max: float,
    trail: Array,
    draws: Array,
    memory: Array,
) -> int:
    """The action of this step, from the robot's last action and what it sees."""
    mode = int(memory[_MODE])
    if mode == _TURN:
        done = abs(memory[_ANGLE]) < 0.005
        if not done or memory[_SPEED] != 0.0:
            return _TURN
        memory[_STILL] = 0.0
        mode = _LOOK
    tight = nearest_distance(points) < body[_SWING] + 0.6 * clearance
    if mode == _BACK:
        if memory[_TRACE] > 0.03 and tight:
            return _BACK
        memory[_STILL] = 0.0
        mode = _AVOID
    if mode == _CREEP:
        if tight and free_way(points, 0.0, body[_HALF_WIDTH] + 0.2 * clearance, 0.0) > _STOP:
            return _CREEP
        memory[_STILL] = 0.0
        mode = _LOOK

    ahead = free_way(points, 0.0, body[_SWING] + clearance, 0.0)
    ahead -= min(memory[_TRACE], speed_max * age)  # driven since the scan
    if mode == _DRIVE:
        if ahead < _STOP:
            return _choose(points, weights, body, clearance, pose, trail, draws, 0.0, memory)
        if memory[_SINCE] > _WEIGH and memory[_WARY] > _AWAY:
            memory[_SINCE] = 0.0
            memory[_SIDE] = 0.0
            if _looks_in(points, body, clearance, draws[1], memory):
                return _TURN
            if draws[1] < _RESTLESS:
                return _choose(points, weights, body, clearance, pose, trail, draws, _BETTER, memory)
        return _DRIVE
    if memory[_SPEED] != 0.0 or memory[_RATE] != 0.0 or age > memory[_STILL] + 1e-9:
        return mode
    if mode == _LOOK and ahead > _GO:
        memory[_SINCE] = 0.0
        memory[_BESIDE] = math.inf  # what it sees first has not come abeam
        memory[_BESIDE + 1] = math.inf
        return _DRIVE
    return _choose(points, weights, body, clearance, pose, trail, draws, 0.0, memory)


@part
def _wander_row(
    points: Array,
    weights: Array,
    age: float,
    pose: Array,
    body: Array,
    speed: float,
    turn_rate: float,
    clearance: float,
    draws: Array,
    dt: float,
    memory: Array,
    trail: Array,
    out: Array,
) -> None:
    visits = int(memory[_VISITS])
    last = (visits - 1) % trail.shape[0]
    dx = pose[0] - trail[last, 0]
    dy = pose[1] - trail[last, 1]
    if visits == 0 or dx * dx + dy * dy > _PLACE * _PLACE:
        trail[visits % trail.shape[0], 0] = pose[0]
        trail[visits % trail.shape[0], 1] = pose[1]
        memory[_VISITS] += 1.0

    speed_max = min(speed, body[_SPEED_MAX])
    mode = _decide(points, weights, age, pose, body, clearance, speed_max, trail, draws, memory)
    memory[_MODE] = mode
    braking = body[_BRAKING]
    spin_braking = body[_SPIN_BRAKING]
    v = 0.0
    w = 0.0
    if mode in (_DRIVE, _CREEP):
        width = body[_SWING] + clearance if mode == _DRIVE else body[_HALF_WIDTH] + 0.2 * clearance
        driven = min(memory[_TRACE], speed_max * age)
        ahead = max(0.0, free_way(points, 0.0, width, 0.0) - driven)
        clear = max(0.0, free_way(points, 0.0, width, _DRIFT) - driven)
        v = min(speed_max if mode == _DRIVE else min(speed_max, _SLOW), ahead / max(_TIME_TO_STOP, 2.0 * dt))
        v = min(v, math.sqrt(braking * ahead))
        v = min(v, max(_SLOW, min(clear / _TIME_TO_STOP, math.sqrt(braking * clear))))
        if mode == _CREEP:
            w = -nearest_side(points) * v / _CREEP_RADIUS
            memory[_WARY] = 0.0
        elif _SWAY_RATE * dt < 1.0 and v > 0.0:
            # A thin wall seen end on hides between two beams, unless they sweep.
            memory[_PHASE] += _SWAY_RATE * dt
            w = body[_SWAY] * _SWAY_RATE * math.cos(memory[_PHASE])
    elif mode == _BACK:
        v = -min(min(speed_max, _SLOW), memory[_TRACE] / max(_TIME_TO_STOP, 2.0 * dt))
    elif mode == _TURN and (memory[_SPEED] == 0.0 or math.isinf(braking)):
        angle = memory[_ANGLE]
        fastest = min(min(turn_rate, body[_RATE_MAX]), math.sqrt(spin_braking * abs(angle)))
        w = min(max(angle / dt, -fastest), fastest)

    # The robot's reckoning of its own motion: as the drive will follow the command, nothing hindering it.
    v_now = min(max(v, memory[_SPEED] - braking * dt), memory[_SPEED] + braking * dt)
    w_now = min(max(w, memory[_RATE] - spin_braking * dt), memory[_RATE] + spin_braking * dt)
    memory[_SPEED] = v_now
    memory[_RATE] = w_now
    memory[_ANGLE] -= w_now * dt
    memory[_SINCE] += abs(v_now) * dt
    memory[_WARY] += abs(v_now) * dt
    memory[_TRACE] = 0.0 if mode == _TURN else max(memory[_TRACE] + v_now * dt, 0.0)
    memory[_STILL] = memory[_STILL] + dt if v_now == 0.0 and w_now == 0.0 else 0.0
    out[0] = v
    out[1] = 0.0
    out[2] = w


class Wish(NamedTuple):
    """The driving parameters of N robots, each (N, 1)."""

    speed: Column
    """[m/s]"""
    turn_rate: Column
    """[rad/s]"""
    clearance: Column
    """The distance that they keep free around them [m]."""


class Chance(NamedTuple):
    """Keys (N,), counter (N, 3) and block of the random numbers, for `philox.pairs`."""

    keys: npt.NDArray[np.uint64]
    counter: npt.NDArray[np.uint32]
    block: int


@kernel
def wander(
    ranges: Array,
    beams: Array,
    half_angle: Array,
    samples: int,
    age: Array,
    pose: Array,
    body: Array,
    speed: Column,
    turn_rate: Column,
    clearance: Column,
    keys: npt.NDArray[np.uint64],
    counter: npt.NDArray[np.uint32],
    block: int,
    dt: float,
    memory: Array,
    trail: Array,
    first: int,
    end: int,
    out: Array,
) -> None:
    """Twists (forward, left, turn) [m/s, m/s, rad/s] of wandering robots, into `out` (N, 3).

    Parameters
    ----------
    ranges, beams, half_angle, samples
        The `Sight` that was seen.
    age
        How old it is [s] (N, 1).
    pose
        Where the robots believe to be, (N, 3); for the trail of places only.
    body
        What the robot knows of its own body, (N, BODY_COLUMNS).
    speed, turn_rate, clearance
        The `Wish`: how it is asked to drive.
    keys, counter, block
        The `Chance`: what two uniform random numbers of each row are drawn by.
    memory, trail
        What it remembers, (N, MEMORY_COLUMNS), and places where it was, (N, places, 2) [m]; changed.
    first, end
        The rows that are worked on.
    """
    points = np.empty((3, ranges.shape[1] * samples))
    most = 1
    for i in range(first, end):
        most = max(most, directions_within(body[i, _VIEW:]))
    weights = np.empty(most)
    drawn = np.empty(2)
    one = drawn[:1]
    other = drawn[1:]
    for i in range(first, end):
        pairs(keys[i], counter, i, block, one, other)
        see_points(ranges[i], beams[i], half_angle[i, 0], points)
        _wander_row(
            points,
            weights,
            age[i, 0],
            pose[i],
            body[i],
            speed[i, 0],
            turn_rate[i, 0],
            clearance[i, 0],
            drawn,
            dt,
            memory[i],
            trail[i],
            out[i],
        )
