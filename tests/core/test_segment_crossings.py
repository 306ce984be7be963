"""How much of a way lies in a shape, against many points along it."""

import math

import numpy as np
import pytest

from amorsim.core.segment_crossings import contains, share_rolled, share_within
from amorsim.core.shapes import Shape

SHAPES = {
    "circle": Shape.circle(0.7, x=0.2, y=-0.1),
    "rectangle": Shape.rectangle(1.4, 0.5, x=-0.1),
    "triangle": Shape.polygon([(-0.8, -0.6), (0.9, -0.2), (0.1, 0.8)]),
    "hook": Shape.polygon([(-0.8, -0.8), (0.8, -0.8), (0.8, 0.8), (0.3, 0.8), (0.3, -0.3), (-0.8, -0.3)]),
}
POINTS = 4001


def is_inside(name, shape, points):
    """Straight from the definition: distance from the centre, or how often a ray to the right meets the border."""
    if name == "circle":
        return np.hypot(points[:, 0] - 0.2, points[:, 1] + 0.1) <= 0.7
    inside = np.zeros(len(points), dtype=bool)
    corners = shape.outline
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if y0 == y1:
            continue
        at = x0 + (points[:, 1] - y0) / (y1 - y0) * (x1 - x0)
        inside ^= ((y0 > points[:, 1]) != (y1 > points[:, 1])) & (points[:, 0] < at)
    return inside


@pytest.mark.parametrize("name", SHAPES)
def test_shares_are_those_of_many_points(name):
    rng = np.random.default_rng(5)
    start, end = rng.uniform(-1.2, 1.2, (2, 300, 2))
    share = share_within(SHAPES[name], start, end)
    parts = np.linspace(0.0, 1.0, POINTS)[:, None]
    for a, b, found in zip(start, end, share, strict=True):
        expected = is_inside(name, SHAPES[name], a + parts * (b - a)).mean()
        # A straight line meets the border of the hook six times at most, at each of which a point may be missed.
        assert found == pytest.approx(expected, abs=6.0 / POINTS)
    assert (contains(SHAPES[name], start) == is_inside(name, SHAPES[name], start)).all()


@pytest.mark.parametrize("name", SHAPES)
def test_of_no_way_all_or_nothing_lies_inside(name):
    points = np.random.default_rng(6).uniform(-1.2, 1.2, (200, 2))
    assert (share_within(SHAPES[name], points, points) == is_inside(name, SHAPES[name], points)).all()


def test_a_way_wholly_inside_counts_in_full_and_one_along_a_cut_once():
    hook = SHAPES["hook"]
    (first, *_) = hook.parts
    ends = np.array([first[0], first[1]])
    assert share_within(hook, ends[:1], ends[1:])[0] <= 1.0
    inner = np.array([[-0.5, -0.6]]), np.array([[0.5, -0.6]])
    assert share_within(hook, *inner).tolist() == [1.0]


def test_chords_of_a_circle():
    circle = Shape.circle(1.0)
    for height in (0.0, 0.3, 0.9, 0.999):
        chord = share_within(circle, np.array([[-2.0, height]]), np.array([[2.0, height]]))
        assert chord[0] == pytest.approx(2.0 * math.sqrt(1.0 - height**2) / 4.0, rel=1e-12)
    assert share_within(circle, np.array([[-2.0, 1.0 + 1e-9]]), np.array([[2.0, 1.0 + 1e-9]]))[0] == 0.0


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("ratio", [0.4, 1.0, 1.7])
def test_shares_rolled_are_those_of_small_steps(name, ratio):
    rng = np.random.default_rng(7)
    start, end = rng.uniform(-1.2, 1.2, (2, 100, 2))
    found = share_rolled(SHAPES[name], start, end, np.full(100, ratio))
    count = 4000
    place, inside = np.zeros((100, 1)), np.zeros(100)
    for _ in range(count):
        within = is_inside(name, SHAPES[name], start + place * (end - start))
        inside += within
        place[:, 0] += np.where(within, ratio, 1.0) / count
    # At each of six borders, a step may be counted wrongly, and what follows shifts by as much.
    assert found == pytest.approx(inside / count, abs=12.0 / count)
    if ratio == 1.0:
        assert found == pytest.approx(share_within(SHAPES[name], start, end), abs=1e-12)
