"""What a thread's stack shows."""

import sys

import amorsim as am
from amorsim.ui.simulator.process.stacks import robot_of
from tests import building


def test_a_stack_shows_whose_controller_it_is_in() -> None:
    seen = []

    def controller(_readings: object, _estimate: object, _clock: object) -> None:
        seen.append(robot_of(sys._getframe()))

    robots = [
        building.robot(name=name, pose=am.Pose(x=x, y=2.5), controller=controller)
        for name, x in (("rover", 1.0), ("other", 3.0))
    ]
    am.Simulation(building.scenario(*robots)).step()
    assert sorted(seen) == ["other", "rover"]
    assert robot_of(sys._getframe()) == ""
