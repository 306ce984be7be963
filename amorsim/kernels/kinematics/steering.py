"""Where steered wheels lead: axles in curves, paths while the steering moves, and the steering for a motion.

In a step the steering goes evenly from one angle to another while the wheels roll evenly. The heading is elementary
then; the place is an integral that is none, and is summed up by Gauss's rule in parts so small that what it leaves out
is below the rounding. Where the steering stands, the path is an arc, in closed form.
"""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.actuation import respond
from amorsim.kernels.kinematics.poses import arc

__all__ = [
    "CENTRE",
    "FRONT",
    "REAR",
    "ackermann_advance",
    "ackermann_commands",
    "ackermann_paths",
    "ackermann_stops",
    "ackermann_travel",
    "ackermann_wheels",
    "tricycle_advance",
    "tricycle_commands",
    "tricycle_paths",
]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

# Which wheels of a car are counted.
CENTRE = 0
REAR = 1
FRONT = 2

# Gauss and Legendre's rule of six nodes on [0, 1]; over parts of half a radian the error is under 1e-18 of the way.
_NODES = (
    0.033765242898423975,
    0.16939530676686776,
    0.38069040695840156,
    0.6193095930415985,
    0.8306046932331322,
    0.966234757101576,
)
_WEIGHTS = (
    0.08566224618958525,
    0.1803807865240693,
    0.23395696728634546,
    0.23395696728634546,
    0.1803807865240693,
    0.08566224618958525,
)
_PART = 0.5  # [rad] of heading in a part of a path
_STEERED = 0.1  # [rad] of steering in one
_PARTS_MAX = 4096
_WAITS = math.radians(20.0)  # a tricycle's wheel waits while its steering is so far off


@kernel
def _mean_tangent(start: float, end: float) -> float:
    """The mean tangent of the angles from one to another."""
    width = end - start
    if width == 0.0:
        return math.tan(start)
    return math.log1p(2.0 * math.sin(0.5 * (start + end)) * math.sin(0.5 * width) / math.cos(end)) / width


@kernel
def _mean_sine(start: float, end: float) -> float:
    """The mean sine of the angles from one to another."""
    half = 0.5 * (end - start)
    if half == 0.0:
        return math.sin(start)
    return math.sin(0.5 * (start + end)) * math.sin(half) / half


@kernel
def _parts(heading: float, steered: float) -> int:
    return min(1 + int(max(heading / _PART, steered / _STEERED)), _PARTS_MAX)


@kernel
def _steered_path(way: float, start: float, end: float, wheelbase: float, by_front: bool) -> tuple[float, float, float]:
    """Displacement of the middle of the rear axle as the steering goes from `start` to `end` [rad].

    `way` [m] is what that point rolls, or with `by_front` the steered wheel.
    """
    bend = way / wheelbase
    if start == end:
        if by_front:
            return arc(way * math.cos(start), 0.0, bend * math.sin(start), 1.0)
        return arc(way, 0.0, bend * math.tan(start), 1.0)
    width = end - start
    if by_front:
        turn = bend * _mean_sine(start, end)
        count = _parts(abs(bend), abs(width))
    else:
        turn = bend * _mean_tangent(start, end)
        count = _parts(abs(bend) * max(abs(math.tan(start)), abs(math.tan(end))), abs(width))
    x = 0.0
    y = 0.0
    for piece in range(count):
        for node in range(6):
            u = (piece + _NODES[node]) / count
            steering = start + width * u
            weight = _WEIGHTS[node] / count
            if by_front:
                heading = bend * u * _mean_sine(start, steering)
                weight *= math.cos(steering)
            else:
                heading = bend * u * _mean_tangent(start, steering)
            x += weight * math.cos(heading)
            y += weight * math.sin(heading)
    return way * x, way * y, turn


@kernel
def _speed_of_front(steering: float, skew: float, side: float) -> float:
    """Metres that a front wheel rolls per metre of the rear axle's middle; `side` 1 on the left, -1 on the right."""
    t = math.tan(steering)
    across = 1.0 - side * skew * t
    return math.sqrt(across * across + t * t)


@kernel
def _wheel_ways(start: float, end: float, skew: float, place: int) -> tuple[float, float]:
    """The mean metres that the left and right counted wheels roll per metre of the rear axle's middle.

    `skew` is half the track over the wheelbase.
    """
    if place == CENTRE:
        return 1.0, 1.0
    if place == REAR:
        bent = skew * _mean_tangent(start, end)
        return 1.0 - bent, 1.0 + bent
    if start == end:
        return _speed_of_front(start, skew, 1.0), _speed_of_front(start, skew, -1.0)
    left = 0.0
    right = 0.0
    count = _parts(0.0, abs(end - start))
    for piece in range(count):
        for node in range(6):
            steering = start + (end - start) * ((piece + _NODES[node]) / count)
            weight = _WEIGHTS[node] / count
            left += weight * _speed_of_front(steering, skew, 1.0)
            right += weight * _speed_of_front(steering, skew, -1.0)
    return left, right


@kernel
def _way(before: Array, after: Array, skew: float, place: int) -> float:
    """The roll [rad of a wheel] of the rear axle's middle as a row's joints go from `before` to `after`."""
    left = float(after[1] - before[1])
    if place == CENTRE:
        return left
    right = float(after[2] - before[2])
    if place == REAR:
        return 0.5 * (left + right)
    of_left, of_right = _wheel_ways(before[0], after[0], skew, place)
    return 0.5 * (left / of_left + right / of_right)


@part
def _waits(before: float, after: float) -> float:
    """The share of a step until a steering's error [rad] is below `_WAITS`; it goes evenly from one to the other."""
    if abs(before) <= _WAITS:
        return 0.0
    return (abs(before) - _WAITS) / (abs(before) - abs(after)) if abs(after) < _WAITS else 1.0


@part
def _steer(
    start: float, wanted: float, most: float, rate: float, lag: float, dt: float, out: Array
) -> tuple[float, float, float]:
    """A steering's target, its mean angle in a step and that after it; `out` gets the last and the mean rate."""
    target = min(max(wanted, -most), most)
    end, summed = respond(start, target, rate, lag, dt)
    out[0] = end
    out[1] = (end - start) / dt
    return target, summed / dt, end


@kernel
def ackermann_advance(
    joints: Array,
    rates: Array,
    command: Array,
    wheelbase: Column,
    track: Column,
    place: int,
    steering_max: Column,
    steering_rate: Column,
    steering_lag: Column,
    rate_max: Column,
    acceleration_max: Column,
    lag: Column,
    dt: float,
    out: Array,
) -> None:
    """Joints and rates of cars a step later, into `out` (2, N, j); the command is (steering [rad], wheels [rad/s])."""
    for i in range(joints.shape[0]):
        skew = 0.5 * track[i, 0] / wheelbase[i, 0]
        start = joints[i, 0]
        _, _, end = _steer(
            start, command[i, 0], steering_max[i, 0], steering_rate[i, 0], steering_lag[i, 0], dt, out[:, i, 0]
        )
        # What the shaft does now, by the wheels that are counted.
        left, right = _wheel_ways(start, start, skew, place)
        if place == CENTRE:
            rate = rates[i, 1]
        elif place == REAR:
            rate = 0.5 * (rates[i, 1] + rates[i, 2])
        else:
            rate = 0.5 * (rates[i, 1] / left + rates[i, 2] / right)
        target = min(max(command[i, 1], -rate_max[i, 0]), rate_max[i, 0])
        rate, turned = respond(rate, target, acceleration_max[i, 0], lag[i, 0], dt)
        left, right = _wheel_ways(start, end, skew, place)
        left_now, right_now = _wheel_ways(end, end, skew, place)
        out[0, i, 1] = joints[i, 1] + turned * left
        out[1, i, 1] = rate * left_now
        if place != CENTRE:
            out[0, i, 2] = joints[i, 2] + turned * right
            out[1, i, 2] = rate * right_now


@kernel
def ackermann_paths(
    before: Array,
    after: Array,
    fraction: Array,
    wheel_radius: Column,
    wheelbase: Column,
    track: Column,
    place: int,
    out: Array,
) -> None:
    """Displacements of cars at fractions (N, 1) of a step, into `out` (N, 3)."""
    for i in range(before.shape[0]):
        skew = 0.5 * track[i, 0] / wheelbase[i, 0]
        f = fraction[i, 0]
        way = _way(before[i], after[i], skew, place) * wheel_radius[i, 0] * f
        end = before[i, 0] + (after[i, 0] - before[i, 0]) * f
        out[i, 0], out[i, 1], out[i, 2] = _steered_path(way, before[i, 0], end, wheelbase[i, 0], False)


@kernel
def ackermann_stops(
    before: Array, after: Array, fraction: Array, wheelbase: Column, track: Column, place: int, out: Array
) -> None:
    """Joints of cars that stop at fractions (N, 1) of a step, into `out` (N, j): wheels at the angles of that place.

    In a step in which the steering moves, a wheel does not roll evenly while the base does.
    """
    for i in range(before.shape[0]):
        skew = 0.5 * track[i, 0] / wheelbase[i, 0]
        f = fraction[i, 0]
        start = before[i, 0]
        whole = after[i, 0]
        end = start + (whole - start) * f
        out[i, 0] = end
        if place == CENTRE:
            out[i, 1] = before[i, 1] + (after[i, 1] - before[i, 1]) * f
            continue
        left_part, right_part = _wheel_ways(start, end, skew, place)
        left_whole, right_whole = _wheel_ways(start, whole, skew, place)
        if place == FRONT:
            out[i, 1] = before[i, 1] + (after[i, 1] - before[i, 1]) * (f * (left_part / left_whole))
            out[i, 2] = before[i, 2] + (after[i, 2] - before[i, 2]) * (f * (right_part / right_whole))
            continue
        # The mean of both goes evenly; their difference as the curve has it, and what is beyond that evenly.
        way = _way(before[i], after[i], skew, place)
        left = (after[i, 1] - before[i, 1]) - way * left_whole
        out[i, 1] = before[i, 1] + f * (way * left_part + left)
        out[i, 2] = before[i, 2] + f * (way * right_part - left)


@kernel
def ackermann_travel(
    before: Array, after: Array, wheel_radius: Column, wheelbase: Column, track: Column, place: int, out: Array
) -> None:
    """Bounds on the paths of cars in a step, into `out` (N, 2): way [m] and turning [rad], at their fastest."""
    for i in range(before.shape[0]):
        skew = 0.5 * track[i, 0] / wheelbase[i, 0]
        way = abs(_way(before[i], after[i], skew, place) * wheel_radius[i, 0])
        out[i, 0] = way
        out[i, 1] = way / wheelbase[i, 0] * max(abs(math.tan(before[i, 0])), abs(math.tan(after[i, 0])))


@kernel
def ackermann_commands(
    twists: Array, joints: Array, wheel_radius: Column, wheelbase: Column, steering_max: Column, out: Array
) -> None:
    """Steering [rad] and rate of the wheels [rad/s] of cars for `twists` (N, 3), into `out` (N, 2).

    At rest the steering goes where a turn would need it, or stays.
    """
    for i in range(twists.shape[0]):
        most = steering_max[i, 0]
        forward = twists[i, 0]
        turn = twists[i, 2]
        if forward != 0.0:
            steering = math.atan(wheelbase[i, 0] * turn / forward)
        elif turn != 0.0:
            steering = math.copysign(most, turn)
        else:
            steering = joints[i, 0]
        out[i, 0] = min(max(steering, -most), most)
        out[i, 1] = forward / wheel_radius[i, 0]


@kernel
def ackermann_wheels(steering: Array, wheelbase: Column, track: Column, out: Array) -> None:
    """Angles [rad] of the left and the right front wheel, into `out` (N, 2), for `steering` (N, 1) of the middle."""
    for i in range(steering.shape[0]):
        t = math.tan(steering[i, 0])
        skew = 0.5 * track[i, 0] / wheelbase[i, 0]
        out[i, 0] = math.atan(t / (1.0 - skew * t))
        out[i, 1] = math.atan(t / (1.0 + skew * t))


@kernel
def tricycle_advance(
    joints: Array,
    rates: Array,
    command: Array,
    steering_max: Column,
    steering_rate: Column,
    steering_lag: Column,
    rate_max: Column,
    acceleration_max: Column,
    lag: Column,
    dt: float,
    out: Array,
) -> None:
    """Joints and rates of tricycles a step later, into `out` (2, N, 2); the command is (steering, front wheel)."""
    for i in range(joints.shape[0]):
        target, mean, end = _steer(
            joints[i, 0], command[i, 0], steering_max[i, 0], steering_rate[i, 0], steering_lag[i, 0], dt, out[:, i, 0]
        )
        # The slower the farther the steering is off: else it sets off in the direction of a moment ago.
        rate, turned = rates[i, 1], 0.0
        waits = dt * _waits(target - joints[i, 0], target - end)
        if waits > 0.0:
            rate, turned = respond(rate, 0.0, acceleration_max[i, 0], lag[i, 0], waits)
        if waits < dt:
            error = target - mean if waits == 0.0 else 0.5 * (_WAITS + abs(target - end))
            wheel = min(max(command[i, 1], -rate_max[i, 0]), rate_max[i, 0]) * (1.0 - abs(error) / _WAITS)
            rate, more = respond(rate, wheel, acceleration_max[i, 0], lag[i, 0], dt - waits)
            turned += more
        out[0, i, 1] = joints[i, 1] + turned
        out[1, i, 1] = rate


@kernel
def tricycle_paths(
    before: Array, after: Array, fraction: Array, wheel_radius: Column, wheelbase: Column, out: Array
) -> None:
    """Displacements of tricycles at fractions (N, 1) of a step, into `out` (N, 3)."""
    for i in range(before.shape[0]):
        f = fraction[i, 0]
        way = (after[i, 1] - before[i, 1]) * wheel_radius[i, 0] * f
        end = before[i, 0] + (after[i, 0] - before[i, 0]) * f
        out[i, 0], out[i, 1], out[i, 2] = _steered_path(way, before[i, 0], end, wheelbase[i, 0], True)


@kernel
def tricycle_commands(
    twists: Array, joints: Array, wheel_radius: Column, wheelbase: Column, steering_max: Column, out: Array
) -> None:
    """Steering [rad] and rate of the front wheel [rad/s] of tricycles for `twists` (N, 3), into `out` (N, 2).

    Where the steering cannot go as far as it should, it goes to its end, and the wheel at the rate that brings its
    velocity nearest to the wanted one. At rest it stays.
    """
    for i in range(twists.shape[0]):
        ahead = twists[i, 0]
        aside = twists[i, 2] * wheelbase[i, 0]  # the front wheel's velocity
        sign = -1.0 if ahead < 0.0 else 1.0
        wanted = math.atan2(sign * aside, sign * ahead)
        steering = min(max(wanted, -steering_max[i, 0]), steering_max[i, 0])
        speed = math.sqrt(ahead * ahead + aside * aside) * math.cos(wanted - steering)
        out[i, 0] = steering if speed != 0.0 else joints[i, 0]
        out[i, 1] = sign * speed / wheel_radius[i, 0]
