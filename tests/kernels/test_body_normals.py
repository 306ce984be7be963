"""Normals of bodies' surfaces, against how the range changes from one ray to the next."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.kernels.raycast.body_normals import normals_of
from tests.kernels.test_body_rays import SHAPES, Scene

STEP = 1e-6  # [rad] to either side


def normals(scene, origins, bearings, which):
    out = np.empty(which.shape)
    edge_rows = max(sum(map(len, shape.parts)) for shape in scene.shapes)
    normals_of(scene.bodies, scene.poses, edge_rows, np.array(origins, dtype=float), bearings, which, out)
    return out


@pytest.mark.parametrize("shape", SHAPES, ids=range(len(SHAPES)))
def test_a_normal_is_square_to_the_surface_and_looks_back(shape):
    random = np.random.default_rng(3)
    scene = Scene([shape], [(0.3, -0.2, 0.7)])
    angles = random.uniform(-math.pi, math.pi, 40)
    away = shape.reach + random.uniform(0.1, 3.0, 40)
    headings = random.uniform(-math.pi, math.pi, 40)
    origins = np.stack((0.3 + away * np.cos(angles), -0.2 + away * np.sin(angles), headings), axis=1)
    towards = angles + math.pi - headings
    bearings = towards[:, None] + np.linspace(-0.5, 0.5, 31)
    ranges, hit = scene.cast(origins, bearings)
    found = normals(scene, origins, bearings, hit)
    assert (np.isfinite(found) == (hit == 0)).all()
    assert (hit == 0).sum() > 50
    world = headings[:, None] + bearings
    assert (np.cos(found - world)[hit == 0] <= 1e-12).all()
    right, left = (scene.cast(origins, bearings + side * STEP)[0] for side in (-1.0, 1.0))
    ends = [reach * np.exp(1j * (world + side * STEP)) for reach, side in ((right, -1.0), (left, 1.0))]
    with np.errstate(invalid="ignore"):
        along = ends[1] - ends[0]
        smooth = np.abs(left - 2.0 * ranges + right) < 1e-9  # no corner between the two
        smooth &= np.abs(along) < 1e-3
        slant = np.abs((along * np.exp(-1j * found)).real) / np.abs(along)
    assert smooth.sum() > 50
    assert slant[smooth].max() < 1e-3  # of ranges right to some 1e-15, a step of 1e-6 apart, on radii of 0.1 and more


def test_there_is_no_normal_where_nothing_is_entered():
    scene = Scene([SHAPES[0], SHAPES[2]], [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0)])
    which = np.array([[0, 1, -1, 0]])
    bearings = np.array([[0.0, 0.0, 0.0, 1.0]])
    found = normals(scene, [(-1.0, 0.0, 0.0)], bearings, which)
    assert found[0, :2] == pytest.approx([math.pi, math.pi])
    assert np.isnan(found[0, 2:]).all()
    assert np.isnan(normals(scene, [(0.1, 0.0, 0.0)], bearings[:, :1], which[:, :1])).all()
