"""The parts of a particle filter, against published figures and obvious twins."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.kernels.filters.gaussians import draw_around, root
from amorsim.kernels.filters.headings import fill_turns
from amorsim.kernels.filters.modes import Modes, bins, find_modes
from amorsim.kernels.filters.resampling import average, effective_size, kld_size, recovery_probability, resample


@pytest.mark.parametrize(
    ("error", "quantile", "occupied", "wanted"),
    [
        # Beluga, test_take_while_kld.cpp.
        *((0.01, 1.28155, k, n) for k, n in ((3, 228), (4, 311), (5, 388), (6, 461), (7, 531), (100, 5871))),
        *((0.01, 2.32635, k, n) for k, n in ((3, 462), (4, 569), (5, 666), (6, 756), (7, 843), (100, 6733))),
        # Fox's formula.
        *((0.05, z, 10, n) for z, n in ((0.99, 131), (2.326, 217), (3.0, 273))),
        *((0.05, z, 50, n) for z, n in ((0.99, 588), (2.326, 750), (3.0, 842))),
        *((0.05, z, 500, n) for z, n in ((0.99, 5303), (2.326, 5755), (3.0, 5992))),
    ],
)
def test_as_many_particles_as_published(error, quantile, occupied, wanted):
    assert kld_size(occupied, error, quantile) == wanted


def test_one_bin_needs_one_particle_and_not_the_most():
    assert kld_size(1, 0.05, 2.326) == 1.0


@pytest.mark.parametrize(
    ("weights", "size"), [([1.0, 0.5, 0.0], 1.8), ([1.0, 0.5, 0.5], 8.0 / 3.0), ([0.0, 0.0], 0.0), ([0.2] * 5, 5.0)]
)
def test_effective_sample_sizes_are_those_of_kish(weights, size):
    assert effective_size(np.array(weights)) == pytest.approx(size, rel=1e-12)


@pytest.mark.parametrize(
    ("gains", "means", "wanted"),
    [
        ((0.001, 0.1), (1.0, 0.5), 0.05),
        ((0.001, 0.1), (0.5, 0.1), 0.08),
        ((0.001, 0.1), (0.5, 0.0), 0.10),
        ((0.001, 0.1), (1.0, 1.5), 0.0),
        ((0.5, 1.0), (2.0, 1.0), 1.0 / 3.0),
        ((0.5, 1.0), (2.0, 1.0, 1.0), 0.2),
    ],
)
def test_the_worse_the_weights_become_the_more_particles_are_at_random(gains, means, wanted):
    averages = np.full(2, np.nan)
    for mean in means:
        average(mean, averages, *gains)
    assert recovery_probability(averages) == pytest.approx(wanted, abs=0.001)


def test_low_variance_resampling_keeps_each_particle_as_often_as_its_weight_says():
    rng = np.random.default_rng(2)
    for n in (1, 7, 100, 1000):
        weights = rng.random(300) ** 8
        weights[rng.random(300) < 0.3] = 0.0
        weights /= weights.sum()
        picks = np.empty(n, dtype=np.int64)
        resample(weights, rng.random(), picks)
        often = np.bincount(picks, minlength=300)
        assert (often >= np.floor(n * weights - 1e-9)).all()
        assert (often <= np.ceil(n * weights + 1e-9)).all()


@pytest.mark.parametrize("offset", [1e-300, 1.0 - 2.0**-53])
def test_resampling_never_walks_beyond_the_last_particle_with_weight(offset):
    weights = np.full(1000, 0.1)  # these do not add up to a whole number
    weights[997:] = 0.0
    picks = np.empty(4999, dtype=np.int64)
    resample(weights, offset, picks)
    assert picks.max() == 996
    assert (np.diff(picks) >= 0).all()


@pytest.mark.parametrize("variances", [(1.0, 2.0, 0.5), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)])
def test_the_root_of_a_covariance_gives_it_back(variances):
    rng = np.random.default_rng(5)
    turned = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    covariance = turned @ np.diag(variances) @ turned.T
    covariance = 0.5 * (covariance + covariance.T)
    lower = np.empty((3, 3))
    root(covariance, lower)
    np.testing.assert_allclose(lower @ lower.T, covariance, atol=1e-7)
    assert (np.triu(lower, 1) == 0.0).all()
    means, drawn = np.zeros((1, 3)), np.empty((1, 3))
    normals = rng.normal(size=(1, 3))
    draw_around(means, covariance[None], normals, drawn)
    np.testing.assert_allclose(drawn[0], lower @ normals[0], atol=1e-15)


def modes_of(particles, weights=None, side=0.5, turns=36, count=4):
    weights = np.full(len(particles), 1.0 / len(particles)) if weights is None else weights
    found = Modes(np.empty((1, count, 3)), np.empty((1, count, 3, 3)), np.empty((1, count)))
    headings = np.stack((np.sin(particles[:, 2]), np.cos(particles[:, 2])))
    occupied = find_modes(particles, headings, weights, side, turns, bins(len(particles)), 0, found)
    return occupied, *(array[0] for array in found)


def test_clusters_are_modes_heaviest_first():
    rng = np.random.default_rng(8)
    middles = np.array([[0.0, 0.0, math.pi - 0.05], [6.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    counts = (300, 500, 200)
    clusters = [rng.normal(middle, (0.1, 0.1, 0.05), (count, 3)) for middle, count in zip(middles, counts, strict=True)]
    particles = np.concatenate(clusters)
    particles[:, 2] = (particles[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
    _, poses, covariances, weights = modes_of(particles)
    np.testing.assert_allclose(weights[:3], [0.5, 0.3, 0.2], rtol=1e-12)
    assert np.isnan(weights[3])
    for pose, covariance, k in zip(poses, covariances, (1, 0, 2), strict=False):
        np.testing.assert_allclose(pose[:2], clusters[k][:, :2].mean(axis=0), atol=1e-12)
        assert abs(math.remainder(pose[2] - clusters[k][:, 2].mean(), 2.0 * math.pi)) < 1e-4
        np.testing.assert_allclose(covariance, np.cov(clusters[k].T), rtol=0.01, atol=2e-6)


def test_bins_are_counted_once_each():
    particles = np.array([[0.1, 0.1, 0.0], [0.2, 0.2, 0.01], [0.7, 0.1, 0.0], [-0.1, 0.1, 0.0], [0.1, 0.1, 3.0]])
    occupied, _, _, weights = modes_of(particles)
    assert occupied == 4
    np.testing.assert_allclose(weights[:2], [0.8, 0.2])


def test_a_mode_of_one_particle_has_no_spread():
    _, poses, covariances, _ = modes_of(np.array([[1.0, 2.0, 0.5]]))
    np.testing.assert_allclose(poses[0], [1.0, 2.0, 0.5], atol=1e-15)
    assert (covariances[0] == 0.0).all()


def test_sines_and_cosines_of_headings_are_right_to_the_last_places():
    headings = np.concatenate((np.linspace(-math.pi, math.pi, 4001), np.arange(-4, 5) * math.pi / 4.0, [1e-300, -0.0]))
    poses = np.zeros((len(headings), 3))
    poses[:, 2] = headings
    out = np.empty((2, len(headings) + 5))
    fill_turns(poses, out)
    assert np.abs(out[0, : len(headings)] - np.sin(headings)).max() <= 6e-16
    assert np.abs(out[1, : len(headings)] - np.cos(headings)).max() <= 6e-16
