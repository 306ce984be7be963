"""The detour of a robot that drives a quarter of a circle."""

import math

import amorsim_example as example
import numpy as np
import pytest

import amorsim as am


def test_detour() -> None:
    angle = np.linspace(0.0, math.pi / 2.0, 101)
    true = np.stack((np.cos(angle), np.sin(angle), angle + math.pi / 2.0), axis=1)[:, None]
    episode = am.Episode(
        robot="rover",
        replicas=(0,),
        time=0.1 * np.arange(101),
        kept={"true_pose": true},
        events=(),
        map=am.Map.from_segments([(0, 0, 1, 0)]),
        shape=am.Shape.circle(0.1),
    )
    assert example.Detour().measure(episode)[0] == pytest.approx(math.pi / 2.0 / math.sqrt(2.0), rel=1e-4)
