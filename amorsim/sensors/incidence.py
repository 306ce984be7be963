"""At what angle a beam meets a surface: a body's shape, or a wall, which is felt closely beside the beam."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.contracts import View
from amorsim.core.poses import wrap_angle

__all__ = ["PATCH", "incidence", "nearest_incidence"]

Array = npt.NDArray[np.float64]

PATCH = 0.05
"""[m] to either side of a beam at which a wall is probed.

A map is cells, and the outline of a slanting wall is steps of their size: the slope is right to about a cell over
twice this length, which is half a degree in cells of 1 mm. In cells as large as this it says little. On the other side,
no wall shorter than this has a slope of its own; the area that an ultrasonic pulse is reflected by is of that size.
"""

# Rays in which the nearest return is looked for, by parts of a cone's half angle; for bodies as near to each other as
# those that make a sonar's reading, in a cone of 30 degrees. Their number is fixed: one that depended on the widest
# cone of all rows would make a row's bits depend on the other rows.
_WALL_FAN = np.linspace(-1.0, 1.0, 31)[None, :]
_BODY_FAN = np.linspace(-1.0, 1.0, 601)[None, :]
_BODY_STEP = 2.0 / 600.0  # from one of these to the next

_EVEN = 3.0  # a probe so many times farther off than the other lies on another surface: an edge, or a corner's far side


def incidence(view: View, origins: Array, bearings: Array, ranges: Array, range_max: Array) -> Array:
    """Angles [rad] `(M, k)` in [0, pi / 2] between beams and the normals of what they meet; 0 where nothing returned.

    The normal is that of what was hit: of a robot or an obstacle, of its shape at that point; of a wall, see `PATCH`.

    Parameters
    ----------
    view
        The world; `origins` are world poses `(M, 3)`, as many for each of its rows.
    bearings, ranges
        `(1, k)` or `(M, k)` [rad] from the origins' headings, and `(M, k)` [m] what was found there.
    range_max
        `(N, 1)` [m], beyond which nothing returns.
    """
    _, body = view.look(origins, bearings, range_max, landmarks=False)
    of_walls = _wall_incidence(view, origins, bearings, ranges, range_max)
    of_bodies = _body_incidence(view, origins, bearings, body)
    return np.where(np.isfinite(ranges) & (body >= 0), of_bodies, of_walls)


def nearest_incidence(view: View, origins: Array, half_angle: Array, range_max: Array) -> Array:
    """Angles of incidence [rad] `(N, m)` where the nearest returns of cones come from; 0 where nothing returns.

    `origins` are world poses `(N * m, 3)` of cones, `half_angle` [rad] and `range_max` [m] `(N, 1)`.
    """
    per_row = len(origins) // view.rows
    half = np.repeat(np.broadcast_to(half_angle, (view.rows, 1)), per_row, axis=0)
    bearing, nearest = _nearest(half * _WALL_FAN, view.cast(origins, half * _WALL_FAN, range_max, bodies=False))
    found = _wall_incidence(view, origins, bearing, nearest, range_max)
    if len(view.bodies().reach) > 1:
        # The ray that meets a body nearest; then, as a thin post's normal turns much from ray to ray, closer about it.
        aside = np.zeros((len(origins), 1))
        for width, fan in ((half, _BODY_FAN), (half * _BODY_STEP, _WALL_FAN)):
            rays = aside + width * fan
            ranges, body = view.look(origins, rays, range_max, landmarks=False)
            aside, reach = _nearest(rays, np.where(body >= 0, ranges, np.inf))
        _, body = view.look(origins, aside, range_max, landmarks=False)
        found = np.where(reach < nearest, _body_incidence(view, origins, aside, body), found)
    return found.reshape(view.rows, per_row)


def _nearest(bearings: Array, ranges: Array) -> tuple[Array, Array]:
    """The bearing and the range `(M, 1)` of the nearest of each row's rays `(M, k)`."""
    which = np.argmin(ranges, axis=1)[:, None]
    return np.take_along_axis(bearings, which, axis=1), np.take_along_axis(ranges, which, axis=1)


def _body_incidence(view: View, origins: Array, bearings: Array, body: npt.NDArray[np.int64]) -> Array:
    """Angles [rad] `(M, k)` between beams and the normals of the bodies that they enter; 0 where there is none."""
    normal = view.normals(origins, bearings, body)
    between = np.abs(wrap_angle(normal - (origins[:, 2:] + bearings) - np.pi))
    return np.where(np.isnan(normal), 0.0, np.minimum(between, np.pi / 2.0))


def _wall_incidence(view: View, origins: Array, bearings: Array, ranges: Array, range_max: Array) -> Array:
    """Angles [rad] `(M, k)` between beams and the walls that they meet, as `incidence` gives them.

    Two more beams are cast beside each, so as to meet the wall `PATCH` away, and a line laid through what they find;
    through the nearer one and the beam's own end where the other looks past an edge. Bodies do not keep them off.
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
    reach = view.cast(origins, np.ascontiguousarray(bearings + turn), limit, bodies=False)
    known = np.isfinite(reach)
    reach = np.where(known, reach, 0.0)
    x, y = reach * np.cos(turn), reach * np.sin(turn)
    gap = np.where(known, np.sqrt((x - ahead) ** 2 + y**2), np.inf)
    return x, y, gap
