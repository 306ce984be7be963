"""The memory of what was seen: where in a cell, and what of it counts for a robot that turns or backs."""

import math

import numpy as np
import pytest

from amorsim.kernels.avoidance.arcs import Box
from amorsim.kernels.avoidance.seen_window import Window, guard, remember
from amorsim.kernels.behaviours.free_space import Sight

BOX = Box(-0.25, 0.25, -0.2, 0.2, math.inf)  # rear, front, right, left
SIZE, SIDE = 80, 0.05
LIMITS = np.array([[1.0, 2.0, 1.0, 4.0]])


def sight(ranges, half=0.75 * math.pi):
    """Beams over 270 degrees from the base point."""
    ranges = np.atleast_2d(np.asarray(ranges, dtype=float))
    count = ranges.shape[1]
    headings = np.linspace(-half, half, count)
    none = np.zeros(count)
    beams = np.stack((none, none, headings, np.cos(headings), np.sin(headings)))[None]
    return Sight(ranges, np.ascontiguousarray(beams), np.zeros((1, 1)), 1)


NOTHING = sight(np.full(7, np.inf))


def empty():
    seen = np.full((1, SIZE, SIZE), -1e30, dtype=np.float32)
    corner = np.full((1, 2), -(2**40), dtype=np.int64)
    return Window(seen, corner, SIDE, np.zeros((1, SIZE, SIZE, 2), dtype=np.int8))


def seen_at(x, y, pose=(0.0, 0.0, 0.0)):
    """A memory of one place [m] in the world, seen from a pose."""
    window = empty()
    far, bearing = math.hypot(x - pose[0], y - pose[1]), math.atan2(y - pose[1], x - pose[0]) - pose[2]
    one = np.array([[0.0], [0.0], [bearing], [math.cos(bearing)], [math.sin(bearing)]])[None]
    look = Sight(np.array([[far]]), one, np.zeros((1, 1)), 1)
    remember(look, np.array([pose]), np.zeros((1, 1)), np.ones(1, dtype=np.int64), window, 0, 1)
    return window


def guarded(window, wanted, present=NOTHING, margin=0.01, pose=(0.0, 0.0, 0.0)):
    """The twist of a robot at rest that wants another, one step of 0.1 s later."""
    moving, out = np.zeros((1, 2)), np.zeros((1, 3))
    none, since = np.zeros((1, 1)), np.full((1, 1), -1.0)
    asked = np.array([wanted]), np.ones((1, 1), dtype=bool), 0.1
    guard(present, none, np.array([pose]), BOX, np.full((1, 1), margin), LIMITS, window, since, *asked, moving, out)
    return out[0, 0], out[0, 2]


BACK, TURN = (-0.1, 0.0), (0.0, 0.3)


@pytest.mark.parametrize("place", [(-0.612, 0.343), (0.0, 0.0), (1.24999999, -0.98)])
def test_a_place_is_remembered_to_a_part_of_its_cell(place):
    window = seen_at(*place, pose=(0.5, 0.7, 0.3))
    row, col = np.argwhere(window.seen[0] > -1.0)[0]
    at = [(n + 0.5 + (part + 0.5) / 256) * SIDE for n, part in zip((col, row), window.place[0, row, col], strict=True)]
    # Cells are those of the world modulo the window's.
    off = (np.array(at) - place + 0.5 * SIZE * SIDE) % (SIZE * SIDE) - 0.5 * SIZE * SIDE
    np.testing.assert_allclose(off, 0.0, atol=0.5 * SIDE / 256 + 1e-9)


def test_something_behind_holds_a_robot_that_backs():
    assert guarded(empty(), BACK)[0] < 0.0
    assert guarded(seen_at(-0.264, 0.0), BACK)[0] == 0.0


def test_a_robot_backs_past_what_is_next_to_its_way_though_the_middle_of_its_cell_is_in_it():
    """Its side is at y = 0.23 m; a post is at 0.245 m, and the middle of the post's cell at 0.225 m."""
    pose = (0.0, 0.03, 0.0)
    assert guarded(seen_at(-0.264, 0.245, pose), BACK, pose=pose)[0] < 0.0
    assert guarded(seen_at(-0.264, 0.226, pose), BACK, pose=pose)[0] == 0.0


def test_where_the_robot_stands_there_is_nothing_whatever_it_remembers():
    for place in ((-0.1, 0.1), (-0.24, 0.0)):
        assert guarded(seen_at(*place, pose=(0.9, 0.0, math.pi)), BACK)[0] < 0.0
        assert guarded(seen_at(*place, pose=(0.9, 0.0, math.pi)), TURN)[1] > 0.0


def test_in_sight_the_present_reading_counts():
    """It remembers something 1.5 mm off its side, near the corner; if it were there, the robot would not turn."""
    pose = (0.0, 0.03, 0.0)
    remembered = seen_at(0.24, 0.2315, pose)
    assert guarded(remembered, TURN, pose=pose)[1] > 0.0
    sees = sight(np.full(3, math.hypot(0.24, 0.2015)), half=math.atan2(0.2015, 0.24))
    assert guarded(empty(), TURN, present=sees, pose=pose)[1] == 0.0
    looks_elsewhere = sight(np.full(3, np.inf), half=0.2)
    assert guarded(remembered, TURN, present=looks_elsewhere, pose=pose)[1] == 0.0
