"""UMBmark on a robot of a scenario: squares driven both ways round, and the drive's errors from them."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.algorithms.umbmark import (
    ExactFit,
    PublishedFigures,
    WheelGeometry,
    exact_fit,
    published_figures,
    systematic_error,
)
from amorsim.array_types import Array
from amorsim.controllers.square import Square
from amorsim.core.errors import AmorsimError
from amorsim.core.poses import compose, relative
from amorsim.core.rows import stack, take
from amorsim.drives.differential import Differential
from amorsim.scenario.spec import Deviation, Robot, Scenario
from amorsim.simulation.simulation import Simulation
from amorsim.studies.robot_under_test import (
    alone,
    chosen_robot,
    empty_world,
    only_odometry,
    true_value,
    with_settled_errors,
)

__all__ = ["SPEED_MAX", "Squares", "Umbmark", "corrected_scenario", "drive_squares", "fit_squares", "umbmark"]


SPEED_MAX = 0.2  # [m/s] the method's own: faster, wheels slip, and random errors hide the systematic ones
_STANDS = 1e-6  # [rad/s] slower wheels stand: motors with a lag come to rest only in the limit
_PATHS = ("drive.wheel_radius_left", "drive.wheel_radius_right", "drive.track")


@attrs.frozen(kw_only=True, eq=False)
class Squares:
    """Squares that one robot drove one way round.

    Attributes
    ----------
    ends
        Absolute less odometric displacement from start to end (x, y) [m] in the frame of the start, `(n, 2)`.
    angles
        Joint angles from the encoders [rad], at every step, `(T, n, 2)`.
    """

    ends: Array
    angles: Array


@attrs.frozen(kw_only=True, eq=False)
class Umbmark:
    """All results of the method.

    Attributes
    ----------
    clockwise, anticlockwise
        End points `(n, 2)` [m].
    published, exact
        The figures of Borenstein and Feng, and the least-squares fit.
    nominal
        The geometry in the robot's software; `corrected_published` and `corrected` are the corrections by each method.
    error_before, error_after_published, error_after
        E_max,syst [m] with each of the three, driven with the same random draws.
    """

    robot: str
    side: float
    speed: float
    clockwise: Array
    anticlockwise: Array
    published: PublishedFigures
    exact: ExactFit
    nominal: WheelGeometry
    corrected_published: WheelGeometry
    corrected: WheelGeometry
    error_before: float
    error_after_published: float
    error_after: float
    after: tuple[Array, Array]  # end points (n, 2) with `corrected`: clockwise, anticlockwise


def umbmark(
    scenario: Scenario,
    *,
    robot: str | None = None,
    side: float = 4.0,
    speed: float = 0.2,
    runs: int = 5,
    in_its_world: bool = False,
) -> Umbmark:
    """Drive the bidirectional square, and find the drive's errors.

    The robot drives by its odometry, with the scenario's own step (noise may be given per step). Runs are replicas of
    one and the same robot with random draws of their own: errors that replicas draw are those of replica 0.

    Parameters
    ----------
    robot
        Its name; without it, the first.
    side
        Side of the square [m].
    speed
        Its speed [m/s], at most `SPEED_MAX`.
    runs
        Number of runs each way round, at least two; the method's own number is five.
    in_its_world
        Drive on the scenario's map, from the robot's own start, instead of in an empty world.

    Raises
    ------
    AmorsimError
        If the robot has no differential drive or no encoder, a number is out of its bounds, or the robot collides or
        does not reach the end.
    """
    chosen = chosen_robot(scenario, robot)
    drive = _differential(chosen)
    if not 0.0 < speed <= SPEED_MAX:
        raise AmorsimError(f"speed: expected a number > 0 and <= {SPEED_MAX:g} m/s, as the method asks, got {speed!r}")
    if not (0.0 < side < math.inf):
        raise AmorsimError(f"side: expected a number > 0 [m], got {side!r}")
    if runs < 2:
        raise AmorsimError(f"runs: expected 2 at least, for the intervals come from how runs scatter, got {runs!r}")
    go = functools.partial(drive_squares, scenario, side=side, speed=speed, runs=runs, in_its_world=in_its_world)
    clockwise, anticlockwise = go(chosen)
    nominal = WheelGeometry(drive.wheel_radius_left, drive.wheel_radius_right, drive.track)
    published = published_figures(clockwise.ends, anticlockwise.ends, side, nominal.track)
    exact = fit_squares(drive, clockwise, anticlockwise)
    by_published = nominal.corrected(published.mean.ed, published.mean.eb)
    by_fit = nominal.corrected(exact.ed.value, exact.eb.value)
    again_published = go(_with_geometry(chosen, by_published, scenario.seed))
    again = go(_with_geometry(chosen, by_fit, scenario.seed))
    return Umbmark(
        robot=chosen.name,
        side=side,
        speed=speed,
        clockwise=clockwise.ends,
        anticlockwise=anticlockwise.ends,
        published=published,
        exact=exact,
        nominal=nominal,
        corrected_published=by_published,
        corrected=by_fit,
        error_before=systematic_error(clockwise.ends, anticlockwise.ends),
        error_after_published=systematic_error(*(squares.ends for squares in again_published)),
        error_after=systematic_error(*(squares.ends for squares in again)),
        after=(again[0].ends, again[1].ends),
    )


def corrected_scenario(scenario: Scenario, robot: str, geometry: WheelGeometry) -> Scenario:
    """The scenario with another nominal geometry of a robot's drive; the true geometry stays the same.

    Errors give true values relative to nominal ones, so the errors of the drive's geometry become absolute values.
    """
    chosen = chosen_robot(scenario, robot)
    _differential(chosen)
    changed = _with_geometry(chosen, geometry, scenario.seed)
    robots = [changed if other is chosen else other for other in scenario.robots]
    return attrs.evolve(scenario, robots=robots, resolved=None)


def _differential(robot: Robot) -> Differential:
    if not isinstance(robot.drive, Differential):
        kind = type(robot.drive).__name__
        raise AmorsimError(f"robot {robot.name!r}: UMBmark is for differential drives, and this one's is {kind}")
    return robot.drive


def _with_geometry(robot: Robot, geometry: WheelGeometry, seed: int) -> Robot:
    drive: Any = robot.drive
    true = {path: Deviation(value=true_value(robot, path, seed)) for path in _PATHS}
    changed = attrs.evolve(
        drive,
        wheel_radius_left=geometry.radius_left,
        wheel_radius_right=geometry.radius_right,
        track=geometry.track,
    )
    return attrs.evolve(robot, drive=changed, errors={**robot.errors, **true})


# ------------------------------------------------------------------------------------------------------- driving


def drive_squares(
    scenario: Scenario, robot: Robot, *, side: float, speed: float, runs: int, in_its_world: bool = False
) -> tuple[Squares, Squares]:
    """Squares of a side [m] at a speed [m/s], clockwise in replicas 0 ... runs - 1 and anticlockwise in the next ones.

    Raises
    ------
    AmorsimError
        If the robot has no odometry, meets something, or does not come to the end.
    """
    settled, encoder = only_odometry(with_settled_errors(robot, scenario.seed))
    driven = []
    for direction, first in (("clockwise", 0), ("anticlockwise", runs)):
        controller = Square(side=side, speed=speed, direction=direction)
        driver = attrs.evolve(settled, controller=controller, on_collision="end")
        world = None if in_its_world else empty_world(1.5 * side + 10.0)
        prepared = alone(scenario, driver, world)
        driven.append(_drive(prepared, encoder, controller, range(first, first + runs)))
    return driven[0], driven[1]


def _drive(scenario: Scenario, encoder: str, controller: Square, replicas: Sequence[int]) -> Squares:
    simulation = Simulation(scenario, replicas=replicas)
    group = simulation._fleet.groups[0]
    nominal = group.robot.sensors[encoder]
    sensor: Any = nominal.sensor
    true_start, estimated_start = simulation.true_pose, simulation.estimated_pose
    angles = [sensor.angles(group.readings[encoder].measured)]
    # Generous, so that only a run that never ends reaches it.
    most = simulation.steps_of(
        12.0 * (controller.side / controller.speed + 0.5 * math.pi / controller.turn_rate) + 120.0
    )
    specified = scenario.robots[0].sensors[encoder]
    # Then it stands until the encoder's last reading has come in.
    late = simulation.steps_of(specified.latency + (1.0 / specified.rate if specified.rate else 0.0)) + 1
    while late:
        if simulation.tick > most:
            raise AmorsimError(
                f"robot {scenario.robots[0].name!r} did not come round the square in {simulation.time:.0f} s; its "
                "steps may be too long for its speed, or its drive too slow"
            )
        simulation.step()
        angles.append(sensor.angles(group.readings[encoder].measured))
        for event in simulation.events:
            if event.kind == "collision":
                raise AmorsimError(
                    f"robot {event.name!r} met {event.other!r} at {event.time:.1f} s, and so came not round the "
                    "square; take a smaller side, or drive in an empty world"
                )
        is_round = group.driver.state["reached"] >= 4 * controller.laps
        if is_round.all() and not (np.abs(group.joint_rates) > _STANDS).any():
            late -= 1
    true = relative(true_start, simulation.true_pose)
    believed = relative(estimated_start, simulation.estimated_pose)
    return Squares(ends=true[:, :2] - believed[:, :2], angles=np.array(angles)[:, :, :2])  # less a hitch


# ------------------------------------------------------------------------------------------------------- fitting


def fit_squares(drive: Differential, clockwise: Squares, anticlockwise: Squares) -> ExactFit:
    """Ed and Eb by least squares over all end points, each square recomputed from its encoder readings.

    Raises
    ------
    AmorsimError
        If no differential drive near the nominal one fits the end points.
    """
    predictors = [_predictor(drive, squares.angles) for squares in (clockwise, anticlockwise)]
    nominal = [predict(np.ones((1, 2))) for predict in predictors]

    def predict(tried: Array) -> Array:
        return np.concatenate([p(tried) - at for p, at in zip(predictors, nominal, strict=True)], axis=1)

    try:
        return exact_fit(predict, clockwise.ends, anticlockwise.ends)
    except ValueError as error:
        raise AmorsimError(f"Ed and Eb cannot be fitted to these squares: {error}") from None


def _predictor(drive: Differential, angles: Array) -> Callable[[Array], Array]:
    """Where a drive with Ed and Eb `(c, 2)` ends, `(c, n, 2)` [m] from its start, if its joints went so `(T, n, 2)`."""
    steps, runs = len(angles) - 1, angles.shape[1]
    # One after another in memory: all steps of all runs are moved at once, then put together step by step.
    before, after = (part.reshape(-1, 2) for part in (angles[:-1], angles[1:]))
    nominal = WheelGeometry(drive.wheel_radius_left, drive.wheel_radius_right, drive.track)

    def predict(tried: Array) -> Array:
        count = len(tried)
        drives = []
        for ed, eb in tried.tolist():
            left, right, track = nominal.corrected(ed, eb)
            drives.append(attrs.evolve(drive, wheel_radius_left=left, wheel_radius_right=right, track=track))
        rows = np.repeat(np.arange(count), steps * runs)
        moved = take(stack(drives), rows).displacement(
            np.tile(before, (count, 1)), np.tile(after, (count, 1)), np.ones((len(rows), 1))
        )
        by_step = moved.reshape(count, steps, runs, 3).transpose(1, 0, 2, 3).reshape(steps, count * runs, 3)
        pose = np.zeros((count * runs, 3))
        for displacement in by_step:
            pose = compose(pose, displacement)
        return pose[:, :2].reshape(count, runs, 2)

    return predict
