"""The motion of the wheels as estimators predict with it: a nominal drive's displacement, and the doubt in it."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import Drive, Joint, Measurement, RobotModel
from amorsim.core.errors import ComponentError, did_you_mean
from amorsim.core.execution.workers import in_turn
from amorsim.kernels.kinematics import odometry, poses
from amorsim.kernels.number_checks import has_nan

__all__ = [
    "Counted",
    "Reckoned",
    "Step",
    "angles_of",
    "bind_angles",
    "bind_differences",
    "bind_readings",
    "bind_step",
    "carry",
    "check_encoder",
    "check_keeps_up",
    "is_current",
    "reckon",
    "sensor_of",
    "step_of",
]


_FAR = 1e12  # [rad] further than any wheel turns; squares of lengths beyond soon overflow
_LEAP = 1e4  # [rad] more than any wheel turns between two readings: over a thousand turns
_NUDGE = 1e-5  # [rad] by which a joint is turned to find the body's motion; the error is of second order in it


@functools.cache
def _rolling(joints: tuple[Joint, ...]) -> Ints:
    return np.array([i for i, joint in enumerate(joints) if joint.rolls], dtype=np.int64)


def _bind_jacobian(drive: Drive, before: Array, after: Array, radius: Array, out: Array) -> Callable[[], None]:
    """A function that writes the body's motion per metre of travel of each rolling joint into `out` `(N, 3, r)`."""
    offered: Any = getattr(drive, "jacobian", None)
    if offered is not None:
        return lambda: np.copyto(out, offered(before, after))
    return bind_differences(drive, before, after, radius, out)


def bind_differences(drive: Drive, before: Array, after: Array, radius: Array, out: Array) -> Callable[[], None]:
    """A function that writes the body's motion (forward, left, turn) per metre of each rolling joint's travel.

    It turns each joint a little, halfway between `before` and `after` `(N, j)`, and writes into `out` `(N, 3, r)`;
    `radius` `(N, r)` [m/rad] is that of the joints that roll.
    """
    middle, turned, moved = np.empty_like(before), np.empty((2, *before.shape)), np.empty((2, len(before), 3))
    displace = [drive.bind_displacement(middle, turned[side], moved[side]) for side in (0, 1)]
    calls: list[Callable[[], None]] = []
    for number, joint in enumerate(_rolling(drive.joints).tolist()):
        calls.append(functools.partial(odometry.turn_joint, before, after, joint, _NUDGE, middle, *turned))
        calls += displace
        calls.append(functools.partial(odometry.difference_quotients, moved[0], moved[1], _NUDGE, radius, number, out))
    return in_turn(calls)


class Step(NamedTuple):
    """The displacements of N robots by their nominal drives, and how errors of the rolling joints add to them."""

    displacement: Array  # (N, 3)
    twist: Array  # (N, 3)
    jacobian: Array  # (N, 3, r)
    before: Array  # (N, j) joints
    after: Array  # (N, j)
    rolling: Ints  # (r,) which of the joints
    radius: Array  # (N, r) [m]


class Reckoned(NamedTuple):
    """The poses of N robots after their joints have moved."""

    pose: Array  # (N, 3)
    covariance: Array  # (N, 3, 3)
    turn: Array  # (N, 1) [rad] over the motion


def bind_step(drive: Drive, before: Array, after: Array) -> tuple[Step, Callable[[], None]]:
    """The motion as the joints `(N, j)` of a nominal drive move, and a function that computes it from the joints."""
    rows, rolling = len(after), _rolling(drive.joints)
    radius = np.ascontiguousarray(drive.rolling_radius())
    displacement, twist, jacobian = np.empty((rows, 3)), np.empty((rows, 3)), np.empty((rows, 3, len(rolling)))
    if drive.goes_on_arcs:
        move: Callable[[], None] = functools.partial(poses.exponential, twist, np.ones((rows, 1)), displacement)
    else:
        move = drive.bind_displacement(before, after, displacement)
    calls = [drive.bind_twist(before, after, twist), move, _bind_jacobian(drive, before, after, radius, jacobian)]
    return Step(displacement, twist, jacobian, before, after, rolling, radius), in_turn(calls)


def step_of(drive: Drive, before: Array, after: Array) -> Step:
    """The motion as the joints `(N, j)` of a nominal drive move.

    Joints that are nan, as `angles_of` gives before the first reading, have not moved.
    """
    if has_nan(after.ravel()):
        before, after = np.nan_to_num(before), np.nan_to_num(after)
    step, compute = bind_step(drive, before, after)
    compute()
    return step


def carry(step: Step, pose: Array, covariance: Array, variance: Any) -> Reckoned:
    """Poses and covariances after a step from them, to first order.

    White noise on the travel of each rolling joint widens the covariance, by `variance` `(N, 1)` [m^2/m].
    """
    rows = len(step.after)
    found = Reckoned(np.empty((rows, 3)), np.empty((rows, 3, 3)), step.twist[:, 2:])
    odometry.reckon(pose, covariance, *step, variance, found.pose, found.covariance)
    return found


def reckon(drive: Drive, pose: Array, covariance: Array, before: Array, after: Array, variance: Any) -> Reckoned:
    """Poses and covariances after the nominal drive's joints have moved: `carry` by `step_of`."""
    return carry(step_of(drive, before, after), pose, covariance, variance)


def sensor_of(who: str, robot: RobotModel, name: str, field: str, kind: str) -> Any:
    """The sensor of a robot's model that a field of an estimator names.

    Raises
    ------
    ComponentError
        If the robot has no such sensor.
    """
    sensors = robot.sensors
    if name not in sensors:
        names = ", ".join(repr(known) for known in sensors) or "none"
        raise ComponentError(
            f"{who} reads the sensor {name!r}, which the robot does not have; its sensors: {names}."
            f"{did_you_mean(name, sensors)} Name the robot's {kind} in the field {field!r}."
        )
    return sensors[name].sensor


def check_encoder(who: str, robot: RobotModel, name: str) -> None:
    """Raise a `ComponentError` if the robot has no such sensor, or one that counts no joints."""
    sensor = sensor_of(who, robot, name, "encoder", "encoder")
    if not callable(getattr(sensor, "angles", None)):
        raise ComponentError(
            f"{who} reads the sensor {name!r}, but a {type(sensor).__name__} counts no "
            "joints: it has no method angles(values). Name the robot's encoder in the field 'encoder'."
        )


def check_keeps_up(who: str, robot: RobotModel, encoder: str, laser: str) -> None:
    """Raise a `ComponentError` if a row's laser may read in a step in which its encoder does not."""
    are_alike = not (robot.sensors[encoder].rates or robot.sensors[laser].rates)
    for row in range(1 if are_alike else robot.rows):
        # A sensor reads at the first tick at or after each multiple of its period.
        counts, scans = _rate(robot, encoder, row), _rate(robot, laser, row)
        keeps_up = counts * robot.dt > 1.0 - 1e-9 or abs(counts / scans - round(counts / scans)) < 1e-9
        if not keeps_up:
            whose = "" if are_alike else f" on {robot.who(row)}"
            raise ComponentError(
                f"{who} lays scans of {laser!r} where the sensor {encoder!r} says that the robot is, but that one "
                f"reads at {counts:g} Hz and {laser!r} at {scans:g} Hz{whose}; give {encoder!r} no rate, or a multiple "
                "of the other's"
            )


def _rate(robot: RobotModel, name: str, row: int) -> float:
    """How often a row's sensor reads [Hz], at most in every step."""
    rate, most = robot.sensors[name].rate_of(row), 1.0 / robot.dt
    return most if rate is None else min(rate, most)


def angles_of(robot: RobotModel, encoder: str, measured: Array, joints: Array) -> tuple[Array, Array]:
    """Angles `(N, j)` [rad] of the joints at the last reading and at this one; `joints` is nan before the first.

    A reading of nan, or of angles that no wheel can have turned, is none: the joints stand until the next one, which
    shows all that they have moved since. Where counts have leapt further than wheels turn from one reading to the next,
    nobody knows what moved: nothing has, and the reading is the new reference.
    """
    before, after = np.empty(joints.shape), np.empty(joints.shape)
    angles = _angles(robot, encoder, measured, joints.shape)
    odometry.joints_between(joints, angles, _FAR, _LEAP, before, after)
    return before, after


def _angles(robot: RobotModel, encoder: str, measured: Array, shape: tuple[int, ...]) -> Array:
    """The angles of the drive's joints `(N, j)` [rad] that an encoder's reading shows."""
    sensor: Any = robot.sensors[encoder].sensor
    angles = np.ascontiguousarray(sensor.angles(measured), dtype=np.float64)
    if angles.shape != shape:  # the kernel would read beyond them
        raise ComponentError(
            f"sensor {encoder!r} ({type(sensor).__name__}): expected the angles of the drive's joints from angles(), "
            f"an array {shape} [rad], got one of the shape {angles.shape}"
        )
    return angles


def bind_angles(
    robot: RobotModel, encoder: str, measured: Array, joints: Array
) -> tuple[Array, Array, Callable[[], None]]:
    """As `angles_of`, with arrays that a function writes; it updates `joints`, and those that are nan become 0."""
    before, after = np.empty(joints.shape), np.empty(joints.shape)

    def take() -> None:
        angles = _angles(robot, encoder, measured, joints.shape)
        odometry.take_angles(joints, angles, _FAR, _LEAP, before, after)

    return before, after, take


class Counted(NamedTuple):
    """Rows `(N, 1)` whose wheels may be compared with what else is measured; see `odometry.take_readings`."""

    taken: Bools
    current: Bools
    follows: Bools


def bind_readings(
    robot: RobotModel, encoder: str, reading: Measurement, joints: Array, counted: Counted
) -> tuple[Array, Array, Callable[[], None]]:
    """As `bind_angles`, and the function writes into `counted`."""
    before, after = np.empty(joints.shape), np.empty(joints.shape)

    def take() -> None:
        angles = _angles(robot, encoder, reading.measured, joints.shape)
        odometry.take_readings(joints, angles, reading.fresh, _FAR, _LEAP, before, after, *counted)

    return before, after, take


def is_current(robot: RobotModel, encoder: str, reading: Measurement, after: Array, was: Bools) -> Bools:
    """Whether a pose that the joints `after` have moved is where the robot is `(N, 1)`; no other may be corrected.

    Where a new reading of the encoder is lost, the wheels have moved by what the next one will show. Until then the
    pose is not current. Without a new reading it is what it `was` `(N, 1)` in the update before, and at the start it is
    current. An estimator calls this in every update.
    """
    sensor: Any = robot.sensors[encoder].sensor
    is_taken = reading.fresh & (sensor.angles(reading.measured) == after).all(axis=1, keepdims=True)
    return np.where(reading.fresh, is_taken, was)
