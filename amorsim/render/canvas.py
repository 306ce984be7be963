"""A canvas for smooth lines: drawn three times as fine as it is shown, then averaged down."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from amorsim.array_types import Bools

__all__ = ["FINENESS", "Canvas"]

FINENESS = 3
"""Fine pixels along the side of a shown one."""

# More than this many dots of a line only paint over each other, and would take seconds.
_DOTS_MAX = 4_000_000

Points = NDArray[np.float64]


class Canvas:
    """An empty white canvas of a size [px]; lengths and places are in shown pixels, x right, y down.

    What is drawn is cut off at the edge of `frame`, a box (left, top, right, bottom) within the canvas.
    """

    def __init__(self, width: int, height: int) -> None:
        self._image = Image.new("RGB", (width * FINENESS, height * FINENESS), "white")
        self.frame = (0, 0, width, height)

    def shown(self) -> Image.Image:
        """The picture so far, at its size."""
        return self._image.reduce(FINENESS)

    def rectangle(self, box: tuple[float, float, float, float], colour: str) -> None:
        """Fill a box (left, top, right, bottom)."""
        left, top, right, bottom = (round(edge * FINENESS) for edge in self._within(box))
        if right > left and bottom > top:
            self._image.paste(colour, (left, top, right, bottom))

    def mask(self, dots: Bools, place: tuple[float, float], colour: str) -> None:
        """Colour the fine pixels that are true in `dots`, (rows, columns); `place` is their top left."""
        left, top = (round(edge * FINENESS) for edge in place)
        x0, y0, x1, y1 = (edge * FINENESS for edge in self.frame)
        seen = dots[max(y0 - top, 0) : max(y1 - top, 0), max(x0 - left, 0) : max(x1 - left, 0)]
        if seen.size:
            self._image.paste(colour, (max(left, x0), max(top, y0)), Image.fromarray(seen))

    def polygon(self, corners: Points, colour: str, *, opacity: float = 1.0) -> None:
        """Fill a closed outline, corners (V, 2)."""
        x0, y0, x1, y1 = (edge * FINENESS for edge in self.frame)
        fine = corners * FINENESS
        left, top = np.floor(np.maximum(fine.min(axis=0), (x0, y0))).astype(int)
        right, bottom = np.ceil(np.minimum(fine.max(axis=0), (x1, y1))).astype(int)
        if right <= left or bottom <= top:
            return
        stencil = Image.new("L", (int(right - left), int(bottom - top)))
        inside = [(float(x - left), float(y - top)) for x, y in fine]
        ImageDraw.Draw(stencil).polygon(inside, fill=round(255 * opacity))
        self._image.paste(colour, (int(left), int(top)), stencil)

    def hatch(self, corners: Points, colour: str, spacing: float, width: float) -> None:
        """Slanting lines of a width, so far apart, within a closed outline, corners (V, 2)."""
        x0, y0, x1, y1 = (edge * FINENESS for edge in self.frame)
        fine = corners * FINENESS
        left, top = np.floor(np.maximum(fine.min(axis=0), (x0, y0))).astype(int).tolist()
        right, bottom = np.ceil(np.minimum(fine.max(axis=0), (x1, y1))).astype(int).tolist()
        if right <= left or bottom <= top:
            return
        stencil = Image.new("1", (right - left, bottom - top))
        ImageDraw.Draw(stencil).polygon([(float(x - left), float(y - top)) for x, y in fine], fill=1)
        rows, columns = np.ogrid[top:bottom, left:right]
        is_line = (rows + columns) % max(round(spacing * FINENESS * math.sqrt(2.0)), 2) < width * FINENESS * math.sqrt(
            2.0
        )
        self.mask(np.asarray(stencil) & is_line, (left / FINENESS, top / FINENESS), colour)

    def segments(self, ends: Points, colour: str, width: float) -> None:
        """Straight lines of a width, each between two places, (K, 4); many of them, so their ends are not round."""
        x0, y0, x1, y1 = (edge * FINENESS for edge in self.frame)
        stencil = Image.new("1", (x1 - x0, y1 - y0))
        pen = ImageDraw.Draw(stencil)
        far = 4 * max(x1 - x0, y1 - y0)
        fine = np.clip(ends * FINENESS - np.array([x0, y0, x0, y0]), -far, far)
        for piece in fine[np.all(np.isfinite(fine), axis=1)].tolist():
            pen.line(piece, fill=1, width=max(1, round(width * FINENESS)))
        self._image.paste(colour, (x0, y0), stencil)

    def line(self, points: Points, colour: str, width: float, *, dash: tuple[float, float] | None = None) -> None:
        """A line of round ends and corners through points (T, 2), whole or in dashes and gaps of two lengths.

        A point that is not finite interrupts the line; a single point is a dot.
        """
        # What is far out of sight is drawn at the edge of this box: no line takes for ever to walk along.
        left, top, right, bottom = self.frame
        far = 4 * max(right - left, bottom - top)
        for piece in _finite_pieces(points):
            kept = np.clip(piece, (left - far, top - far), (right + far, bottom + far))
            self._line(kept * FINENESS, colour, width * FINENESS, dash)

    def _line(self, points: Points, colour: str, width: float, dash: tuple[float, float] | None) -> None:
        dots = _dots(points, None if dash is None else (dash[0] * FINENESS, dash[1] * FINENESS))
        radius = width / 2
        reach = math.ceil(radius)
        x0, y0, x1, y1 = (edge * FINENESS for edge in self.frame)
        near = np.all((dots >= (x0 - reach, y0 - reach)) & (dots < (x1 + reach, y1 + reach)), axis=1)
        cells = np.floor(dots[near]).astype(np.intp)
        if not len(cells):
            return
        left, top = cells.min(axis=0) - reach
        columns, rows = cells.max(axis=0) + reach + 1 - (left, top)
        thin = np.zeros((rows, columns), np.bool_)
        thin[cells[:, 1] - top, cells[:, 0] - left] = True
        where = np.flatnonzero(thin)
        thick = np.zeros(rows * columns, np.bool_)
        # A margin of `reach` is around all dots, so that no offset of the pen's disc runs over a row's end.
        for dy in range(-reach, reach + 1):
            for dx in range(-reach, reach + 1):
                if dx * dx + dy * dy <= radius * radius:
                    thick[where + (dy * columns + dx)] = True
        self.mask(thick.reshape(rows, columns), (left / FINENESS, top / FINENESS), colour)

    def _within(self, box: Sequence[float]) -> tuple[float, float, float, float]:
        left, top, right, bottom = self.frame
        return max(box[0], left), max(box[1], top), min(box[2], right), min(box[3], bottom)


def _finite_pieces(points: Points) -> list[Points]:
    """The longest stretches of finite points."""
    finite = np.all(np.isfinite(points), axis=1)
    if finite.all():
        return [points] if len(points) else []
    breaks = np.flatnonzero(np.diff(finite.astype(np.int8))) + 1
    pieces = np.split(points, breaks)
    return [piece for piece in pieces if np.isfinite(piece[0]).all()]


def _dots(points: Points, dash: tuple[float, float] | None) -> Points:
    """Points along a line, at most one pixel apart, (D, 2); those in gaps left out."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    ends = np.concatenate(([0.0], np.cumsum(steps)))
    length = ends[-1]
    if length == 0:
        return points[:1]
    along = np.linspace(0.0, length, min(math.ceil(length) + 1, _DOTS_MAX))
    if dash is not None:
        along = along[along % (dash[0] + dash[1]) < dash[0]]
    return np.stack((np.interp(along, ends, points[:, 0]), np.interp(along, ends, points[:, 1])), axis=1)
