"""Two or more systems on the same seeds, worlds and noise: what may be claimed of their differences."""

from __future__ import annotations

import csv
import io
import itertools
import json
import math
import os
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.algorithms.resampling import bootstrap_interval, holm, paired_effect, permutation_p
from amorsim.core.arguments import check_text, texts
from amorsim.core.errors import AnalysisError, did_you_mean
from amorsim.core.whole_files import write_text
from amorsim.sweeps.table import Study, read_study

__all__ = ["Comparison", "Difference", "Summary", "by_draws", "compare", "paired"]

Array = npt.NDArray[np.float64]
Key = tuple[Any, ...]

LEVEL = 0.05
ABOUT = "comparison.json"
_MADE_OF = ("seeds", "replicas", "duration", "amorsim", "python", "packages", "system", "processor")


@attrs.frozen(kw_only=True)
class Summary:
    """One system's values of a metric: how many there are and how many are missing, and their mean and median.

    The mean is that of all values, as `amorsim sweep` prints it. `low` and `high` are its 95 % interval, in which the
    values of one seed and replica count as one, their mean: they had the same draws.
    """

    label: str
    metric: str
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
    pairs, left_out
        How many pairs there are, one for each seed and replica; and how many pairs of values were left out because one
        of the two is missing.
    mean, low, high
        Of the differences, with the 95 % interval by the bootstrap.
    unpaired_low, unpaired_high
        The interval that the same values give if one forgets which belong together (Welch).
    p, p_corrected
        By a permutation test, two-sided; corrected for all differences of the comparison (Holm). nan without pairs.
    effect
        Cohen's d of the paired differences; nan of fewer than two.
    gain
        Variance of the difference of independent values, over that of paired ones: above 1, pairing pays.
    better
        The label of the better system, if that may be claimed.
    """

    metric: str
    unit: str
    first: str
    second: str
    pairs: int
    left_out: int
    mean: float
    low: float
    high: float
    unpaired_low: float
    unpaired_high: float
    p: float
    p_corrected: float
    effect: float
    gain: float
    better: str = ""

    @property
    def is_significant(self) -> bool:
        """Whether a difference may be claimed at 5 %."""
        return self.p_corrected < LEVEL

    def __str__(self) -> str:
        if self.pairs < 2:
            return (
                f"{self.metric}: nothing may be claimed of {self.first} and {self.second}: expected two pairs at least "
                f"in which both have a value, got {self.pairs}"
            )
        unit = f" {self.unit}" if self.unit else ""
        figures = (
            f"{abs(self.mean):.4g}{unit} on the mean (95 % interval of the difference {self.low:.4g} to "
            f"{self.high:.4g}{unit}, {_p(self.p_corrected)}, d = {self.effect:.2f}, {self.pairs} pairs)"
        )
        if not self.is_significant:
            return (
                f"{self.metric}: no difference between {self.first} and {self.second} may be claimed; they differ by "
                f"{figures}"
            )
        way = "lower" if self.mean < 0.0 else "higher"
        claim = f", so {self.better} is better" if self.better else ""
        return f"{self.metric}: {self.second} is {way} than {self.first} by {figures}{claim}"


def _p(value: float) -> str:
    return "p < 0.001" if value < 0.001 else f"p = {value:.2g}"


@attrs.frozen(kw_only=True, eq=False)
class Comparison:
    """What `compare` found: a summary of each system and metric, and each pair's difference.

    Attributes
    ----------
    differences_of
        The paired differences themselves, by metric, first and second.
    origin
        What was compared: ``studies`` with seeds and versions, and the ``command`` that repeats it.
    """

    labels: tuple[str, ...]
    summaries: tuple[Summary, ...]
    differences: tuple[Difference, ...]
    differences_of: Mapping[tuple[str, str, str], Array]
    origin: Mapping[str, Any] = attrs.field(factory=dict)

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
        write_text(folder / "comparison.csv", text.getvalue())
        about = {
            "format": 1,
            "labels": self.labels,
            "summaries": [attrs.asdict(each) for each in self.summaries],
            "differences": [{**attrs.asdict(each), "claim": str(each)} for each in self.differences],
            "origin": dict(self.origin),
        }
        write_text(folder / ABOUT, json.dumps(about, indent=2) + "\n")
        return [folder / "comparison.csv", folder / ABOUT]


def compare(
    *studies: Study | str | os.PathLike[str],
    labels: Sequence[str] = (),
    axis: str | None = None,
    metrics: Sequence[str] = (),
) -> Comparison:
    """Compare studies of the same seeds and replicas, or the values of an axis within one study.

    Values of the same seed, replica and other axes belong together: the draws were the same for all. They were the same
    along other axes, too, so the differences there are not independent: their mean counts as one, for each seed and
    replica.

    Parameters
    ----------
    studies
        Studies, or their folders.
    labels
        A name for each; without them, the studies' own.
    axis
        Of one study: its values are what is compared.
    metrics
        Which; without them, all that all studies have.

    Raises
    ------
    StudyError
        If a folder is none of a study.
    AnalysisError
        If they have too little in common.
    """
    labels = texts(labels, "labels", "names")
    metrics = texts(metrics, "metrics", "names")
    read = [one if isinstance(one, Study) else read_study(one) for one in studies]
    if axis is not None:
        if len(read) != 1:
            raise AnalysisError(f"axis: is for one study, got {len(read)}")
        return attrs.evolve(_along(read[0], axis, metrics), origin=_origin(read, axis, metrics))
    if len(read) < 2:
        raise AnalysisError(f"expected two studies at least, or one and an axis of it, got {len(read)}")
    names = list(labels) or _names(read)
    if len(names) != len(read) or len(set(names)) < len(names):
        raise AnalysisError(f"labels: expected {len(read)} different names, got {names}")
    if len({tuple(sorted(study.axes)) for study in read}) > 1:
        axes = "; ".join(f"{name}: {', '.join(study.axes) or 'none'}" for name, study in zip(names, read, strict=True))
        raise AnalysisError(f"expected studies with the same axes, got {axes}")
    chosen = _chosen(read, metrics)
    systems = {
        name: _keyed(study, [*sorted(study.axes), "seed", "replica"], chosen)
        for name, study in zip(names, read, strict=True)
    }
    found = paired(systems, {name: read[0].about["metrics"][name] for name in chosen})
    return attrs.evolve(found, origin=_origin(read, None, metrics))


def _origin(studies: Sequence[Study], axis: str | None, metrics: Sequence[str]) -> dict[str, Any]:
    """What is compared: each study with all that it is made of, and the command that repeats the comparison."""
    folders = [study.folder.resolve().name for study in studies]
    command = ["amorsim", "compare", *folders, *(["--axis", axis] if axis else [])]
    for metric in metrics:
        command += ["--metric", metric]
    about = [
        {"folder": folder, "scenario": Path(str(study.about.get("scenario", ""))).name}
        | {key: study.about[key] for key in _MADE_OF if key in study.about}
        for folder, study in zip(folders, studies, strict=True)
    ]
    return {"studies": about, "command": shlex.join(command)}


def _names(studies: Sequence[Study]) -> list[str]:
    """Names that tell studies apart: their own, or those of their folders."""
    own = [str(study.about.get("name", "")) for study in studies]
    if len(set(own)) == len(own):
        return own
    folders = [study.folder.resolve().name for study in studies]
    return folders if len(set(folders)) == len(folders) else [str(study.folder) for study in studies]


def _along(study: Study, axis: str, metrics: Sequence[str]) -> Comparison:
    check_text(axis, "axis", "the name of an axis")
    if axis not in study.axes:
        known = ", ".join(study.axes) or "none"
        raise AnalysisError(f"{study.folder}: there is no axis {axis!r}, but: {known}.{did_you_mean(axis, study.axes)}")
    chosen = _chosen([study], metrics)
    whole = _keyed(study, [axis, *(name for name in study.axes if name != axis), "seed", "replica"], chosen)
    systems: dict[str, dict[Key, list[float]]] = {}
    for key, values in whole.items():
        systems.setdefault(str(key[0]), {})[key[1:]] = values
    if len(systems) < 2:
        raise AnalysisError(f"{study.folder}: the axis {axis!r} has one value only; there is nothing to compare")
    return paired(systems, {name: study.about["metrics"][name] for name in chosen})


def _chosen(studies: Sequence[Study], metrics: Sequence[str]) -> list[str]:
    common = [name for name in studies[0].metrics if all(name in study.metrics for study in studies)]
    for name in metrics:
        if name not in common:
            raise AnalysisError(
                f"metrics: there is no {name!r} that all have, but: {', '.join(common) or 'none'}."
                f"{did_you_mean(name, common)}"
            )
    if not common:
        raise AnalysisError("expected studies with a metric in common")
    return list(metrics) or common


def _keyed(study: Study, keys: Sequence[str], metrics: Sequence[str]) -> dict[Key, list[float]]:
    rows = zip(*(study[name].tolist() for name in keys), strict=True)
    values = np.stack([study[name] for name in metrics], axis=1).tolist()
    return dict(zip(rows, values, strict=True))


def paired(
    systems: Mapping[str, Mapping[Key, Sequence[float]]], metrics: Mapping[str, Mapping[str, str]]
) -> Comparison:
    """Compare systems by values of metrics, each under a key that says which belong together.

    Parameters
    ----------
    systems
        By label: for each key, the values of the metrics in order. The last two parts of a key are the seed and the
        replica. Only values of different ones are independent.
    metrics
        By name, in that order: ``unit``, and ``better``, which is ``"lower"``, ``"higher"`` or ``"neither"``.

    Raises
    ------
    AnalysisError
        If two systems have no key in common.
    """
    summaries, raw = [], []
    differences_of: dict[tuple[str, str, str], Array] = {}
    for place, (metric, about) in enumerate(metrics.items()):
        for label, found in systems.items():
            summaries.append(
                _summary(label, metric, np.array([values[place] for values in found.values()]), list(found))
            )
        for first, second in itertools.combinations(systems, 2):
            common = [key for key in systems[first] if key in systems[second]]
            if not common:
                raise AnalysisError(
                    f"{first} and {second} have no seed and replica in common; run them with the same seeds and "
                    "replicas, so that they meet the same noise"
                )
            a, b = (np.array([systems[label][key][place] for key in common], float) for label in (first, second))
            there = ~(np.isnan(a) | np.isnan(b))
            keys = [key for key, is_there in zip(common, there.tolist(), strict=True) if is_there]
            left_out = len(common) - len(keys)
            a, b = (by_draws(values[there], keys) for values in (a, b))
            differences_of[metric, first, second] = b - a
            raw.append(_difference(metric, about, first, second, a, b, left_out))
    corrected = holm([each.p for each in raw])
    differences = []
    for each, p in zip(raw, corrected, strict=True):
        better = ""
        wanted = metrics[each.metric]["better"]
        if p < LEVEL and wanted in ("lower", "higher"):
            better = each.second if (each.mean < 0.0) == (wanted == "lower") else each.first
        differences.append(attrs.evolve(each, p_corrected=p, better=better))
    return Comparison(
        labels=tuple(systems),
        summaries=tuple(summaries),
        differences=tuple(differences),
        differences_of=differences_of,
    )


def by_draws(values: Array, keys: Sequence[Key]) -> Array:
    """The mean of the values `(n,)` of each seed and replica, the last two parts of their keys."""
    places: dict[Key, int] = {}
    place = np.array([places.setdefault(key[-2:], len(places)) for key in keys], dtype=np.int64)
    if len(places) == len(keys):
        return values
    return np.asarray(np.bincount(place, values) / np.bincount(place))


def _summary(label: str, metric: str, values: Array, keys: Sequence[Key]) -> Summary:
    has_value = ~np.isnan(values)
    there = values[has_value]
    draws = by_draws(there, [key for key, is_there in zip(keys, has_value.tolist(), strict=True) if is_there])
    low, high = bootstrap_interval(draws) if len(draws) > 1 else (math.nan, math.nan)
    return Summary(
        label=label,
        metric=metric,
        count=len(there),
        missing=len(values) - len(there),
        mean=float(np.mean(there)) if len(there) else math.nan,
        median=float(np.median(there)) if len(there) else math.nan,
        low=low,
        high=high,
    )


def _difference(
    metric: str, about: Mapping[str, str], first: str, second: str, a: Array, b: Array, left_out: int
) -> Difference:
    differences = b - a
    few = len(differences) < 2
    low, high = (math.nan, math.nan) if few else bootstrap_interval(differences)
    apart = math.nan if few else float(np.var(a, ddof=1) + np.var(b, ddof=1))
    together = math.nan if few else float(np.var(differences, ddof=1))
    mean = float(np.mean(differences)) if len(differences) else math.nan
    half = _welch(a, b)
    p = permutation_p(differences) if len(differences) else math.nan
    return Difference(
        metric=metric,
        unit=about["unit"],
        first=first,
        second=second,
        pairs=len(differences),
        left_out=left_out,
        mean=mean,
        low=low,
        high=high,
        unpaired_low=mean - half,
        unpaired_high=mean + half,
        p=p,
        p_corrected=p,
        effect=paired_effect(differences) if len(differences) else math.nan,
        gain=apart / together if together else math.inf if apart else 1.0,
    )


def _welch(a: Array, b: Array) -> float:
    """Half the width of the 95 % interval of a difference of means of independent values."""
    from scipy.special import stdtrit

    if len(a) < 2 or len(b) < 2:
        return math.nan
    parts = [float(np.var(values, ddof=1)) / len(values) for values in (a, b)]
    if sum(parts) == 0.0:
        return 0.0
    square = sum(part**2 / (len(values) - 1) for part, values in zip(parts, (a, b), strict=True))
    return float(stdtrit(sum(parts) ** 2 / square, 0.975)) * math.sqrt(sum(parts))
