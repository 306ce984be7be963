"""What a notebook shows of a value in the last line of a cell: a picture or a table, with plain text."""

from __future__ import annotations

import functools
import html
import io
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from PIL import Image

from amorsim.analysis.differences import Comparison
from amorsim.contracts import Frame, Plan
from amorsim.core.errors import AmorsimError
from amorsim.core.maps.map import Map
from amorsim.render.picture import draw_map, draw_run
from amorsim.runs.drawing import draw
from amorsim.runs.session import RunSummary
from amorsim.runs.traces import paths_at_start, things_at_start
from amorsim.scenario.spec import Robot, Scenario
from amorsim.simulation.simulation import Simulation
from amorsim.sweeps.table import Study

__all__ = ["bundle"]

Bundle = dict[str, Any]
SIZE = 720
"""Longer side of pictures [px]."""
ROWS = 10
"""Rows of a table that are shown."""


def bundle(value: Any) -> Bundle:
    """The content that a notebook may show, by MIME type: plain text always, and a picture or a table."""
    found = {"text/plain": str(value) if isinstance(value, Comparison) else repr(value)}
    try:
        return found | _shown(value)
    except AmorsimError as error:  # a cell that shows a scenario with faults does not fail
        return found | {"text/html": f"<p>{html.escape(repr(value))}</p><p>{html.escape(str(error))}</p>"}


@functools.singledispatch
def _shown(_: Any) -> Bundle:
    return {}


@_shown.register
def _(value: Map) -> Bundle:
    return _picture(draw_map(value, size=SIZE))


@_shown.register
def _(value: Scenario) -> Bundle:
    # Without a simulation, which would run users' programs.
    picture = draw_run(
        value.map,
        paths_at_start(value),
        zones=[zone.outline for zone in value.zones],
        patches=value.floor.patches,
        things=things_at_start(value),
        size=SIZE,
    )
    return _picture(picture)


@_shown.register
def _(value: Simulation) -> Bundle:
    return _picture(draw(value, size=SIZE))


@_shown.register
def _(value: Robot) -> Bundle:
    rows = [("drive", _name(value.drive))]
    rows += [(f"sensor {name}", _name(unit.sensor)) for name, unit in value.sensors.items()]
    rows += [(f"estimator {name}", _name(estimator)) for name, estimator in value.estimators.items()]
    rows += [("controller", _name(value.controller))] if value.controller else []
    rows += [(f"error {path}", str(deviation)) for path, deviation in value.errors.items()]
    return _table((value.name, value.model), rows)


@_shown.register
def _(value: Plan) -> Bundle:
    facts = f"{value.status}: {value.length:.2f} m, {value.expanded} expanded"
    if not len(value.poses):
        return {"text/html": f"<p>{html.escape(value.message or facts)}</p>"}
    return {"text/html": f"<p>{html.escape(facts)}</p>{_drawn_path(value)}"}


@_shown.register
def _(value: Frame) -> Bundle:
    names = list(value.estimates)
    rows = [
        [value.names[n], int(value.replica[n]), f"{value.time[n]:g}"]
        + [_pose(pose[n]) for pose in (value.true_pose, *(value.estimates[name].pose for name in names))]
        for n in range(min(len(value.names), ROWS))
    ]
    return _table(("robot", "replica", "time [s]", "true x, y, heading", *names), rows, len(value.names))


@_shown.register
def _(value: RunSummary) -> Bundle:
    rows = [
        (name, f"{way:.2f}", f"{value.final_error[name]:.3f}", value.collisions[name])
        for name, way in value.distance.items()
    ]
    found = _table(("robot", "driven [m]", "off at the end [m]", "collisions"), rows)
    note = "" if value.is_complete else " (broken off)"
    found["text/html"] += f"<p>{value.steps} steps{note} in {html.escape(str(value.folder))}</p>"
    return found


@_shown.register
def _(value: Study) -> Bundle:
    columns = [name for name in value if name != "digest"]
    count = len(value["point"])
    rows = [[_cell(value[name][row]) for name in columns] for row in range(min(count, ROWS))]
    return _table(columns, rows, count)


@_shown.register
def _(value: Comparison) -> Bundle:
    rows = [
        (each.label, each.metric, each.count, *(f"{number:.4g}" for number in (each.mean, each.low, each.high)))
        for each in value.summaries
    ]
    found = _table(("system", "metric", "values", "mean", "95 % from", "to"), rows)
    claims = "".join(f"<li>{html.escape(str(each))}</li>" for each in value.differences)
    found["text/html"] += f"<ul>{claims}</ul>"
    return found


def _picture(picture: Image.Image) -> Bundle:
    file = io.BytesIO()
    picture.save(file, "PNG")
    return {"image/png": file.getvalue()}


def _name(component: Any) -> str:
    return type(component).__name__


def _pose(pose: Any) -> str:
    return ", ".join(f"{number:.3f}" for number in pose)


def _cell(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, (float, np.floating)) else str(value)


def _table(head: Sequence[str], rows: Iterable[Sequence[Any]], count: int | None = None) -> Bundle:
    """A table as HTML, in the notebook's own colours; `count` is the number of rows there are."""
    shown = list(rows)
    lines = "".join(f"<tr>{''.join(f'<td>{html.escape(str(cell))}</td>' for cell in row)}</tr>" for row in shown)
    top = "".join(f"<th>{html.escape(name)}</th>" for name in head)
    rest = f"<p>{count - len(shown)} more rows</p>" if count and count > len(shown) else ""
    return {"text/html": f"<table><thead><tr>{top}</tr></thead><tbody>{lines}</tbody></table>{rest}"}


def _drawn_path(plan: Plan) -> str:
    """A plan's path and what it searched, as SVG in the colour of the text."""
    places = np.concatenate((plan.points, plan.searched)) if len(plan.searched) else plan.points
    low, high = places.min(axis=0), places.max(axis=0)
    side = float(max(*(high - low), 1e-3))
    margin = 0.03 * side
    width, height = (float(extent) + 2.0 * margin for extent in high - low)

    def shown(points: Any) -> str:
        # SVG has y downwards.
        return " ".join(f"{x - low[0] + margin:.3f},{high[1] - y + margin:.3f}" for x, y in points.tolist())

    dots = plan.searched[:: max(1, len(plan.searched) // 2000)]
    searched = "".join(
        f'<circle cx="{place.partition(",")[0]}" cy="{place.partition(",")[2]}" r="{0.004 * side:.4f}"/>'
        for place in shown(dots).split()
    )
    path = f'points="{shown(plan.points)}" fill="none" stroke="#d1242f" stroke-width="{0.008 * side:.4f}"'
    return (
        f'<svg viewBox="0 0 {width:.3f} {height:.3f}" width="{SIZE // 2 * width / max(width, height):.0f}" role="img" '
        f'aria-label="the path"><g fill="currentColor" opacity="0.25">{searched}</g><polyline {path}/></svg>'
    )
