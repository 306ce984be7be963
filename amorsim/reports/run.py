"""The report of a run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.algorithms.intervals import mean_interval
from amorsim.analysis.measuring import episode_of
from amorsim.analysis.run_files import RunFiles
from amorsim.contracts import Metric
from amorsim.metrics import Collisions, HeadingError, Nees, PathLength, PositionError, Turning
from amorsim.render.picture_file import read_png
from amorsim.render.words import rounded
from amorsim.reports.page import Page, interval_cell

__all__ = ["run_page"]

_METRICS: tuple[tuple[str, Metric], ...] = (
    ("position error at the end", PositionError()),
    ("position error, root mean square", PositionError(at="rms")),
    ("position error, largest", PositionError(at="max")),
    ("heading error at the end", HeadingError()),
    ("NEES at the end", Nees()),
    ("path length", PathLength()),
    ("turning", Turning()),
    ("collisions", Collisions()),
)
_SHOWN = {"rad": ("°", math.degrees(1.0))}  # as in the plots
_MOST_ROBOTS, _MOST_EVENTS, _MOST_SENSORS = 5, 40, 4
_MOST_LETTERS = 200_000  # of the scenario


def run_page(folder: Path) -> Page:
    """The page of a run in a folder.

    Raises
    ------
    RunError
        If it is not a run's folder, or a file in it is damaged.
    """
    files = RunFiles(folder)
    about = files.about
    replicas = len(files.replicas)
    what = f"{replicas} replicas" if replicas > 1 else f"replica {files.replicas[0]}"
    page = Page(f"Run {folder.resolve().name}", f"seed {about['seed']}, {what}, status: {about['status']}")
    page.heading("Figures")
    for robot in files.robots[:_MOST_ROBOTS]:
        page.paragraph(f"{robot}:")
        page.table(
            ["", "mean over replicas [95 % interval]", "least", "most"] if replicas > 1 else ["", "value"],
            _figures(files, robot),
        )
    if len(files.robots) > _MOST_ROBOTS:
        page.paragraph(f"and {len(files.robots) - _MOST_ROBOTS} more robots")
    page.heading("Pictures")
    _pictures(page, files)
    _events(page, files)
    page.heading("How it was made")
    page.facts(_facts(about))
    page.paragraph("To run it again and compare all bits, from its folder:")
    page.command(f"amorsim reproduce {folder.resolve().name}")
    page.paragraph("To see it in the Simulator, moment by moment:")
    page.command(f"amorsim replay {folder.resolve().name}")
    text = (folder / "scenario.toml").read_text(encoding="utf-8", errors="replace")
    page.listing("The scenario, as it was simulated", text[:_MOST_LETTERS])
    return page


def _figures(files: RunFiles, robot: str) -> list[list[str]]:
    rows = []
    for name, metric in _METRICS:
        values = metric.measure(episode_of(files, metric.needs(), robot=robot))
        unit, scale = _SHOWN.get(metric.unit, (metric.unit, 1.0))
        values = scale * values[~np.isnan(values)]
        if not len(values):
            rows.append([name, *["-"] * (3 if len(files.replicas) > 1 else 1)])
            continue
        mean, low, high, _ = mean_interval(values)
        ends = [float(np.min(values)), float(np.max(values))] if len(files.replicas) > 1 else []
        cells = [interval_cell(mean, low, high), *(rounded(end, 0.5 * (high - low)) for end in ends)]
        rows.append([name, *(f"{cell} {unit}".rstrip() for cell in cells)])
    return rows


def _pictures(page: Page, files: RunFiles) -> None:
    picture = files.folder / "picture.png"
    if picture.exists():
        page.picture(read_png(picture), "map and paths")
    try:
        from amorsim.analysis.plots.plot import pictures_of
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "matplotlib":
            raise
        page.paragraph('More pictures need matplotlib: python -m pip install "amorsim[plot]"')
        return
    sensors = 0
    for robot in files.robots[:_MOST_ROBOTS]:
        for kind, (what, draw) in pictures_of(files, robot, None).items():
            if kind == "path" and picture.exists() and len(files.replicas) == 1:
                continue  # the run's own picture has it
            sensors += kind.startswith("sensor-")
            if kind.startswith("sensor-") and sensors > _MOST_SENSORS:
                continue
            figure = draw()
            if figure is not None:
                page.figure(figure, f"{robot}: {what}")


def _events(page: Page, files: RunFiles) -> None:
    table = files.table("events", replica="all")
    count = len(table["time"])
    page.heading("Events")
    if not count:
        page.paragraph("none")
        return
    has_replica = "replica" in table
    rows = []
    for i in range(min(count, _MOST_EVENTS)):
        speed = float(table["speed"][i])
        rows.append(
            [
                f"{table['time'][i]:.3f} s",
                *([str(table["replica"][i])] if has_replica else []),
                str(table["robot"][i]),
                str(table["kind"][i]).replace("_", " "),
                str(table["other"][i] or table["path"][i]),
                "" if math.isnan(speed) else f"{speed:.3f} m/s",
            ]
        )
    page.table(["time", *(["replica"] if has_replica else []), "of", "what", "with", "speed"], rows)
    if count > _MOST_EVENTS:
        page.paragraph(f"and {count - _MOST_EVENTS} more, in events.csv")


def _facts(about: dict[str, Any]) -> list[tuple[str, object]]:
    digests = about.get("digests", {})
    shown = [f"{replica}: {digest}" for replica, digest in list(digests.items())[:3]]
    packages = ", ".join(f"{name} {version}" for name, version in about.get("packages", {}).items())
    return [
        ("seed", about["seed"]),
        ("replicas", len(about["replicas"])),
        ("step", f"{about['dt']:g} s"),
        ("simulated time", f"{about.get('steps_done', about['steps']) * about['dt']:g} s"),
        ("amorsim", about.get("amorsim", "unknown")),
        ("Python", about.get("python", "unknown")),
        ("packages", packages),
        ("plugins", ", ".join(f"{name} {version}" for name, version in about.get("plugins", {}).items())),
        ("machine", f"{about.get('system', '')} {about.get('processor', '')}"),
        ("digest by replica", ", ".join(shown) + (" ..." if len(digests) > 3 else "")),
    ]
