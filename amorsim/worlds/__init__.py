"""Generated worlds: ``am.worlds.office(seed=7)`` is a `Map`. The generators' classes are in the modules.

With ``per="replica"``, or a `Distribution` in the place of a number, each replica of a simulation gets a world of its
own; the `Map` is that of replica 0.
"""

from __future__ import annotations

from typing import Any

from amorsim.core.map import Map
from amorsim.worlds.barn_fields import Barn
from amorsim.worlds.caves import Cave
from amorsim.worlds.crossings import Crossing
from amorsim.worlds.forests import Forest
from amorsim.worlds.functions import generated
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


def office(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """An office floor; `options` are the fields of `Office`. Raises `MapError` if they admit no world."""
    return generated(Office, seed, per, options)


def maze(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A maze; `options` are the fields of `Maze`. Raises `MapError` if they admit no world."""
    return generated(Maze, seed, per, options)


def cave(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A cave; `options` are the fields of `Cave`. Raises `MapError` if they admit no world."""
    return generated(Cave, seed, per, options)


def forest(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A forest; `options` are the fields of `Forest`. Raises `MapError` if they admit no world."""
    return generated(Forest, seed, per, options)


def warehouse(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A warehouse; `options` are the fields of `Warehouse`. Raises `MapError` if they admit no world."""
    return generated(Warehouse, seed, per, options)


def crossing(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """Streets that cross; `options` are the fields of `Crossing`. Raises `MapError` if they admit no world."""
    return generated(Crossing, seed, per, options)


def barn(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A field as of the BARN challenge; `options` are the fields of `Barn`. Raises `MapError` if they admit none."""
    return generated(Barn, seed, per, options)
