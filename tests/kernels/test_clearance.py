"""Gaps between bodies and the cells of a grid, against all cells one by one and where arithmetic is exact."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely.affinity import affine_transform

from amorsim.core.shapes import Shape, pack
from amorsim.kernels.collision.clearance import map_gaps
from amorsim.kernels.grid.draft import grid_from_array
from tests.examples import settings

BAND = 1e-12  # [m] rounding of the oracle's and the kernel's coordinates together stays far below this
SHAPES = [
    Shape.circle(0.25),
    Shape.circle(0.1, x=0.3, y=-0.2),
    Shape.rectangle(0.5, 0.4),
    Shape.rectangle(1.5, 0.01, x=0.5),
    Shape.polygon([(0, 0), (0.25, 0.2), (-0.2, 0), (0.25, -0.2)]),
    Shape.polygon([(0, 0), (0.5, 0), (0.25, 0.5)], rounding=0.125),
    Shape(vertices=(((-0.3, 0.0), (0.3, 0.0)),), radius=0.1, border=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))),
]
BODIES = pack(SHAPES)


def gaps(grid, frame, body, poses, cap=math.inf, bodies=BODIES):
    """Gaps and points of as many queries as there are poses."""
    poses = np.array(poses, dtype=float).reshape(-1, 3)
    count = len(poses)
    out = np.full(count, -7.0)
    where = np.full((count, 2), -7.0)
    body = np.broadcast_to(np.asarray(body, dtype=np.int64), (count,)).copy()
    cap = np.broadcast_to(np.asarray(cap, dtype=float), (count,)).copy()
    map_gaps(grid, *map(float, frame), bodies, body, poses, cap, out, where)
    return out, where


def gap(grid, frame, body, pose, cap=math.inf, bodies=BODIES):
    return float(gaps(grid, frame, body, [pose], cap, bodies)[0][0])


class Cells:
    """The plain twin: every occupied cell as a polygon, and the outside as a wide frame."""

    def __init__(self, cells, resolution, frame=(0.0, 0.0, 0.0)):
        self.grid = grid_from_array(np.asarray(cells, dtype=np.uint8), resolution)
        self.resolution, self.frame = resolution, frame
        rows, cols = np.nonzero(cells)
        height, width = np.shape(cells)
        far = 20.0 / resolution
        boxes = shapely.box(cols, rows, cols + 1, rows + 1).tolist()
        boxes += [
            shapely.box(-far, -far, 0, height + far), shapely.box(width, -far, width + far, height + far),
            shapely.box(-far, -far, width + far, 0), shapely.box(-far, height, width + far, height + far),
        ]  # fmt: skip
        x, y, yaw = frame
        c, s = resolution * math.cos(yaw), resolution * math.sin(yaw)
        self.boxes = np.array([affine_transform(box, [c, -s, s, c, x, y]) for box in boxes])

    def expected(self, shape, pose):
        """Distance less the radius; if the core overlaps, negative by an area that says how clearly."""
        c, s = math.cos(pose[2]), math.sin(pose[2])
        least = math.inf
        for part in shape.parts:
            kind = {1: shapely.Point, 2: shapely.LineString}.get(len(part), shapely.Polygon)
            placed = affine_transform(kind(part), [c, -s, s, c, pose[0], pose[1]])
            distance = float(shapely.distance(placed, self.boxes).min())
            if distance == 0.0 and shape.radius == 0.0:
                distance = -float(shapely.area(shapely.intersection(placed, self.boxes)).max())
            least = min(least, distance - shape.radius)
        return least

    def check(self, body, pose):
        expected = self.expected(SHAPES[body], pose)
        (found,), (where,) = gaps(self.grid, self.frame, body, [pose])
        if expected >= 0.0:
            assert -BAND < found <= expected + BAND
            assert found >= expected - BAND
            if expected > BAND:
                assert found > 0.0
        elif expected < -BAND:
            assert found < 0.0
        # The point is in an occupied place and, where nothing overlaps, as far from the body as the gap says.
        assert shapely.distance(shapely.Point(where), self.boxes).min() < BAND
        if found >= 0.0:
            c, s = math.cos(pose[2]), math.sin(pose[2])
            dx, dy = where[0] - pose[0], where[1] - pose[1]
            point = shapely.Point(c * dx + s * dy, c * dy - s * dx)
            kinds = {1: shapely.Point, 2: shapely.LineString}
            cores = [kinds.get(len(p), shapely.Polygon)(p) for p in SHAPES[body].parts]
            away = min(point.distance(part) for part in cores) - SHAPES[body].radius
            assert abs(away - found) < BAND


def random_cells(seed, share, shape):
    rng = np.random.default_rng(seed)
    return rng.random(shape) < share


WORLDS = [
    Cells(random_cells(1, 0.02, (30, 41)), 0.1),
    Cells(random_cells(2, 0.01, (90, 75)), 0.05, (-1.3, 2.7, 0.6)),
    Cells(random_cells(3, 0.002, (150, 200)), 0.03, (100.0, -50.0, -2.5)),
    Cells(np.zeros((20, 20)), 0.25, (0.0, 0.0, math.pi / 2)),
]


def random_poses(world, count, rng):
    """Poses in the world, most of them in the map and some around it."""
    height, width = world.grid.rows * world.resolution, world.grid.cols * world.resolution
    x, y, yaw = world.frame
    u = rng.uniform(-0.2, width + 0.2, count)
    v = rng.uniform(-0.2, height + 0.2, count)
    c, s = math.cos(yaw), math.sin(yaw)
    return np.c_[x + c * u - s * v, y + s * u + c * v, rng.uniform(-4, 4, count)]


@pytest.mark.parametrize("world", WORLDS, ids=["plain", "turned", "far", "empty"])
def test_random_bodies_agree_with_all_cells_one_by_one(world):
    rng = np.random.default_rng(7)
    for pose in random_poses(world, 200, rng):
        world.check(int(rng.integers(len(SHAPES))), pose)


@pytest.mark.long
@pytest.mark.parametrize("world", WORLDS, ids=["plain", "turned", "far", "empty"])
def test_many_random_bodies_agree_with_all_cells_one_by_one(world):
    rng = np.random.default_rng(8)
    for pose in random_poses(world, 20_000, rng):
        world.check(int(rng.integers(len(SHAPES))), pose)


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_any_small_grid_agrees_with_all_cells_one_by_one(data):
    rows, cols = data.draw(st.integers(1, 20)), data.draw(st.integers(1, 20))
    cells = np.zeros((rows, cols))
    for _ in range(data.draw(st.integers(0, 6))):
        cells[data.draw(st.integers(0, rows - 1)), data.draw(st.integers(0, cols - 1))] = 1
    coordinates = st.floats(-3, 3)
    frame = data.draw(st.tuples(coordinates, coordinates, coordinates))
    world = Cells(cells, data.draw(st.sampled_from([0.05, 0.1, 0.3, 1.0])), frame)
    for _ in range(5):
        pose = data.draw(st.tuples(coordinates, coordinates, coordinates))
        world.check(data.draw(st.integers(0, len(SHAPES) - 1)), pose)


@pytest.mark.parametrize("cap", [0.0, 0.02, 0.3])
def test_a_cap_only_caps(cap):
    rng = np.random.default_rng(9)
    for world in WORLDS:
        poses = random_poses(world, 3000, rng)
        body = rng.integers(0, len(SHAPES), 3000)
        free, _ = gaps(world.grid, world.frame, body, poses)
        capped, where = gaps(world.grid, world.frame, body, poses, cap)
        np.testing.assert_array_equal(capped < 0.0, free < 0.0)
        np.testing.assert_array_equal(capped[free >= 0.0], np.minimum(free, cap)[free >= 0.0])
        beyond = free > cap + BAND
        assert np.isnan(where[beyond]).all()
        assert not np.isnan(where[free < cap]).any()
        assert beyond.any()


def test_a_query_does_not_depend_on_the_others():
    rng = np.random.default_rng(10)
    world = WORLDS[1]
    poses = random_poses(world, 200, rng)
    body = rng.integers(0, len(SHAPES), 200)
    together, points = gaps(world.grid, world.frame, body, poses, 0.5)
    for q in range(200):
        alone, point = gaps(world.grid, world.frame, body[q], poses[q], 0.5)
        np.testing.assert_array_equal(alone[0], together[q])
        np.testing.assert_array_equal(point[0], points[q])


@settings(deadline=None)
@given(
    st.sampled_from(WORLDS),
    st.integers(0, len(SHAPES) - 1),
    st.integers(0, 10**6),
    st.floats(-4, 4),
    st.floats(0, 1),
)
def test_moving_by_no_more_than_the_gap_never_overlaps(world, body, seed, direction, fraction):
    (pose,) = random_poses(world, 1, np.random.default_rng(seed))
    free = gap(world.grid, world.frame, body, pose)
    if free > 0.0:
        step = fraction * free
        moved = (pose[0] + step * math.cos(direction), pose[1] + step * math.sin(direction), pose[2])
        assert gap(world.grid, world.frame, body, moved) >= 0.0


def test_the_whole_gap_straight_towards_the_nearest_point_touches_without_overlap():
    """The worst case of the property above."""
    rng = np.random.default_rng(11)
    touched = 0
    for world in WORLDS:
        poses = random_poses(world, 2000, rng)
        free, where = gaps(world.grid, world.frame, 0, poses)
        poses, free, where = (array[free > 1e-9] for array in (poses, free, where))
        away = np.hypot(*(where - poses[:, :2]).T)
        poses[:, :2] += (where - poses[:, :2]) * (free / away)[:, None]
        left, _ = gaps(world.grid, world.frame, 0, poses)
        assert (left >= 0.0).all()
        assert left.max() < BAND
        touched += len(left)
    assert touched > 1000


# Where arithmetic is exact: a map of unit cells at the origin, cell (5, 5) and a block of nine occupied.
UNIT = np.zeros((40, 70), dtype=np.uint8)
UNIT[5, 5] = 1
UNIT[20:23, 30:33] = 1
UNIT_GRID = grid_from_array(UNIT, 1.0)
HERE = (0.0, 0.0, 0.0)
EXACT = pack(
    [
        Shape.rectangle(2.0, 2.0),
        Shape.polygon([(2, 0), (0, 2), (-2, 0), (0, -2)]),
        Shape.circle(1.25),
        Shape.rectangle(0.25, 0.25),
        Shape.polygon([(0, 0), (5, 0), (5, 5), (0, 5), (0, 4), (4, 4), (4, 1), (0, 1)]),
    ]
)
SQUARE, DIAMOND, DISC, SMALL, MOUTH = range(5)
TINY = 2.0**-40


@pytest.mark.parametrize(
    ("body", "at", "into"),
    [
        (SQUARE, (4, 5.5), (1, 0)),  # against the cell's left side
        (SQUARE, (7, 5.5), (-1, 0)),
        (SQUARE, (5.5, 4), (0, 1)),
        (SQUARE, (5.5, 7), (0, -1)),
        (SQUARE, (4, 4), (1, 1)),  # corner on corner
        (SQUARE, (7, 7), (-1, -1)),
        (DIAMOND, (3, 5.5), (1, 0)),  # tip on a side
        (DIAMOND, (4, 4), (1, 1)),  # edge on a corner
        (DIAMOND, (7, 4), (-1, 1)),
        (DIAMOND, (24 + 5, 19), (1, 1)),
        (DISC, (3.75, 5.5), (1, 0)),
        (DISC, (5 - 0.75, 5 - 1.0), (1, 1)),  # three, four, five
        (DISC, (33 + 1.0, 23 + 0.75), (-1, -1)),
        (SQUARE, (1, 20), (-1, 0)),  # the outside of the map
        (SQUARE, (69, 20), (1, 0)),
        (SQUARE, (20, 1), (0, -1)),
        (SQUARE, (20, 39), (0, 1)),
        (DISC, (1.25, 1.25), (-1, -1)),
        (MOUTH, (29, 19), (0, 1)),  # around the block of nine, touching it above and below
        (MOUTH, (29, 19), (0, -1)),
    ],
)
def test_touching_is_free_and_the_least_step_further_overlaps(body, at, into):
    assert gap(UNIT_GRID, HERE, body, (*at, 0.0), bodies=EXACT) == 0.0
    further = (at[0] + TINY * into[0], at[1] + TINY * into[1], 0.0)
    assert gap(UNIT_GRID, HERE, body, further, bodies=EXACT) < 0.0
    assert gap(UNIT_GRID, HERE, body, further, cap=0.0, bodies=EXACT) < 0.0
    if body != MOUTH:
        back = (at[0] - 2.0**-20 * into[0], at[1] - 2.0**-20 * into[1], 0.0)
        assert 0.0 < gap(UNIT_GRID, HERE, body, back, bodies=EXACT) < 2.0**-19


def test_a_body_wholly_in_something_solid_overlaps():
    solid = grid_from_array(np.ones((300, 300), dtype=np.uint8), 0.01)
    for body in range(len(SHAPES)):
        assert gap(solid, HERE, body, (1.5, 1.5, 0.3)) < 0.0
    assert gap(UNIT_GRID, HERE, SMALL, (31.5, 21.5, 0.0), bodies=EXACT) < 0.0
    assert gap(UNIT_GRID, HERE, SMALL, (31.0, 21.0, 0.0), bodies=EXACT) < 0.0


def test_a_cell_wholly_in_a_body_overlaps():
    world = np.zeros((300, 300), dtype=np.uint8)
    world[150, 150] = 1
    assert gap(grid_from_array(world, 0.01), HERE, 2, (1.5, 1.5, 0.3)) < 0.0
    assert gap(grid_from_array(world, 0.01), HERE, 0, (1.5, 1.5, 0.3)) < 0.0


def test_a_body_wholly_outside_overlaps():
    for at in ((-5, 20), (75, 20), (20, -5), (20, 45), (-1e6, 1e6)):
        assert gap(UNIT_GRID, HERE, SQUARE, (*at, 0.0), bodies=EXACT) < 0.0


@settings(deadline=None, max_examples=300)
@given(st.data())
def test_integer_polygons_overlap_exactly_where_shapely_says(data):
    """On small integers both predicates are exact, so the sign must agree always, touching included."""
    corners = st.lists(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), min_size=3, max_size=6)
    try:
        shape = Shape.polygon(data.draw(corners))
    except ValueError:
        return
    x, y = data.draw(st.tuples(st.integers(0, 12), st.integers(0, 12)))
    placed = shapely.Polygon(shape.outline + np.array([x, y]))
    shapely.prepare(placed)
    cells = shapely.box(5, 5, 6, 6), shapely.box(-99, -99, 0, 99), shapely.box(-99, -99, 99, 0)
    expected = any(placed.relate_pattern(cell, "T********") for cell in cells)
    found = gap(UNIT_GRID, HERE, 0, (x, y, 0.0), bodies=pack([shape]))
    assert (found < 0.0) == expected


@given(st.integers(-20, 60), st.integers(-20, 60), st.integers(1, 24))
@settings(deadline=None, max_examples=300)
def test_discs_overlap_exactly_where_integers_say(x, y, radius):
    """In units of a quarter cell: a disc against cell (5, 5) and the two near sides of the map."""
    dx = max(20 - x, 0, x - 24)
    dy = max(20 - y, 0, y - 24)
    expected = dx * dx + dy * dy < radius * radius or x < radius or y < radius
    found = gap(UNIT_GRID, HERE, 0, (x / 4, y / 4, 0.0), bodies=pack([Shape.circle(radius / 4)]))
    assert (found < 0.0) == expected


def test_distances_in_the_open_are_found_across_pages_and_tables():
    """A grid of 1 mm cells wider than a table of the hierarchy, with three cells in it."""
    cells = np.zeros((600, 9000), dtype=np.uint8)
    places = [(300, 2), (310, 4500), (599, 8999)]
    for place in places:
        cells[place] = 1
    world = Cells(cells, 0.001, (10.0, 20.0, 0.0))
    small = Shape.circle(0.02)
    rng = np.random.default_rng(12)
    for x, y in rng.uniform((0.03, 0.03), (8.97, 0.57), (300, 2)):
        pose = (10.0 + x, 20.0 + y, 0.0)
        found = gap(world.grid, world.frame, 0, pose, bodies=pack([small]))
        assert found == pytest.approx(world.expected(small, pose), abs=BAND)


def test_free_space_gives_the_cap_to_the_bit_and_no_point():
    empty = grid_from_array(np.zeros((1000, 1000), dtype=np.uint8), 0.01)
    for cap in (0.0, 0.1, 1 / 3, 2.0):
        out, where = gaps(empty, HERE, 0, [(5.0, 5.0, 1.0)], cap)
        assert out[0] == cap
        assert np.isnan(where).all()


def test_the_point_of_contact_is_the_cells():
    (found,), (where,) = gaps(UNIT_GRID, HERE, DIAMOND, [(2.75, 5.25, 0.0)], bodies=EXACT)
    assert found == pytest.approx(0.25, abs=1e-13)
    np.testing.assert_array_equal(where, (5.0, 5.25))
    (found,), (where,) = gaps(UNIT_GRID, HERE, DISC, [(1.0, 30.0, 0.0)], bodies=EXACT)
    assert found < 0.0
    np.testing.assert_array_equal(where, (0.0, 30.0))


@pytest.mark.parametrize("pose", [(math.nan, 1, 0), (1, math.inf, 0), (1, 1, math.nan)])
def test_a_pose_that_is_not_finite_gives_nan(pose):
    out, where = gaps(UNIT_GRID, HERE, 0, [pose])
    assert np.isnan(out[0])
    assert np.isnan(where).all()
