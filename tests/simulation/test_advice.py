"""Remarks on what is hardly meant."""

import pytest

from amorsim.scenario.spec import Landmark, Light
from amorsim.simulation.advice import advice
from tests.building import room, scenario


@pytest.mark.parametrize(
    ("landmarks", "lights", "paths"),
    [
        ([Landmark(id=1, x=6.0, y=2.0)], [Light(x=1.0, y=1.0)], []),  # on the wall, and seen
        ([Landmark(id=1, x=1.0, y=1.0), Landmark(id=2, x=7.0, y=2.0)], [], ["landmarks.1"]),
        ([Landmark(id=1, x=6.0002, y=2.0, radius=0.0)], [], ["landmarks.0"]),
        ([], [Light(x=1.0, y=1.0), Light(x=0.0, y=2.0)], ["lights.1"]),
    ],
)
def test_marks_and_lamps_that_nobody_can_see_are_remarked_on(landmarks, lights, paths):
    found = advice(scenario(map=room(), landmarks=landmarks, lights=lights))
    assert [remark.partition(":")[0] for remark in found] == paths
