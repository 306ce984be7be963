"""Generated worlds: ``am.worlds.office(seed=7)`` is a `Map`. The generators' classes are in the modules."""

from __future__ import annotations

from typing import Any

from amorsim.core.map import Map
from amorsim.worlds.barn_fields import Barn
from amorsim.worlds.caves import Cave
from amorsim.worlds.crossings import Crossing
from amorsim.worlds.forests import Forest
from amorsim.worlds.made import generated
from amorsim.worlds.mazes import Maze
from amorsim.worlds.offices import Office
from amorsim.worlds.warehouses import Warehouse

__all__ = [
    "Barn",
    "Cave",
    "Crossing",
    "Forest",
    "Maze",
    "Office",
    "Warehouse",
    "barn",
    "cave",
    "crossing",
    "forest",
    "maze",
    "office",
    "warehouse",
]


def office(seed: int = 0, **options: Any) -> Map:
    """An office floor; `options` are the fields of `Office`. Raises `MapError` if they admit no world."""
    return generated(Office, seed, options)


def maze(seed: int = 0, **options: Any) -> Map:
    """A maze; `options` are the fields of `Maze`. Raises `MapError` if they admit no world."""
    return generated(Maze, seed, options)


def cave(seed: int = 0, **options: Any) -> Map:
    """A cave; `options` are the fields of `Cave`. Raises `MapError` if they admit no world."""
    return generated(Cave, seed, options)


def forest(seed: int = 0, **options: Any) -> Map:
    """A forest; `options` are the fields of `Forest`. Raises `MapError` if they admit no world."""
    return generated(Forest, seed, options)


def warehouse(seed: int = 0, **options: Any) -> Map:
    """A warehouse; `options` are the fields of `Warehouse`. Raises `MapError` if they admit no world."""
    return generated(Warehouse, seed, options)


def crossing(seed: int = 0, **options: Any) -> Map:
    """Streets that cross; `options` are the fields of `Crossing`. Raises `MapError` if they admit no world."""
    return generated(Crossing, seed, options)


def barn(seed: int = 0, **options: Any) -> Map:
    """A field as of the BARN challenge; `options` are the fields of `Barn`. Raises `MapError` if they admit none."""
    return generated(Barn, seed, options)
