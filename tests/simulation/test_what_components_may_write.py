"""Components that write into the arrays they are given change neither the truth nor what others get."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import numpy as np

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
