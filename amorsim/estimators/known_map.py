"""What is derived from the map that a localizing robot knows: distances to walls, and where it may be."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Hashable, Sequence
from typing import Concatenate, NamedTuple, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from amorsim.array_types import Array, Ints, Ints32
from amorsim.contracts import RobotModel
from amorsim.core.errors import ComponentError, MapError
from amorsim.core.maps.free_places import free_places
from amorsim.core.maps.map import Map
from amorsim.kernels import elementary
from amorsim.kernels.filters.beams import Field, Place
from amorsim.kernels.filters.particles import Free
from amorsim.kernels.grid.distances import distances

__all__ = [
    "MOST_CELLS",
    "PARTS",
    "Ends",
    "field_from",
    "field_of",
    "free_of",
    "maps_of",
    "no_field",
    "nowhere",
    "place_of",
]

P = ParamSpec("P")
T = TypeVar("T")


MOST_CELLS = 10**8
PARTS = 10  # of a cell, to which distances are rounded
_MOST_FINER = 10**7  # cells on which distances to walls are taken, if a field's are larger
_ROUNDING = 1e-9  # of a cell, by which a map may seem longer than whole cells
_KEPT = 4  # of what is made of a map for one set of arguments
_LARGEST = 2**31 - 1  # sum of a scan's steps


def maps_of(who: str, robot: RobotModel) -> Sequence[tuple[Map, Ints]]:
    """The maps that robots know, in order, each with its rows.

    Raises
    ------
    ComponentError
        If one knows none.
    """
    rows: dict[Map, list[int]] = {}
    for row, known in enumerate(robot.maps or (robot.map,) * robot.rows):
        if known is None:
            raise ComponentError(
                f"{who} localizes the robot on the map that it knows, but it knows none; name one in knowledge.map"
            )
        rows.setdefault(known, []).append(row)
    return [(known, np.array(which, dtype=np.int64)) for known, which in rows.items()]


def place_of(known: Map) -> Place:
    """The pose of a map in the world."""
    x, y, yaw = known.origin
    return Place(x, y, math.cos(yaw), math.sin(yaw))


def _once(make: Callable[Concatenate[Map, P], T]) -> Callable[Concatenate[Map, P], T]:
    """Keeps the results of `make` for a map and the last few other arguments; they must not refer to the map."""
    made: WeakKeyDictionary[Map, dict[Hashable, T]] = WeakKeyDictionary()

    @functools.wraps(make)
    def kept(known: Map, /, *args: P.args, **kwargs: P.kwargs) -> T:
        of_map = made.setdefault(known, {})
        if args not in of_map:
            while len(of_map) >= _KEPT:
                of_map.pop(next(iter(of_map)))
            of_map[args] = make(known, *args, **kwargs)
        return of_map[args]

    return kept


class Ends(NamedTuple):
    """The likelihood of a beam's end by its distance to a wall: ``hit`` times a Gaussian, and ``rest`` anywhere."""

    std: float  # [m]
    distance_max: float  # [m] at which all walls beyond count
    hit: float
    rest: float  # [1/m]
    beams: int  # that are added up, at most
    cubed: bool  # whether cubes of densities are added, and not logarithms


@_once
def _parts_away(known: Map, resolution: float, distance_max: float) -> tuple[Ints32, float, int]:
    """How far each cell of a map is from the surface of a wall, in parts of a cell; their side [m], and the margin.

    Distances are those of the cells' middles, from inside of walls as from outside. They are taken on finer cells, as
    far as the map has any, or the surfaces would be off by up to a cell.

    Raises
    ------
    ComponentError
        If there were more than `MOST_CELLS` cells.
    """
    resolution = max(resolution, known.resolution)
    margin = math.ceil(distance_max / resolution)
    cols, rows = (max(1, math.ceil(length / resolution - _ROUNDING)) + 2 * margin for length in known.size)
    if rows * cols > MOST_CELLS:
        raise ComponentError(
            f"monte_carlo: a likelihood field of {rows * cols:.3g} cells of {resolution:g} m is too large; expected "
            f"{MOST_CELLS:g} at most: use a larger field_resolution"
        )
    finer = next(times for times in (5, 3, 1) if times == 1 or rows * cols * times * times <= _MOST_FINER)
    side = max(known.resolution, resolution / finer)
    far = math.ceil(distance_max / side)
    walls = np.pad(known.to_array(resolution=side), far)
    away, inside = np.empty(walls.shape), np.empty(walls.shape)
    distances(walls, away)
    distances(1 - walls, inside)
    np.copyto(away, inside, where=walls > 0)
    at_row, at_col = (
        np.clip(((np.arange(count) - margin + 0.5) * (resolution / side) + far).astype(np.int64), 0, most - 1)
        for count, most in zip((rows, cols), walls.shape, strict=True)
    )
    # A surface is half a cell from the middle of the cell beside it.
    parts = (away[at_row[:, None], at_col] - 0.5) * (PARTS * side / resolution)
    return np.rint(np.minimum(parts, PARTS * margin)).astype(np.int32), resolution, margin


def field_from(parts_away: Ints32, resolution: float, margin: int, ends: Ends) -> Field:
    """The likelihood field of cells (rows, cols) with those distances from a wall, in parts of a cell.

    They include a margin of so many cells to each side, and are at most as far as that.
    """
    away = np.minimum(np.arange(PARTS * margin + 1) * (resolution / PARTS), ends.distance_max)
    density = ends.rest + ends.hit * (
        elementary.exp(-0.5 * (away / ends.std) ** 2) / (ends.std * math.sqrt(2.0 * math.pi))
    )
    added = elementary.power(density, 3.0) if ends.cubed else elementary.log(density)
    base = float(added[-1])
    unit = (float(added[0]) - base) / (_LARGEST // ends.beams) or 1.0
    steps = np.rint((added - base) / unit).astype(np.int32)[parts_away.reshape(-1)]
    steps.flags.writeable = False
    rows, cols = parts_away.shape
    return Field(steps, rows, cols, resolution, margin * resolution, unit, base)


@_once
def field_of(known: Map, resolution: float, ends: Ends) -> Field:
    """The likelihood field of a map: the weight that a beam adds which ends in a cell, by its distance to a wall.

    The field reaches beyond the map by as much as the longest distance that counts.

    Raises
    ------
    ComponentError
        If it would have more than `MOST_CELLS` cells.
    """
    parts_away, resolution, margin = _parts_away(known, resolution, ends.distance_max)
    return field_from(parts_away, resolution, margin, ends)


@_once
def free_of(known: Map) -> Free:
    """The squares of a map where a robot may be, connected to the roomiest of them.

    Raises
    ------
    ComponentError
        If nothing is free.
    """
    try:
        middles, side = free_places(known)
    except MapError as error:
        raise ComponentError(f"monte_carlo looks for the robot anywhere on its map, but {error}") from None
    middles = np.ascontiguousarray(middles)
    middles.flags.writeable = False
    return Free(middles, side)


def no_field() -> Field:
    """An empty field, for filters that use none."""
    steps: Ints32 = np.zeros(1, dtype=np.int32)
    steps.flags.writeable = False
    return Field(steps, 1, 1, 1.0, 0.0, 1.0, 0.0)


def nowhere() -> Free:
    """No squares, for filters that add no random particles."""
    middles: Array = np.zeros((1, 2))
    middles.flags.writeable = False
    return Free(middles, 0.0)
