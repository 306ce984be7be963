"""Two or more systems on the same seeds, worlds and noise: what may be claimed of their differences."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from amorsim.analysis.differences import Comparison
from amorsim.analysis.paired import Key, paired
from amorsim.analysis.scenario_differences import differing_parts
from amorsim.core.arguments import check_text, texts
from amorsim.core.errors import AnalysisError, did_you_mean
from amorsim.core.unknown_names import no_such
from amorsim.sweeps.table import Study, read_study

__all__ = ["compare"]

_MADE_OF = ("seeds", "replicas", "duration", "amorsim", "python", "packages", "system", "processor")


def compare(
    *studies: Study | str | os.PathLike[str],
    labels: Sequence[str] = (),
    axis: str | None = None,
    metrics: Sequence[str] = (),
    estimators: Sequence[str] = (),
) -> Comparison:
    """Compare studies of the same seeds and replicas, or the values of an axis or the estimators within one study.

    Values of the same seed, replica and other axes belong together: the draws were the same for all. They were the same
    along other axes, too, so the differences there are not independent: their mean counts as one, for each seed and
    replica.

    Parameters
    ----------
    studies
        Studies, or their folders. One alone, without an axis: what is compared are the estimators that its metrics
        judge, where metrics differ in the estimator alone.
    labels
        A name for each; without them, the studies' own.
    axis
        Of one study: its values are what is compared.
    metrics
        Which; without them, all that all studies have.
    estimators
        Whose: only metrics that judge one of these. Without them, all.

    Raises
    ------
    StudyError
        If a folder is none of a study.
    AnalysisError
        If they have too little in common.
    """
    labels = texts(labels, "labels", "names")
    metrics = texts(metrics, "metrics", "names")
    estimators = texts(estimators, "estimators", "names")
    read = [one if isinstance(one, Study) else read_study(one) for one in studies]
    if axis is not None and len(read) != 1:
        raise AnalysisError(f"axis: is for one study, got {len(read)}")
    if not read:
        raise AnalysisError("expected a study at least, got none")
    if axis is not None:
        found = _along(read[0], axis, _chosen(read, metrics, estimators))
    elif len(read) == 1:
        found = _within(read[0], metrics, estimators)
    else:
        found = _between(read, labels, _chosen(read, metrics, estimators))
    return attrs.evolve(found, axis=axis or "", origin=_origin(read, axis, metrics, estimators))


def _origin(
    studies: Sequence[Study], axis: str | None, metrics: Sequence[str], estimators: Sequence[str]
) -> dict[str, Any]:
    """The studies that are compared, with all that they are made of, and the command that repeats the comparison."""
    folders = [study.folder.resolve().name for study in studies]
    command = ["amorsim", "compare", *folders, *(["--axis", axis] if axis else [])]
    for option, names in (("--metric", metrics), ("--estimator", estimators)):
        for name in names:
            command += [option, name]
    about = [
        {"folder": folder, "scenario": Path(str(study.about.get("scenario", ""))).name}
        | {key: study.about[key] for key in _MADE_OF if key in study.about}
        for folder, study in zip(folders, studies, strict=True)
    ]
    return {"studies": about, "command": shlex.join(command)}


# ----------------------------------------------------------------------------------------------------- what is compared


def _between(studies: Sequence[Study], labels: Sequence[str], chosen: Sequence[str]) -> Comparison:
    """Studies, each a system."""
    names = list(labels) or _names(studies)
    if len(names) != len(studies) or len(set(names)) < len(names):
        raise AnalysisError(f"labels: expected {len(studies)} different names, got {names}")
    by_name = dict(zip(names, studies, strict=True))
    if len({tuple(sorted(study.axes)) for study in studies}) > 1:
        axes = "; ".join(f"{name}: {', '.join(study.axes) or 'none'}" for name, study in by_name.items())
        raise AnalysisError(f"expected studies with the same axes, got {axes}")
    systems = {name: _keyed(study, [*sorted(study.axes), "seed", "replica"], chosen) for name, study in by_name.items()}
    found = paired(systems, {metric: _about(studies, metric) for metric in chosen})
    differences = [
        attrs.evolve(each, remark=differing_parts(by_name[each.first], by_name[each.second]))
        if each.is_identical
        else each
        for each in found.differences
    ]
    return attrs.evolve(found, differences=tuple(differences))


def _about(studies: Sequence[Study], metric: str) -> dict[str, str]:
    """The record of a metric that several studies share; with all estimators if they judge different ones."""
    estimators = dict.fromkeys(_estimator_of(study, metric) for study in studies)
    return {**studies[0].about["metrics"][metric], "estimator": ", ".join(filter(None, estimators))}


def _names(studies: Sequence[Study]) -> list[str]:
    """Different names for the studies: their own, or those of their folders."""
    own = [str(study.about.get("name", "")) for study in studies]
    if len(set(own)) == len(own):
        return own
    folders = [study.folder.resolve().name for study in studies]
    return folders if len(set(folders)) == len(folders) else [str(study.folder) for study in studies]


def _along(study: Study, axis: str, chosen: Sequence[str]) -> Comparison:
    """The values of an axis, each a system."""
    check_text(axis, "axis", "the name of an axis")
    if axis not in study.axes:
        raise AnalysisError(f"{study.folder}: {no_such('axis', axis, study.axes)}")
    whole = _keyed(study, [axis, *(name for name in study.axes if name != axis), "seed", "replica"], chosen)
    systems: dict[str, dict[Key, list[float]]] = {}
    for key, values in whole.items():
        systems.setdefault(str(key[0]), {})[key[1:]] = values
    if len(systems) < 2:
        raise AnalysisError(f"{study.folder}: the axis {axis!r} has one value only; there is nothing to compare")
    found = paired(systems, {metric: study.about["metrics"][metric] for metric in chosen})
    remark = f"{axis} does not reach this metric"
    return attrs.evolve(
        found,
        differences=tuple(
            attrs.evolve(each, remark=remark) if each.is_identical else each for each in found.differences
        ),
    )


def _within(study: Study, metrics: Sequence[str], estimators: Sequence[str]) -> Comparison:
    """The estimators of one study as systems: they got the same readings of the same drives."""
    columns: dict[str, dict[str, str]] = {}  # by measure and estimator
    for name, about in study.about["metrics"].items():
        measure, estimator = about.get("measure", ""), _estimator_of(study, name)
        is_chosen = not metrics or any(each in metrics for each in (name, measure, measure.partition(" ")[0]))
        if estimator and is_chosen and (not estimators or estimator in estimators):
            columns.setdefault(measure, {}).setdefault(estimator, name)
    columns = {measure: by_estimator for measure, by_estimator in columns.items() if len(by_estimator) > 1}
    names = list(dict.fromkeys(name for by_estimator in columns.values() for name in by_estimator))
    missing = [name for name in estimators if name not in names]
    if not columns or missing:
        known = ", ".join(f"{name} ({_estimator_of(study, name) or 'no estimator'})" for name in study.metrics)
        raise AnalysisError(
            f"{study.folder}: expected two estimators at least that are judged by the same metric"
            f"{', of those named' if estimators else ''}; the study's metrics are {known}. To compare other things, "
            f"name two studies, or an axis; this study's are: {', '.join(study.axes) or 'none'}"
        )
    keys = list(zip(*(study[name].tolist() for name in (*study.axes, "seed", "replica")), strict=True))
    nothing = np.full(len(keys), np.nan)
    systems = {
        name: dict(
            zip(
                keys, np.stack([study.get(c.get(name, ""), nothing) for c in columns.values()], 1).tolist(), strict=True
            )
        )
        for name in names
    }
    about = {
        measure: {**study.about["metrics"][next(iter(by_estimator.values()))], "estimator": ""}
        for measure, by_estimator in columns.items()
    }
    found = paired(systems, about)
    return attrs.evolve(
        found,
        summaries=tuple(each for each in found.summaries if each.label in columns[each.metric]),
        differences=tuple(each for each in found.differences if {each.first, each.second} <= {*columns[each.metric]}),
    )


def _estimator_of(study: Study, metric: str) -> str:
    """The estimator that a metric of a study judges; empty if none, and for studies of earlier versions."""
    return str(study.about["metrics"][metric].get("estimator", ""))


def _chosen(studies: Sequence[Study], metrics: Sequence[str], estimators: Sequence[str]) -> list[str]:
    """Those metrics named by the user that all studies have."""
    common = [name for name in studies[0].metrics if all(name in study.metrics for study in studies)]
    for name in metrics:
        if name not in common:
            raise AnalysisError(f"metrics: {no_such('common metric', name, common)}")
    if not common:
        raise AnalysisError("expected studies with a metric in common")
    chosen = list(metrics) or common
    judged = {name: {_estimator_of(study, name) for study in studies} for name in chosen}
    known = dict.fromkeys(name for names in judged.values() for name in sorted(names) if name)
    for name in estimators:
        if name not in known:
            raise AnalysisError(
                f"estimators: no metric judges {name!r}; judged are: {', '.join(known) or 'none'}."
                f"{did_you_mean(name, known)}"
            )
    return [name for name in chosen if not estimators or judged[name] <= set(estimators)]


def _keyed(study: Study, keys: Sequence[str], metrics: Sequence[str]) -> Mapping[Key, list[float]]:
    rows = zip(*(study[name].tolist() for name in keys), strict=True)
    values = np.stack([study[name] for name in metrics], axis=1).tolist()
    return dict(zip(rows, values, strict=True))
