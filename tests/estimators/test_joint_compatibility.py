"""Which sightings are of which landmarks, found for all of them together."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.stats import chi2

from amorsim.core.parameters import ParameterError
from amorsim.estimators import Ekf
from amorsim.kernels.filters.compatible import pair_up, search
from tests.estimators.ekf_rig import Filter, seen

GATE = 0.999


def filter_of(association, marks, **changes):
    given = {"wheel_variance": 1e-4, "landmarks": "fiducial", "range_std": 0.05, "bearing_std": 0.02}
    return Filter(Ekf(**given | changes, association=association), marks=marks)


def best_of_all(p, fits, slopes, residuals, noise):
    """All ways to pair sightings with landmarks, one after the other: the most pairs, then the nearest."""
    slots, landmarks = fits.shape
    best = (0, 0.0, [-1] * slots)
    for choice in itertools.product(range(-1, landmarks), repeat=slots):
        used = [(slot, k) for slot, k in enumerate(choice) if k >= 0]
        if len({k for _, k in used}) < len(used) or not all(fits[pair] for pair in used) or not used:
            continue
        h = np.concatenate([slopes[pair] for pair in used])
        v = np.concatenate([residuals[pair] for pair in used])
        r = np.zeros((len(v), len(v)))
        for n, pair in enumerate(used):
            a, b, c = noise[pair]
            r[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] = [[a, b], [b, c]]
        square = v @ np.linalg.solve(h @ p @ h.T + r, v)
        if square <= chi2.ppf(GATE, len(v)) and (len(used), -square) > (best[0], -best[1]):
            best = (len(used), square, list(choice))
    return best


@pytest.mark.parametrize("seed", range(12))
def test_the_pairs_are_the_best_of_all(seed):
    rng = np.random.default_rng(seed)
    slots, landmarks = 4, 4
    gates = np.array([math.inf, *chi2.ppf(GATE, 2 * np.arange(1, slots + 1))])
    room = search(slots, landmarks, gates)
    root = rng.normal(size=(4, 4)) * 0.3
    p = root @ root.T
    room.slopes[:] = rng.normal(size=room.slopes.shape)
    room.residuals[:] = rng.normal(size=room.residuals.shape) * 1.5
    room.noise[:] = (0.05, 0.01, 0.08)
    room.fits[:] = rng.random(room.fits.shape) < 0.7
    pair_up(p, room)
    count, _, wanted = best_of_all(p, room.fits, room.slopes, room.residuals, room.noise)
    assert (room.best >= 0).sum() == count
    assert room.best.tolist() == wanted


def test_jointly_landmarks_are_distinguished_where_the_nearest_is_wrong():
    """Posts in a row, half as far from each other as the robot may be off: all are shifted by one, or none is."""
    marks = [(0, 4.0, float(y)) for y in (-1.0, 0.0, 1.0)]
    start = {"start_std": 0.5, "start_heading_std": 0.002}
    pose = (0.0, -0.62, 0.0)
    reading = seen(pose, marks)
    nearest, joint = filter_of("nearest", marks, **start), filter_of("joint", marks, **start)
    nearest.step(fiducial=reading)
    found = joint.step(fiducial=reading)
    assert joint.beliefs()["landmarks_match"][0, :3].tolist() == [0.0, 1.0, 2.0]
    assert nearest.beliefs()["landmarks_match"][0, :3].tolist() != [0.0, 1.0, 2.0]
    assert np.abs(found.pose[0] - pose).max() < 0.05


def test_a_sighting_of_something_else_is_left_out():
    marks = [(0, 5.0, 0.0), (0, 0.0, 4.0), (0, -3.0, -2.0)]
    robot = filter_of("joint", marks, start_std=0.1, start_heading_std=0.05)
    pose = (0.05, -0.04, 0.02)
    robot.step(fiducial=seen(pose, [*marks[:2], (0, 3.0, 3.0)]))
    beliefs = robot.beliefs()
    assert beliefs["landmarks_match"][0, :2].tolist() == [0.0, 1.0]
    assert np.isnan(beliefs["landmarks_used"][0, 2:]).all()


def test_it_is_in_the_estimators_choices():
    with pytest.raises(ParameterError, match="'joint'"):
        filter_of("jointly", [(0, 1.0, 1.0)])
