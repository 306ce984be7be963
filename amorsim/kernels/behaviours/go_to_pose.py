"""Going to a pose: turn towards it, drive there, turn to its heading."""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel
from amorsim.kernels.kinematics.actuation import respond
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["approach", "head_for"]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

_ALIGNED = 0.01  # [rad] a robot that stands, and gathers speed slowly, sets off with no larger error
_STILL = 0.1  # of the tolerance of a place: a robot that comes no farther by its motors' lag stands
_STEERING_TIME = 1.0  # [s] in which such a robot puts its heading right as it drives


@kernel
def approach(error: float, limit: float, braking: float, dt: float) -> float:
    """A rate that removes an error without overshoot: all of it in this step, or what can be stopped."""
    size = abs(error)
    most = size / dt
    if math.isfinite(braking):
        # What is driven in this step, and then at half of the braking there is, adds up to the error.
        half = 0.5 * braking
        most = half * (math.sqrt(dt * dt + 2.0 * size / half) - dt)
    return math.copysign(min(most, limit), error)


@kernel
def head_for(
    pose: Array,
    goal: Array,
    speed: Column,
    turn_rate: Column,
    tolerance: Array,
    limits: Array,
    lag: Array,
    dt: float,
    moving: Array,
    turning: Array,
    out: Array,
) -> None:
    """Twists towards goals and whether they are reached, into `out` (N, 4): forward, left, turn, 1 or 0.

    Motors with a lag T go on after a command: at a speed v by v T, if the command is 0 from now on. A command u for one
    step adds u dt to that. So errors are reckoned from where the robot would come without another command.

    Parameters
    ----------
    pose
        Where the robots believe to be, (N, 3).
    goal
        x [m], y [m] and heading [rad], nan for any heading, (N, 3).
    speed, turn_rate
        Fastest [m/s] and [rad/s], each (N, 1).
    tolerance
        Distance [m] within which a place counts as reached, error [rad] within which its heading does, and
        error [rad] beyond which the bearing of a goal is put right in place and not on the way, (N, 3).
    limits
        Of the drive: speed, turn, and how fast each changes, (N, 4).
    lag
        Of its motors [s], (N, 1).
    moving, turning
        Speed [m/s] and turn [rad/s] of the robots now, by their own reckoning, in the first column; changed.
    """
    for i in range(pose.shape[0]):
        fastest = min(speed[i, 0], limits[i, 0])
        turn_fastest = min(turn_rate[i, 0], limits[i, 1])
        dx = goal[i, 0] - pose[i, 0]
        dy = goal[i, 1] - pose[i, 1]
        distance = math.sqrt(dx * dx + dy * dy)
        v = 0.0
        w = 0.0
        reached = 0.0
        braking = limits[i, 2] * dt
        # With limits on how fast wheels change, turning begins when the robot stands: else it would drift aside.
        ahead = moving[i, 0] * lag[i, 0]
        coming = turning[i, 0] * lag[i, 0]
        still = moving[i, 0] == 0.0 or 0.0 < abs(ahead) <= _STILL * tolerance[i, 0]
        stands = still or (math.isinf(braking) and lag[i, 0] == 0.0)
        if distance <= tolerance[i, 0] and not stands:
            pass
        elif distance <= tolerance[i, 0]:
            error = wrap(goal[i, 2] - pose[i, 2])
            if math.isnan(error) or (abs(error) <= tolerance[i, 1] and abs(coming) <= tolerance[i, 1]):
                reached = 1.0
            else:
                w = approach(error - coming, turn_fastest, limits[i, 3], dt)
        else:
            error = wrap(math.atan2(dy, dx) - pose[i, 2])
            turn_first = tolerance[i, 2]
            if still and not math.isinf(braking):
                turn_first = min(turn_first, _ALIGNED)
            if abs(error) > turn_first:
                if stands:
                    w = approach(error - coming, turn_fastest, limits[i, 3], dt)
            else:
                v = approach(max(distance - ahead, 0.0), fastest, limits[i, 2], dt)
                if math.isinf(braking):
                    w = approach(error - coming, turn_fastest, limits[i, 3], dt)
                else:
                    # Wheels that speed up as fast as they can do not steer: half of what they can is kept for that.
                    v = min(v, moving[i, 0] + 0.5 * braking)
                    w = min(max((error - coming) / max(_STEERING_TIME, 4.0 * dt), -turn_fastest), turn_fastest)
        if lag[i, 0] > 0.0:
            moving[i, 0], _ = respond(moving[i, 0], v, limits[i, 2], lag[i, 0], dt)
            turning[i, 0], _ = respond(turning[i, 0], w, limits[i, 3], lag[i, 0], dt)
        else:
            moving[i, 0] = min(max(v, moving[i, 0] - braking), moving[i, 0] + braking)
        out[i, 0] = v
        out[i, 1] = 0.0
        out[i, 2] = w
        out[i, 3] = reached
