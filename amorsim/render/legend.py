"""The entries of a picture's legend, and the sample drawn for each."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from amorsim.core.patches import DROP, Patch
from amorsim.render import marks
from amorsim.render.canvas import Canvas
from amorsim.render.obstacles import draw_lamp, draw_landmark, draw_obstacle

__all__ = ["Item", "items_of"]

_NAMES_SHOWN = 5

Points = NDArray[np.float64]
Draw = Callable[[Canvas, Points, float], None]


@attrs.frozen
class Item:
    """An entry of the legend: its words, and how its sample is drawn about a place."""

    text: str
    draw: Draw | None


def items_of(
    names: Sequence[str], *, true: bool, estimated: bool, zones: int, kinds: Collection[str], hits: int
) -> list[Item]:
    """The entries for those things that are in a picture.

    Parameters
    ----------
    names
        The robots'.
    true, estimated
        Whether there are such paths.
    zones, hits
        How many zones and collisions there are.
    kinds
        Which things stand in it: obstacle, landmark, lamp; and what is on its floor: marking, drop.
    """
    more = len(names) - _NAMES_SHOWN
    heading = ", ".join(names[:_NAMES_SHOWN]) + (f" and {more} more" if more > 0 else "")
    found = [
        (bool(heading), Item(heading + ":", None)),
        (true, Item("true path", _line_sample(marks.draw_true_path))),
        (estimated, Item("estimated path", _line_sample(marks.draw_estimated_path))),
        (true, Item("start", marks.draw_start)),
        (true, Item("end", marks.draw_true_end)),
        (estimated, Item("estimated end", marks.draw_estimated_end)),
        (zones > 0, Item("zone" if zones == 1 else "zones", _zone_sample)),
        *((kind in kinds, Item(kind, draw)) for kind, draw in _SAMPLES.items()),
        (hits > 0, Item(f"{hits} collision{'s' if hits > 1 else ''}", marks.draw_collision)),
    ]
    return [item for shown, item in found if shown]


def _line_sample(draw: Draw) -> Draw:
    """A short stretch of a path, drawn as the path is."""

    def sample(canvas: Canvas, place: Points, unit: float) -> None:
        draw(canvas, place + np.array([(-34.0, 0.0), (34.0, 0.0)]) * unit, unit)

    return sample


def _zone_sample(canvas: Canvas, place: Points, unit: float) -> None:
    """A small zone about a place."""
    marks.draw_zone(canvas, place + np.array([(-13.0, -11.0), (13.0, -11.0), (13.0, 11.0), (-13.0, 11.0)]) * unit, unit)


def _patch_sample(*, is_drop: bool) -> Draw:
    """A piece of a marking, or a small drop, about a place."""

    def sample(canvas: Canvas, place: Points, unit: float) -> None:
        corners = place + np.array([(-13.0, -9.0), (13.0, -9.0), (13.0, 9.0), (-13.0, 9.0)]) * unit
        along = place + np.array([(-16.0, 0.0), (16.0, 0.0)]) * unit
        patch = Patch(corners, 0.0, DROP, True) if is_drop else Patch(along, 7.0 * unit, "black")
        marks.draw_patch(canvas, patch, patch.points, 1.0, unit)

    return sample


_SAMPLES = {
    "marking": _patch_sample(is_drop=False),
    "drop": _patch_sample(is_drop=True),
    "obstacle": draw_obstacle,
    "landmark": draw_landmark,
    "lamp": draw_lamp,
}
