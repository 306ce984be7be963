"""Rays against bodies, against shapely and against every edge one by one in longer arithmetic."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely.affinity import affine_transform

from amorsim.core.shapes import Shape, pack
from amorsim.kernels.collision.body_hash import BodyHash, hash_bodies
from amorsim.kernels.raycast.body_beams import cast_beams
from amorsim.kernels.raycast.body_rays import cast_bodies
from tests.examples import settings

SHAPES = [
    Shape.circle(0.25),
    Shape.circle(0.1, x=0.3, y=-0.2),
    Shape.rectangle(0.5, 0.4),
    Shape.rectangle(2.0, 0.01, x=0.5),
    Shape.polygon([(0, 0), (0.25, 0.2), (-0.2, 0), (0.25, -0.2)]),
    Shape.polygon([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0.9), (0.9, 0.9), (0.9, 0.1), (0, 0.1)]),
    Shape.polygon([(0, 0), (0.5, 0), (0.25, 0.5)], rounding=0.125),
    Shape(vertices=(((-0.5, 0.0), (0.5, 0.0)),), radius=0.2, border=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))),
]


class Scene:
    """Bodies by replica, and one sensor a row; `cast` returns ranges and what was hit.

    By default bodies are looked at one by one, in one bucket; `buckets` are rows and columns of a hash.
    """

    def __init__(self, shapes, poses, replica_first=None, buckets=(1, 1), owner=None):
        self.shapes = list(shapes)
        self.bodies = pack(self.shapes)
        self.poses = np.array(poses, dtype=float).reshape(-1, 3)
        first = [0, len(self.shapes)] if replica_first is None else replica_first
        self.first = np.array(first, dtype=np.int64)
        self.owner = np.arange(len(self.shapes)) if owner is None else np.array(owner, dtype=np.int64)
        self.widest = max(self.bodies.reach, default=1.0)
        rows, cols = buckets
        self.table = BodyHash(
            side=2.0 * self.widest,
            rows=rows,
            cols=cols,
            first=np.empty((len(self.first) - 1) * rows * cols + 1, dtype=np.int64),
            body=np.empty(len(self.shapes), dtype=np.int64),
            owner=np.empty(len(self.shapes), dtype=np.int64),
            disc=np.empty((len(self.shapes), 3)),
        )
        hash_bodies(self.poses, self.bodies.reach, self.owner, self.first, self.table)

    def around(self, rows, own, replica):
        """The first arguments of all kernels that look at bodies: these, and whose and where the sensors are."""
        return (
            self.bodies,
            self.poses,
            max((sum(map(len, shape.parts)) for shape in self.shapes), default=0),
            self.table,
            self.widest,
            np.broadcast_to(np.asarray(replica, dtype=np.int64), (rows,)).copy(),
            np.broadcast_to(np.asarray(own, dtype=np.int64), (rows,)).copy(),
        )

    def cast(
        self,
        origins,
        bearings,
        *,
        own=-1,
        replica=0,
        range_max=math.inf,
        walls=math.inf,
        asks=True,
        by=cast_bodies,
    ):
        origins = np.array(origins, dtype=float).reshape(-1, 3)
        bearings = np.atleast_2d(np.asarray(bearings, dtype=float))
        rows, beams = len(origins), bearings.shape[1]
        out = np.broadcast_to(np.asarray(walls, dtype=float), (rows, beams)).copy()
        hit = np.full(out.shape, -1, dtype=np.int64)
        by(
            *self.around(rows, own, replica),
            origins,
            np.cos(bearings),
            np.sin(bearings),
            np.atleast_1d(np.asarray(range_max, dtype=float)),
            out,
            hit if asks else np.empty((0, 0), dtype=np.int64),
        )
        return out, hit


def direction(heading, bearing):
    ch, sh, cb, sb = math.cos(heading), math.sin(heading), math.cos(bearing), math.sin(bearing)
    return ch * cb - sh * sb, sh * cb + ch * sb


def random_scene(seed, count=12, spread=3.0):
    rng = np.random.default_rng(seed)
    shapes = [SHAPES[i] for i in rng.integers(0, len(SHAPES), count)]
    poses = np.c_[rng.uniform(-spread, spread, (count, 2)), rng.uniform(-4, 4, count)]
    return Scene(shapes, poses), rng


# shapely ------------------------------------------------------------------------------------------


def placed(shape, pose, grow=0.0):
    """The shape as one shapely geometry, grown by a little; round corners become chords."""
    kinds = {1: shapely.Point, 2: shapely.LineString}
    c, s = math.cos(pose[2]), math.sin(pose[2])
    frame = [c, -s, s, c, *pose[:2]]
    cores = [affine_transform(kinds.get(len(part), shapely.Polygon)(part), frame) for part in shape.parts]
    radius = shape.radius + grow
    whole = shapely.union_all(cores)
    return whole.buffer(radius, quad_segs=500 if shape.radius else 8) if radius else whole


def shapely_ranges(geometry, origin, directions, far=20.0):
    start = np.array(origin)
    lines = shapely.linestrings([[start, start + far * np.array(along)] for along in directions])
    distances = shapely.distance(shapely.intersection(geometry, lines), shapely.Point(origin))
    return np.where(np.isnan(distances), math.inf, distances)  # nan from an empty intersection


def check_against_shapely(shape, pose, origin, heading, bearings):
    """Ranges lie between those to a slightly larger and a slightly smaller body, and agree but at glances."""
    (ranges,), (hits,) = Scene([shape], [pose]).cast((*origin, heading), bearings)
    grow = 1e-6 if shape.radius else 2e-8  # a chord's sagitta is 3e-7 m
    directions = [direction(heading, bearing) for bearing in bearings]
    least, expected, most = (shapely_ranges(placed(shape, pose, d), origin, directions) for d in (grow, 0.0, -grow))
    assert (least <= ranges).all()
    assert (ranges <= most).all()
    with np.errstate(invalid="ignore"):
        facing = most - least < 50 * grow
    np.testing.assert_allclose(ranges[facing], expected[facing], rtol=0, atol=1e-5 if shape.radius else 1e-12)
    np.testing.assert_array_equal(hits, np.where(ranges < math.inf, 0, -1))
    return np.isfinite(ranges).sum()


def check_many(count, seed):
    rng = np.random.default_rng(seed)
    seen = 0
    for n in range(count // 10):
        shape = SHAPES[n % len(SHAPES)]
        pose = (*rng.uniform(-1, 1, 2), rng.uniform(-4, 4))
        origin = tuple(rng.uniform(-2, 2, 2))
        towards = math.atan2(pose[1] - origin[1], pose[0] - origin[0])
        heading = rng.uniform(-4, 4)
        bearings = towards - heading + rng.normal(0, 0.4, 10)
        seen += check_against_shapely(shape, pose, origin, heading, bearings)
    assert 0.3 * count < seen < 0.95 * count


@pytest.mark.long
def test_three_thousand_random_rays_agree_with_shapely():
    check_many(3000, 1)


@pytest.mark.nightly
def test_a_hundred_thousand_random_rays_agree_with_shapely():
    check_many(100_000, 2)


# The plain twin: every edge and every arc one by one, in the longest floats there are -------------


def twin_ranges(shape, pose, origin, heading, bearing):
    """Distances to every crossing of the outlines of the parts, and the sine of the angle between at each."""
    L = np.longdouble
    d = np.array(direction(heading, bearing), dtype=L)
    c, s = np.cos(L(pose[2])), np.sin(L(pose[2]))
    crossings = []
    for part in shape.parts:
        v = part.astype(L)
        v = np.stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1]], axis=1)
        v += np.array(pose[:2], dtype=L) - np.array(origin, dtype=L)
        if shape.radius:
            for x, y in v:
                along, across = d[0] * x + d[1] * y, d[0] * y - d[1] * x
                square = L(shape.radius) ** 2 - across**2
                if square > 0:
                    half = np.sqrt(square)
                    crossings += [
                        (along - half, half / L(shape.radius)),
                        (along + half, half / L(shape.radius)),
                    ]
        if len(v) > 1:
            edge = np.roll(v, -1, axis=0) - v
            length = np.hypot(edge[:, 0], edge[:, 1])
            normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / length[:, None]
            start = v + L(shape.radius) * normal
            for p, e, n, size in zip(start, edge, normal, length, strict=True):
                speed = d @ n
                if speed != 0:
                    t = (p @ n) / speed
                    where = (t * d - p) @ e / size
                    if 0 <= where <= size:
                        crossings.append((t, abs(speed)))
    return sorted(crossings)


@pytest.mark.parametrize("far", [0.0, 1000.0], ids=["near", "far"])
def test_ranges_are_exact_to_a_few_units_in_the_last_place(far):
    """From outside a convex body: the first crossing, within what a few ulp of its place can do."""
    rng = np.random.default_rng(3)
    convex = [shape for shape in SHAPES if len(shape.parts) == 1]
    checked, worst = 0, 0.0
    for n in range(3000):
        shape = convex[n % len(convex)]
        pose = (*(far + rng.uniform(-1, 1, 2)), rng.uniform(-4, 4))
        angle = rng.uniform(-4, 4)
        origin = (pose[0] + 2 * math.cos(angle), pose[1] + 2 * math.sin(angle))
        heading = rng.uniform(-4, 4)
        bearing = angle + math.pi - heading + rng.normal(0, 0.15)
        (((found,),), _) = Scene([shape], [pose]).cast((*origin, heading), [bearing])
        crossings = twin_ranges(shape, pose, origin, heading, bearing)
        if not crossings or min(sine for _, sine in crossings) < 0.05:
            continue
        expected, sine = crossings[0]
        place = abs(expected) + shape.reach  # far from the world's origin is not an excuse: the difference is exact
        worst = max(worst, abs(float(found - expected)) * float(sine) / (place * 2.0**-52))
        checked += 1
    assert checked > 1000
    assert worst < 8.0


# What is exact ------------------------------------------------------------------------------------


def test_a_beam_at_a_square_and_at_a_circle_reads_the_distance():
    scene = Scene([Shape.rectangle(1.0, 1.0), Shape.circle(0.5)], [(3.0, 0.0, 0.0), (0.0, 4.0, 1.0)])
    ranges, hits = scene.cast([(0.0, 0.0, 0.0), (0.0, 1.0, 0.0)], [0.0])
    assert ranges.tolist() == [[2.5], [math.inf]]
    assert hits.tolist() == [[0], [-1]]
    ranges, hits = scene.cast((0.5, 4.0, 0.0), [0.0])
    assert (ranges[0, 0], hits[0, 0]) == (0.0, 1)  # a start on the border
    ranges, hits = scene.cast((1.5, 4.0, math.pi), [0.0])
    assert ranges[0, 0] == pytest.approx(1.0, abs=1e-15)


def test_a_ray_along_an_edge_meets_the_corner():
    """Borders belong to the body."""
    scene = Scene([Shape.rectangle(1.0, 1.0)], [(3.0, 0.0, 0.0)])
    assert scene.cast((0.0, 0.5, 0.0), [0.0])[0][0, 0] == 2.5
    assert scene.cast((0.0, 0.5 + 2.0**-40, 0.0), [0.0])[0][0, 0] == math.inf


@pytest.mark.parametrize("index", range(len(SHAPES)))
def test_a_start_inside_reads_zero_in_every_direction(index):
    shape = SHAPES[index]
    pose = (0.7, -0.3, 0.9)
    inner = placed(shape, pose, -1e-4)
    rng = np.random.default_rng(4)
    starts = [p for p in rng.uniform(-2, 2, (20_000, 2)) if inner.contains(shapely.Point(p))][:20]
    if not starts:
        starts = [inner.representative_point().coords[0]]
    ranges, hits = Scene([shape], [pose]).cast([(*p, 0.3) for p in starts], np.linspace(-4, 4, 40))
    assert (ranges == 0.0).all()
    assert (hits == 0).all()


# Who is seen --------------------------------------------------------------------------------------


def fan(count, width=2 * math.pi, start=-math.pi):
    return start + width * np.arange(count) / count


def test_a_nearer_wall_is_kept_and_a_farther_one_is_not():
    scene = Scene([Shape.rectangle(1.0, 1.0)], [(3.0, 0.0, 0.0)])
    for walls, expected, body in ((2.0, 2.0, -1), (2.5, 2.5, -1), (2.75, 2.5, 0)):
        ranges, hits = scene.cast((0.0, 0.0, 0.0), [0.0], walls=walls)
        assert (ranges[0, 0], hits[0, 0]) == (expected, body)


def test_nothing_is_seen_beyond_the_range():
    scene = Scene([Shape.rectangle(1.0, 1.0)], [(3.0, 0.0, 0.0)])
    origins = [(0.0, 0.0, 0.0)] * 3
    ranges, hits = scene.cast(origins, [0.0], range_max=[2.5, np.nextafter(2.5, 0.0), 9.0])
    assert ranges.tolist() == [[2.5], [math.inf], [2.5]]
    assert hits.tolist() == [[0], [-1], [0]]


def test_a_sensor_sees_neither_its_own_body_nor_another_replica():
    scene = Scene([SHAPES[0]] * 4, [(0, 0, 0), (2, 0, 0), (0, 0, 0), (3, 0, 0)], replica_first=[0, 2, 4])
    ranges, hits = scene.cast([(0, 0, 0)] * 4, [0.0], own=[0, 2, -1, 3], replica=[0, 1, 1, 1])
    assert ranges.tolist() == [[1.75], [2.75], [0.0], [0.0]]
    assert hits.tolist() == [[1], [3], [2], [2]]


def test_of_bodies_equally_far_the_lowest_index_counts():
    scene = Scene([SHAPES[2]] * 3, [(5, 0, 0), (2, 0, 0), (2, 0, 0)])
    assert scene.cast((0, 0, 0), [0.0])[1][0, 0] == 1


def test_the_order_of_bodies_changes_no_range():
    scene, rng = random_scene(5)
    origins = np.c_[rng.uniform(-3, 3, (20, 2)), rng.uniform(-4, 4, 20)]
    ranges, hits = scene.cast(origins, fan(181))
    order = rng.permutation(len(scene.shapes))
    other = Scene([scene.shapes[i] for i in order], scene.poses[order])
    again, others = other.cast(origins, fan(181))
    np.testing.assert_array_equal(again, ranges)
    once = (ranges > 0.0) & (hits >= 0)
    np.testing.assert_array_equal(order[others[once]], hits[once])
    assert once.sum() > 500


@pytest.mark.parametrize("spread", [0.5, 3.0, 50.0])
@pytest.mark.parametrize("scan", [fan(181), fan(181, 1.5, -0.7), np.linspace(-math.pi, math.pi, 90), fan(7, 6, 2)])
def test_leaving_out_beams_by_their_angle_changes_no_bit(spread, scan):
    """A scan in order is cut to the beams that can hit; the same beams shuffled, or each alone, are not."""
    scene, rng = random_scene(6, count=30, spread=spread)
    origins = np.c_[rng.uniform(-spread, spread, (30, 2)), rng.uniform(-4, 4, 30)]
    ranges, hits = scene.cast(origins, scan)
    order = rng.permutation(len(scan))
    shuffled, shuffled_hits = scene.cast(origins, scan[order])
    np.testing.assert_array_equal(shuffled, ranges[:, order])
    np.testing.assert_array_equal(shuffled_hits, hits[:, order])
    for j in range(0, len(scan), 5):
        np.testing.assert_array_equal(scene.cast(origins, scan[j : j + 1])[0][:, 0], ranges[:, j])
    assert (hits >= 0).any()


def test_a_row_does_not_depend_on_the_others():
    scene, rng = random_scene(7)
    origins = np.c_[rng.uniform(-3, 3, (20, 2)), rng.uniform(-4, 4, 20)]
    own = rng.integers(-1, 12, 20)
    tables = fan(61) + rng.normal(0, 0.5, 20)[:, None]
    limits = rng.uniform(1, 5, 20)
    together = scene.cast(origins, tables, own=own, range_max=limits)
    for i in range(20):
        alone = scene.cast(origins[i], tables[i], own=own[i], range_max=limits[i])
        np.testing.assert_array_equal(alone[0][0], together[0][i])
        np.testing.assert_array_equal(alone[1][0], together[1][i])
    same = scene.cast(origins, np.tile(fan(61), (20, 1)), range_max=np.full(20, 4.0))
    np.testing.assert_array_equal(same[0], scene.cast(origins, fan(61), range_max=4.0)[0])


@settings(deadline=None)
@given(st.integers(0, 10**6), st.floats(0.1, 6.0))
def test_ranges_are_no_more_than_asked_and_name_who_was_hit(seed, range_max):
    scene, rng = random_scene(seed, count=5)
    origin = (*rng.uniform(-3, 3, 2), rng.uniform(-4, 4))
    (ranges,), (hits,) = scene.cast(origin, fan(60), range_max=range_max)
    (free,), _ = scene.cast(origin, fan(60))
    assert ((ranges <= range_max) == (hits >= 0)).all()
    np.testing.assert_array_equal(ranges, np.where(free <= range_max, free, math.inf))
    for j in np.flatnonzero(hits >= 0):
        alone = Scene([scene.shapes[hits[j]]], [scene.poses[hits[j]]])
        assert alone.cast(origin, fan(60)[j : j + 1])[0][0, 0] == ranges[j]


@pytest.mark.parametrize("spread", [0.3, 3.0, 40.0])
@pytest.mark.parametrize("buckets", [(2, 2), (8, 16), (64, 64)])
def test_a_hash_of_bodies_changes_no_bit(spread, buckets):
    """Whether far bodies share buckets or not, and whatever the range."""
    rng = np.random.default_rng(8)
    shapes = [SHAPES[i] for i in rng.integers(0, len(SHAPES), 200)]
    poses = np.c_[rng.uniform(-spread, spread, (200, 2)), rng.uniform(-4, 4, 200)]
    poses[150:] = poses[100:150]  # twins, in the same place as others
    shapes[150:] = shapes[100:150]
    replica_first = [0, 0, 140, 200]
    plain, hashed = (Scene(shapes, poses, replica_first, b) for b in ((1, 1), buckets))
    origins = np.c_[rng.uniform(-spread, spread, (60, 2)), rng.uniform(-4, 4, 60)]
    asked = {"own": rng.integers(-1, 200, 60), "replica": rng.integers(0, 3, 60), "walls": rng.uniform(0, 9, (60, 61))}
    for range_max in (0.0, 0.5, 3.0, rng.uniform(0, 6, 60), math.inf):
        ranges, hits = plain.cast(origins, fan(61), **asked, range_max=range_max)
        again, others = hashed.cast(origins, fan(61), **asked, range_max=range_max)
        np.testing.assert_array_equal(again, ranges)
        np.testing.assert_array_equal(others, hits)
    assert (hits >= 0).any()


@pytest.mark.parametrize("spread", [0.3, 3.0, 40.0])
@pytest.mark.parametrize("buckets", [(1, 1), (8, 16)])
def test_a_single_beam_has_the_bits_of_a_scan(spread, buckets):
    """Of many bodies, some in the same place; behind walls, from within bodies, and whoever carries the sensor."""
    rng = np.random.default_rng(9)
    shapes = [SHAPES[i] for i in rng.integers(0, len(SHAPES), 200)]
    poses = np.c_[rng.uniform(-spread, spread, (200, 2)), rng.uniform(-4, 4, 200)]
    poses[150:], shapes[150:] = poses[100:150], shapes[100:150]
    scene = Scene(shapes, poses, [0, 0, 140, 200], buckets)
    origins = np.c_[rng.uniform(-spread, spread, (400, 2)), rng.uniform(-4, 4, 400)]
    asked = {
        "own": rng.integers(-1, 200, 400),
        "replica": rng.integers(0, 3, 400),
        "walls": rng.uniform(0, 9, (400, 1)),
    }
    seen = 0
    for bearings in (np.zeros((1, 1)), np.full((1, 1), 0.3), rng.uniform(-4, 4, (400, 1))):
        for range_max in (0.0, 0.5, 3.0, rng.uniform(0, 6, 400), math.inf):
            ranges, hits = scene.cast(origins, bearings, **asked, range_max=range_max)
            single, who = scene.cast(origins, bearings, **asked, range_max=range_max, by=cast_beams)
            np.testing.assert_array_equal(single, ranges)
            np.testing.assert_array_equal(who, hits)
            bare, _ = scene.cast(origins, bearings, **asked, range_max=range_max, asks=False, by=cast_beams)
            np.testing.assert_array_equal(bare, ranges)
            seen += (hits >= 0).sum()
    assert seen > 100


@pytest.mark.parametrize("spread", [1.0, 3.0, 40.0])
@pytest.mark.parametrize("width", [0.02, 0.5, 3.0, math.pi, 3.3, 6.0])
def test_a_fan_has_the_bits_of_its_beams(width, spread):
    """Bodies aside of it are not looked at."""
    scene, rng = random_scene(11, count=40, spread=spread)
    scan = fan(31, width, -0.5 * width)
    origins = np.c_[rng.uniform(-spread, spread, (100, 2)), rng.uniform(-4, 4, 100)]
    asked = {"own": rng.integers(-1, 40, 100), "walls": rng.uniform(0, 9, (100, 1)), "range_max": 4.0}
    each = {name: value if name == "range_max" else np.repeat(value, 31, axis=0) for name, value in asked.items()}
    alone, who = scene.cast(np.repeat(origins, 31, axis=0), np.tile(scan, 100)[:, None], **each, by=cast_beams)
    ranges, hits = scene.cast(origins, scan, **asked)
    np.testing.assert_array_equal(ranges, alone.reshape(100, 31))
    np.testing.assert_array_equal(hits, who.reshape(100, 31))
    assert (hits >= 0).any()


@pytest.mark.parametrize("place", [0, 15, 30])
def test_a_bearing_that_is_nan_leaves_the_others_alone(place):
    scene, rng = random_scene(12, count=12)
    origins = np.c_[rng.uniform(-3, 3, (40, 2)), rng.uniform(-4, 4, 40)]
    scan = fan(31, 1.0, -0.5)
    ranges, hits = scene.cast(origins, scan)
    rest = np.delete(np.arange(31), place)
    scan[place] = math.nan
    some, who = scene.cast(origins, scan)
    np.testing.assert_array_equal(some[:, rest], ranges[:, rest])
    np.testing.assert_array_equal(who[:, rest], hits[:, rest])
    assert (hits >= 0).any()


@pytest.mark.parametrize("scan", [fan(181), np.linspace(-math.pi, math.pi, 90), fan(33)[::-1]])
def test_a_crowd_reads_as_the_nearest_of_each_alone(scan):
    """More bodies than are met at once, whether somebody asks who was hit or not."""
    crowd, rng = random_scene(10, count=150, spread=4.0)
    origins = np.c_[rng.uniform(-3, 3, (8, 2)), rng.uniform(-4, 4, 8)]
    walls = rng.uniform(0.5, 9.0, (8, len(scan)))
    alone = [
        Scene([shape], [pose]).cast(origins, scan, walls=walls)[0]
        for shape, pose in zip(crowd.shapes, crowd.poses, strict=True)
    ]
    ranges, hits = crowd.cast(origins, scan, walls=walls)
    np.testing.assert_array_equal(ranges, np.min(alone, axis=0))
    assert (hits >= 0).any()
    assert (hits < 0).any()
    np.testing.assert_array_equal(crowd.cast(origins, scan, walls=walls, asks=False)[0], ranges)


def test_no_bodies_and_no_beams_are_no_trouble():
    nobody = Scene([], [])
    assert nobody.cast([(0, 0, 0)] * 2, fan(5))[0].tolist() == [[math.inf] * 5] * 2
    assert Scene([SHAPES[0]], [(0, 0, 0)]).cast((0, 0, 0), np.empty((1, 0)))[0].shape == (1, 0)
