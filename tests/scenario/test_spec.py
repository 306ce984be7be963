"""Scenarios built in Python: what is taken, and what is refused with words."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.quantize import Quantize
from tests import building


def test_bare_elements_of_a_chain_are_called_after_their_classes() -> None:
    unit = am.MountedSensor(
        sensor=building.encoder(), noise=(Quantize(step=1.0), Gaussian(std=1.0), Quantize(step=2.0))
    )
    assert [element.name for element in unit.noise] == ["quantize", "gaussian", "quantize_2"]


def test_elements_of_one_name_are_refused() -> None:
    twice = [am.NoiseElement(name="a", noise=Gaussian(std=1.0))] * 2
    with pytest.raises(am.ParameterError, match="two elements of the chain are called 'a'"):
        am.MountedSensor(sensor=building.encoder(), noise=twice)


def test_an_error_must_be_a_deviation() -> None:
    with pytest.raises(am.ParameterError, match=r"drive.track: expected a Deviation, .* got 1.02"):
        building.robot(errors={"drive.track": 1.02})


def test_a_controller_must_be_one() -> None:
    with pytest.raises(am.ParameterError, match="expected a controller, a function or a class, got 5"):
        building.robot(controller=5)


def test_a_robot_without_a_pose_starts_where_the_map_says_or_where_most_room_is() -> None:
    given = am.Map.from_segments(
        [[0, 0, 4, 0], [0, 4, 4, 4]], extent=(0, 0, 4, 4), resolution=0.01, start=(1.0, 1.0, 0.5)
    )
    sim = am.Simulation(building.scenario(building.robot(pose=None), map=given))
    assert sim.true_pose[0].tolist() == [1.0, 1.0, 0.5]
    sim = am.Simulation(building.scenario(building.robot(pose=None), map=building.room()))
    assert np.abs(sim.true_pose[0, :2] - (3.0, 2.5)).max() < 0.6


def test_names_must_differ() -> None:
    with pytest.raises(am.ParameterError, match="two robots or obstacles are called 'rover'"):
        building.scenario(building.robot(), building.robot())


@pytest.mark.parametrize("name", ["../../escaped", "a b", "", "laser.front", 5])
def test_names_of_sensors_and_estimators_are_those_that_files_take(name: Any) -> None:
    """They name a run's files, too: such a sensor's readings would be written outside of its folder."""
    with pytest.raises(am.ParameterError, match=r"sensors: expected a name of letters, .*, got"):
        building.robot(sensors={"encoder": building.encoder(), name: am.sensors.Laser()})
    with pytest.raises(am.ParameterError, match=r"estimators: expected a name of letters, .*, got"):
        building.robot(estimators={name: am.estimators.DeadReckoning()})
