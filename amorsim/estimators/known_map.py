"""What a localizing robot derives from the map that it knows: distances to walls, and where it may be."""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt

from amorsim.contracts import RobotModel
from amorsim.core.errors import ComponentError, MapError
from amorsim.core.free_places import free_places
from amorsim.core.map import Map
from amorsim.kernels.filters.beams import Field, Place
from amorsim.kernels.filters.particles import Free
from amorsim.kernels.grid.distances import distances

__all__ = ["MOST_CELLS", "field_of", "free_of", "map_of", "no_field", "nowhere", "place_of"]

MOST_CELLS = 10**8


def map_of(who: str, robot: RobotModel) -> Map:
    """The map that a robot knows.

    Raises
    ------
    ComponentError
        If it knows none.
    """
    if robot.map is None:
        raise ComponentError(
            f"{who} localizes the robot on the map that it knows, but it knows none; name one in knowledge.map"
        )
    return robot.map


def place_of(known: Map) -> Place:
    """Where a map lies in the world."""
    x, y, yaw = known.origin
    return Place(x, y, math.cos(yaw), math.sin(yaw))


@functools.lru_cache(maxsize=4)
def field_of(known: Map, resolution: float, std: float, distance_max: float) -> Field:
    """The likelihood field of a map: the density [1/m] of a return at each cell, by its distance to the nearest wall.

    Walls beyond `distance_max` [m] count as being that far away. The field reaches beyond the map by as much.

    Raises
    ------
    ComponentError
        If it would have more than `MOST_CELLS` cells.
    """
    resolution = max(resolution, known.resolution)
    edge = math.ceil(distance_max / resolution)
    width, height = known.size
    count = (width / resolution + 2 * edge) * (height / resolution + 2 * edge)
    if count > MOST_CELLS:
        raise ComponentError(
            f"monte_carlo: a likelihood field of {count:.3g} cells of {resolution:g} m is too large; expected "
            f"{MOST_CELLS:g} at most: use a larger field_resolution"
        )
    cells = np.pad(known.to_array(resolution=resolution), edge)
    away = np.empty(cells.shape)
    distances(cells, away)
    away = np.minimum(away * resolution, distance_max)
    density = np.exp(-0.5 * (away / std) ** 2) / (std * math.sqrt(2.0 * math.pi))
    density.flags.writeable = False
    return Field(density, resolution, edge * resolution)


@functools.lru_cache(maxsize=4)
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
    """A field for filters that use none."""
    density: npt.NDArray[np.float64] = np.zeros((1, 1))
    density.flags.writeable = False
    return Field(density, 1.0, 0.0)


def nowhere() -> Free:
    """No squares, for filters that draw nothing at random."""
    middles: npt.NDArray[np.float64] = np.zeros((1, 2))
    middles.flags.writeable = False
    return Free(middles, 0.0)
