"""The errors of aligned scans against the least that any unbiased method can have: the bound of Cramér and Rao."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.kernels.matching import icp, priors
from tests.kernels.matching.scenes import WHOLE, outline_of, reference_of

STD = 0.01
WALLS = np.array(
    [
        *((0, 0, 6, 0), (6, 0, 6, 4), (6, 4, 0, 4), (0, 4, 0, 0), (2, 4, 2, 3.2), (2, 3.2, 3.1, 4)),
        *((4.2, 0.9, 4.8, 1.3), (4.8, 1.3, 4.6, 0.7), (4.6, 0.7, 4.2, 0.9)),
    ],
    dtype=float,
)
KEY, POSE = np.array([1.5, 1.2, 0.4]), np.array([1.62, 1.25, 0.5])


def exact(pose):
    """Ranges of beams all around from a pose, and the normals of the walls that they meet."""
    rays = np.stack((np.cos(WHOLE + pose[2]), np.sin(WHOLE + pose[2])), axis=1)
    from_, along = WALLS[:, :2] - pose[:2], WALLS[:, 2:] - WALLS[:, :2]
    turned = rays[:, None, 0] * along[None, :, 1] - rays[:, None, 1] * along[None, :, 0]
    away = (from_[:, 0] * along[:, 1] - from_[:, 1] * along[:, 0])[None] / turned
    where = (from_[None, :, 0] * rays[:, None, 1] - from_[None, :, 1] * rays[:, None, 0]) / turned
    away[~((away > 0.0) & (where >= 0.0) & (where <= 1.0))] = math.inf
    wall = away.argmin(axis=1)
    normals = np.stack((-along[wall, 1], along[wall, 0]), axis=1)
    normals /= np.hypot(*normals.T)[:, None]
    normals *= np.sign((normals * rays).sum(axis=1))[:, None]
    return away.min(axis=1), normals, rays


def bound(pose):
    """The least covariance (3, 3) of a pose from one scan, in the frame of the key scan."""
    information = np.empty((3, 3))
    icp.fisher(*exact(pose), STD, information)
    c, s = math.cos(KEY[2]), math.sin(KEY[2])
    back = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return back @ np.linalg.inv(information) @ back.T


def errors(count, seed, std=STD):
    """Errors (count, 3) of scans with noise that are aligned with a key scan without any."""
    rng = np.random.default_rng(seed)
    key, ranges = reference_of(outline_of(exact(KEY)[0], WHOLE)), exact(POSE)[0]
    true = am.relative(KEY[None], POSE[None])[0]
    work, found = icp.work(len(WHOLE)), icp.result()
    off = np.empty((count, 3))
    for row in off:
        scan = outline_of(ranges + std * rng.normal(size=len(WHOLE)), WHOLE)
        icp.align(key, scan, true.copy(), priors.no_prior(), icp.Search(STD, 0.3, 60, 1e-7), work, found)
        row[:] = found.pose - true
    return off


def least_ratio(covariance, least):
    """The variance in units of the bound, in the direction in which that is least."""
    half = np.linalg.inv(np.linalg.cholesky(least))
    return np.linalg.eigvalsh(half @ covariance @ half.T)[0]


@pytest.mark.long
def test_no_direction_beats_the_bound_and_the_place_has_at_most_twice_its_variance():
    # The least eigenvalue of a covariance of 1000 errors in units of the true one is above 0.8 but once in 10^5.
    covariance, least = np.cov(errors(1000, 1).T), bound(POSE)
    assert least_ratio(covariance, least) > 0.8
    assert np.trace(covariance[:2, :2]) < 2.0 * np.trace(least[:2, :2])
    # Grazing beams tell most of the heading. They count less in the alignment, as lines are never exact.
    assert covariance[2, 2] < 4.0 * least[2, 2]


@pytest.mark.long
def test_scans_with_less_noise_than_assumed_are_below_the_bound():
    assert least_ratio(np.cov(errors(1000, 1, 0.5 * STD).T), bound(POSE)) < 0.8


def test_walls_are_where_a_map_of_them_has_them():
    ranges = am.Map.from_segments(WALLS, resolution=0.001).cast_rays(POSE[None], WHOLE, 8.0)[0]
    assert np.median(np.abs(ranges - exact(POSE)[0])) < 0.002
