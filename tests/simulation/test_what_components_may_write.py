"""Components that write into the arrays they are given change neither the truth nor what others get."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.scenario.spec import MountedSensor
from tests import building


@attrs.frozen(kw_only=True)
class InPlace(am.Noise):
    """Adds one to the array that it is given."""

    def corrupt(self, values: Any, side: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        """The same array."""
        values += 1.0
        return values


class Blank:
    """A controller that blanks what it reads."""

    def command(self, readings: Any, estimate: Any, clock: Any) -> am.Twist:
        for reading in readings.values():
            reading.measured[:] = 0.0
        estimate.pose[:] = 0.0
        estimate.covariance[:] = 0.0
        return am.Twist(forward=0.2, turn=0.1)


@attrs.frozen(kw_only=True)
class Blanking(am.estimators.DeadReckoning):
    """Dead reckoning that blanks all readings after its update."""

    def update(self, robot: Any, readings: Any, command: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        """As before."""
        found = super().update(robot, readings, command, elapsed, state, draws)
        for name in readings:
            readings[name].measured[:] = 0.0
        return found


@attrs.frozen(kw_only=True)
class Careful(am.estimators.Ekf):
    """A filter that doubts its result twice as much."""

    def update(self, robot: Any, readings: Any, command: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        """As before."""
        pose, covariance = super().update(robot, readings, command, elapsed, state, draws)
        return am.contracts.Estimate(pose, 2.0 * covariance)


@attrs.frozen(kw_only=True)
class Slow(am.controllers.Pursuit):
    """Pursuit at half the speed."""

    def command(self, robot: Any, readings: Any, estimate: Any, clock: Any, state: Any, draws: Any) -> Any:
        """As before."""
        return 0.5 * super().command(robot, readings, estimate, clock, state, draws)


def test_a_subclass_of_a_bound_component_may_build_on_its_simple_form() -> None:
    pursuit = {"waypoints": ((4.0, 1.0),), "reverse": "never"}
    sims = []
    for filter_, controller in ((am.estimators.Ekf, am.controllers.Pursuit), (Careful, Slow)):
        robot = building.robot(
            name="rover",
            pose=am.Pose(x=1.0, y=1.0),
            controller=controller(**pursuit),
            estimators={"ekf": filter_(wheel_variance=1e-4)},
        )
        sims.append(am.Simulation(building.scenario(robot)))
    for sim in sims:
        sim.step()  # from rest, the speed in the first step is of the command alone
    commands = [sim.frames()[0].command for sim in sims]
    np.testing.assert_allclose(commands[1], 0.5 * commands[0])
    for sim in sims:
        sim.run(1.0)
    ratio = [np.trace(sim.covariance[0]) / (sim.true_pose[0, 0] - 1.0) for sim in sims]
    assert ratio[1] == pytest.approx(2.0 * ratio[0], rel=0.05)  # the variance grows with the way


def test_noise_that_works_in_place_leaves_the_truth() -> None:
    compass = MountedSensor(sensor=am.sensors.Compass(), noise=building.chain(InPlace()))
    robot = building.robot(sensors={"compass": compass, "encoder": MountedSensor(sensor=building.encoder())})
    sim = am.Simulation(building.scenario(robot))
    sim.step()
    true, measured = sim.readings["compass"].true[0, 0], sim.readings["compass"].measured[0, 0]
    assert measured == true + 1.0
    assert true == sim.true_pose[0, 2]


def test_what_blanks_its_readings_blanks_no_others() -> None:
    def digest(**changes: Any) -> str:
        robot = building.robot(name="rover", sensors=building.all_sensors(), **changes)
        sim = am.Simulation(building.scenario(robot), replicas=2)
        sim.run(1.0)
        return sim.digest()

    class Plain:
        def command(self, readings: Any, estimate: Any, clock: Any) -> am.Twist:
            return am.Twist(forward=0.2, turn=0.1)

    one, other = {"dr": am.estimators.DeadReckoning()}, {"dr": Blanking()}
    assert digest(controller=Blank, estimators=other) == digest(controller=Plain, estimators=one)


@attrs.frozen(kw_only=True)
class Overwriting(am.Sensor):
    """A sensor that takes commands, and writes into all that it gets."""

    unit: ClassVar[str] = "m"
    channels: ClassVar[tuple[str, ...]] = ("lift",)

    def size(self, drive: Any) -> int:
        """One value."""
        return 1

    def actuate(self, command: Any, dt: float, state: Any, draws: Any) -> None:
        """Blank the command."""
        command[:] = 0.0

    def sense(self, view: Any, aim: Any, state: Any, draws: Any) -> Any:
        """Nothing."""
        for array in (view.pose, view.body_pose, view.twist, view.joints, view.joint_rates):
            array[:] = 1.0
        return np.zeros((view.rows, 1)), {}


@attrs.frozen(kw_only=True)
class InPlaceDrive(type(building.drive())):  # type: ignore[misc]
    """A drive that moves the joints in place."""

    def advance(self, joints: Any, rates: Any, command: Any, dt: float, state: Any, draws: Any) -> Any:
        """The arrays that it is given, changed."""
        joints[:], rates[:] = super().advance(joints, rates, command, dt, state, draws)
        command[:] = 0.0
        return joints, rates


@attrs.frozen(kw_only=True)
class OwnStart(am.Estimator):
    """An estimator that keeps the pose that it is given at the start, moves it, and blanks the command."""

    def start(self, context: Any) -> Any:
        """The pose as it is given."""
        return {"pose": context.pose}

    def update(self, robot: Any, readings: Any, command: Any, elapsed: Any, state: Any, draws: Any) -> am.Estimate:
        """A millimetre farther."""
        state["pose"][:, 0] += 0.001
        command[:] = 0.0
        return am.Estimate(state["pose"].copy(), np.zeros((robot.rows, 3, 3)))


@attrs.frozen(kw_only=True)
class Turning(am.controllers.Square):
    """A square that spoils the estimate after its command."""

    def command(self, robot: Any, readings: Any, estimate: Any, clock: Any, state: Any, draws: Any) -> Any:
        """As before."""
        found = super().command(robot, readings, estimate, clock, state, draws)
        estimate.pose[:] = estimate.covariance[:] = 0.5
        return found


@attrs.frozen(kw_only=True)
class Pushing(am.Motion):
    """A motion that stands still, and writes into all that it gets."""

    def start(self, context: Any) -> Any:
        """Nothing."""
        context.pose[:] = 0.0
        return {}

    def propose(self, view: Any, dt: float, state: Any, draws: Any) -> Any:
        """Nothing."""
        for array in (view.body_pose, view.twist, view.free):
            array[:] = 0.0
        return np.zeros((view.rows, 3))


def results(replicas: int = 2, **changes: Any) -> list[Any]:
    """True poses, joints, commands and estimates after each step of a robot that drives a square."""
    given: dict[str, Any] = {"name": "rover", "controller": am.controllers.Square(side=1.0), **changes}
    sim = am.Simulation(building.scenario(building.robot(**given)), replicas=replicas)
    found = []
    for _ in range(20):
        sim.step()
        (frame,) = sim.frames()
        found += [frame.true_pose, frame.readings["encoder"][0], frame.command[:, :2], frame.estimates["own"].pose]
    return [array.tolist() for array in found]


def test_a_sensor_that_writes_into_its_view_and_its_command_changes_neither() -> None:
    own = {"own": am.estimators.DeadReckoning()}
    sensors = {"encoder": building.encoder(), "lift": Overwriting()}
    assert results(estimators=own, sensors=sensors) == results(estimators=own)
    sim = am.Simulation(building.scenario(building.robot(sensors=sensors, controller=am.controllers.Manual())))
    sim.robot("rover").command(0.0, 0.0, 0.5)
    sim.step()
    assert sim.frames()[0].command[0].tolist() == [0.0, 0.0, 0.5]


def test_a_drive_that_moves_the_joints_in_place_drives_as_one_that_does_not() -> None:
    own = {"own": am.estimators.DeadReckoning()}
    fields = attrs.asdict(building.drive(), recurse=False)
    assert results(estimators=own, drive=InPlaceDrive(**fields)) == results(estimators=own)


def test_a_controller_that_writes_into_the_estimate_leaves_the_estimators_own() -> None:
    own = {"own": am.estimators.DeadReckoning()}
    assert results(estimators=own, controller=Turning(side=1.0)) == results(estimators=own)


def test_estimators_that_write_into_the_start_and_the_command_change_neither() -> None:
    alone = results(estimators={"own": OwnStart()})
    assert results(estimators={"own": OwnStart(), "second": OwnStart()}) == alone
    commands = [step[0] for step in alone[2::4]]
    assert any(left != 0.0 for left, _ in commands)


def test_a_motion_that_writes_into_its_view_moves_nothing() -> None:
    box = am.Obstacle(name="box", shape=am.Shape.circle(0.2), pose=am.Pose(x=1.0, y=1.0), motion=Pushing())
    sim = am.Simulation(building.scenario(building.robot(), obstacles=(box,)))
    sim.run(0.5)
    assert sim.obstacle("box").true_pose.tolist() == [1.0, 1.0, 0.0]


def test_a_recorder_that_writes_into_its_frames_moves_nobody(tmp_path: Path) -> None:
    sim, untouched = (am.Simulation(building.scenario(building.robot())) for _ in range(2))
    for _ in range(5):
        (frame,) = sim.frames()
        for array in (frame.true_pose, frame.true_twist, frame.command, frame.tick, frame.time):
            array[:] = 0
        for estimate in frame.estimates.values():
            estimate.pose[:] = 0.0
            estimate.covariance[:] = 0.0
        for true, reading in frame.readings.values():
            true[:] = 0.0
            reading.measured[:] = 0.0
        sim.step()
        untouched.step()
    assert sim.digest() == untouched.digest()
    np.testing.assert_array_equal(sim.true_pose, untouched.true_pose)
