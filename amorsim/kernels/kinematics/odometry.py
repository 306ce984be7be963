"""Wheels and the poses they lead to: two driven wheels on an axle, and how the doubt in a pose grows."""

from __future__ import annotations

import math
from typing import Any

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.actuation import respond
from amorsim.kernels.kinematics.poses import compose

__all__ = [
    "difference_quotients",
    "drive_wheels",
    "joints_between",
    "reckon",
    "take_angles",
    "take_readings",
    "turn_joint",
    "wheel_jacobian",
    "wheel_rates",
    "wheel_twists",
]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any

# Gauss and Legendre's nodes and weights on [0, 1]: exact for polynomials of degree 7. Along a straight step
# the integrand of `_grow_row` is of degree 2; on an arc of a [rad] a step the error is about 1e-7 * a**8
# of the value.
_NODES = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)
_WEIGHTS = (0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692)

_SMALL = 1e-3  # [rad] below this the series' first left-out term, a**6/5040, is under 1e-21


@kernel
def drive_wheels(
    joints: Array,
    rates: Array,
    command: Array,
    rate_max: Column,
    acceleration_max: Column,
    lag: Column,
    dt: float,
    out: Array,
) -> None:
    """Wheels a step later, into `out` (2, N, w): angles [rad] and rates [rad/s].

    A command `(N, w)` [rad/s] beyond `rate_max` (N, 1) is scaled down as a whole, which keeps the path's
    curvature; then each wheel follows by itself (`amorsim.kernels.kinematics.actuation.respond`), its rate changing by
    `acceleration_max` (N, 1) [rad/s^2] at most (inf for no limit), and with a `lag` (N, 1) [s].
    """
    for i in range(joints.shape[0]):
        most = rate_max[i, 0]
        fastest = 0.0
        for j in range(joints.shape[1]):
            fastest = max(fastest, abs(command[i, j]))
        scale = most / fastest if fastest > most else 1.0
        for j in range(joints.shape[1]):
            target = min(max(command[i, j] * scale, -most), most)
            rate, turned = respond(rates[i, j], target, acceleration_max[i, 0], lag[i, 0], dt)
            out[0, i, j] = joints[i, j] + turned
            out[1, i, j] = rate


@kernel
def joints_between(last: Array, angles: Array, far: float, leap: float, before: Array, after: Array) -> None:
    """Angles of joints [rad] at the last reading and at this one, into `before` and `after` (N, j).

    `last` (N, j) is nan before the first reading, which is then the reference of all others. Where any of the new
    `angles` (N, j) of a row is not within `far`, the row's joints stand; where one is more than `leap` from the last,
    they have not moved from the new ones.
    """
    for i in range(last.shape[0]):
        counts = True
        for j in range(last.shape[1]):
            counts &= abs(angles[i, j]) < far
        leapt = False
        for j in range(last.shape[1]):
            after[i, j] = angles[i, j] if counts else last[i, j]
            before[i, j] = after[i, j] if math.isnan(last[i, j]) else last[i, j]
            leapt |= abs(after[i, j] - before[i, j]) > leap
        for j in range(last.shape[1]):
            before[i, j] = after[i, j] if leapt else before[i, j]


@kernel
def take_angles(last: Array, angles: Array, far: float, leap: float, before: Array, after: Array) -> None:
    """As `joints_between`, and the present angles become `last`; joints without a reading so far are at 0 twice."""
    joints_between(last, angles, far, leap, before, after)
    for i in range(last.shape[0]):
        for j in range(last.shape[1]):
            last[i, j] = after[i, j]
            if math.isnan(after[i, j]):
                after[i, j] = 0.0
            if math.isnan(before[i, j]):
                before[i, j] = 0.0


@kernel
def take_readings(
    last: Array,
    angles: Array,
    fresh: Bools,
    far: float,
    leap: float,
    before: Array,
    after: Array,
    taken: Bools,
    current: Bools,
    follows: Bools,
) -> None:
    """As `take_angles`, and write of each row (N, 1) what may be compared with the motion between the readings.

    Parameters
    ----------
    fresh
        Whether the reading is new.
    taken
        Gets whether it is new and shows the joints.
    current
        Gets whether the joints are where they are now: of a row without a new reading, what it was.
    follows
        Gets whether the joints moved from a reading that was taken in the step before to one that is taken now.
    """
    joints_between(last, angles, far, leap, before, after)
    for i in range(last.shape[0]):
        shows = fresh[i, 0]
        goes_on = True
        for j in range(last.shape[1]):
            shows &= angles[i, j] == after[i, j]
            goes_on &= before[i, j] == last[i, j]
            last[i, j] = after[i, j]
            if math.isnan(after[i, j]):
                after[i, j] = 0.0
            if math.isnan(before[i, j]):
                before[i, j] = 0.0
        follows[i, 0] = shows and taken[i, 0] and goes_on
        taken[i, 0] = shows
        if fresh[i, 0]:
            current[i, 0] = shows


@kernel
def wheel_twists(
    before: Array, after: Array, radius_left: Column, radius_right: Column, track: Column, out: Array
) -> None:
    """Motion (forward [m], left [m], turn [rad]) into `out` (N, 3) as a left and a right wheel turn.

    `before` and `after` are the wheels' angles (N, 2) [rad]; radii and track [m] are (N, 1).
    """
    for i in range(before.shape[0]):
        left = (after[i, 0] - before[i, 0]) * radius_left[i, 0]
        right = (after[i, 1] - before[i, 1]) * radius_right[i, 0]
        out[i, 0] = 0.5 * (left + right)
        out[i, 1] = 0.0
        out[i, 2] = (right - left) / track[i, 0]


@kernel
def turn_joint(before: Array, after: Array, joint: int, angle: float, middle: Array, back: Array, ahead: Array) -> None:
    """Joints halfway through a step, into `middle` (N, j), and with one of them turned by `angle` [rad] either way."""
    for i in range(middle.shape[0]):
        for j in range(middle.shape[1]):
            middle[i, j] = 0.5 * (before[i, j] + after[i, j])
            back[i, j] = middle[i, j]
            ahead[i, j] = middle[i, j]
        back[i, joint] -= angle
        ahead[i, joint] += angle


@kernel
def difference_quotients(back: Array, ahead: Array, angle: float, radius: Array, number: int, out: Array) -> None:
    """The body's motion per metre of travel of rolling joint `number`, into ``out[:, :, number]``, `out` (N, 3, r).

    `back` and `ahead` (N, 3) are its displacements as the joint, of `radius` (N, r) [m], turns by `angle` [rad] either
    way. Both are given in one frame, so the errors of first order cancel.
    """
    for i in range(out.shape[0]):
        for k in range(3):
            out[i, k, number] = (ahead[i, k] - back[i, k]) / (2.0 * angle * radius[i, number])


@kernel
def wheel_jacobian(track: Column, out: Array) -> None:
    """Motion (forward, left, turn) per metre of travel of a left and a right wheel, into `out` (N, 3, 2)."""
    for i in range(out.shape[0]):
        for side in range(2):
            out[i, 0, side] = 0.5
            out[i, 1, side] = 0.0
        out[i, 2, 0] = -1.0 / track[i, 0]
        out[i, 2, 1] = 1.0 / track[i, 0]


@kernel
def wheel_rates(twists: Array, radius_left: Column, radius_right: Column, track: Column, out: Array) -> None:
    """Rates [rad/s] of a left and a right wheel at which the body moves with `twists`, into `out` (N, 2).

    The inverse of `wheel_twists` for `twists` (N, 3) in m/s and rad/s. The part to the left cannot be met, and
    is left out.
    """
    for i in range(twists.shape[0]):
        across = 0.5 * twists[i, 2] * track[i, 0]
        out[i, 0] = (twists[i, 0] - across) / radius_left[i, 0]
        out[i, 1] = (twists[i, 0] + across) / radius_right[i, 0]


@kernel
def _along_arc(forward: float, left: float, turn: float) -> tuple[float, float]:
    """The displacement (x, y) [m] by a constant twist, in the frame at its start."""
    if abs(turn) < _SMALL:
        square = turn * turn
        along = 1.0 - square / 6.0 * (1.0 - square / 20.0)
        across = turn / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0))
    else:
        half = math.sin(0.5 * turn)
        along = math.sin(turn) / turn
        across = 2.0 * half * half / turn
    return forward * along - left * across, forward * across + left * along


@part
def _grow_row(
    covariance: Array,
    heading: float,
    forward: float,
    left: float,
    turn: float,
    jacobian: Array,
    before: Array,
    after: Array,
    rolling: Ints,
    radius: Array,
    variance: float,
    out: Array,
) -> None:
    """The covariance of `reckon` for one row."""
    end_x, end_y = _along_arc(forward, left, turn)
    xx = 0.0
    xy = 0.0
    yy = 0.0
    xt = 0.0
    yt = 0.0
    tt = 0.0
    for node in range(4):
        u = _NODES[node]
        x, y = _along_arc(forward * u, left * u, turn * u)
        c = math.cos(turn * u)
        s = math.sin(turn * u)
        for j in range(rolling.shape[0]):
            joint = rolling[j]
            travel = abs((after[joint] - before[joint]) * radius[j])
            weight = _WEIGHTS[node] * variance * travel
            ahead = jacobian[0, j]
            aside = jacobian[1, j]
            gt = jacobian[2, j]
            # Turning by gt here swings the end about this point.
            gx = c * ahead - s * aside - gt * (end_y - y)
            gy = s * ahead + c * aside + gt * (end_x - x)
            xx += weight * gx * gx
            xy += weight * gx * gy
            yy += weight * gy * gy
            xt += weight * gx * gt
            yt += weight * gy * gt
            tt += weight * gt * gt

    c = math.cos(heading)
    s = math.sin(heading)
    # An error e of the heading before moves the end by e * (swing_x, swing_y).
    swing_x = -(s * end_x + c * end_y)
    swing_y = c * end_x - s * end_y
    p_xt = covariance[0, 2]
    p_yt = covariance[1, 2]
    p_tt = covariance[2, 2]
    out[0, 0] = covariance[0, 0] + swing_x * (2.0 * p_xt + swing_x * p_tt)
    out[0, 1] = covariance[0, 1] + swing_y * p_xt + swing_x * p_yt + swing_x * swing_y * p_tt
    out[1, 1] = covariance[1, 1] + swing_y * (2.0 * p_yt + swing_y * p_tt)
    out[0, 2] = p_xt + swing_x * p_tt
    out[1, 2] = p_yt + swing_y * p_tt
    out[2, 2] = p_tt + tt
    out[0, 0] += c * (c * xx - s * xy) - s * (c * xy - s * yy)
    out[0, 1] += s * (c * xx - s * xy) + c * (c * xy - s * yy)
    out[1, 1] += s * (s * xx + c * xy) + c * (s * xy + c * yy)
    out[0, 2] += c * xt - s * yt
    out[1, 2] += s * xt + c * yt
    out[1, 0] = out[0, 1]
    out[2, 0] = out[0, 2]
    out[2, 1] = out[1, 2]


@kernel
def reckon(
    poses: Column,
    covariance: Column,
    displacements: Array,
    twists: Array,
    jacobian: Array,
    before: Array,
    after: Array,
    rolling: Ints,
    radius: Array,
    variance: Column,
    poses_out: Array,
    covariance_out: Array,
) -> None:
    """Poses after a step, into `poses_out` (N, 3), and their covariance, to first order, into `covariance_out`.

    White noise acts on the travel of every rolling joint all along the step: where it acts, it displaces the
    body by the `jacobian`, and what is left of the step carries that on. Integrated over the step instead of
    lumped at one point of it, so the result does not depend on how many steps a path of constant curvature is
    cut into.

    Parameters
    ----------
    poses, covariance
        Before the step, (N, 3) and (N, 3, 3).
    displacements, twists
        The body's motion over the step: where it ends in its frame at the start, and along which arc, (N, 3).
    jacobian
        The body's motion (forward, left, turn) per metre of travel of each rolling joint, (N, 3, r).
    before, after
        Joints (N, j) [rad].
    rolling
        Which of the joints roll, (r,).
    radius
        Travel per radian of these, (N, r) [m].
    variance
        Of the travel, per metre of it, (N, 1) [m^2/m].
    """
    for i in range(covariance.shape[0]):
        _grow_row(
            covariance[i],
            poses[i, 2],
            twists[i, 0],
            twists[i, 1],
            twists[i, 2],
            jacobian[i],
            before[i],
            after[i],
            rolling,
            radius[i],
            variance[i, 0],
            covariance_out[i],
        )
    compose(poses, displacements, poses_out)
