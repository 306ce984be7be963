"""Paths of bodies that slide while their wheels roll (`amorsim.contracts.Noise.slide`)."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Drive
from amorsim.core.poses import compose, exponential

__all__ = ["arcs", "bounds", "displaced", "part_bounds"]


def arcs(twist: Array, slide: Array) -> Array:
    """The twists `(N, 3)` of bodies that slide along arcs; the wheels alone would give `twist`."""
    return np.where(slide != 0.0, twist + slide, twist)  # adding 0.0 would change the sign of a zero


def displaced(drive: Drive, before: Array, after: Array, slide: Array | None, fraction: Array) -> Array:
    """The displacements `(N, 3)` of bodies at fractions `(N, 1)` of the step that slide by `slide` `(N, 3)`.

    On an arc, rolling and sliding add up to one twist. On other paths half of the slide comes before the rolling and
    half after it: accurate to second order in the step.
    """
    if slide is None:
        return drive.displacement(before, after, fraction)
    if drive.goes_on_arcs:
        return exponential(arcs(drive.twist(before, after), slide), fraction)
    rolled = drive.displacement(before, after, fraction)
    half = exponential(0.5 * slide, fraction)
    found = compose(compose(half, rolled), half)
    found[:, 2:] = rolled[:, 2:] + slide[:, 2:] * fraction  # `compose` wraps headings
    return np.where((slide != 0.0).any(axis=1, keepdims=True), found, rolled)


def bounds(travel: Array, slide: Array | None) -> Array:
    """Bounds on the paths `(N, 2)` [m, rad] of bodies that may slide; without a slide they are `travel` `(N, 2)`."""
    if slide is None:
        return travel
    way = np.sqrt(slide[:, 0] ** 2 + slide[:, 1] ** 2)
    turn = np.abs(slide[:, 2])
    # Half of the slide's turn swings the whole path about its start.
    length = travel[:, 0] + way + 0.5 * turn * (travel[:, 0] + way)
    return np.stack((length, travel[:, 1] + turn), axis=1)


def part_bounds(travel: Array, slide: Array | None) -> Array:
    """Bounds on the paths of parts `(N, p, 2)`: a body with parts slides without turning, and so do its parts."""
    if slide is None:
        return travel
    more = np.zeros_like(travel)
    more[:, :, 0] = np.sqrt(slide[:, :1] ** 2 + slide[:, 1:2] ** 2)
    return travel + more
