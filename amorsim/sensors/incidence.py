"""At what angle a beam meets a surface, found by looking closely beside it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.contracts import View

__all__ = ["PATCH", "incidence"]

Array = npt.NDArray[np.float64]

PATCH = 0.05
"""[m] to either side of a beam at which the surface is probed.

A map is cells, and the outline of a slanting wall is steps of their size: the slope is right to about a cell over
twice this length, which is half a degree in cells of 1 mm. In cells as large as this it says little. On the other side,
no surface shorter than this has a slope of its own; the area that an ultrasonic pulse is reflected by is of that size.
"""

_EVEN = 3.0  # a probe so many times farther off than the other lies on another surface: an edge, or a corner's far side


def incidence(view: View, origins: Array, bearings: Array, ranges: Array, range_max: Array) -> Array:
    """Angles [rad] `(M, k)` in [0, pi / 2] between beams and the normals of what they meet; 0 where nothing returned.

    Two more beams are cast beside each, so as to meet the surface `PATCH` away, and a line laid through what they
    find; through the nearer one and the beam's own end where the other looks past an edge. Other bodies have
    surfaces as walls do.

    Parameters
    ----------
    view
        The world; `origins` are world poses `(M, 3)`, as many for each of its rows.
    bearings, ranges
        `(1, k)` or `(M, k)` [rad] from the origins' headings, and `(M, k)` [m] what was found there.
    range_max
        `(N, 1)` [m], beyond which nothing returns.
    """
    met = np.isfinite(ranges)
    ahead = np.where(met, ranges, 1.0)
    spread = np.arctan2(PATCH, ahead)
    # A probe may go farther than the beam: a slanting wall goes on beyond what is seen.
    limit = 2.0 * np.asarray(range_max)
    left_x, left_y, left_gap = _probe(view, origins, bearings, spread, ahead, limit)
    right_x, right_y, right_gap = _probe(view, origins, bearings, -spread, ahead, limit)
    both = np.maximum(left_gap, right_gap) <= _EVEN * np.minimum(left_gap, right_gap)
    nearer_left = left_gap <= right_gap
    along = np.where(both, left_x - right_x, np.where(nearer_left, left_x, right_x) - ahead)
    across = np.where(both, left_y - right_y, np.where(nearer_left, left_y, right_y))
    found = met & np.isfinite(np.minimum(left_gap, right_gap))
    return np.where(found, np.arctan2(np.abs(along), np.abs(across)), 0.0)


def _probe(
    view: View, origins: Array, bearings: Array, turn: Array, ahead: Array, limit: Array
) -> tuple[Array, Array, Array]:
    """Where a beam turned aside ends, along and across the first one, and how far [m] from its end; inf for nowhere."""
    reach = view.cast(origins, np.ascontiguousarray(bearings + turn), limit)
    known = np.isfinite(reach)
    reach = np.where(known, reach, 0.0)
    x, y = reach * np.cos(turn), reach * np.sin(turn)
    gap = np.where(known, np.sqrt((x - ahead) ** 2 + y**2), np.inf)
    return x, y, gap
