"""What each error does to odometry: known cases, and draws that are the same alone as in company."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.controllers.goto import GoTo
from amorsim.controllers.square import Square
from amorsim.noise.diffusion import Diffusion
from amorsim.noise.gaussian import Gaussian
from amorsim.scenario.spec import Deviation, Distribution, MountedSensor, Scenario
from amorsim.studies.attribution import Attribution, attribute_errors
from tests import building


def _scenario(*, errors: Any = None, ground: Any = (), encoder: Any = (), controller: Any = None) -> Scenario:
    robot = building.robot(
        pose=am.Pose(x=1.0, y=1.0),
        errors=errors or {},
        ground=building.chain(*ground),
        sensors={"encoder": MountedSensor(sensor=building.encoder(), noise=building.chain(*encoder))},
        controller=controller or Square(side=2.0, speed=0.4),
    )
    return building.scenario(robot, dt=0.1, duration=40.0)


def _case(found: Attribution, name: str) -> Any:
    return next(case for case in found.cases if case.name == name)


BOTH = {
    "drive.wheel_radius_left": Deviation(scale=1.0001),
    "drive.wheel_radius_right": Deviation(scale=1.0001),
}


def test_wheels_that_are_larger_than_believed_lead_farther() -> None:
    """Straight ahead, a robot whose wheels are larger by s believes to have gone a way that is shorter by s."""
    scenario = _scenario(errors=BOTH, controller=GoTo(x=5.0, y=1.0, speed=0.5))
    found = attribute_errors(scenario, replicas=1)
    # It stops within the controller's tolerance.
    driven = found.reference[-1, 0]
    assert driven == pytest.approx(4.0, abs=0.06)
    # The reference has no error: with larger wheels, the same commands lead farther, and odometry sees the reference.
    assert found.together.errors[0] == pytest.approx([-1e-4 * driven, 0.0], abs=1e-9)
    assert found.together.error == pytest.approx(1e-4 * driven, rel=1e-6)
    assert found.together.believed[-1] == pytest.approx([(1.0 - 1e-4) * driven, 0.0, 0.0], abs=1e-9)
    assert found.together.share == 1.0
    for case in found.cases:
        # Half of the way each. Alone, a wheel bends the path too, by a = 1e-4 * 4 / 0.33 rad: a further 4 m * a^2 / 2.
        assert case.share == pytest.approx(0.5, abs=0.5 * 4.0 * (4e-4 / 0.33) ** 2 / 4e-4)


def test_an_error_alone_is_all_there_is() -> None:
    found = attribute_errors(_scenario(errors={"drive.track": Deviation(scale=1.01)}), replicas=2)
    (case,) = found.cases
    assert case.name == "errors.drive.track"
    assert case.errors.tobytes() == found.together.errors.tobytes()
    assert case.share == pytest.approx(1.0)
    assert found.interaction == pytest.approx(0.0, abs=1e-12)


def test_small_errors_add_up() -> None:
    """To first order the final errors are a sum, and so the shares add up to all; the rest is of second order."""
    errors = {
        "drive.wheel_radius_left": Deviation(scale=1.0003),
        "drive.track": Deviation(scale=Distribution(kind="normal", values=(1.0, 0.001))),
        "pose.heading": Deviation(add=0.001),
    }
    scenario = _scenario(errors=errors, ground=[Diffusion(variance_per_length=1e-9)])
    scenario = attrs.evolve(scenario, duration=15.0)  # not all the way round, where the heading's error would be gone
    found = attribute_errors(scenario, replicas=5)
    assert len(found.cases) == 4
    total = sum(case.errors for case in found.cases)
    # The errors are angles of less than 0.015 rad on a way of 8 m: their effect on one another is of second order.
    assert np.abs(total - found.together.errors).max() < 8.0 * 0.015**2
    assert abs(found.interaction) < 0.05
    assert min(case.error for case in found.cases) > 1e-4


def test_switching_an_error_off_leaves_all_others_as_they_are() -> None:
    errors = {"drive.track": Deviation(scale=Distribution(kind="normal", values=(1.0, 0.02)))}
    ground = [Diffusion(variance_per_length=1e-6), Gaussian(std=1e-4)]
    encoder = [Gaussian(std=20.0, per="increment")]
    whole = attribute_errors(_scenario(errors=errors, ground=ground, encoder=encoder), replicas=3)
    part = attribute_errors(_scenario(errors=errors, ground=ground[1:], encoder=encoder), replicas=3)
    names = [case.name for case in whole.cases]
    assert names == ["errors.drive.track", "ground.diffusion", "ground.gaussian", "sensors.encoder.noise.gaussian"]
    assert [case.name for case in part.cases] == [name for name in names if name != "ground.diffusion"]
    for case in part.cases:
        assert case.errors.tobytes() == _case(whole, case.name).errors.tobytes()
        assert len(np.unique(case.errors[:, 0])) == 3
    assert part.together.error != whole.together.error


def test_errors_that_odometry_does_not_know_are_named() -> None:
    scenario = _scenario(
        errors={"drive.track": Deviation(scale=1.01), "sensors.compass.mount.heading": Deviation(add=1.0)}
    )
    robot = scenario.robots[0]
    sensors = {**robot.sensors, "compass": building.all_sensors()["compass"]}
    found = attribute_errors(attrs.evolve(scenario, robots=[attrs.evolve(robot, sensors=sensors)]), replicas=1)
    assert found.left_out == ("errors.sensors.compass.mount.heading",)
    assert [case.name for case in found.cases] == ["errors.drive.track"]


def test_what_it_knows_of_its_start_and_where_it_is_carried_are_no_errors() -> None:
    scenario = _scenario(errors={"drive.track": Deviation(scale=1.01)})
    lost = attrs.evolve(
        scenario.robots[0],
        initial_belief=am.InitialBelief(kind="gaussian", std=0.2, heading_std=0.1),
        kidnappings=[am.Kidnapping(time=10.0, x=4.0, y=4.0)],
    )
    found = attribute_errors(attrs.evolve(scenario, robots=[lost]), replicas=2)
    plain = attribute_errors(scenario, replicas=2)
    assert found.together.errors.tobytes() == plain.together.errors.tobytes()
    assert found.left_out == ("initial_belief", "kidnappings")
    assert plain.left_out == ()


def test_it_drives_as_the_robot_without_errors_does() -> None:
    found = attribute_errors(_scenario(errors={"drive.track": Deviation(scale=1.05)}), replicas=1)
    clean = am.Simulation(_scenario())
    clean.run()
    start, end = np.array([1.0, 1.0]), clean.true_pose[0, :2]
    assert found.reference[-1, :2] == pytest.approx(end - start, abs=1e-9)


def test_nothing_to_explain_is_said() -> None:
    with pytest.raises(am.AmorsimError, match="robot 'rover' has nothing to explain"):
        attribute_errors(_scenario())
    with pytest.raises(am.AmorsimError, match="replicas: expected a whole number > 0"):
        attribute_errors(_scenario(errors=BOTH), replicas=0)
    still = attrs.evolve(_scenario(errors=BOTH).robots[0], controller=None)
    with pytest.raises(am.AmorsimError, match="robot 'rover' does not move"):
        attribute_errors(building.scenario(still))
