"""Where a robot is on its path."""

import numpy as np
import pytest

from amorsim.kernels.avoidance.guide import ahead_on, find_leg, to_go

PATH = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 5.0], [0.0, 5.0], [0.0, 0.0]])
ALONG = np.array([0.0, 10.0, 15.0, 25.0, 25.0])  # the last is beyond the path's end


@pytest.mark.parametrize(
    ("place", "leg", "found"),
    [
        ((3.0, 0.2), 0, (0, 3.0)),
        ((9.8, 1.5), 0, (1, 11.5)),  # beyond a first leg that is longer than it looks ahead
        ((8.0, 5.0), 1, (2, 17.0)),
        ((3.0, 4.9), 0, (0, 3.0)),  # the leg back is near, but too far along
        ((3.0, 0.0), 2, (2, 22.0)),  # never back
    ],
)
def test_the_nearest_leg_ahead(place, leg, found):
    assert find_leg(PATH, ALONG, 4, leg, 3.0, *place) == found


def test_a_path_of_one_point_is_its_goal():
    assert find_leg(PATH, ALONG, 1, 0, 3.0, 3.0, 4.0) == (0, 0.0)
    assert to_go(PATH, ALONG, 1, 0, 5.0, 2.0, 3.0, 4.0) == 5.0
    assert ahead_on(PATH, ALONG, 1, 0, 2.0) == (0.0, 0.0)


def test_the_way_to_go_is_along_the_path_and_beside_it():
    assert to_go(PATH, ALONG, 4, 0, 12.0, 2.0, 3.0, 0.5) == 25.0 - 3.0 + 2.0 * 0.5
    # The leg back is nearer to the end, but looked at only if the robot is about to get there.
    assert to_go(PATH, ALONG, 4, 0, 12.0, 2.0, 3.0, 4.0) == 25.0 - 14.0 + 2.0 * 7.0
    assert to_go(PATH, ALONG, 4, 0, 16.0, 2.0, 3.0, 4.0) == 25.0 - 22.0 + 2.0


def test_ahead_on_a_path():
    assert ahead_on(PATH, ALONG, 4, 0, 12.0) == (10.0, 2.0)
    assert ahead_on(PATH, ALONG, 4, 1, 99.0) == (0.0, 5.0)
