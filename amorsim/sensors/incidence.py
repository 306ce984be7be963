"""The angle of incidence of a beam on a surface: a body's shape, or a wall, probed close to the beam."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts import Directions, View
from amorsim.core.poses import wrap_angle
from amorsim.kernels.sensing import slopes

__all__ = ["PATCH", "bind_incidence", "bind_nearest_incidence"]


PATCH = 0.05
"""[m] to either side of a beam at which a wall is probed.

A map is cells, and the outline of a slanting wall is steps of their size: the slope is right to about a cell over
twice this length, which is half a degree in cells of 1 mm. In cells of this size it means little. On the other side,
no wall shorter than this has a slope of its own; the area that an ultrasonic pulse is reflected by is of that size.
"""

# Rays that look for the nearest body, as fractions of a cone's half angle. They are as dense as the rays of a sonar's
# reading in a cone of 30 degrees. Their number is fixed: if it depended on the widest cone of all rows, a row's bits
# would depend on the other rows.
_CLOSER_FAN = np.linspace(-1.0, 1.0, 31)[None, :]
_BODY_FAN = np.linspace(-1.0, 1.0, 601)[None, :]
_BODY_STEP = 2.0 / 600.0  # from one of these to the next

_NONE: Ints = np.empty(0, dtype=np.int64)
_EVEN = 3.0  # a probe this many times farther than the other is on another surface: an edge, or a corner's far side


def bind_incidence(view: View, origins: Array, bearings: Array, ranges: Array, range_max: Array) -> Callable[[], Array]:
    """A function of the angles [rad] `(M, k)` in [0, pi / 2] between beams and the normals of surfaces.

    0 where nothing returned. The normal is that of what was hit: of a robot or an obstacle, of its shape at that point;
    of a wall, see `PATCH`.

    Parameters
    ----------
    view
        The world; `origins` are world poses `(M, 3)`, the same number for each of its rows.
    bearings, ranges
        `(1, k)` or `(M, k)` [rad] from the origins' headings, and the ranges `(M, k)` [m] found there. All arrays keep
        their place.
    range_max
        Longest range `(N, 1)` [m]; nothing returns beyond it.
    """
    of_walls = _bind_wall_incidence(view, origins, bearings, ranges, range_max)
    if not view.has_company:
        return of_walls

    def incidence() -> Array:
        _, body = view.look(origins, bearings, range_max, landmarks=False)
        if (body < 0).all():
            return of_walls()
        of_bodies = _body_incidence(view, origins, bearings, body)
        return np.where(np.isfinite(ranges) & (body >= 0), of_bodies, of_walls())

    return incidence


def bind_nearest_incidence(
    view: View, origins: Array, half_angle: Array, range_max: Array, wall: tuple[Array, Array]
) -> Callable[[], Array]:
    """A function of the angles of incidence [rad] `(N, m)` at the nearest return of each cone; 0 where there is none.

    `origins`, which keep their place, are world poses `(N * m, 3)` of cones; `half_angle` [rad] and `range_max` [m] are
    `(N, 1)`. `wall`, whose arrays keep their place too, are bearing and range `(N, m)` of the nearest wall in each, as
    `View.nearest_wall` returns them.
    """
    bearings, ranges = wall
    nearest = ranges.reshape(-1, 1)
    of_walls = _bind_wall_incidence(view, origins, bearings.reshape(-1, 1), nearest, range_max)

    def incidence() -> Array:
        found = of_walls()
        which = _near_bodies(view, origins, half_angle, range_max, nearest) if view.has_company else _NONE
        if len(which):
            row = which // ranges.shape[1]
            of_bodies, reach = _nearest_bodies(view, origins[which], half_angle[row], range_max[row], row)
            found[which] = np.where(reach < nearest[which], of_bodies, found[which])
        return found.reshape(ranges.shape)

    return incidence


def _near_bodies(view: View, origins: Array, half_angle: Array, range_max: Array, nearest: Array) -> Ints:
    """Indices `(P,)` of cones that may meet a body nearer than walls."""
    bodies = view.bodies()
    might = np.empty(len(origins), dtype=np.bool_)
    wider = half_angle * (1.0 + _BODY_STEP)  # the outermost rays go beyond the edge by this step
    slopes.bodies_in_cones(
        origins, wider, nearest, range_max, bodies.poses, bodies.reach, bodies.owner, bodies.own, might
    )
    return np.flatnonzero(might)


def _nearest_bodies(view: View, origins: Array, half: Array, range_max: Array, row: Ints) -> tuple[Array, Array]:
    """Angles of incidence [rad] `(M, 1)` on the nearest body in each cone, and its range [m], inf for none.

    Of each cone, half the angle [rad] and the longest range [m] `(M, 1)`, and the row `(M,)`.
    """
    # First the ray with the nearest body. Then finer rays around it: a thin post's normal changes much between rays.
    rays = (half[:1] if (half == half[0]).all() else half) * _BODY_FAN
    aside, _ = _nearest_body(view, origins, rays, range_max, row)
    aside, reach = _nearest_body(view, origins, aside + half * _BODY_STEP * _CLOSER_FAN, range_max, row)
    _, body = view.look(origins, aside, range_max, landmarks=False, row=row)
    return _body_incidence(view, origins, aside, body, row), reach


def _nearest_body(view: View, origins: Array, rays: Array, range_max: Array, row: Ints) -> tuple[Array, Array]:
    """Bearing and range `(M, 1)` of the nearest body on any of the rays `(1 or M, k)`."""
    ranges, body = view.look(origins, rays, range_max, landmarks=False, row=row)
    return _nearest(rays, np.where(body >= 0, ranges, np.inf))


def _nearest(bearings: Array, ranges: Array) -> tuple[Array, Array]:
    """The bearing and the range `(M, 1)` of the nearest of each row's rays `(M, k)`."""
    bearing, nearest = np.empty((len(ranges), 1)), np.empty((len(ranges), 1))
    slopes.nearest_rays(bearings, ranges, bearing, nearest)
    return bearing, nearest


def _body_incidence(view: View, origins: Array, bearings: Array, body: Ints, row: Ints | None = None) -> Array:
    """Angles [rad] `(M, k)` between beams and the normals of the bodies that they enter; 0 where there is none."""
    normal = view.normals(origins, bearings, body, row)
    between = np.abs(wrap_angle(normal - (origins[:, 2:] + bearings) - np.pi))
    return np.where(np.isnan(normal), 0.0, np.minimum(between, np.pi / 2.0))


def _bind_wall_incidence(
    view: View, origins: Array, bearings: Array, ranges: Array, range_max: Array
) -> Callable[[], Array]:
    """A function of the angles [rad] `(M, k)` between beams and the walls that they meet, as in `bind_incidence`.

    Two probes are cast close to each beam, to meet the wall `PATCH` away. The wall's line goes through their ends. If
    one probe passes an edge, the line goes through the nearer end and the beam's own end. Bodies do not block probes.
    """
    shape = len(ranges), 2 * ranges.shape[1]
    towards, probes = Directions(np.empty(shape), np.empty(shape)), np.empty(shape)
    # A probe may be longer than the beam: a slanted wall continues beyond the range of view.
    cast = view.bind_cast(origins, towards, 2.0 * range_max, probes, bodies=False)

    def incidence() -> Array:
        slopes.probe(bearings, ranges, PATCH, *towards)
        cast()
        found = np.empty(ranges.shape)
        slopes.incidences(ranges, probes, PATCH, _EVEN, found)
        return found

    return incidence
