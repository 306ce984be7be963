"""The reports of a study and of a comparison."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from amorsim.algorithms.intervals import mean_interval
from amorsim.analysis.differences import metric_of_estimator, p_in_words
from amorsim.core.errors import StudyError
from amorsim.core.files.json_files import read_table
from amorsim.core.files.reading import read_bytes, reason
from amorsim.render.picture_file import read_png
from amorsim.render.words import rounded, significant
from amorsim.reports.page import Page, interval_cell
from amorsim.sweeps.table import Study, counted, read_study

__all__ = ["comparison_page", "study_page"]

_MOST_POINTS, _MOST_METRICS, _MOST_LETTERS = 200, 12, 200_000


def study_page(folder: Path) -> Page:
    """The page of a study in a folder; raises `StudyError` if it is not a study's."""
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
        "Means over replicas and seeds, with their 95 % intervals in brackets. Where not all have a value, it says how "
        "many do."
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
    file = folder / "study.toml"
    try:
        text = read_bytes(file).decode(errors="replace")
    except OSError as error:
        raise StudyError(f"{file}: cannot be read ({reason(error)}); the study's command writes it again") from None
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
            cells.append(counted(interval_cell(*mean_interval(there)[:3]), values) if len(there) else "-")
        rows.append(cells)
    return rows


def _pictures(page: Page, study: Study) -> None:
    try:
        from amorsim.analysis.plots.comparison_plots import draw_metric
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
        about = read_table(file, StudyError)
        labels = ", ".join(about["labels"])
        axis = about.get("axis", "")
        page = Page(
            f"Comparison along {axis}: {labels}" if axis else f"Comparison of {labels}",
            "the same seeds, replicas and noise for all",
        )
        page.heading("What may be claimed")
        for each in about["differences"]:
            page.paragraph(each["claim"])
        if (folder / "comparison.png").exists():
            page.picture(read_png(folder / "comparison.png"), "paired differences, with their 95 % intervals")
        page.heading("Systems")
        page.table(
            ["metric", axis or "system", "mean [95 % interval]", "median", "values", "without"],
            [_summary_cells(each) for each in about["summaries"]],
        )
        page.heading("Differences")
        page.table(
            ["metric", "difference", "mean [95 % interval]", "unpaired", "p (Holm)", "d", "gain of pairing", "pairs"],
            [_difference_cells(each) for each in about["differences"]],
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise StudyError(f"{file}: cannot be read ({type(error).__name__}: {error})") from None
    page.paragraph(
        "Differences are of pairs that met the same noise. Intervals and p are those of the mean difference: Student's "
        "t, from ten pairs on also corrected for skewness. Both are corrected for the number of differences (Holm), so "
        "that an interval excludes 0 exactly where a difference may be claimed. The gain is the variance of the "
        "difference of independent values over that of the pairs: pairs need that many times fewer replicas."
    )
    try:
        _origin(page, about.get("origin", {}))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise StudyError(f"{file}: cannot be read ({type(error).__name__}: {error})") from None
    return page


def _summary_cells(each: dict[str, Any]) -> list[str]:
    median = rounded(each["median"], 0.5 * (each["high"] - each["low"]))
    figures = interval_cell(each["mean"], each["low"], each["high"])
    return [_metric(each), each["label"], figures, median, str(each["count"]), str(each["missing"])]


def _difference_cells(each: dict[str, Any]) -> list[str]:
    unpaired = interval_cell(each["mean"], each["unpaired_low"], each["unpaired_high"])
    return [
        _metric(each),
        f"{each['second']} - {each['first']}",
        interval_cell(each["mean"], each["low"], each["high"]),
        unpaired.partition(" ")[2],
        p_in_words(each["p_corrected"]).removeprefix("= "),
        f"{each['effect']:.2f}",
        significant(each["gain"], 2),
        str(each["pairs"]),
    ]


def _metric(each: dict[str, Any]) -> str:
    unit = f" [{each['unit']}]" if each.get("unit") else ""
    return metric_of_estimator(each["metric"], each.get("estimator", "")) + unit


def _origin(page: Page, origin: dict[str, Any]) -> None:
    """How a comparison was made; empty if its file does not say so."""
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
