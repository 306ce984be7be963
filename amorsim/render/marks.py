"""How paths and marks look: one function a mark, the same in the picture and in its legend."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from amorsim.core.patches import Patch
from amorsim.render.canvas import Canvas

__all__ = [
    "COLOURS",
    "draw_body",
    "draw_collision",
    "draw_estimated_end",
    "draw_estimated_path",
    "draw_patch",
    "draw_start",
    "draw_true_end",
    "draw_true_path",
    "draw_zone",
]

COLOURS = MappingProxyType(
    {
        "wall": "#2b2f36",
        "outside": "#e9ecef",
        "true": "#1b7f5c",
        "body": "#bfe3d6",
        "estimated": "#2f6fde",
        "obstacle": "#9aa4af",
        "edge": "#3d444d",
        "collision": "#d1242f",
        "zone": "#c98a1b",
        "text": "#1f2328",
        "faint": "#8b949e",
    }
)
"""What is drawn in which colour."""

Points = NDArray[np.float64]

# Each takes a canvas, points (T, 2) or one place (2,) in its pixels, and the unit [px] that widths are in.


def draw_true_path(canvas: Canvas, points: Points, unit: float) -> None:
    """A solid line."""
    canvas.line(points, COLOURS["true"], 4.5 * unit)


def draw_estimated_path(canvas: Canvas, points: Points, unit: float) -> None:
    """A dashed line, thinner, so that a true path shows on both sides of it."""
    canvas.line(points, COLOURS["estimated"], 2.8 * unit, dash=(11 * unit, 7 * unit))


def draw_start(canvas: Canvas, place: Points, unit: float) -> None:
    """A ring."""
    canvas.line(place[np.newaxis], COLOURS["true"], 19 * unit)
    canvas.line(place[np.newaxis], "white", 10 * unit)


def draw_true_end(canvas: Canvas, place: Points, unit: float) -> None:
    """Draw the disc at the end of a true path."""
    canvas.line(place[np.newaxis], "white", 20 * unit)
    canvas.line(place[np.newaxis], COLOURS["true"], 15 * unit)


def draw_estimated_end(canvas: Canvas, place: Points, unit: float) -> None:
    """A diamond."""
    for reach, colour in ((12.5, "white"), (9.5, COLOURS["estimated"])):
        canvas.polygon(place + np.array([(0, -1), (1, 0), (0, 1), (-1, 0)]) * reach * unit, colour)


def draw_collision(canvas: Canvas, place: Points, unit: float) -> None:
    """A cross."""
    for width, colour in ((8.0, "white"), (4.2, COLOURS["collision"])):
        for slope in (-1, 1):
            canvas.line(place + np.array([(-9, -9 * slope), (9, 9 * slope)]) * unit, colour, width * unit)


def draw_zone(canvas: Canvas, outline: Points, unit: float) -> None:
    """A tinted and hatched part of the floor."""
    canvas.polygon(outline, "#f3d9a4", opacity=0.45)
    canvas.hatch(outline, COLOURS["zone"], 14 * unit, 1.6 * unit)
    canvas.line(np.concatenate((outline, outline[:1])), COLOURS["zone"], 2 * unit)


def draw_patch(canvas: Canvas, patch: Patch, points: Points, scale: float, unit: float) -> None:
    """A patch of the floor, its points on the canvas, where a metre is `scale`; lines are wide enough to be seen."""
    if patch.width > 0.0:
        canvas.line(points, patch.colour, max(patch.width * scale, 2.0 * unit))
    else:
        canvas.polygon(points, patch.colour)
    if patch.is_drop:
        canvas.hatch(points, COLOURS["faint"], 10.0 * unit, 1.6 * unit)
        canvas.line(np.concatenate((points, points[:1])), COLOURS["edge"], 2.0 * unit)


def draw_body(canvas: Canvas, outline: Points, unit: float, colour: str | None = None) -> None:
    """Draw an outline filled with the body's own colour, or tinted so that what is beneath shows through."""
    canvas.polygon(outline, colour or COLOURS["body"], opacity=0.8)
    canvas.line(np.concatenate((outline, outline[:1])), COLOURS["true"], 3 * unit)
