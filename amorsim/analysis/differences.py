"""The result of a comparison: figures of each system, paired differences, and what may be claimed of them."""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.array_types import Array
from amorsim.core.display import in_notebook
from amorsim.core.files.atomic_files import write_text
from amorsim.render.words import significant, with_interval

__all__ = ["ABOUT", "Comparison", "Difference", "Summary", "metric_of_estimator", "p_in_words"]


ABOUT = "comparison.json"


@attrs.frozen(kw_only=True)
class Summary:
    """One system's values of a metric: how many, how many are missing, mean and median.

    The mean is that of all values, as `amorsim sweep` prints it. `low` and `high` are its 95 % interval
    (`mean_interval`), in which the values of one seed and replica count as one, their mean: they had the same draws.
    """

    label: str
    metric: str
    estimator: str
    unit: str
    count: int
    missing: int
    mean: float
    median: float
    low: float
    high: float


@attrs.frozen(kw_only=True)
class Difference:
    """The difference of two systems in a metric, `second` less `first`, over pairs of one seed and replica.

    Attributes
    ----------
    estimator
        The one that the metric judges; empty if it judges none, or where two systems are compared by theirs.
    pairs, left_out
        How many pairs there are, one for each seed and replica; and how many pairs of values were left out because one
        of the two is missing.
    mean, low, high
        Of the differences, with their 95 % interval (`mean_interval`), widened as far as the correction of `p` asks. It
        excludes 0 exactly where a difference may be claimed. nan where there are too few pairs.
    confidence
        Of the interval: 0.95, or more where it is widened.
    unpaired_low, unpaired_high
        The interval that the same values give if one forgets which belong together (Welch).
    p, p_corrected
        The p-value of the interval, two-sided; corrected for all differences of the comparison (Holm). nan without
        pairs. Where all differences are alike, that of the sign test.
    effect
        Cohen's d of the paired differences; nan of fewer than two.
    gain
        Variance of the difference of independent values, over that of paired ones: above 1, pairing pays. nan where
        nothing differs.
    better
        The label of the better system, if that may be claimed.
    remark
        What else is to be known, such as why all pairs are identical.
    """

    metric: str
    estimator: str
    unit: str
    first: str
    second: str
    pairs: int
    left_out: int
    mean: float
    low: float
    high: float
    confidence: float
    unpaired_low: float
    unpaired_high: float
    p: float
    p_corrected: float
    effect: float
    gain: float
    better: str = ""
    remark: str = ""

    @property
    def is_significant(self) -> bool:
        """Whether a difference may be claimed at 5 %: its interval excludes 0."""
        return self.low > 0.0 or self.high < 0.0

    @property
    def is_identical(self) -> bool:
        """Whether no pair differs at all."""
        return self.pairs > 0 and self.mean == self.low == self.high == 0.0

    def __str__(self) -> str:
        return f"{metric_of_estimator(self.metric, self.estimator)}: {self._claim()}"

    def _claim(self) -> str:
        both = f"{self.first} and {self.second}"
        remark = f"; {self.remark}" if self.remark else ""
        if self.is_identical:
            return f"{both} are identical in all {self.pairs} pairs{remark}"
        unit = f" {self.unit}" if self.unit else ""
        if self.pairs < 2:
            return (
                f"nothing may be claimed of {both}: expected two pairs at least in which both have a value, got "
                f"{self.pairs}"
            )
        if math.isnan(self.low):
            return (
                f"nothing may be claimed of {both}: all {self.pairs} pairs differ by {significant(abs(self.mean))}"
                f"{unit}, so nothing shows how pairs scatter, and they are too few for a test of signs"
            )
        mean, low, high = with_interval(self.mean, self.low, self.high)
        figures = (
            f"{mean.lstrip('-')}{unit} on the mean (95 % interval of the difference {low} to {high}{unit}, "
            f"p {p_in_words(self.p_corrected)}, d = {self.effect:.2f}, {self.pairs} pairs)"
        )
        if not self.is_significant:
            return f"no difference between {both} may be claimed; they differ by {figures}{remark}"
        way = "lower" if self.mean < 0.0 else "higher"
        better = f", so {self.better} is better" if self.better else ""
        return f"{self.second} is {way} than {self.first} by {figures}{better}{remark}"


def metric_of_estimator(metric: str, estimator: str) -> str:
    """A metric's name with that of the estimator that it judges, unless it has that already."""
    return f"{metric} of {estimator}" if estimator and estimator not in metric else metric


def p_in_words(value: float) -> str:
    """A p-value after the letter: ``= 0.013``, ``< 0.001``."""
    return "< 0.001" if value < 0.001 else f"= {value:.2g}"


@attrs.frozen(kw_only=True, eq=False)
class Comparison:
    """The result of `compare`: a summary of each system and metric, and each pair's difference.

    Attributes
    ----------
    differences_of
        The paired differences themselves, by metric, first and second.
    axis
        Whose values were compared; empty if other things were.
    origin
        What was compared: ``studies`` with seeds and versions, and the ``command`` that repeats it.
    """

    labels: tuple[str, ...]
    summaries: tuple[Summary, ...]
    differences: tuple[Difference, ...]
    differences_of: Mapping[tuple[str, str, str], Array]
    axis: str = ""
    origin: Mapping[str, Any] = attrs.field(factory=dict)

    _repr_mimebundle_ = in_notebook

    def __str__(self) -> str:
        return "\n".join(map(str, self.differences))

    def save(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write ``comparison.csv``, with a line for each pair, and ``comparison.json``; returns where they lie.

        Raises
        ------
        RunError
            If a file cannot be written.
        """
        folder = Path(folder)
        text = io.StringIO()
        names = [field.name for field in attrs.fields(Difference)]
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(names)
        writer.writerows([getattr(each, name) for name in names] for each in self.differences)
        write_text(folder / "comparison.csv", text.getvalue(), within=folder)
        about = {
            "format": 1,
            "labels": self.labels,
            "axis": self.axis,
            "summaries": [attrs.asdict(each) for each in self.summaries],
            "differences": [{**attrs.asdict(each), "claim": str(each)} for each in self.differences],
            "origin": dict(self.origin),
        }
        write_text(folder / ABOUT, json.dumps(about, indent=2) + "\n", within=folder)
        return [folder / "comparison.csv", folder / ABOUT]
