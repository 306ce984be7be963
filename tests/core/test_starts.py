"""Starts on a map: what is said where no footprint fits."""

from __future__ import annotations

import numpy as np
import pytest

from amorsim.core.errors import MapError
from amorsim.core.maps.footprint_room import freest_start
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape


def test_no_room_is_said_with_the_room_that_there_is() -> None:
    # A corridor of 0.4 m between thick walls: of an overlap, how deep it is in one cell says nothing.
    cells = np.ones((40, 60))
    cells[16:24, 2:58] = 0
    with pytest.raises(MapError) as caught:
        freest_start(Map.from_array(cells, resolution=0.05), Shape.rectangle(0.6, 0.5))
    message = str(caught.value)
    assert "a footprint that reaches 0.391 m from its base point fits: " in message
    assert "is 0.175 m from the nearest wall, and the map is 3 m x 2 m. Take a smaller robot, or if the map" in message
    assert message.endswith("is larger in fact, say so by its resolution, size, unit or scale")


def test_a_robot_that_fits_where_a_heading_allows_it_gets_that_place() -> None:
    cells = np.ones((60, 40))
    cells[2:58, 16:24] = 0
    x, y, heading = freest_start(Map.from_array(cells, resolution=0.05), Shape.rectangle(0.6, 0.34))
    assert 0.8 < x < 1.2
    assert 0.1 < y < 2.9
    assert abs(abs(heading) - np.pi / 2) < 1e-9
