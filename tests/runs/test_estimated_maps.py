"""The maps that a run leaves in its folder."""

from pathlib import Path

import numpy as np

import amorsim as am
from amorsim.estimators import DeadReckoning, GridMapping
from tests.estimators.slam_rig import scenario

SMALL = {"wheel_variance": 1e-3, "resolution": 0.1, "width": 9.0, "height": 7.0}


def test_a_run_leaves_the_maps_of_its_first_replica(tmp_path: Path) -> None:
    sim = am.Simulation(scenario(mapping=GridMapping(**SMALL), wheels=DeadReckoning()), replicas=2)
    with am.record(sim, tmp_path / "run") as session:
        for _ in range(15):
            sim.step()
            session.keep()
        wanted = am.estimated_map(sim.frames()[0].beliefs["mapping"])
    assert [path.name for path in sorted((tmp_path / "run" / "estimated-maps").iterdir())] == [
        "rover-mapping.pgm",
        "rover-mapping.yaml",
    ]
    found = am.load_map(tmp_path / "run" / "estimated-maps" / "rover-mapping.yaml")
    np.testing.assert_array_equal(found.to_array(), wanted.to_array())
    np.testing.assert_array_equal(found.unknown_array(), wanted.unknown_array())
    assert found.to_array().any()


def test_a_run_without_a_map_leaves_none(tmp_path: Path) -> None:
    am.run(scenario(wheels=DeadReckoning()), tmp_path / "run", duration=0.5)
    assert not (tmp_path / "run" / "estimated-maps").exists()
