"""The map that an estimator believes in, as a map."""

import numpy as np
import pytest

import amorsim as am

GRID = np.array([[0.9, 0.1, np.nan], [0.5, 0.65, 0.35]])
BELIEFS = {"occupancy": GRID, "occupancy_origin": np.array([1.0, -2.0]), "occupancy_resolution": np.array(0.5)}


def test_cells_are_occupied_free_or_unknown():
    found = am.estimated_map(BELIEFS, name="mine")
    np.testing.assert_array_equal(found.to_array(), [[1, 0, 0], [0, 0, 0]])
    np.testing.assert_array_equal(found.unknown_array(), [[0, 0, 1], [1, 1, 1]])
    assert found.origin == (1.0, -2.0, 0.0)
    assert found.resolution == 0.5
    assert found.name == "mine"


def test_one_of_several_robots_is_asked_for():
    beliefs = {
        "occupancy": np.stack((GRID, GRID[::-1])),
        "occupancy_origin": np.array([[1.0, -2.0], [3.0, 4.0]]),
        "occupancy_resolution": np.array([0.5, 0.25]),
    }
    found = am.estimated_map(beliefs, 1)
    np.testing.assert_array_equal(found.to_array(), [[0, 0, 0], [1, 0, 0]])
    assert (found.origin, found.resolution) == ((3.0, 4.0, 0.0), 0.25)
    with pytest.raises(am.MapError, match="one of the 2 robots, counted from 0, got 2"):
        am.estimated_map(beliefs, 2)


def test_it_is_saved_for_ros_and_read_again(tmp_path):
    found = am.save_map(am.estimated_map(BELIEFS), tmp_path / "mine.yaml")
    again = am.load_map(tmp_path / "mine.yaml")
    np.testing.assert_array_equal(again.unknown_array(), [[0, 0, 1], [1, 1, 1]])
    assert again.origin == found.origin


def test_bounds_are_given():
    found = am.estimated_map(BELIEFS, occupied=0.5, free=0.5)
    np.testing.assert_array_equal(found.to_array(), [[1, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(found.unknown_array(), [[0, 0, 1], [1, 0, 0]])
    with pytest.raises(am.MapError, match="0 <= free <= occupied <= 1"):
        am.estimated_map(BELIEFS, occupied=0.2)


def test_beliefs_without_a_map_are_refused():
    with pytest.raises(am.MapError, match=r"expected 'occupancy'.*got gyro_bias"):
        am.estimated_map({"gyro_bias": np.zeros(1)})
