"""Recorders and windows get the joints' mean rates over a step, which is what encoders can tell of it."""

from __future__ import annotations

import numpy as np
import pytest

import amorsim as am
from amorsim.core.shapes import Shape
from amorsim.noise import Scale
from tests import building

DT = 0.1


def _alone() -> dict:
    return {}


def _with_company() -> dict:
    other = building.robot(name="other", pose=am.Pose(x=-30.0))
    return {"others": [other]}


def _on_a_ground() -> dict:
    return {"ground": building.chain(Scale(factor=0.9))}


def _before_a_wall() -> dict:
    return {"map": building.room(6.0, 6.0, 0.01), "pose": am.Pose(x=5.2, y=3.0), "on_collision": "continue"}


@pytest.mark.parametrize("case", [_alone, _with_company, _on_a_ground, _before_a_wall])
def test_true_rates_are_those_that_a_perfect_encoder_tells(case) -> None:
    given = case()
    world, others = given.pop("map", building.empty()), given.pop("others", [])
    robot = building.robot(
        drive=building.drive(acceleration_max=7.2),
        sensors={"encoder": am.MountedSensor(sensor=building.encoder())},
        **({"shape": Shape.circle(0.2), "pose": am.Pose()} | given),
    )
    sim = am.Simulation(building.scenario(robot, *others, map=world, dt=DT))
    sim.robot("rover").drive(forward=0.5, turn=0.4)
    (group, row), snapshot = sim._fleet.robot_row("rover", 0), None
    before = group.frame()
    assert not before.joint_rates.any()
    for tick in range(15):
        sim.step()
        frame = group.frame()
        counts = frame.readings["encoder"][0][row] - before.readings["encoder"][0][row]
        expected = counts / 39400.0 * 2.0 * np.pi / DT
        assert frame.joint_rates[row] == pytest.approx(expected, abs=1e-9)
        if tick == 7:
            snapshot, kept = sim.snapshot(), frame.joint_rates.copy()
        before = frame
    sim.restore(snapshot)
    assert group.frame().joint_rates.tolist() == kept.tolist()
