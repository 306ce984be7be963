"""Comparisons pair what met the same noise, and claim what may be claimed."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import amorsim as am
from amorsim.algorithms.intervals import mean_interval
from amorsim.analysis import compare
from amorsim.analysis.differences import Difference
from amorsim.analysis.paired import paired
from tests.examples import settings
from tests.sweeps.studies import SCENARIO, TRACK, tables

LOWER = {"error": {"unit": "m", "better": "lower"}}


def systems(count=60, shift=0.1, seed=1):
    """Two systems whose errors share most of their noise, the second one's larger by `shift`."""
    random = np.random.default_rng(seed)
    common, own = random.gamma(2.0, 1.0, count), 0.1 * random.normal(size=(2, count))
    first, second = common + own[0], common + own[1] + shift
    return {
        "a": {(1, i): [value] for i, value in enumerate(first.tolist())},
        "b": {(1, i): [value] for i, value in enumerate(second.tolist())},
    }


def test_pairing_makes_a_difference_visible() -> None:
    (found,) = paired(systems(), LOWER).differences
    assert found.is_significant
    assert found.better == "a"
    assert found.low < 0.1 < found.high
    assert found.gain > 50.0
    assert found.unpaired_low < 0.0 < found.unpaired_high
    assert found.unpaired_high - found.unpaired_low > 5.0 * (found.high - found.low)
    assert str(found).startswith("error: b is higher than a by 0.")
    assert str(found).endswith("60 pairs), so a is better")


def test_without_a_difference_nothing_is_claimed() -> None:
    (found,) = paired(systems(shift=0.0, seed=4), LOWER).differences
    assert not found.is_significant
    assert found.better == ""
    assert "no difference between a and b may be claimed" in str(found)


def test_of_a_metric_without_a_better_side_nothing_is_better() -> None:
    (found,) = paired(systems(), {"nees": {"unit": "", "better": "neither"}}).differences
    assert found.is_significant
    assert found.better == ""
    (found,) = paired(systems(), {"success": {"unit": "", "better": "higher"}}).differences
    assert found.better == "b"


def test_p_values_of_several_pairs_are_corrected() -> None:
    three = systems(shift=0.03)
    three["c"] = {key: [value + 1.0] for key, (value,) in three["a"].items()}
    found = paired(three, LOWER)
    assert [(each.first, each.second) for each in found.differences] == [("a", "b"), ("a", "c"), ("b", "c")]
    assert all(each.p_corrected >= each.p for each in found.differences)
    assert found.differences[1].p_corrected == pytest.approx(3.0 * found.differences[1].p)


def test_pairs_without_a_value_are_left_out_and_counted() -> None:
    two = systems()
    two["a"][1, 0] = [math.nan]
    del two["b"][1, 5]
    found = paired(two, LOWER)
    assert (found.differences[0].pairs, found.differences[0].left_out) == (58, 1)
    assert [each.missing for each in found.summaries] == [1, 0]


def test_a_metric_without_pairs_is_no_test_that_p_values_are_corrected_for() -> None:
    two = {label: {key: [*values, math.nan] for key, values in found.items()} for label, found in systems().items()}
    error, arrival = paired(two, LOWER | {"arrival": {"unit": "s", "better": "lower"}}).differences
    assert error.p_corrected == error.p
    assert math.isnan(arrival.p_corrected)
    assert not arrival.is_significant
    assert str(arrival).startswith("arrival: nothing may be claimed of a and b: expected two pairs at least")


def test_an_axis_that_changes_nothing_makes_nothing_surer() -> None:
    """Along other axes the draws are the same: what differs there alone is not independent."""
    small = systems(count=10, shift=0.05)
    along = {
        label: {(axis, *key): values for axis in (0.5, 1.0) for key, values in found.items()}
        for label, found in small.items()
    }
    found, wanted = paired(along, LOWER), paired(small, LOWER)
    for each in attrs.fields(Difference):
        assert getattr(found.differences[0], each.name) == pytest.approx(getattr(wanted.differences[0], each.name))
    assert found.differences[0].pairs == 10
    for one, other in zip(found.summaries, wanted.summaries, strict=True):
        assert (one.mean, one.low, one.high) == pytest.approx((other.mean, other.low, other.high))
        assert one.count == 2 * other.count


def test_what_some_points_of_an_axis_lack_is_left_out_there_alone() -> None:
    two = {"a": {(x, 1, i): [float(i)] for x in (1, 2) for i in range(4)}}
    two["b"] = {key: [value + key[0]] for key, (value,) in two["a"].items()}
    two["b"][2, 1, 3] = [math.nan]
    found = paired(two, LOWER)
    assert found.differences_of["error", "a", "b"].tolist() == [1.5, 1.5, 1.5, 1.0]
    assert (found.differences[0].pairs, found.differences[0].left_out) == (4, 1)


def test_the_mean_of_a_system_is_that_of_its_values_also_where_some_are_missing() -> None:
    values = {(x, 1, i): [float(10 * x + i)] for x in (1, 2) for i in range(3)}
    values[2, 1, 0] = [math.nan]
    first, _ = paired({"a": values, "b": values}, LOWER).summaries
    assert (first.mean, first.count, first.missing) == (pytest.approx((10 + 11 + 12 + 21 + 22) / 5), 5, 1)


def test_one_pair_has_no_effect_size() -> None:
    two = {"a": {(1, 0): [1.0]}, "b": {(1, 0): [2.0]}}
    (found,) = paired(two, LOWER).differences
    assert math.isnan(found.effect)
    assert str(found).endswith("in which both have a value, got 1")


@settings(max_examples=200)
@given(
    shifts=st.lists(st.sampled_from([0.0, 0.2, 0.5, 1.0]), min_size=1, max_size=4),
    count=st.integers(1, 25),
    seed=st.integers(0, 1000),
    whole=st.booleans(),
)
def test_no_interval_contradicts_the_verdict_beside_it(shifts: list[float], count: int, seed: int, whole: bool) -> None:
    """Of errors, and of counts, of which few differ; also where several differences are corrected for."""
    random = np.random.default_rng(seed)
    made = {"reference": random.gamma(1.0, 1.0, count)}
    made |= {f"by {place}": random.gamma(1.0, 1.0, count) + shift for place, shift in enumerate(shifts)}
    values = {label: (np.round(each) if whole else each).tolist() for label, each in made.items()}
    found = paired({label: {(1, i): [x] for i, x in enumerate(each)} for label, each in values.items()}, LOWER)
    for each in found.differences:
        excludes_zero = each.low > 0.0 or each.high < 0.0
        assert excludes_zero == each.is_significant == bool(each.better)
        assert excludes_zero == (each.p_corrected < 0.05)
        assert ("may be claimed" in str(each) or "identical" in str(each)) == (not excludes_zero)
        assert each.confidence >= 0.95
        single = mean_interval(found.differences_of[each.metric, each.first, each.second])
        assert math.isnan(each.low) or each.low <= single.low <= single.high <= each.high


def test_of_no_difference_hardly_any_interval_excludes_0() -> None:
    """Of 400 comparisons of equal systems with 20 pairs; the bound is the binomial one of 0.1 %."""
    random = np.random.default_rng(3)
    claimed = 0
    for _ in range(400):
        one, other = random.rayleigh(1.0, (2, 20)).tolist()
        (each,) = paired(
            {label: {(1, i): [x] for i, x in enumerate(xs)} for label, xs in (("a", one), ("b", other))}, LOWER
        ).differences
        claimed += each.is_significant
    assert claimed <= stats.binom.ppf(0.999, 400, 0.05)


def test_identical_pairs_are_called_so_and_are_no_test_to_correct_for() -> None:
    two = {label: {key: [*values, 1.0] for key, values in found.items()} for label, found in systems().items()}
    error, same = paired(two, LOWER | {"length": {"unit": "m", "better": "lower"}}).differences
    assert str(same) == "length: a and b are identical in all 60 pairs"
    assert (same.p_corrected, same.better) == (1.0, "")
    assert math.isnan(same.gain)
    assert error.p_corrected == error.p


def test_equal_differences_of_few_pairs_are_not_claimed() -> None:
    """Five successes against five failures would be as one-sided in one of 16 comparisons without a difference."""

    def found(count: int) -> Difference:
        return paired({x: {(1, i): [v] for i in range(count)} for x, v in (("a", 1.0), ("b", 0.0))}, LOWER).differences[
            0
        ]

    assert (found(5).p, found(5).better) == (2 / 32, "")
    assert str(found(5)).startswith("error: nothing may be claimed of a and b: all 5 pairs differ by 1.000 m")
    assert (found(6).low, found(6).high, found(6).better) == (-1.0, -1.0, "b")


def test_systems_without_a_common_seed_are_refused() -> None:
    with pytest.raises(am.AnalysisError, match=r"a and b have no seed and replica in common"):
        paired({"a": {(1, 0): [1.0]}, "b": {(2, 0): [1.0]}}, LOWER)


@pytest.mark.long
def test_studies_and_axes_are_compared(tmp_path: Path) -> None:
    both = am.sweep(tables(tmp_path / "s", replicas=20, seeds=[1, 2]), tmp_path / "both")
    along = compare(both, axis=TRACK)
    assert along.labels == ("1.0", "1.05")
    one, other = (
        am.sweep(tables(tmp_path / "s", replicas=20, seeds=[1, 2], axes={TRACK: [scale]}), tmp_path / name)
        for name, scale in (("one", 1.0), ("other", 1.05))
    )
    # Each study has one value of the axis, so nothing of theirs belongs together.
    with pytest.raises(am.AnalysisError, match=r"no seed and replica in common"):
        compare(one, other)
    for study in (one, other):
        study.about["axes"] = {}
    two = compare(one, other, labels=("1.0", "1.05"))
    assert [str(each) for each in two.differences] == [str(each) for each in along.differences]
    length = next(each for each in along.differences if each.metric == "length")
    assert length.pairs == 40
    made = along.save(tmp_path)
    with made[0].open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["metric"] for line in lines] == ["final_error", "length"]
    assert json.loads(made[1].read_text())["labels"] == ["1.0", "1.05"]


ESTIMATORS = """
[robots.estimators]
wheels = { use = "dead_reckoning" }
filter = { use = "ekf", wheel_variance = 1e-4 }
"""


def of_estimators(folder: Path, name: str, variance: str = "1e-4", **changes: object) -> am.Study:
    """A study of a robot with three estimators, two of which do the same."""
    given = tables(folder / "s", axes=None, replicas=6)
    estimators = ESTIMATORS.replace("1e-4", variance)
    text = SCENARIO.replace("\n[robots.errors", f"{estimators}\n[robots.errors")
    (folder / "s" / f"{name}.toml").write_text(text)
    metrics = {
        f"{use}_{whose}": {"use": use, "estimator": whose}
        for use in ("position_error", "heading_error")
        for whose in ("wheels", "filter")
    }
    given |= {"scenario": str(folder / "s" / f"{name}.toml"), "metrics": metrics | {"off": {"use": "position_error"}}}
    return am.sweep(given | changes, folder / name)


def test_a_study_knows_which_estimator_each_metric_judges(tmp_path: Path) -> None:
    study = of_estimators(tmp_path, "one")
    judged = {name: (about["estimator"], about["measure"]) for name, about in study.about["metrics"].items()}
    assert judged["position_error_filter"] == ("filter", "position_error")
    assert judged["off"] == ("dead_reckoning", "position_error")
    assert "position_error_wheels" in str(compare(study, study, labels=["a", "b"], estimators=["wheels"]))


def test_estimators_are_compared_within_one_study(tmp_path: Path) -> None:
    study = of_estimators(tmp_path, "one")
    found = compare(study)
    assert found.labels == ("wheels", "filter", "dead_reckoning")
    pairs = [(each.metric, each.first, each.second) for each in found.differences]
    assert pairs == [
        ("position_error", "wheels", "filter"),
        ("position_error", "wheels", "dead_reckoning"),
        ("position_error", "filter", "dead_reckoning"),
        ("heading_error", "wheels", "filter"),
    ]
    wanted = study["position_error_filter"] - study["position_error_wheels"]
    assert found.differences_of["position_error", "wheels", "filter"] == pytest.approx(wanted)
    assert found.differences[1].is_identical
    assert len(compare(study, estimators=["wheels", "filter"]).differences) == 2
    (one,) = compare(study, metrics=["heading_error"]).differences
    assert one.metric == "heading_error"
    with pytest.raises(am.AnalysisError, match=r"expected two estimators at least .*, of those named"):
        compare(study, estimators=["wheels"])


def test_identical_studies_say_what_differs_but_does_not_reach_the_metric(tmp_path: Path) -> None:
    one, other = (of_estimators(tmp_path, name, variance) for name, variance in (("one", "1e-4"), ("other", "1e-3")))
    found = {each.metric: each for each in compare(one, other).differences}
    assert str(found["position_error_wheels"]) == (
        "position_error_wheels: one and other are identical in all 6 pairs; their scenarios differ in "
        "robots.rover.estimators.filter.wheel_variance, which does not reach this metric"
    )
    assert str(found["off"]).startswith("off of dead_reckoning: one and other are identical in all 6 pairs;")
    again = compare(one, one, labels=["a", "b"])
    assert str(again.differences[0]).endswith("in all 6 pairs; their scenarios do not differ")
    (tmp_path / "s" / "other.toml").unlink()
    assert str(compare(one, other).differences[0]).endswith("are identical in all 6 pairs")


def test_an_axis_that_does_not_reach_a_metric_is_named(tmp_path: Path) -> None:
    study = am.sweep(tables(tmp_path / "s", replicas=3, metrics={"n": {"use": "collisions"}}), tmp_path / "out")
    (found,) = compare(study, axis=TRACK).differences
    assert str(found) == f"n: 1.0 and 1.05 are identical in all 3 pairs; {TRACK} does not reach this metric"


def test_what_cannot_be_compared_is_reported(tmp_path: Path) -> None:
    study = am.sweep(tables(tmp_path / "s", replicas=2), tmp_path / "out")
    with pytest.raises(
        am.AnalysisError, match=r"expected two estimators at least .*; the study's metrics are final_error \(dead"
    ):
        compare(study)
    with pytest.raises(am.AnalysisError, match=r"expected a study at least"):
        compare()
    with pytest.raises(am.AnalysisError, match=r"estimators: no metric judges 'ekf'; judged are: dead_reckoning"):
        compare(study, axis=TRACK, estimators=["ekf"])
    with pytest.raises(am.AnalysisError, match=r"no axis 'track'; known axes: robots.rover"):
        compare(study, axis="track")
    with pytest.raises(am.AnalysisError, match=r"no common metric 'eror'; known common metrics: final_error, length"):
        compare(study, axis=TRACK, metrics=["eror"])
    with pytest.raises(am.AnalysisError, match=r"labels: expected 2 different names"):
        compare(study, study, labels=["a", "a"])
    with pytest.raises(am.StudyError, match=r"expected the folder of a study"):
        compare(tmp_path, tmp_path)
