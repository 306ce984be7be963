"""Wheels that steer and roll together under a body that need not turn with them."""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel
from amorsim.kernels.kinematics.actuation import respond
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["DRIVEN", "FIXED", "FOLLOWS", "courses", "synchro_advance", "synchro_commands", "synchro_paths"]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

# How the body turns: never, with the wheels, or by a motor of its own (the third joint).
FIXED = 0
FOLLOWS = 1
DRIVEN = 2

_STEERING_TIME = 0.5  # [s] in which wheels that point elsewhere are brought round


@kernel
def _course(joints: Array, turret: int) -> float:
    if turret == FOLLOWS:
        return 0.0
    return float(joints[0] - joints[2]) if turret == DRIVEN else float(joints[0])


@kernel
def synchro_advance(
    joints: Array,
    rates: Array,
    command: Array,
    steering_max: Column,
    rate_max: Column,
    turret_max: Column,
    spin: Column,
    acceleration: Column,
    lag: Column,
    dt: float,
    out: Array,
) -> None:
    """Joints and rates a step later, into `out` (2, N, j): of steering, wheels and perhaps a turret.

    If the command of steering or wheels is too fast, both are scaled down, which keeps the curvature of the path.
    `spin` limits how fast the rates of steering and turret change, `acceleration` that of the wheels.
    """
    for i in range(joints.shape[0]):
        over = max(abs(command[i, 0]) / steering_max[i, 0], abs(command[i, 1]) / rate_max[i, 0])
        scale = 1.0 / over if over > 1.0 else 1.0
        for j in range(joints.shape[1]):
            most = turret_max[i, 0]
            if j < 2:
                most = steering_max[i, 0] if j == 0 else rate_max[i, 0]
            target = min(max(command[i, j] * (scale if j < 2 else 1.0), -most), most)
            limit = acceleration[i, 0] if j == 1 else spin[i, 0]
            rate, turned = respond(rates[i, j], target, limit, lag[i, 0], dt)
            out[0, i, j] = joints[i, j] + turned
            out[1, i, j] = rate


@kernel
def synchro_paths(before: Array, after: Array, fraction: Array, wheel_radius: Column, turret: int, out: Array) -> None:
    """Displacements at fractions (N, 1) of a step, into `out` (N, 3): the direction turns evenly as the wheels roll."""
    for i in range(before.shape[0]):
        f = fraction[i, 0]
        turned = (after[i, 0] - before[i, 0]) * f
        half = 0.5 * turned
        chord = (after[i, 1] - before[i, 1]) * wheel_radius[i, 0] * f
        if half != 0.0:
            chord *= math.sin(half) / half
        direction = _course(before[i], turret) + half
        out[i, 0] = chord * math.cos(direction)
        out[i, 1] = chord * math.sin(direction)
        if turret == FOLLOWS:
            out[i, 2] = turned
        elif turret == DRIVEN:
            out[i, 2] = (after[i, 2] - before[i, 2]) * f
        else:
            out[i, 2] = 0.0


@kernel
def synchro_commands(twists: Array, joints: Array, wheel_radius: Column, turret: int, out: Array) -> None:
    """Rates [rad/s] of steering, wheels and turret for `twists` (N, 3), into `out` (N, c)."""
    for i in range(twists.shape[0]):
        course = _course(joints[i], turret)
        along = twists[i, 0] * math.cos(course) + twists[i, 1] * math.sin(course)
        across = twists[i, 1] * math.cos(course) - twists[i, 0] * math.sin(course)
        error = 0.0
        if turret == FOLLOWS:
            along = twists[i, 0]  # the body cannot go aside
        elif along != 0.0 or across != 0.0:
            error = math.atan2(across, along)
            if abs(error) > 0.5 * math.pi:  # the wheels roll backwards as well
                error = wrap(error + math.pi)
        out[i, 0] = twists[i, 2] + error / _STEERING_TIME
        out[i, 1] = along / wheel_radius[i, 0]
        if turret == DRIVEN:
            out[i, 2] = twists[i, 2]


@kernel
def courses(joints: Array, turret: int, out: Array) -> None:
    """Directions [rad] of the wheels in the body's frame, into `out` (N, 1)."""
    for i in range(joints.shape[0]):
        out[i, 0] = _course(joints[i], turret)
