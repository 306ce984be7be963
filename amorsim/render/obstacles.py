"""Obstacles, landmarks and lamps in the picture of a run."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from amorsim.core.parameters import ParameterError
from amorsim.render.canvas import Canvas
from amorsim.render.marks import COLOURS

__all__ = ["KINDS", "Thing", "draw_lamp", "draw_landmark", "draw_obstacle", "draw_thing"]

Points = NDArray[np.float64]
KINDS = ("obstacle", "landmark", "lamp")
_PLAIN = {"obstacle": COLOURS["obstacle"], "landmark": "#7b4fc9", "lamp": "#f2b705"}
_EDGE = COLOURS["edge"]


def _points(value: Any) -> Points:
    return np.array(value, np.float64).reshape(-1, 2)


def _check_kind(_: Any, attribute: Any, value: str) -> None:
    if value not in KINDS:
        raise ParameterError(attribute.name, f"expected one of {', '.join(KINDS)}, got {value!r}")


@attrs.frozen(kw_only=True, eq=False)
class Thing:
    """An obstacle with its outline, a landmark with its radius, or a lamp; in metres of the world.

    `kind` is one of `KINDS`; `place` (1, 2) and `outline` (V, 2), empty for all but obstacles; `colour` is its own,
    none for that of its kind; `label` is written next to it.
    """

    kind: str = attrs.field(validator=_check_kind)
    place: Points = attrs.field(converter=_points)
    outline: Points = attrs.field(factory=lambda: np.empty((0, 2)), converter=_points)
    radius: float = 0.0
    colour: str | None = None
    label: str = ""


def draw_thing(canvas: Canvas, thing: Thing, place: Points, outline: Points, scale: float, unit: float) -> None:
    """Draw a thing at `place` (2,), with `outline` (V, 2), in the canvas' pixels; a metre is `scale` of them."""
    colour = thing.colour or _PLAIN[thing.kind]
    if thing.kind == "obstacle":
        canvas.polygon(outline, colour, opacity=0.75)
        canvas.line(np.concatenate((outline, outline[:1])), _EDGE, 2.0 * unit)
    elif thing.kind == "landmark":
        reach = max(thing.radius * scale, 6.0 * unit)
        canvas.line(place[np.newaxis], _EDGE, 2.0 * reach + 4.0 * unit)
        canvas.line(place[np.newaxis], colour, 2.0 * reach)
    else:
        draw_lamp(canvas, place, unit)


def draw_obstacle(canvas: Canvas, place: Points, unit: float) -> None:
    """A square, as obstacles' sample."""
    corners = place + 11.0 * unit * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    canvas.polygon(corners, _PLAIN["obstacle"], opacity=0.75)
    canvas.line(np.concatenate((corners, corners[:1])), _EDGE, 2.0 * unit)


def draw_landmark(canvas: Canvas, place: Points, unit: float) -> None:
    """A disc with an edge."""
    canvas.line(place[np.newaxis], _EDGE, 20.0 * unit)
    canvas.line(place[np.newaxis], _PLAIN["landmark"], 16.0 * unit)


def draw_lamp(canvas: Canvas, place: Points, unit: float) -> None:
    """A disc with rays."""
    for i in range(8):
        along = np.array([math.cos(i * math.pi / 4.0), math.sin(i * math.pi / 4.0)])
        canvas.line(np.stack((place + 10.0 * unit * along, place + 16.0 * unit * along)), _PLAIN["lamp"], 3.0 * unit)
    canvas.line(place[np.newaxis], _EDGE, 16.0 * unit)
    canvas.line(place[np.newaxis], _PLAIN["lamp"], 12.5 * unit)
