"""Pictures of comparisons and of studies: intervals of differences, and metrics along axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from amorsim.algorithms.intervals import mean_interval
from amorsim.analysis.differences import Comparison, metric_of_estimator
from amorsim.analysis.paired import by_draws
from amorsim.analysis.plots.figures import tidy
from amorsim.array_types import Bools, Ints
from amorsim.sweeps.table import Study

__all__ = ["draw_comparison", "draw_metric"]


_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_MARKERS = "osD^vP"
_MOST_LINES = 6  # along a second axis
_MOST_TICKS = 30
_MOST_BARS = 200  # beyond them, intervals are drawn as a band


def draw_comparison(found: Comparison) -> Figure:
    """The paired differences of each pair of systems, a panel for each metric: mean, 95 % interval, and every pair."""
    metrics = list(dict.fromkeys(each.metric for each in found.differences))
    pairs = max(sum(each.metric == metric for each in found.differences) for metric in metrics)
    figure = Figure(figsize=(9.0, len(metrics) * (0.9 + 0.55 * pairs) + 0.6), layout="constrained")
    axes = figure.subplots(len(metrics), 1, squeeze=False)[:, 0]
    for axis, metric in zip(axes, metrics, strict=True):
        tidy(axis)
        axis.axvline(0.0, color="#6b7280", linewidth=1.0)
        of = [each for each in found.differences if each.metric == metric]
        for place, each in enumerate(of):
            values = found.differences_of[metric, each.first, each.second]
            spread = 0.12 * np.sin(2.4 * np.arange(len(values)))  # the same in every picture
            axis.plot(values, place + 0.18 + spread, ".", color="#9ca3af", markersize=3, zorder=1)
            colour = _COLOURS[0] if each.is_significant else "#374151"
            axis.plot([each.unpaired_low, each.unpaired_high], [place, place], color=colour, linewidth=1.0, alpha=0.5)
            axis.plot([each.low, each.high], [place, place], color=colour, linewidth=4.0)
            axis.plot(each.mean, place, "o", color=colour, markersize=8, markeredgecolor="white")
        unit = f" [{of[0].unit}]" if of[0].unit else ""
        axis.set_yticks(range(len(of)), [f"{each.second}\nless {each.first}" for each in of], fontsize=8)
        axis.set_ylim(len(of) - 0.4, -0.6)
        axis.set_xlabel(f"difference of {metric_of_estimator(metric, of[0].estimator)}{unit}", fontsize=9)
    figure.suptitle(
        "paired differences: mean, 95 % interval (thick), without pairing (thin), every pair (dots)",
        x=0.01,
        ha="left",
        fontsize=10,
    )
    return figure


def draw_metric(study: Study, metric: str) -> Figure:
    """A metric along the study's first axis: mean and 95 % interval, a line for each value of the second axis."""
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    axis = figure.subplots()
    tidy(axis)
    unit = study.about["metrics"][metric]["unit"]
    axis.set_ylabel(f"{metric} [{unit}]" if unit else metric)
    first = study.axes[0] if study.axes else ""
    labels = study.about["axes"][first] if first else ["all"]
    is_number = bool(first) and all(type(label) in (int, float) for label in labels)
    others = [name for name in study.axes[1:2] if len(study.about["axes"][name]) <= _MOST_LINES]
    lines = study.about["axes"][others[0]] if others else [None]
    groups = _Groups(study, first)
    for number, line in enumerate(lines):
        of_line = None if line is None else study[others[0]] == _in_table(study, others[0], line)
        points = []
        for place, label in enumerate(labels):
            rows = groups.rows(label, of_line)
            rows = rows[~np.isnan(study[metric][rows])]
            if not len(rows):
                continue
            draws = list(zip(study["seed"][rows].tolist(), study["replica"][rows].tolist(), strict=True))
            independent = by_draws(study[metric][rows], draws)  # further axes have the same draws
            _, low, high, _ = mean_interval(independent)
            at = float(label) if is_number else float(place)
            points.append((at, float(np.mean(study[metric][rows])), low, high))
        if not points:
            continue
        places, means, lows, highs = np.array(points).T
        style: dict[str, Any] = {"color": _COLOURS[number % 6], "marker": _MARKERS[number % 6]}
        label = None if line is None else f"{others[0].rpartition('.')[2]} = {line}"
        if len(places) <= _MOST_BARS or not is_number:
            reach = np.nan_to_num(np.maximum([means - lows, highs - means], 0.0))
            axis.errorbar(places, means, yerr=reach, capsize=3, linewidth=1.4, label=label, **style)
            continue
        places, means, lows, highs = np.array(sorted(points)).T
        axis.plot(places, means, color=style["color"], linewidth=1.0, label=label)
        axis.fill_between(places, lows, highs, color=style["color"], alpha=0.25, linewidth=0.0)
    if not is_number:
        shown = range(0, len(labels), -(-len(labels) // _MOST_TICKS))
        axis.set_xticks(shown, [str(labels[place])[:30] for place in shown])
    axis.set_xlabel(first, fontsize=9)
    if others:
        axis.legend(frameon=False, fontsize=9)
    axis.set_title("mean over replicas, seeds and further axes, with its 95 % interval", loc="left", fontsize=9)
    return figure


class _Groups:
    """The rows of a study by the value of an axis, found once for all values."""

    def __init__(self, study: Study, axis: str) -> None:
        self._study, self._axis = study, axis
        values = study[axis] if axis else np.zeros(len(study["point"]))
        order = np.argsort(values, kind="stable")
        found, starts = np.unique(values[order], return_index=True)
        self._rows = dict(zip(found.tolist(), np.split(order, starts[1:]), strict=False))

    def rows(self, label: Any, chosen: Bools | None) -> Ints:
        """The rows with this value, in their order; only those that are chosen, where these are given."""
        key = _in_table(self._study, self._axis, label) if self._axis else 0.0
        rows: Ints = self._rows.get(key, np.empty(0, dtype=np.int64))
        if chosen is not None:
            rows = rows[chosen[rows]]
        return rows


def _in_table(study: Study, axis: str, label: Any) -> Any:
    """A label as the table has it."""
    return str(label) if study[axis].dtype == object else label
