"""Previews: without errors the square is driven as it is believed, and readings are those that are true."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.core.errors import AmorsimError
from amorsim.studies.preview import preview_noise, preview_square


def scenario_of(**errors: am.Deviation) -> tuple[am.Scenario, am.Robot]:
    """The demo with a robot that has these errors and no noise."""
    scenario = am.load("demo")
    (robot, *_) = scenario.robots
    sensors = {name: attrs.evolve(unit, noise=()) for name, unit in robot.sensors.items()}
    plain = attrs.evolve(
        robot, sensors=sensors, ground=(), errors={key.replace("_of_", "."): e for key, e in errors.items()}
    )
    return attrs.evolve(scenario, robots=[plain], source=None, resolved=None), plain


def test_a_robot_without_errors_drives_what_it_believes() -> None:
    scenario, robot = scenario_of()
    found = preview_square(scenario, robot, side=2.0, replicas=2)
    assert found.true.shape == found.estimated.shape
    assert len(found.true) == 2
    # Encoders count whole ticks: over 8 m that is less than a millimetre or two.
    assert np.hypot(*found.ends.T).max() < 0.01
    assert found.estimated[..., 0].max() == pytest.approx(2.0, abs=0.02)


def test_an_error_that_is_drawn_differs_between_replicas() -> None:
    scenario, robot = scenario_of(drive_of_track=am.Deviation(scale=am.Distribution(kind="normal", values=(1.0, 0.05))))
    found = preview_square(scenario, robot, side=2.0, replicas=3)
    far = np.hypot(*found.ends.T)
    assert far.min() > 0.0
    assert len(np.unique(far.round(9))) == 3


def test_readings_without_noise_are_true() -> None:
    scenario, robot = scenario_of()
    assert np.abs(preview_noise(scenario, robot.name, "laser", samples=500, replicas=2)).max() == 0.0
    with pytest.raises(AmorsimError, match="no sensor 'nothing'"):
        preview_noise(scenario, robot.name, "nothing")


def test_a_robot_that_knows_nothing_of_its_start_has_previews_too() -> None:
    scenario = am.load("find-yourself")
    (robot,) = scenario.robots
    assert np.isfinite(preview_square(scenario, robot, side=2.0, replicas=2).ends).all()
    assert len(preview_noise(scenario, robot.name, "laser", samples=500, replicas=2)) == 500
