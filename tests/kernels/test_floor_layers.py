"""Which shape lies on top, against shapely."""

import numpy as np
import shapely

from amorsim.core.shapes import pack
from amorsim.kernels.sensing.floor_layers import topmost
from amorsim.scenario.pose import Pose
from tests.kernels.test_body_rays import SHAPES
from tests.sensors.sight import placed

HAIR = 1e-3  # [m] a place so near to a border is not judged: shapely's round corners are chords


def test_the_last_shape_that_covers_a_place_is_reported():
    random = np.random.default_rng(5)
    poses = random.uniform((-1.0, -1.0, -3.0), (1.0, 1.0, 3.0), (len(SHAPES), 3))
    ground = [
        placed(shape, Pose(x=x, y=y, heading=heading))
        for shape, (x, y, heading) in zip(SHAPES, poses.tolist(), strict=True)
    ]
    places = random.uniform(-2.0, 2.0, (4000, 2))
    out = np.empty(len(places), dtype=np.int64)
    topmost(pack(SHAPES), poses, places, out)
    points = shapely.points(places)
    inside = np.array([shapely.contains(each, points) for each in ground])
    expected = np.where(inside.any(axis=0), len(ground) - 1 - np.argmax(inside[::-1], axis=0), -1)
    sure = np.array([shapely.distance(each.boundary, points) > HAIR for each in ground]).all(axis=0)
    assert sure.mean() > 0.95
    np.testing.assert_array_equal(out[sure], expected[sure])
    assert len(np.unique(out)) >= len(SHAPES)  # all but one of 1 cm


def test_borders_count_as_covered():
    square = next(shape for shape in SHAPES if shape.radius == 0.0)
    out = np.empty(4, dtype=np.int64)
    corners = np.array(square.vertices[0])[:4]
    topmost(pack([square]), np.zeros((1, 3)), corners, out)
    assert out.tolist() == [0, 0, 0, 0]
