"""Shapes: what is accepted, how it is cut into convex parts, and the arrays that kernels get."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

import amorsim as am
from amorsim.core.shapes import Shape, pack
from tests.examples import settings

NOTCHED = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 0.5), (0.0, 2.0)]
SPIRAL = [(0, 0), (5, 0), (5, 5), (1, 5), (1, 2), (3, 2), (3, 3), (2, 3), (2, 4), (4, 4), (4, 1), (0, 1)]


def cross(part, i):
    a, b, c = part[i - 1], part[i], part[(i + 1) % len(part)]
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])


def check_parts(shape, polygon):
    """Parts are convex, anticlockwise, do not overlap, and add up to the polygon."""
    parts = [shapely.Polygon(part) for part in shape.parts]
    size = max(polygon.bounds[2] - polygon.bounds[0], polygon.bounds[3] - polygon.bounds[1])
    for part in shape.parts:
        assert part.dtype == np.float64
        assert part.shape[1] == 2
        assert all(cross(part, i) >= -1e-10 * size * size for i in range(len(part)))
    assert sum(part.area for part in parts) == pytest.approx(polygon.area, rel=1e-9)
    assert shapely.union_all(parts).symmetric_difference(polygon).area <= 1e-9 * polygon.area
    corners = set(map(tuple, shape.outline.tolist()))
    assert all(tuple(vertex) in corners for part in shape.parts for vertex in part.tolist())


@pytest.mark.parametrize("vertices", [NOTCHED, NOTCHED[::-1], SPIRAL, SPIRAL[::-1]], ids=str)
def test_non_convex_polygons_are_cut_into_convex_parts(vertices):
    shape = Shape.polygon(vertices)
    assert len(shape.parts) > 1
    check_parts(shape, shapely.Polygon(vertices))


@settings(deadline=None)
@given(st.lists(st.floats(0.2, 1.0), min_size=3, max_size=16), st.floats(-3, 3), st.booleans())
def test_any_star_shaped_polygon_is_cut_into_convex_parts(radii, start, clockwise):
    angles = start + 2 * np.pi * np.arange(len(radii)) / len(radii)
    vertices = np.c_[radii * np.cos(angles), radii * np.sin(angles)]
    polygon = shapely.Polygon(vertices)
    assume(polygon.is_valid and polygon.area > 1e-3)
    check_parts(Shape.polygon(vertices[::-1] if clockwise else vertices), polygon)


def test_a_convex_polygon_is_one_part_whatever_its_order():
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    for vertices in (square, square[::-1], [*square, square[0]], np.array(square)):
        (part,) = Shape.polygon(vertices).parts
        assert shapely.Polygon(part).exterior.is_ccw
        assert {tuple(vertex) for vertex in part.tolist()} == set(square)


def test_vertices_on_a_straight_border_are_dropped():
    shape = Shape.polygon([(0, 0), (0.5, 0), (0.5, 0), (1, 0), (1, 1), (0, 1), (0, 1 / 3)])
    assert shape == Shape.polygon([(0, 0), (1, 0), (1, 1), (0, 1)])


def test_the_paths_of_a_tenth_are_straight():
    """Multiples of 0.1 lie on a line only up to rounding, and are not reflex corners either."""
    slope = [(0.1 * i, 0.3 * i) for i in range(1, 10)]
    assert len(Shape.polygon([(0, 0), (1, 0), (1, 3), *slope[::-1]]).outline) == 3


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        ([], "three vertices|pairs"),
        ([(0, 0), (1, 0)], "three vertices at least, got 2"),
        ([(0, 0), (1, 0), (0, 0)], "three vertices at least, got 2"),
        ([(0, 0), (1, 0), (math.nan, 1)], "finite"),
        ([(0, 0), (1, 0), (math.inf, 1)], "finite"),
        ([(0, 0), (1, 1), (2, 2)], "one line"),
        ([(0, 0), (0, 0), (0, 0), (0, 0)], "one line"),
        ([(0, 0), (1, 1), (1, 0), (0, 1)], "meet itself"),
        ([(0, 0), (3, 0), (3, 3), (1, -1)], "meet itself"),
        ([(0, 0), (2, 0), (2, 2), (2, 0), (2, -1), (0, -1)], "meet itself"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], "pairs"),
        ([1, 2, 3], "pairs"),
        ([(0, 0), (1,), (0, 1)], "pairs"),
        ([("a", 0), (1, 0), (0, 1)], "pairs"),
    ],
    ids=str,
)
def test_what_is_no_simple_polygon_is_refused(vertices, message):
    with pytest.raises(am.ShapeError, match=message):
        Shape.polygon(vertices)


@pytest.mark.parametrize("radius", [0.0, -1.0, math.nan, math.inf])
def test_a_circle_needs_a_radius(radius):
    with pytest.raises(am.ShapeError, match="radius"):
        Shape.circle(radius)


@pytest.mark.parametrize(("length", "width"), [(0.0, 1.0), (1.0, -1.0), (math.nan, 1.0), (1.0, math.inf)])
def test_a_rectangle_needs_its_sides(length, width):
    with pytest.raises(am.ShapeError, match="rectangle"):
        Shape.rectangle(length, width)


@pytest.mark.parametrize("rounding", [-0.1, math.nan, math.inf])
def test_rounding_is_not_negative(rounding):
    with pytest.raises(am.ShapeError, match="rounding"):
        Shape.polygon(NOTCHED, rounding=rounding)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"vertices": (), "radius": 1.0}, "one convex part"),
        ({"vertices": ((),), "radius": 1.0}, "one convex part"),
        ({"vertices": (((0.0, 0.0),),), "radius": 0.0}, "radius above 0"),
        ({"vertices": (((0.0, 0.0), (1.0, 0.0)),), "radius": 0.0}, "radius above 0"),
        ({"vertices": (tuple(NOTCHED),), "radius": 0.0}, "convex"),
        ({"vertices": (((0.0, 0.0), (0.0, 1.0), (1.0, 0.0)),), "radius": 0.0}, "anticlockwise"),
        ({"vertices": (((0.0, 0.0),),), "radius": math.nan}, "radius"),
    ],
)
def test_parts_that_kernels_could_not_handle_are_refused(fields, message):
    with pytest.raises(am.ShapeError, match=message):
        Shape(border=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), **fields)


def test_a_rectangle_lies_where_it_is_put():
    """The Pioneer 2 reaches 0.210 m ahead of its axle and 0.301 m behind it."""
    shape = Shape.rectangle(0.5, 0.25, x=-0.125)
    assert set(map(tuple, shape.outline.tolist())) == {
        (-0.375, -0.125), (0.125, -0.125), (0.125, 0.125), (-0.375, 0.125),
    }  # fmt: skip
    assert shape.reach == math.hypot(0.375, 0.125)


def test_a_circle_is_one_vertex_and_a_radius():
    shape = Shape.circle(0.5, x=3.0, y=4.0)
    assert [part.tolist() for part in shape.parts] == [[[3.0, 4.0]]]
    assert shape.radius == 0.5
    assert shape.reach == 5.5
    assert shape.outline.shape == (64, 2)
    assert shapely.Polygon(shape.outline).exterior.is_ccw
    np.testing.assert_allclose(np.hypot(*(shape.outline - (3.0, 4.0)).T), 0.5, rtol=1e-15)


def test_the_outline_of_a_rounded_polygon_goes_around_it():
    shape = Shape.polygon(NOTCHED, rounding=0.25)
    outline = shapely.Polygon(shape.outline)
    assert outline.exterior.is_ccw
    grown = shapely.Polygon(NOTCHED).buffer(0.25, quad_segs=64)
    assert outline.symmetric_difference(grown).area < 1e-3 * grown.area
    assert shape.reach == math.hypot(2, 2) + 0.25


def test_shapes_compare_hash_and_pickle_by_value():
    shapes = [
        Shape.circle(0.25), Shape.circle(0.5), Shape.rectangle(0.5, 0.25),
        Shape.polygon(NOTCHED), Shape.polygon(NOTCHED, rounding=0.25),
    ]  # fmt: skip
    assert len(set(shapes)) == len(shapes)
    for shape in shapes:
        copy = pickle.loads(pickle.dumps(shape))
        assert copy == shape
        assert hash(copy) == hash(shape)
    assert Shape.rectangle(0.5, 0.25) == Shape.polygon([(-0.25, -0.125), (0.25, -0.125), (0.25, 0.125), (-0.25, 0.125)])


def test_the_arrays_of_a_shape_are_copies():
    shape = Shape.rectangle(1.0, 1.0)
    shape.parts[0][:] = 7.0
    shape.outline[:] = 7.0
    assert shape == Shape.rectangle(1.0, 1.0)
    assert shape.outline.max() == 0.5


def test_pack_lays_shapes_end_to_end():
    shapes = [
        Shape.circle(0.25, x=1.0),
        Shape.polygon(NOTCHED),
        Shape.circle(0.25, x=1.0),
        Shape.rectangle(1, 2),
    ]
    bodies = pack(iter(shapes))
    assert [array.dtype for array in bodies] == [np.float64, np.int64, np.int64, np.float64, np.float64]
    assert all(array.flags.c_contiguous for array in bodies)
    for b, shape in enumerate(shapes):
        first, last = bodies.part_first[b : b + 2]
        parts = [bodies.vertices[slice(*bodies.vertex_first[p : p + 2])] for p in range(first, last)]
        assert len(parts) == len(shape.parts)
        for part, expected in zip(parts, shape.parts, strict=True):
            np.testing.assert_array_equal(part, expected)
        assert bodies.radius[b] == shape.radius
        assert bodies.reach[b] == shape.reach
    assert bodies.part_first[-1] == len(bodies.vertex_first) - 1
    assert bodies.vertex_first[-1] == len(bodies.vertices)


def test_pack_of_nothing_is_empty_arrays():
    bodies = pack([])
    assert [array.shape for array in bodies] == [(0, 2), (1,), (1,), (0,), (0,)]
    assert [array.dtype for array in bodies] == [np.float64, np.int64, np.int64, np.float64, np.float64]
