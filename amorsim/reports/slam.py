"""The report of an estimator's work on a log."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from amorsim.analysis.logs.slam_on_log import SlamResult
from amorsim.analysis.pose_errors import PoseErrors
from amorsim.core.maps.map import Map
from amorsim.reports.page import Page

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["error_table", "slam_page"]

PATHS = (("path", "as known at the end"), ("online", "as known at each scan"), ("odometry", "by the wheels alone"))
"""The paths of a `SlamResult`, and what they are."""


def slam_page(
    found: SlamResult, world: Map, log: str, facts: Iterable[tuple[str, object]], errors: dict[str, PoseErrors]
) -> Page:
    """The page of a log's result.

    Parameters
    ----------
    world
        The map that was drawn.
    log
        The name of the log.
    facts
        Names and values: how it was made.
    errors
        In known relations, by the name of the path; nothing if there are none.
    """
    page = Page(f"Map and path from {log}", f"{len(found.path)} scans" + ("" if found.is_whole else ", interrupted"))
    if errors:
        page.heading("Errors in known relations")
        page.table(*error_table(errors))
    page.heading("Pictures")
    try:
        import matplotlib as _  # noqa: F401
    except ModuleNotFoundError:
        page.paragraph('Pictures need matplotlib: python -m pip install "amorsim[plot]"')
    else:
        page.figure(_map_figure(found, world), "the map that all scans draw, and the path as known at the end")
        page.figure(_path_figure(found), "the path as known at the end, at each scan, and by the wheels alone")
        if errors:
            page.figure(_error_figure(errors), "share of the known relations with at most this error")
    page.heading("How it was made")
    page.facts(facts)
    return page


def error_table(errors: dict[str, PoseErrors]) -> tuple[list[str], list[list[str]]]:
    """Head and rows of a table of errors in known relations."""
    head = ["path", "relations", "mean [m]", "median [m]", "largest [m]", "mean [°]"]
    rows = [
        [
            what,
            str(len(errors[name].position)),
            *(f"{value:.3f}" for value in _figures(errors[name].position)),
            f"{math.degrees(float(np.abs(errors[name].heading).mean())):.2f}",
        ]
        for name, what in PATHS
        if name in errors
    ]
    return head, rows


def _figures(position: Any) -> tuple[float, float, float]:
    return float(np.mean(position)), float(np.median(position)), float(np.max(position))


def _axis(title_x: str, title_y: str) -> tuple[Figure, Any]:
    from matplotlib.figure import Figure

    from amorsim.analysis.plots.figures import tidy

    figure = Figure(figsize=(9.0, 7.8), layout="constrained")
    axis: Any = figure.subplots()
    tidy(axis)
    axis.set_xlabel(title_x)
    axis.set_ylabel(title_y)
    return figure, axis


def _map_figure(found: SlamResult, world: Map) -> Figure:
    from amorsim.analysis.plots.figures import ESTIMATED, legend

    figure, axis = _axis("x [m]", "y [m]")
    axis.grid(visible=False)  # too like walls
    cells, unknown = world.to_array() != 0, world.unknown_array() != 0
    image = np.where(cells, 0.1, 1.0)
    image[unknown & ~cells] = 0.85
    (x, y, _), (width, height) = world.origin, world.size
    axis.imshow(image, origin="lower", extent=(x, x + width, y, y + height), cmap="gray", vmin=0.0, vmax=1.0)
    axis.plot(*found.path.poses[:, :2].T, **{**ESTIMATED, "label": "path", "linestyle": "-", "linewidth": 0.8})
    axis.set_aspect("equal")
    legend(figure, axis)
    return figure


def _path_figure(found: SlamResult) -> Figure:
    from amorsim.analysis.plots.figures import ESTIMATED, MEASURED, OTHERS, legend

    figure, axis = _axis("x [m]", "y [m]")
    for (name, what), style in zip(reversed(PATHS), (MEASURED, OTHERS[0], ESTIMATED), strict=True):
        axis.plot(*getattr(found, name).poses[:, :2].T, **{**style, "linewidth": 1.0, "label": what})
    axis.set_aspect("equal")
    legend(figure, axis)
    return figure


def _error_figure(errors: dict[str, PoseErrors]) -> Figure:
    from amorsim.analysis.plots.figures import ESTIMATED, MEASURED, OTHERS, legend

    figure, axis = _axis("error of the position [m]", "share of the relations")
    for (name, what), style in zip(PATHS, (ESTIMATED, OTHERS[0], MEASURED), strict=True):
        if name in errors:
            apart = np.sort(errors[name].position)
            axis.step(apart, np.arange(1, len(apart) + 1) / len(apart), where="post", **{**style, "label": what})
    axis.set_xscale("log")
    legend(figure, axis)
    return figure
