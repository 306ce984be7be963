"""Tracks against Gaussians conditioned as a whole: robot, key, the match's error, and the next key's."""

import numpy as np
import pytest

import amorsim as am
from amorsim.kernels.matching import tracks

SHARED = 0.75


def positive(rng, scale):
    a = rng.normal(size=(3, 3)) * scale
    return a @ a.T + 0.1 * scale * scale * np.eye(3)


def turning(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def swinging(dx, dy):
    return np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])


def a_track(rng):
    """A track of one row, whose key's pose and motion are correlated."""
    joint = rng.normal(size=(6, 6)) * 0.01
    joint = joint @ joint.T + 1e-5 * np.eye(6)
    key, pose = np.array([[1.0, 2.0, 0.6]]), np.array([[1.4, 2.9, 1.1]])
    nothing = np.zeros((1, 3)), np.zeros((1, 1, 2))
    made = tracks.Tracks(
        pose, joint[None, 3:, 3:].copy(), key, joint[None, :3, :3].copy(), joint[None, 3:, :3].copy(),
        np.zeros((1, 4, 3)), *nothing,
    )  # fmt: skip
    return made, joint


def given(joint, of, noise, value):
    """Mean and covariance of a Gaussian of mean 0, given that `of` times it and noise is `value`."""
    gain = joint @ of.T @ np.linalg.inv(of @ joint @ of.T + noise)
    return gain @ value, joint - gain @ of @ joint


@pytest.mark.parametrize("seed", range(5))
def test_a_match_and_the_key_that_it_places_are_those_of_the_whole_gaussian(seed):
    rng = np.random.default_rng(seed)
    track, joint = a_track(rng)
    at, heading = tracks.correction(), track.key_pose[0, 2]
    to_world = turning(heading)
    match, own = np.linalg.inv(positive(rng, 0.01)), np.linalg.inv(positive(rng, 0.01))
    own_world = turning(track.pose[0, 2]) @ own @ turning(track.pose[0, 2]).T
    match_world = to_world @ match @ to_world.T
    shared = 2.0 * SHARED * np.linalg.inv(match_world + own_world)
    error = np.linalg.inv(match_world)
    # Key, motion, the match's error, the next key's: the match says motion + error.
    whole = np.zeros((12, 12))
    whole[:6, :6] = joint
    whole[6:9, 6:9], whole[9:, 9:] = error, np.linalg.inv(own_world)
    whole[6:9, 9:], whole[9:, 6:9] = shared, shared.T
    assert np.linalg.eigvalsh(whole).min() > -1e-12
    of = np.concatenate((np.zeros((3, 3)), np.eye(3), np.eye(3), np.zeros((3, 3))), axis=1)
    value = rng.normal(size=3) * 1e-7
    mean, whole = given(whole, of, np.zeros((3, 3)), value)

    before, key = track.pose.copy(), track.key_pose.copy()
    kept = to_world.T @ joint[3:, 3:] @ to_world
    found = am.relative(key, before + mean[3:6])[0]
    after = to_world.T @ whole[3:6, 3:6] @ to_world
    tracks.correct(0, track, found, after, np.linalg.inv(kept), kept, match, at)
    np.testing.assert_allclose(track.key_pose[0] - key[0], mean[:3], rtol=1e-5, atol=1e-14)
    np.testing.assert_allclose(am.relative(track.key_pose, track.pose)[0], found, atol=1e-12)
    np.testing.assert_allclose(track.key_covariance[0], whole[:3, :3], rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(track.cross[0], whole[3:6, :3], rtol=1e-6, atol=1e-12)
    carry = swinging(*(track.pose - track.key_pose)[0, :2])
    robot = np.concatenate((carry, np.eye(3), np.zeros((3, 6))), axis=1)
    total = np.empty((1, 3, 3))
    tracks.total_covariances(track, total)
    np.testing.assert_allclose(total[0], robot @ whole @ robot.T, rtol=1e-6, atol=1e-12)

    pose, old, moved = track.pose.copy(), track.key_pose.copy(), np.empty(3)
    tracks.begin_key(0, track, own, at, moved)
    new = robot + np.concatenate((np.zeros((3, 9)), np.eye(3)), axis=1)
    np.testing.assert_allclose(track.key_pose[0], pose[0] + mean[9:], rtol=0, atol=1e-12)
    np.testing.assert_allclose(moved, am.relative(old, track.key_pose)[0], atol=1e-12)
    np.testing.assert_allclose(track.key_covariance[0], new @ whole @ new.T, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(track.spread[0], whole[9:, 9:], rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(track.cross[0], (robot - new) @ whole @ new.T, rtol=1e-5, atol=1e-11)
    link = new - np.concatenate((carry, np.zeros((3, 9))), axis=1)
    there = turning(old[0, 2]).T
    np.testing.assert_allclose(track.link[0, 1:], there @ link @ whole @ link.T @ there.T, rtol=1e-5, atol=1e-11)
    np.testing.assert_array_equal(track.link[0, 0], moved)
    # The robot is where it was: a key changes nothing of what is known of it, but for the way to it.
    tracks.total_covariances(track, total)
    np.testing.assert_allclose(total[0], robot @ whole @ robot.T, rtol=1e-2, atol=1e-7)


def test_the_first_key_is_off_by_its_points_alone():
    rng = np.random.default_rng(7)
    track, _ = a_track(rng)
    track.spread[:] = track.key_covariance[:] = track.cross[:] = 0.0
    own, at = np.linalg.inv(positive(rng, 0.01)), tracks.correction()
    tracks.forget_correction(at)
    tracks.begin_key(0, track, own, at, np.empty(3))
    turn = turning(track.pose[0, 2])
    error = np.linalg.inv(turn @ own @ turn.T)
    np.testing.assert_allclose(track.spread[0], error, rtol=1e-9)
    np.testing.assert_allclose(track.key_covariance[0], error, rtol=1e-9)
    np.testing.assert_allclose(track.cross[0], -error, rtol=1e-9)
    total = np.empty((1, 3, 3))
    tracks.total_covariances(track, total)
    np.testing.assert_allclose(total[0], 0.0, atol=1e-12)
