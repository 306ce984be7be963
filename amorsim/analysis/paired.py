"""Differences between systems in the values of metrics, paired by a key of each value."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from amorsim.algorithms.effects import holm, paired_effect
from amorsim.algorithms.intervals import mean_interval, welch_half_width
from amorsim.analysis.differences import Comparison, Difference, Summary
from amorsim.array_types import Array
from amorsim.core.errors import AnalysisError

__all__ = ["Key", "by_draws", "paired"]

Key = tuple[Any, ...]

LEVEL = 0.05


def paired(
    systems: Mapping[str, Mapping[Key, Sequence[float]]], metrics: Mapping[str, Mapping[str, str]]
) -> Comparison:
    """Compare systems by the values of metrics; values with equal keys are pairs.

    Parameters
    ----------
    systems
        By label: for each key, the values of the metrics in order. The last two parts of a key are the seed and the
        replica. Only values of different ones are independent.
    metrics
        By name, in that order: ``unit``, ``better``, which is ``"lower"``, ``"higher"`` or ``"neither"``, and
        ``estimator``, the one that is judged, if any.

    Raises
    ------
    AnalysisError
        If two systems have no key in common.
    """
    summaries, pairs = [], []
    for place, (metric, about) in enumerate(metrics.items()):
        for label, found in systems.items():
            values = np.array([values[place] for values in found.values()])
            summaries.append(_summary(label, metric, about, values, list(found)))
        for first, second in itertools.combinations(systems, 2):
            pairs.append(_Pairs(systems, metric, place, first, second))
    # Pairs that are identical to the bit are no test, which others would have to be corrected for.
    corrected = holm([math.nan if each.are_identical else each.p for each in pairs])
    return Comparison(
        labels=tuple(systems),
        summaries=tuple(summaries),
        differences=tuple(
            each.difference(metrics[each.metric], each.p if each.are_identical else p)
            for each, p in zip(pairs, corrected, strict=True)
        ),
        differences_of={(each.metric, each.first, each.second): each.differences for each in pairs},
    )


def by_draws(values: Array, keys: Sequence[Key]) -> Array:
    """The mean of the values `(n,)` of each pair of seed and replica, the last two parts of their keys."""
    places: dict[Key, int] = {}
    place = np.array([places.setdefault(key[-2:], len(places)) for key in keys], dtype=np.int64)
    if len(places) == len(keys):
        return values
    return np.asarray(np.bincount(place, values) / np.bincount(place))


def _summary(label: str, metric: str, about: Mapping[str, str], values: Array, keys: Sequence[Key]) -> Summary:
    has_value = ~np.isnan(values)
    there = values[has_value]
    draws = by_draws(there, [key for key, is_there in zip(keys, has_value.tolist(), strict=True) if is_there])
    interval = mean_interval(draws)
    return Summary(
        label=label,
        metric=metric,
        estimator=about.get("estimator", ""),
        unit=about["unit"],
        count=len(there),
        missing=len(values) - len(there),
        mean=float(np.mean(there)) if len(there) else math.nan,
        median=float(np.median(there)) if len(there) else math.nan,
        low=interval.low,
        high=interval.high,
    )


class _Pairs:
    """The values of two systems in a metric, paired by seed and replica."""

    def __init__(
        self,
        systems: Mapping[str, Mapping[Key, Sequence[float]]],
        metric: str,
        place: int,
        first: str,
        second: str,
    ) -> None:
        self.metric, self.first, self.second = metric, first, second
        common = [key for key in systems[first] if key in systems[second]]
        if not common:
            raise AnalysisError(
                f"{first} and {second} have no seed and replica in common; run them with the same seeds and "
                "replicas, so that they meet the same noise"
            )
        a, b = (np.array([systems[label][key][place] for key in common], float) for label in (first, second))
        there = ~(np.isnan(a) | np.isnan(b))
        keys = [key for key, is_there in zip(common, there.tolist(), strict=True) if is_there]
        self.left_out = len(common) - len(keys)
        self._a, self._b = (by_draws(values[there], keys) for values in (a, b))
        self.differences = self._b - self._a
        self.are_identical = not self.differences.any()
        self.p = mean_interval(self.differences).p
        are_equal = len(self.differences) > 1 and self.differences.min() == self.differences.max()
        self._differ_equally = are_equal and not self.are_identical
        if self._differ_equally:
            # Nothing scatters, as with counts of few pairs. All that is known is that their signs are the same.
            self.p = 2.0 ** (1 - len(self.differences))

    def difference(self, about: Mapping[str, str], p_corrected: float) -> Difference:
        """The difference, with an interval that excludes 0 exactly where the corrected p is below 5 %."""
        differences, count = self.differences, len(self.differences)
        # Where the correction makes p so many times larger, the interval has a level so many times smaller.
        confidence = 1.0 - LEVEL * (self.p / p_corrected if p_corrected > 0.0 else 1.0)
        mean, low, high, _ = mean_interval(differences, confidence)
        if self._differ_equally and p_corrected >= LEVEL:
            low = high = math.nan
        half = apart = together = math.nan
        if count > 1:
            variances = [float(np.var(values, ddof=1)) for values in (self._a, self._b)]
            half = welch_half_width([variance / count for variance in variances], (count, count), confidence)
            apart, together = sum(variances), float(np.var(differences, ddof=1))
        wanted = about["better"]
        better = ""
        if (low > 0.0 or high < 0.0) and wanted in ("lower", "higher"):
            better = self.second if (mean < 0.0) == (wanted == "lower") else self.first
        return Difference(
            metric=self.metric,
            estimator=about.get("estimator", ""),
            unit=about["unit"],
            first=self.first,
            second=self.second,
            pairs=count,
            left_out=self.left_out,
            mean=mean,
            low=low,
            high=high,
            confidence=confidence,
            unpaired_low=mean - half,
            unpaired_high=mean + half,
            p=self.p,
            p_corrected=p_corrected,
            effect=paired_effect(differences) if count else math.nan,
            gain=apart / together if together else math.inf if differences.any() else math.nan,
            better=better,
        )
