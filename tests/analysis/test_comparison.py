"""Comparisons pair what met the same noise, and claim what may be claimed."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.analysis import compare
from amorsim.analysis.comparison import Difference, paired
from tests.sweeps.studies import TRACK, tables

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


def test_systems_without_a_common_seed_are_refused() -> None:
    with pytest.raises(am.AnalysisError, match=r"a and b have no seed and replica in common"):
        paired({"a": {(1, 0): [1.0]}, "b": {(2, 0): [1.0]}}, LOWER)


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


def test_what_cannot_be_compared_is_reported(tmp_path: Path) -> None:
    study = am.sweep(tables(tmp_path / "s", replicas=2), tmp_path / "out")
    with pytest.raises(am.AnalysisError, match=r"expected two studies at least"):
        compare(study)
    with pytest.raises(am.AnalysisError, match=r"there is no axis 'track', but: robots.rover"):
        compare(study, axis="track")
    with pytest.raises(am.AnalysisError, match=r"there is no 'eror' that all have, but: final_error, length"):
        compare(study, axis=TRACK, metrics=["eror"])
    with pytest.raises(am.AnalysisError, match=r"labels: expected 2 different names"):
        compare(study, study, labels=["a", "a"])
    with pytest.raises(am.StudyError, match=r"expected the folder of a study"):
        compare(tmp_path, tmp_path)
