"""A motor that follows commands: a first-order lag and a limit on change, exact for any length of step."""

from __future__ import annotations

import math

from amorsim.kernels.compile import kernel

__all__ = ["respond"]


@kernel
def respond(value: float, target: float, limit: float, lag: float, dt: float) -> tuple[float, float]:
    """A quantity `dt` [s] later, and its integral over that time.

    It follows ``value' = (target - value) / lag``, no faster than `limit`: a ramp while the target is far, then an
    exponential. Solved in closed form, so that two steps of half the length end where one does. `limit` may be inf,
    `lag` [s] 0.
    """
    error = target - value
    size = abs(error)
    near = limit * lag if lag > 0.0 else 0.0  # so far from the target the ramp ends
    ramp = (size - near) / limit if size > near else 0.0
    if ramp >= dt:
        change = math.copysign(limit * dt, error)
        return value + change, (value + 0.5 * change) * dt
    if lag == 0.0:
        return target, target * dt - 0.5 * error * ramp
    left = math.copysign(min(size, near), error)
    rest = dt - ramp
    ramped = 0.5 * (value + target - left) * ramp if ramp > 0.0 else 0.0
    return target - left * math.exp(-rest / lag), ramped + target * rest + left * lag * math.expm1(-rest / lag)
