"""A recorded run, for the tests of the window that replays it and of the page that it is exported to."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.recorders.arrays import Arrays
from amorsim.scenario.spec import Recording
from tests import building


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two replicas of a robot that drives into a wall, with particles, next to one that stands."""
    cloud = am.estimators.MonteCarlo(wheel_variance=1e-3, particles_min=100, particles_max=200)
    walls = building.room()
    rover = building.robot(
        name="rover",
        pose=am.Pose(x=4.0, y=2.5),
        sensors=building.all_sensors(),
        estimators={"cloud": cloud},
        knowledge=am.Knowledge(map=walls),
        controller=am.controllers.Wander(speed=0.4),
    )
    standing = building.robot(name="other", pose=am.Pose(x=1.0, y=1.0))
    what = Recording(picture=False, also=[Arrays(every=0.5)])
    scenario = building.scenario(rover, standing, map=walls, recording=what)
    simulation = am.Simulation(scenario, seed=3, replicas=[0, 5])
    path = tmp_path_factory.mktemp("replay") / "monday"
    with am.record(simulation, path, duration=8.0) as session:
        for step in range(60):
            if step == 20:
                for replica in (0, 5):
                    simulation.hand_over("rover", "hand", replica=replica)
            if step >= 20:
                for replica in (0, 5):
                    simulation.robot("rover", replica).drive(forward=0.8, turn=0.02 * replica)
            simulation.step()
            session.keep()
    return path
