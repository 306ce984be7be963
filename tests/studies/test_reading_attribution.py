"""What each error of a sensor does to its readings: known cases, and draws that are the same alone as in company."""

from __future__ import annotations

import math
from typing import Any

import pytest

import amorsim as am
from amorsim import noise
from amorsim.sensors import Compass, Gyro, Laser
from amorsim.studies.attribution import attribute_errors
from amorsim.studies.reading_attribution import ReadingAttribution, attribute_readings
from tests import building
from tests.drives.fleet import MAKERS, make


def explain(unit: am.MountedSensor, *, replicas: int = 40, duration: float = 5.0, **changes: Any) -> ReadingAttribution:
    robot = building.robot(
        sensors={"encoder": building.encoder(), "sensor": unit},
        **({"controller": am.controllers.Square(side=1.0, speed=0.3)} | changes),
    )
    return attribute_readings(building.scenario(robot, duration=duration), "sensor", replicas=replicas)


def by_name(found: ReadingAttribution) -> dict[str, Any]:
    return {case.name.rpartition(".")[2]: case for case in found.cases}


def test_variances_of_independent_errors_are_their_shares() -> None:
    """A bias of 3 and white noise of 4 make 5 together, of which the bias has 9 / 25 and the noise 16 / 25."""
    unit = am.MountedSensor(sensor=Gyro(), noise=(noise.Bias(value=0.03), noise.Gaussian(std=0.04)))
    found = explain(unit, replicas=200)
    cases = by_name(found)
    count = 200 * 50
    assert cases["bias"].error == pytest.approx(0.03, rel=1e-9)
    assert cases["gaussian"].error == pytest.approx(0.04, rel=5.0 * math.sqrt(0.5 / count))
    assert found.together.error == pytest.approx(0.05, rel=5.0 * math.sqrt(1.0 / count))
    # What is left between bias and noise in a share: a product of mean 0 and deviation 0.03 * 0.04, of 0.05^2.
    assert cases["bias"].share == pytest.approx(9.0 / 25.0, abs=10.0 * 12.0 / 25.0 / math.sqrt(count))
    assert found.together.share == 1.0
    assert found.interaction == pytest.approx(0.0, abs=1e-9)  # they add up, draw by draw
    assert found.unit == "rad/s"
    assert found.time.tolist() == pytest.approx([0.1 * i for i in range(1, 51)])


def test_errors_of_geometry_count_and_those_of_the_drive_do_not() -> None:
    errors = {
        "sensors.sensor.mount.heading": am.Deviation(add=0.05),
        "drive.track": am.Deviation(scale=1.05),
    }
    found = explain(am.MountedSensor(sensor=Compass()), errors=errors, replicas=1)
    (case,) = found.cases
    assert case.name == "errors.sensors.sensor.mount.heading"
    # The short way round, also where the heading goes through half a turn.
    assert case.error == pytest.approx(0.05, rel=1e-9)
    assert case.share == 1.0


def test_returns_that_are_lost_count_apart() -> None:
    unit = am.MountedSensor(sensor=Laser(beams=9), noise=(noise.Dropout(probability=0.2), noise.Bias(value=0.1)))
    found = explain(unit, replicas=20)
    cases = by_name(found)
    count = 20 * 50 * 9
    assert cases["dropout"].changed == pytest.approx(0.2, abs=5.0 * math.sqrt(0.16 / count))
    assert (cases["dropout"].error, cases["bias"].changed) == (0.0, 0.0)
    assert found.together.changed == cases["dropout"].changed  # the same values are lost
    assert cases["bias"].share == pytest.approx(1.0, rel=1e-12)


def test_a_controller_that_uses_the_sensor_does_not_change_its_way() -> None:
    """The commands are those of one drive; errors of the sensor cannot lead the robot elsewhere."""
    wander = am.controllers.Wander(sensor="sensor", speed=0.3)
    chain = (noise.Gaussian(std=0.05), noise.Bias(value=0.2))
    unit = am.MountedSensor(sensor=Laser(beams=31), noise=chain)
    found = explain(unit, controller=wander, replicas=3, duration=8.0)
    assert by_name(found)["bias"].by_step == pytest.approx(0.2, rel=1e-9)
    assert found.interaction == pytest.approx(0.0, abs=1e-9)


def test_jitter_of_latency_is_an_error_and_latency_is_none() -> None:
    chain = (noise.LatencyJitter(spread=0.2),)
    found = explain(am.MountedSensor(sensor=Gyro(), latency=0.3, noise=chain), replicas=20)
    (case,) = found.cases
    assert case.error > 0.0  # where the robot changes its rate, old and new readings differ
    with pytest.raises(am.AmorsimError, match="has nothing to explain"):
        explain(am.MountedSensor(sensor=Gyro(), latency=0.3))


def test_what_cannot_be_explained_is_said() -> None:
    robot = building.robot(sensors={"finder": am.MountedSensor(sensor=am.sensors.Fiducial())}, estimators={})
    scenario = building.scenario(robot)
    with pytest.raises(am.AmorsimError, match=r"several quantities \(range, bearing, id\), whose errors have no sum"):
        attribute_readings(scenario, "finder")
    with pytest.raises(am.AmorsimError, match=r"no sensor 'fnder'; did you mean 'finder'"):
        attribute_readings(scenario, "fnder")
    with pytest.raises(am.AmorsimError, match="expected a whole number > 0"):
        attribute_readings(scenario, "finder", replicas=0)


def test_others_in_the_scenario_stay_as_they_are() -> None:
    """Another robot, with a controller of its own, drives on and is seen in all cases alike."""
    unit = am.MountedSensor(sensor=Laser(beams=31), noise=(noise.Gaussian(std=0.01),))
    watcher = building.robot(name="watcher", sensors={"sensor": unit}, estimators={}, pose=am.Pose(x=1.0, y=1.0))
    other = building.robot(name="other", controller=building.Roam(), pose=am.Pose(x=3.0, y=3.0))
    found = attribute_readings(building.scenario(watcher, other, duration=3.0), "sensor", robot="watcher", replicas=5)
    assert found.cases[0].error == pytest.approx(0.01, rel=5.0 * math.sqrt(0.5 / (5 * 30 * 31)))
    assert found.cases[0].changed == 0.0


ERRORS = {
    "ackermann rear": "wheelbase",
    "ackermann front": "wheel_radius",
    "ackermann centre": "wheelbase",
    "synchro fixed": "wheel_radius",
    "synchro follows": "wheel_radius",
    "synchro driven": "wheel_radius",
    "tricycle": "wheelbase",
    "mecanum": "wheel_radius_rear_left",
    "tractor": "track",
    "differential": "track",
}


@pytest.mark.parametrize("name", MAKERS)
def test_errors_of_every_drive_are_explained(name: str) -> None:
    """The same commands with the error of the drive, with noise by length, and with both."""
    drive = make(name)

    def weave(readings: Any, estimate: Any, clock: Any) -> am.Twist:
        return am.Twist(0.3, 0.3 if clock.time < 3.0 else -0.2)

    robot = building.robot(
        drive=drive,
        shape=am.Shape.circle(0.2),
        pose=am.Pose(x=1.0, y=2.0),
        controller=weave,
        errors={f"drive.{ERRORS[name]}": am.Deviation(scale=1.03)},
        ground=building.chain(noise.Diffusion(variance_per_length=1e-6)),
    )
    found = attribute_errors(building.scenario(robot, duration=6.0, map=building.room(12.0, 10.0)), replicas=5)
    cases = {case.name: case for case in found.cases}
    wrong = cases[f"errors.drive.{ERRORS[name]}"]
    assert 0.002 < wrong.error < 0.5
    assert wrong.share > 0.8
    assert cases["ground.diffusion"].error < 0.02
    assert abs(found.interaction) < 0.05
