"""Paths that lead to the numbers of a robot: one to each."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import amorsim as am
from amorsim.core.errors import ScenarioError
from amorsim.scenario.parameter_paths import with_value
from tests import building
from tests.building import rover_text

ROBOT = building.robot(sensors={"encoder": building.encoder(), "sonar": building.ring()})


def test_an_element_of_a_list_is_named_by_its_number() -> None:
    changed = with_value(ROBOT, "sensors.sonar.elements.2.x", 0.2)
    assert [mount.x for mount in changed.sensors["sonar"].sensor.elements] == [0.1, 0.1, 0.2, 0.1]


@pytest.mark.parametrize("number", ["02", "²", "٢", "-1", "4", "9" * 5000])
@pytest.mark.parametrize("path", ["sensors.sonar.elements.{}.x", "errors.sensors.sonar.elements.{}.x.add"])
def test_a_number_that_is_spelt_otherwise_is_none(path: str, number: str) -> None:
    with pytest.raises(LookupError, match=r"no element .*; known elements: 0 to 3"):
        with_value(ROBOT, path.format(number), 0.2)


@pytest.mark.parametrize("path", ["sensors.sonar.sensor.range_max", "errors.sensors.sonar.sensor.range_max.scale"])
def test_no_second_path_leads_to_the_parameters_of_a_sensor(path: str) -> None:
    with pytest.raises(LookupError, match="no parameter 'sensor'"):
        with_value(ROBOT, path, 1.1)


def test_a_chain_without_elements_says_so() -> None:
    with pytest.raises(LookupError, match="no element 'gaussian'; known elements: none"):
        with_value(ROBOT, "sensors.sonar.noise.gaussian.std", 0.1)


@pytest.mark.parametrize("key", ["elements.03.heading_deg", 'elements."²".heading_deg', "sensor.range_max"])
def test_a_file_gives_a_number_one_error(key: str, tmp_path: Path) -> None:
    good = ["[robots.errors.sensors.sonar]", "elements.3.heading_deg = { add = 2.0 }"]
    file = building.write_rover(tmp_path, *good)
    (error,) = am.load(file).robots[0].errors.values()
    assert error.add == math.radians(2.0)
    file.write_text(rover_text(*good, f"{key} = {{ add = 1.0 }}"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"no (element|parameter) "):
        am.load(file)
