"""The reports of a study and of a comparison."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.algorithms.intervals import mean_interval
from amorsim.core.errors import StudyError
from amorsim.reports.page import Page
from amorsim.sweeps.table import Study, counted, read_study

__all__ = ["comparison_page", "study_page"]

_MOST_POINTS, _MOST_METRICS, _MOST_LETTERS = 200, 12, 200_000


def study_page(folder: Path) -> Page:
    """The page of a study in a folder; raises `StudyError` if it is none of a study."""
    study = read_study(folder)
    about = study.about
    points = np.unique(study["point"])
    page = Page(
        f"Study {about['name']}",
        f"{len(points)} of {about['points']} points, {about['replicas']} replicas for each of "
        f"{len(about['seeds'])} seed{'s' if len(about['seeds']) > 1 else ''}, "
        f"{about['duration']:g} s each; status: {about['status']}",
    )
    page.heading("Figures")
    page.paragraph(
        "Means over replicas and seeds, with their 95 % intervals (Student's t). Where not all have a value, it says "
        "how many do."
    )
    page.table(["point", *study.axes, *(_named(study, name) for name in study.metrics)], _points(study))
    if len(points) > _MOST_POINTS:
        page.paragraph(f"and {len(points) - _MOST_POINTS} more points, in the study's table")
    if study.failures:
        page.heading("Points that failed")
        page.table(["point", "why"], [[str(point), error] for point, error in study.failures[:_MOST_POINTS]])
    _pictures(page, study)
    page.heading("How it was made")
    page.facts(
        [
            ("scenario", Path(about["scenario"]).name),
            ("seeds", ", ".join(map(str, about["seeds"]))),
            ("replicas", about["replicas"]),
            ("duration", f"{about['duration']:g} s"),
            ("a replica ends", about["stop"]),
            *((f"axis {name}", _labels(labels)) for name, labels in about["axes"].items()),
            *_circumstances(about),
        ]
    )
    page.paragraph("To repeat it, with the file of the study:")
    page.command(f"amorsim sweep {about['name']}.toml --out another-folder")
    text = (folder / "study.toml").read_text(encoding="utf-8", errors="replace")
    page.listing("The study's file", text[:_MOST_LETTERS])
    return page


def _named(study: Study, metric: str) -> str:
    unit = study.about["metrics"][metric]["unit"]
    return f"{metric} [{unit}]" if unit else metric


def _labels(labels: list[Any]) -> str:
    shown = ", ".join(map(str, labels[:20]))
    return shown + (f" ... ({len(labels)} values)" if len(labels) > 20 else "")


def _points(study: Study) -> list[list[str]]:
    """A row for each point; the rows of a point follow one another."""
    points, first, counts = np.unique(study["point"], return_index=True, return_counts=True)
    rows = []
    for point, begin, count in list(zip(points.tolist(), first.tolist(), counts.tolist(), strict=True))[:_MOST_POINTS]:
        cells = [str(point), *(str(study[axis][begin]) for axis in study.axes)]
        for metric in study.metrics:
            values = study[metric][begin : begin + count]
            there = values[~np.isnan(values)]
            if len(there) > 1:
                interval = mean_interval(there)
                cells.append(counted(f"{interval.value:.4g} ± {interval.half_width:.2g}", values))
            else:
                cells.append(counted(f"{there[0]:.4g}", values) if len(there) else "-")
        rows.append(cells)
    return rows


def _pictures(page: Page, study: Study) -> None:
    try:
        from amorsim.analysis.comparison_plots import draw_metric
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "matplotlib":
            raise
        return
    page.heading("Pictures")
    for metric in study.metrics[:_MOST_METRICS]:
        page.figure(draw_metric(study, metric), f"{metric} along {study.axes[0] if study.axes else 'nothing'}")


def comparison_page(folder: Path) -> Page:
    """The page of a comparison in a folder.

    Raises
    ------
    StudyError
        If its file cannot be read.
    """
    file = folder / "comparison.json"
    try:
        about = json.loads(file.read_text(encoding="utf-8"))
        page = Page("Comparison of " + ", ".join(about["labels"]), "the same seeds, replicas and noise for all")
        page.heading("What may be claimed")
        for each in about["differences"]:
            page.paragraph(each["claim"])
        if (folder / "comparison.png").exists():
            page.picture((folder / "comparison.png").read_bytes(), "paired differences, with their 95 % intervals")
        page.heading("Systems")
        page.table(
            ["metric", "system", "mean", "95 % from", "to", "median", "values", "without"],
            [
                [
                    each["metric"],
                    each["label"],
                    *(f"{each[key]:.5g}" for key in ("mean", "low", "high", "median")),
                    str(each["count"]),
                    str(each["missing"]),
                ]
                for each in about["summaries"]
            ],
        )
        page.heading("Differences")
        keys = ("mean", "low", "high", "unpaired_low", "unpaired_high", "p", "p_corrected", "effect", "gain")
        names = ("mean", "95 % from", "to", "unpaired from", "to", "p", "p (Holm)", "d", "gain of pairing")
        page.table(
            ["metric", "difference", *names, "pairs"],
            [
                [
                    each["metric"],
                    f"{each['second']} - {each['first']}",
                    *(f"{each[key]:.4g}" for key in keys),
                    str(each["pairs"]),
                ]
                for each in about["differences"]
            ],
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise StudyError(f"{file}: cannot be read ({type(error).__name__}: {error})") from None
    page.paragraph(
        "Differences are of pairs that met the same noise. Intervals are by the bootstrap (BCa), p-values by permuting "
        "the signs of the differences, corrected for their number (Holm). The gain is the variance of the difference "
        "of independent values over that of the pairs: pairs need that many times fewer replicas."
    )
    try:
        _origin(page, about.get("origin", {}))
    except (KeyError, TypeError, AttributeError) as error:
        raise StudyError(f"{file}: cannot be read ({type(error).__name__}: {error})") from None
    return page


def _origin(page: Page, origin: dict[str, Any]) -> None:
    """How a comparison was made; nothing where its file does not say it."""
    if not origin:
        return
    page.heading("How it was made")
    for each in origin["studies"]:
        page.facts(
            [
                ("study", each["folder"]),
                ("scenario", each["scenario"]),
                ("seeds", ", ".join(map(str, each["seeds"]))),
                ("replicas", each["replicas"]),
                ("duration", f"{each['duration']:g} s"),
                *_circumstances(each),
            ]
        )
    page.paragraph("To repeat it:")
    page.command(origin["command"])


def _circumstances(about: dict[str, Any]) -> list[tuple[str, object]]:
    """Versions and machine of a study."""
    return [
        ("amorsim", about["amorsim"]),
        ("Python", about["python"]),
        ("packages", ", ".join(f"{name} {version}" for name, version in about["packages"].items())),
        ("machine", f"{about['system']} {about['processor']}"),
    ]
