"""Absolute and relative pose errors are those of evo, on trajectories projected to the plane."""

from __future__ import annotations

import functools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.analysis import Trajectory, Transform, ape, read_tum, relation_errors, rpe

TRAJECTORIES = Path(__file__).resolve().parents[3] / "shared" / "maps" / "trajectories"
# What evo 1.38.1 gives for the same files, their poses projected to z = 0 and yaw; poses are associated up to 10 ms.
EVO = json.loads((Path(__file__).parent / "evo.json").read_text(encoding="utf-8"))
ALIGN = {"none": "none", "umeyama": "umeyama", "scale": "umeyama_scale", "origin": "first"}
PAIRS = {
    "1 frames False": {"delta": 1, "unit": "steps", "every": False},
    "10 frames True": {"delta": 10, "unit": "steps"},
    "1.0 m False": {"delta": 1.0, "unit": "m", "every": False},
    "0.5 m True": {"delta": 0.5, "unit": "m"},
}
FIGURES = ("rmse", "mean", "median", "std", "min", "max")

needs_trajectories = pytest.mark.skipif(not TRAJECTORIES.exists(), reason="the shared trajectories are not there")


@functools.cache
def read(name: str) -> Trajectory:
    return read_tum(TRAJECTORIES / f"freiburg1_xyz-{name}.txt")


def check(found: am.analysis.PoseErrors, key: str) -> None:
    for kind, statistics in (("trans", found.statistics), ("rot", found.heading_statistics)):
        wanted = EVO[key.format(kind)]
        assert statistics.count == wanted["n"]
        for figure in FIGURES:
            assert getattr(statistics, figure) == pytest.approx(wanted[figure], abs=1e-9)


@needs_trajectories
@pytest.mark.parametrize("align", ALIGN)
@pytest.mark.parametrize("name", ["rgbdslam", "rgbdslam_drift"])
def test_ape_is_that_of_evo(name: str, align: str) -> None:
    found = ape(read("groundtruth"), read(name), align=ALIGN[align], most_apart=0.01)
    check(found, f"{name} {align} ape {{}}")
    assert found.dropped == len(read(name)) - len(found)


@needs_trajectories
@pytest.mark.parametrize("pairs", PAIRS)
@pytest.mark.parametrize("name", ["rgbdslam", "rgbdslam_drift"])
def test_rpe_is_that_of_evo(name: str, pairs: str) -> None:
    for align in ("none", "scale"):
        found = rpe(read("groundtruth"), read(name), align=ALIGN[align], most_apart=0.01, **PAIRS[pairs])
        check(found, f"{name} {align} rpe {{}} {pairs}")


@needs_trajectories
def test_evo_itself_says_the_same() -> None:
    pytest.importorskip("evo")
    from evo.core import metrics, sync, trajectory

    def of(name: str) -> object:
        own = read(name)
        half, zero = 0.5 * own.poses[:, 2], np.zeros(len(own))
        places = np.column_stack((own.poses[:, :2], zero))
        turns = np.column_stack((np.cos(half), zero, zero, np.sin(half)))
        return trajectory.PoseTrajectory3D(places, turns, own.time)

    reference, estimate = sync.associate_trajectories(of("groundtruth"), of("rgbdslam"), max_diff=0.01)
    estimate.align(reference)
    theirs = metrics.APE(metrics.PoseRelation.translation_part)
    theirs.process_data((reference, estimate))
    ours = ape(read("groundtruth"), read("rgbdslam"), align="umeyama", most_apart=0.01)
    assert np.abs(ours.position - theirs.error).max() < 1e-9


def line(count: int = 11, speed: float = 1.0, name: str = "line") -> Trajectory:
    time = 0.1 * np.arange(count)
    return Trajectory(time=time, poses=np.column_stack((speed * time, 0.0 * time, 0.0 * time)), name=name)


def test_the_transform_is_returned_and_is_none_by_default() -> None:
    reference = line()
    moved = Trajectory(time=reference.time, poses=Transform(1.0, 2.0, 0.5).apply(reference.poses))
    assert ape(reference, moved).transform == Transform()
    assert ape(reference, moved).statistics.min > 1.0
    for align in ("first", "umeyama"):
        found = ape(reference, moved, align=align)
        assert found.statistics.max < 1e-12
        assert found.transform.angle == pytest.approx(-0.5)
        assert "turn -28.6479 degrees" in str(found)
    assert "alignment: none" in str(ape(reference, moved))


def test_one_pose_is_refused_where_it_must_be_turned() -> None:
    one = Trajectory(time=[0.0], poses=[[1.0, 2.0, 0.0]], name="one")
    with pytest.raises(am.AnalysisError, match=r"one: cannot be aligned: expected two poses at least"):
        ape(one, one, align="umeyama")
    assert len(ape(one, one)) == 1


def test_poses_without_a_partner_are_counted() -> None:
    reference = line()
    late = Trajectory(time=reference.time[:5] + np.array([0.0, 0.0, 0.06, 0.0, 0.0]), poses=reference.poses[:5])
    assert ape(reference, late, most_apart=0.03).dropped == 1
    with pytest.raises(am.AnalysisError, match=r"have no poses less than"):
        ape(reference, Trajectory(time=reference.time + 9.0, poses=reference.poses))


def test_interpolation_finds_poses_between() -> None:
    reference = line()
    between = Trajectory(time=reference.time[:-1] + 0.03, poses=reference.poses[:-1] + np.array([0.03, 0.0, 0.0]))
    assert ape(reference, between, interpolate=True).statistics.max < 1e-12
    assert ape(reference, between).statistics.max == pytest.approx(0.03)


def test_interpolation_takes_all_poses_of_a_denser_estimate() -> None:
    reference, dense = line(11), line(101)
    dense = Trajectory(time=dense.time / 10.0, poses=dense.poses * np.array([0.1, 1.0, 1.0]))
    found = ape(reference, dense, interpolate=True)
    assert (len(found), found.dropped) == (101, 0)
    assert found.statistics.max < 1e-12
    assert len(ape(reference, dense)) == 11
    # Where the reference has a gap, nothing is known between.
    kept = np.r_[0:4, 7:11]
    gap = Trajectory(time=reference.time[kept], poses=reference.poses[kept])
    found = ape(gap, dense, interpolate=True)
    assert (len(found), found.dropped) == (101 - 29, 29)


@pytest.mark.parametrize("every", [True, False])
def test_a_stretch_of_time_is_so_long_across_gaps_too(every: bool) -> None:
    """A robot whose estimate is 10 % too slow, so that each stretch of 0.5 s is 5 cm wrong; a third is missing."""
    reference, slow = line(101), line(101, speed=0.9)
    kept = np.sort(np.random.default_rng(5).permutation(101)[:70])
    kept = kept[(kept < 40) | (kept > 60)]
    found = rpe(reference, Trajectory(time=slow.time[kept], poses=slow.poses[kept]), delta=0.5, unit="s", every=every)
    assert found.position == pytest.approx(0.05)
    there = set(kept.tolist())
    if every:
        assert np.round(found.time * 10).astype(int).tolist() == [k for k in sorted(there) if k - 5 in there]
    else:  # one after another, none of which begins before the one before has ended
        assert len(found) > 3
        assert (np.diff(found.time) > 0.5 - 1e-9).all()
        assert found.time.max() > 7.0  # they go on behind the gap


def test_a_stretch_of_time_may_be_asked_for_where_poses_share_a_partner() -> None:
    quick = Trajectory(time=0.01 * np.arange(101), poses=np.zeros((101, 3)))
    slow = line(201)
    found = rpe(quick, slow, delta=0.5, unit="s", most_apart=0.05)
    assert found.position == pytest.approx(0.5)


def test_errors_by_time_and_distance() -> None:
    reference, slow = line(), line(speed=0.9)
    found = ape(reference, slow)
    by_time, by_way = found.by_time(0.5), found.by_distance(0.5)
    assert [begin for begin, _ in by_time] == [0.0, 0.5, 1.0]
    assert [statistics.count for _, statistics in by_way] == [5, 5, 1]
    assert by_time[2][1].mean == pytest.approx(0.1)
    (first, *_) = rpe(reference, slow, delta=0.2, unit="s").position
    assert first == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"align": "se3"}, "align: expected one of none, first"),
        ({"most_apart": -1.0}, "most_apart"),
        ({"most_apart": math.nan}, "most_apart"),
    ],
)
def test_wrong_options_are_reported(options: dict[str, object], words: str) -> None:
    with pytest.raises(am.AnalysisError, match=words):
        ape(line(), line(), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"unit": "km"}, "unit: expected one of m, steps, s"),
        ({"delta": 0.0}, "delta: expected a number > 0"),
        ({"delta": 1.5, "unit": "steps"}, "a whole number > 0"),
        ({"delta": 50.0}, "there is no stretch of 50 m"),
    ],
)
def test_wrong_stretches_are_reported(options: dict[str, object], words: str) -> None:
    with pytest.raises(am.AnalysisError, match=words):
        rpe(line(), line(), **options)  # type: ignore[arg-type]


def test_relations_are_judged_without_a_true_trajectory() -> None:
    estimate = line(21)
    turned = Trajectory(time=estimate.time, poses=Transform(3.0, 1.0, 2.0).apply(estimate.poses))
    relations = [(0.0, 1.0, 1.0, 0.0, 0.0), (0.52, 1.5, 0.9, 0.0, 0.1), (0.0, 9.0, 1.0, 0.0, 0.0)]
    found = relation_errors(turned, relations)
    assert found.position == pytest.approx([0.0, 0.1], abs=1e-12)
    assert found.heading == pytest.approx([0.0, 0.1], abs=1e-12)
    assert found.dropped == 1
    # Two times that one pose is nearest to: it may be that of either, and the third relation names the other.
    twins = [(0.0, 1.0, 1.0, 0.0, 0.0), (0.0, 1.51, 9.0, 0.0, 0.0), (0.51, 1.49, 9.0, 0.0, 0.0)]
    assert relation_errors(turned, twins).position == pytest.approx([0.0], abs=1e-12)
    assert len(relation_errors(turned, twins[:2]).position) == 2
    # Unless it is the very time of one.
    exact = [(0.0, 1.0, 1.0, 0.0, 0.0), (0.0, 1.01, 9.0, 0.0, 0.0)]
    assert relation_errors(turned, exact).position == pytest.approx([0.0], abs=1e-12)
    with pytest.raises(am.AnalysisError, match=r"relations: expected numbers of the shape \(M, 5\)"):
        relation_errors(turned, [(0.0, 1.0)])
    with pytest.raises(am.AnalysisError, match=r"no poses at the times"):
        relation_errors(turned, [(50.0, 60.0, 0.0, 0.0, 0.0)])
    wrong: Any = "0.1"
    with pytest.raises(am.ParameterError, match=r"most_apart: expected a number of seconds, got '0\.1'"):
        relation_errors(estimate, relations, most_apart=wrong)
