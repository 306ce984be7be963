"""Which places walls shut off, against exact geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.core.maps.connectivity import shut_off
from tests.examples import settings

SIDE = 6.0
corner = st.tuples(st.floats(0.0, SIDE), st.floats(0.0, SIDE))


def joined(free: shapely.Geometry, one: tuple[float, float], other: tuple[float, float]) -> bool | None:
    """Whether two places are in one part of what is free; None where either is not free."""
    parts = [part for part in shapely.get_parts(free) if part.contains(shapely.Point(one))]
    if not parts or not free.contains(shapely.Point(other)):
        return None
    return bool(parts[0].contains(shapely.Point(other)))


@settings(max_examples=60, deadline=None)
@given(
    walls=st.lists(st.tuples(corner, corner), min_size=1, max_size=8),
    places=st.lists(corner, min_size=2, max_size=6),
    room=st.floats(0.1, 0.4),
    resolution=st.sampled_from([0.01, 0.05]),
)
def test_only_what_is_certain_is_said_and_of_that_nearly_all(
    walls: list[tuple[tuple[float, float], tuple[float, float]]],
    places: list[tuple[float, float]],
    room: float,
    resolution: float,
) -> None:
    border = [(0, 0, SIDE, 0), (SIDE, 0, SIDE, SIDE), (SIDE, SIDE, 0, SIDE), (0, SIDE, 0, 0)]
    segments = [*border, *((*a, *b) for a, b in walls)]
    world = am.Map.from_segments(np.array(segments, dtype=float), resolution=resolution)
    lines = shapely.MultiLineString([[line[:2], line[2:]] for line in segments])
    inside = shapely.box(0.0, 0.0, SIDE, SIDE)
    # A wall is its line's cells, none of which is farther from it than a diagonal.
    surely_free = inside.difference(lines.buffer(room + 1.5 * resolution))
    perhaps_free = inside.difference(lines.buffer(max(0.6 * room - 1.5 * resolution, 1e-3)))
    start, *others = places
    said = shut_off(world, room, start, others)
    for place, is_shut in zip(others, said.tolist(), strict=True):
        if joined(surely_free, start, place):
            assert not is_shut
        both_are_free = joined(surely_free, start, place) is not None
        if both_are_free and joined(perhaps_free, start, place) is False:
            assert is_shut


@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_a_map_that_is_turned_and_moved_is_looked_at_in_its_frame(yaw: float) -> None:
    cells = np.zeros((40, 80), dtype=np.uint8)
    cells[:, 40] = 1
    world = am.Map.from_array(cells, resolution=0.1, origin=(5.0, -3.0, yaw))

    def at(x: float, y: float) -> tuple[float, float]:
        c, s = math.cos(yaw), math.sin(yaw)
        return 5.0 + c * x - s * y, -3.0 + s * x + c * y

    assert shut_off(world, 0.2, at(1.0, 2.0), [at(3.0, 1.0), at(6.0, 2.0)]).tolist() == [False, True]


def test_a_world_too_large_to_look_at_closely_is_not_judged() -> None:
    world = am.Map.from_segments([(0, 0, 0, 9000), (500, 0, 500, 9000)], resolution=0.01)
    assert shut_off(world, 0.1, (100.0, 10.0), [(700.0, 10.0)]).tolist() == [False]
