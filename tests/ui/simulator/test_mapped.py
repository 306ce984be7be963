"""What a window gets of maps, matched scans and pose graphs."""

from __future__ import annotations

import base64
import io

import numpy as np
from PIL import Image

import amorsim as am
from amorsim.estimators import DeadReckoning, GraphSlam, GridMapping
from amorsim.ui.simulator.frames.mapped import mapped_of
from tests.estimators.slam_rig import scenario

SMALL = {"wheel_variance": 1e-3, "resolution": 0.1, "width": 9.0, "height": 7.0}


def test_a_window_gets_what_was_mapped() -> None:
    mapping, slam = GridMapping(**SMALL), GraphSlam(**SMALL, range_std=0.01, key_distance=0.3, nodes=20)
    sim = am.Simulation(scenario(mapping=mapping, slam=slam, wheels=DeadReckoning()))
    sim.run(2.0)
    first, second = mapped_of(sim, "rover")
    assert [first["estimator"], second["estimator"]] == ["mapping", "slam"]
    assert first["scan"] is None
    assert first["poses"] is None
    assert len(second["scan"] or []) > 50
    poses, edges = second["poses"] or [], second["edges"] or []
    assert len(poses) >= 2
    assert edges[0] == [0, 1]
    cells = first["map"]
    assert cells is not None
    left, low, right, high = cells["extent"]
    assert left < 1.2  # it looks ahead, from x = 1.1 m
    assert right == 5.5  # the end of the map
    with Image.open(io.BytesIO(base64.b64decode(cells["png"]))) as picture:
        opacity = np.asarray(picture)[::-1, :, 1]
    assert opacity.shape == (round((high - low) / 0.1), round((right - left) / 0.1))
    beliefs = sim.frames()[0].beliefs["mapping"]
    known = np.isfinite(beliefs["occupancy"][0])
    assert (opacity > 0).sum() == known.sum()
    assert (opacity > 150).sum() == (beliefs["occupancy"][0][known] > 0.6).sum()


def test_a_robot_that_maps_nothing_has_none() -> None:
    sim = am.Simulation(scenario(wheels=DeadReckoning()))
    assert mapped_of(sim, "rover") == []
