"""Pictures of studies show the means of the table, of few points and of very many."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from matplotlib.collections import LineCollection, PolyCollection

from amorsim.algorithms.intervals import mean_interval
from amorsim.analysis.plots.comparison_plots import draw_metric
from amorsim.sweeps.table import Study


def study(labels: list[Any], replicas: int, second: tuple[str, ...] = ()) -> Study:
    """Random values of a metric along one axis or two."""
    axes = {"first": labels} | ({"second": list(second)} if second else {})
    cells = [(label, other) for label in labels for other in second or ("",) for _ in range(replicas)]
    first = np.array([label for label, _ in cells], dtype=object if isinstance(labels[0], str) else float)
    columns = {
        "point": np.arange(len(cells)) // replicas,
        "first": first,
        "seed": np.ones(len(cells), dtype=np.int64),
        "replica": np.arange(len(cells)) % replicas,
        "off": np.random.default_rng(1).random(len(cells)),
    }
    if second:
        columns["second"] = np.array([other for _, other in cells], dtype=object)
    about = {"axes": axes, "metrics": {"off": {"unit": "m", "better": "lower"}}, "status": "finished"}
    return Study(Path(), about, columns)


@pytest.mark.parametrize("second", [(), ("a", "b")])
def test_points_are_means_with_their_intervals(second: tuple[str, ...]) -> None:
    found = study([3.0, 1.0, 2.0], 5, second)
    (axis,) = draw_metric(found, "off").axes
    bars = [each for each in axis.collections if isinstance(each, LineCollection)]
    for number, other in enumerate(second or ("",)):
        chosen = found["second"] == other if second else np.ones(15, dtype=bool)
        for place, label in enumerate([3.0, 1.0, 2.0]):
            interval = mean_interval(found["off"][chosen & (found["first"] == label)])
            (low, high) = bars[number].get_segments()[place]
            assert low == pytest.approx((label, interval.low))
            assert high == pytest.approx((label, interval.high))


def test_values_along_an_axis_that_is_not_drawn_count_once_for_each_replica() -> None:
    found = study([1.0, 2.0], 5, tuple("abcdefg"))
    (axis,) = draw_metric(found, "off").axes
    (bars,) = [each for each in axis.collections if isinstance(each, LineCollection)]
    for place, values in enumerate(found["off"].reshape(2, 7, 5)):
        interval = mean_interval(values.mean(axis=0))
        (low, high) = bars.get_segments()[place]
        assert (low[1], high[1]) == pytest.approx((interval.low, interval.high))


def test_very_many_numbers_have_a_band() -> None:
    found = study([float(value) for value in range(500)], 3)
    (axis,) = draw_metric(found, "off").axes
    (line,) = axis.lines
    means = found["off"].reshape(500, 3).mean(axis=1)
    assert line.get_ydata() == pytest.approx(means)
    assert sum(isinstance(each, PolyCollection) for each in axis.collections) == 1


def test_very_many_names_have_few_ticks() -> None:
    found = study([f"variant {number}" for number in range(1000)], 1)
    (axis,) = draw_metric(found, "off").axes
    assert 10 <= len(axis.get_xticks()) <= 30
    assert [tick.get_text() for tick in axis.get_xticklabels()][:2] == ["variant 0", "variant 34"]
