"""Submaps: the points of several scans in one frame, and a scan from another side laid on them."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.kernels.matching import correlative, icp, submaps, tracking
from tests.kernels.matching.scenes import HALF, off, room, scan

BEAMS, REACH = len(HALF), 20.0
MOUNT = np.zeros(3)
RULES = tracking.Rules(
    match_distance=0.0,
    match_angle=0.0,
    key_distance=0.0,
    key_angle=0.0,
    key_share=0.6,
    least_fit=0.35,
    sure_fit=0.45,
    window=correlative.Window(0.5, math.radians(20.0), math.radians(1.0)),
    search=icp.Search(0.01, 0.3, 60, 1e-6),
)


def outlines_of(world, poses):
    scans = [scan(world, pose)[1] for pose in poses]
    return tracking.Outlines(*(np.array([getattr(one, name) for one in scans]) for name in ("points", "lines", "rays")))


def relative_to(first, poses):
    return am.relative(np.repeat(np.array(first)[None], len(poses), axis=0), np.array(poses))


@pytest.mark.parametrize("reach", [2.0, REACH])
def test_its_points_and_lines_are_those_of_its_scans(reach):
    world, poses = room(), np.array([[1.5, 1.2, 0.4], [1.9, 1.3, 1.5], [2.4, 1.6, 2.5]])
    scans, there = outlines_of(world, poses), relative_to(poses[1], poses)
    out, at = icp.reference(3 * BEAMS), tracking.room(BEAMS, REACH, 0.04, 0.06)
    submaps.draw_submap(scans, there, MOUNT, reach, np.empty_like(scans.points), out, at.picture)
    wanted = []
    for pose, points, lines in zip(there, scans.points, scans.lines, strict=True):
        turn = np.array([[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]])
        moved = points @ turn.T + pose[:2]
        near = np.hypot(*moved.T) <= reach
        wanted.append(np.hstack((moved, lines[:, :2] @ turn.T + pose[:2], lines[:, 2:] @ turn.T))[near])
    expected = np.concatenate(wanted)
    count = len(expected)
    np.testing.assert_allclose(np.hstack((out.points[:count], out.lines[:count])), expected, atol=1e-12)
    assert np.isnan(out.points[count:]).all()
    fine, side = at.picture.fine, at.picture.fine.shape[0]
    cells = np.floor((expected[:, :2] - at.picture.corner) / at.picture.resolution).astype(int)
    assert fine[cells[:, 1], cells[:, 0]].min() > 0.9
    # Half of the way to what the first scan sees, space is free.
    halfway = 0.5 * (there[0, :2] + expected[: len(wanted[0]), :2])
    cells = np.floor((halfway - at.picture.corner) / at.picture.resolution).astype(int)
    assert ((cells >= 0) & (cells < side)).all()
    assert np.median(fine[cells[:, 1], cells[:, 0]]) < 0.0


def test_a_scan_from_the_other_side_is_laid_on_it():
    """One old scan looks the other way and shows too little; those around it show the rest."""
    world = room()
    poses = np.array([[1.5, 1.4, 0.0], [1.5, 1.4, 1.6], [1.5, 1.4, 3.1], [1.5, 1.4, -1.6]])
    newest = np.array([1.8, 1.6, 2.9])
    fits = []
    for chosen in (poses[:1], poses):
        scans = outlines_of(world, [*chosen, newest])
        at = tracking.room(BEAMS, REACH, 0.04, 0.06)
        true = relative_to(poses[0], [newest])[0]
        at.start[:] = true + np.array((0.3, -0.25, 0.2))
        fits.append(
            submaps.align_with_submap(
                scans,
                relative_to(poses[0], chosen),
                MOUNT,
                REACH,
                np.empty_like(scans.points),
                icp.reference(len(chosen) * BEAMS),
                RULES,
                at,
            )
        )
    distance, turned = off(at.result.pose, true)
    assert distance < 0.01
    assert turned < 0.01
    assert fits[0] < 0.5 < 0.8 < fits[1]
