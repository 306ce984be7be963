"""What encoders' counts say of joints."""

from __future__ import annotations

import numpy as np

from amorsim.kernels.kinematics.odometry import joints_between

FAR, LEAP = 1e12, 1e4
SOME = (0.0, 0.5, -3.0, 2e4, 1e12, -1e13, np.inf, -np.inf, np.nan)


def twin(last, angles):
    lacks = ~(np.abs(angles) < FAR)
    after = np.where(lacks.any(axis=1, keepdims=True), last, angles)
    before = np.where(np.isnan(last), after, last)
    leapt = np.abs(after - before) > LEAP
    return np.where(leapt.any(axis=1, keepdims=True), after, before), after


def test_readings_that_are_late_lost_or_impossible() -> None:
    """All pairs of such angles of two joints, after all such readings before that can have been held."""
    held = [value for value in SOME if not np.abs(value) >= FAR]
    rows = [(last, now) for last in np.array(np.meshgrid(held, held)).T.reshape(-1, 2) for now in pairs(SOME)]
    last, angles = (np.array(each) for each in zip(*rows, strict=True))
    before, after = np.empty(last.shape), np.empty(last.shape)
    joints_between(last, angles, FAR, LEAP, before, after)
    expected = twin(last, angles)
    np.testing.assert_array_equal(before, expected[0])
    np.testing.assert_array_equal(after, expected[1])
    assert (before != after).any()


def pairs(values):
    return [(a, b) for a in values for b in values]
