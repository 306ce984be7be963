"""Lines of a drawing, collected from its curves and areas: curves as chords, areas as rows of lines."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from amorsim.core.errors import MapError
from amorsim.core.parameters import parameter

__all__ = ["Drawing", "chord_error"]

_MOST_LINES = 2_000_000

Points = NDArray[np.float64]


def chord_error() -> Any:
    """The field ``chord_error`` of a loader."""
    return parameter(0.001, unit="m", gt=0, help="the farthest that a chord may be from the curve that it stands for")


class Drawing:
    """The lines so far, in metres, and what was left out, each kind counted."""

    def __init__(self, error: float) -> None:
        self.error = error
        """The farthest [m] that a chord may be from its curve."""
        self._parts: list[Points] = []
        self._count = 0
        self._left_out: dict[str, int] = {}

    def leave_out(self, what: str, count: int = 1) -> None:
        """Count something that is not a wall."""
        self._left_out[what] = self._left_out.get(what, 0) + count

    @property
    def remarks(self) -> tuple[str, ...]:
        """One remark on all that was left out; none if nothing was."""
        if not self._left_out:
            return ()
        return ("left out: " + ", ".join(f"{count} {what}" for what, count in self._left_out.items()),)

    @property
    def segments(self) -> Points:
        """All lines (M, 4)."""
        return np.concatenate(self._parts) if self._parts else np.zeros((0, 4))

    def add_lines(self, points: ArrayLike) -> None:
        """Add the lines from each of some places (n, 2) to the next; a single place is a line of no length."""
        places = np.asarray(points, dtype=np.float64).reshape(-1, 2)
        if len(places) == 1:
            places = np.repeat(places, 2, axis=0)
        self._add(np.concatenate((places[:-1], places[1:]), axis=1))

    def add_bezier(self, points: Sequence[ArrayLike]) -> None:
        """Add chords of a Bezier curve of three or four control points."""
        controls = np.asarray(points, dtype=np.float64)
        degree = len(controls) - 1
        # A chord over a step h is off by h² / 8 of the largest second derivative, which is at a control point of it.
        bends = np.hypot(*(controls[:-2] - 2.0 * controls[1:-1] + controls[2:]).T)
        t = self._steps(math.sqrt(degree * (degree - 1) * float(bends.max()) / (8.0 * self.error)))[:, None]
        levels = [np.broadcast_to(control, (len(t), 2)) for control in controls]
        while len(levels) > 1:  # de Casteljau, for all t at once
            levels = [one * (1.0 - t) + other * t for one, other in itertools.pairwise(levels)]
        self.add_lines(levels[0])

    def add_arc(self, middle: ArrayLike, axes: ArrayLike, first: float, sweep: float) -> None:
        """Add chords of ``middle + axes[0] cos t + axes[1] sin t`` for `t` [rad] from `first` on, over `sweep`."""
        centre, (one, other) = np.asarray(middle, np.float64), np.asarray(axes, np.float64)
        is_square = float(one[0] * other[0] + one[1] * other[1]) == 0.0
        radius = max(math.hypot(*one), math.hypot(*other)) if is_square else math.hypot(*one, *other)
        t = first + sweep * self._steps(abs(sweep) * math.sqrt(radius / (8.0 * self.error)))[:, None]
        self.add_lines(centre + one * np.cos(t) + other * np.sin(t))

    def add_area(self, rings: Sequence[Points], side: float) -> None:
        """Add a line through the middle of each row of cells of `side` [m], where it is inside of closed rings."""
        starts = np.concatenate([ring[:-1] for ring in rings])
        ends = np.concatenate([ring[1:] for ring in rings])
        low, high = np.minimum(starts[:, 1], ends[:, 1]), np.maximum(starts[:, 1], ends[:, 1])
        # The rows whose middles an edge crosses, its lower end counted and its upper one not.
        first, after = np.ceil(low / side - 0.5), np.ceil(high / side - 0.5)
        self.refuse_too_many(float((after - first).sum()) / 2.0)
        counts = (after - first).astype(np.int64)
        edge = np.repeat(np.arange(len(starts)), counts)
        row = first[edge] + np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)
        y = (row + 0.5) * side
        (x0, y0), (x1, y1) = starts[edge].T, ends[edge].T
        x = x0 + (x1 - x0) * ((y - y0) / (y1 - y0))
        order = np.lexsort((x, row))
        x, y = x[order], y[order]
        self._add(np.stack((x[0::2], y[0::2], x[1::2], y[1::2]), axis=-1))

    def _steps(self, pieces: float) -> Points:
        """Parameters from 0 to 1 for that many pieces at least."""
        self.refuse_too_many(pieces)
        return np.linspace(0.0, 1.0, max(1, math.ceil(pieces)) + 1)

    def _add(self, lines: Points) -> None:
        self.refuse_too_many(len(lines))
        self._count += len(lines)
        self._parts.append(lines)

    def refuse_too_many(self, more: float) -> None:
        """Raise an error if that many more lines would be too many."""
        # Also true of a number that overflowed to nan.
        if not self._count + more <= _MOST_LINES:
            raise MapError(
                f"the drawing takes more than {_MOST_LINES} lines; are its units right, or may curves and areas be "
                "coarser (chord_error, resolution)?"
            )
