"""Where a map is free, and has most room."""

from __future__ import annotations

import numpy as np
import pytest

from amorsim.core.errors import MapError
from amorsim.core.maps.free_places import free_places, freest_place
from amorsim.core.maps.map import Map
from amorsim.core.maps.roomiest_place import roomiest

ROOM = np.array([[0, 0, 4, 0], [4, 0, 4, 3], [4, 3, 0, 3], [0, 3, 0, 0]], dtype=float)


def test_the_freest_place_is_in_the_largest_room() -> None:
    # Two rooms in a field: the place is in the larger room, though there is more room in the field.
    rooms = np.concatenate([ROOM + 1.0, [[1, 1, 0, 0]], ROOM * 0.5 + [6.0, 1.0, 6.0, 1.0]])
    x, y = freest_place(Map.from_segments(rooms[[0, 1, 2, 3, 5, 6, 7, 8]], extent=(0, 0, 9, 5)))
    assert 1 < x < 5
    assert 1 < y < 4
    assert abs(y - 2.5) < 0.1
    assert min(x - 1, 5 - x) > 1.4


def test_a_hollow_pillar_is_no_room() -> None:
    pillar = ROOM * 0.1 + [4.8, 4.8, 4.8, 4.8]
    x, y = freest_place(Map.from_segments(pillar, extent=(0, 0, 10, 10), resolution=0.01))
    assert not (4.8 <= x <= 5.2 and 4.8 <= y <= 5.1)


def test_a_place_is_found_however_fine_the_rooms() -> None:
    # Rooms 0.2 m wide in a map of 50 m: at a 256th of it no coarse cell is free.
    lines = np.arange(0, 50.2, 0.2)
    walls = np.concatenate([[[x, 0, x, 50] for x in lines], [[0, y, 50, y] for y in lines]])
    world = Map.from_segments(walls, resolution=0.01)
    place = freest_place(world)
    assert not world.occupied([place]).any()
    assert freest_place(world) == place


def test_a_full_map_has_no_place() -> None:
    with pytest.raises(MapError, match=r"the map, 5 m x 5 m, has no free place of 1 m x 1 m; .*unit or scale"):
        freest_place(Map.from_array(np.ones((5, 5)), resolution=1.0))


def test_roomiest_is_the_middle_of_a_free_square() -> None:
    free = np.zeros((9, 20), dtype=bool)
    free[2:7, 3:8] = True
    assert roomiest(free) == (4, 5, 3)
    # Along a hall of even width its middle, and not an end.
    free = np.zeros((5, 31), dtype=bool)
    free[1:4, 1:30] = True
    assert roomiest(free) == (2, 15, 2)
    assert roomiest(np.zeros((4, 4), dtype=bool)) is None


def test_free_places_are_joined_to_the_roomiest() -> None:
    """Not in a hollow block, nor around the building; those of the largest hall, and through its doors."""
    hall = [(2, 2, 12, 2), (12, 2, 12, 8), (12, 8, 2, 8), (2, 8, 2, 2), (8, 2, 8, 4.5), (8, 5.5, 8, 8)]
    block = [(4, 4, 5, 4), (5, 4, 5, 5), (5, 5, 4, 5), (4, 5, 4, 4)]
    world = Map.from_segments(np.array(hall + block, dtype=float), extent=(0, 0, 16, 10), resolution=0.01)
    places, side = free_places(world)
    assert ((places > (2, 2)) & (places < (12, 8))).all()
    assert not ((places > (4, 4)) & (places < (5, 5))).all(axis=1).any()
    assert (places[:, 0] > 8).any()  # beyond the door
    assert len(places) * side * side == pytest.approx(59.0, rel=0.1)
    assert not world.occupied(places).any()


def test_nothing_unknown_is_a_free_place() -> None:
    # A wide unknown field beside a small known room, both free to drive in.
    cells, unknown = np.zeros((40, 100)), np.zeros((40, 100))
    unknown[:, 20:] = 1
    world = Map.from_array(cells, unknown=unknown, resolution=0.1)
    assert freest_place(world)[0] < 2.0
    assert free_places(world)[0][:, 0].max() < 2.0
    assert freest_place(Map.from_array(cells, resolution=0.1))[0] == pytest.approx(5.0, abs=0.2)
