"""Generated worlds in Python: a function for each generator, which makes a map of its parameters by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from amorsim.contracts import WorldGenerator
from amorsim.core.arguments import checked
from amorsim.core.distributions import Distribution
from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError, describe
from amorsim.core.unknown_names import no_such
from amorsim.worlds.barn_fields import Barn
from amorsim.worlds.caves import Cave
from amorsim.worlds.crossings import Crossing
from amorsim.worlds.drawn import DrawnParameter, DrawnWorld, can_be_drawn, middle_of
from amorsim.worlds.forests import Forest
from amorsim.worlds.made import MadeWorld, make_world
from amorsim.worlds.mazes import Maze
from amorsim.worlds.offices import Office
from amorsim.worlds.warehouses import Warehouse

__all__ = ["barn", "cave", "crossing", "forest", "maze", "office", "warehouse"]


def office(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """An office floor; `options` are the fields of `Office`. Raises `MapError` if they admit no world."""
    return _generated(Office, seed, per, options)


def maze(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A maze; `options` are the fields of `Maze`. Raises `MapError` if they admit no world."""
    return _generated(Maze, seed, per, options)


def cave(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A cave; `options` are the fields of `Cave`. Raises `MapError` if they admit no world."""
    return _generated(Cave, seed, per, options)


def forest(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A forest; `options` are the fields of `Forest`. Raises `MapError` if they admit no world."""
    return _generated(Forest, seed, per, options)


def warehouse(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A warehouse; `options` are the fields of `Warehouse`. Raises `MapError` if they admit no world."""
    return _generated(Warehouse, seed, per, options)


def crossing(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """Streets that cross; `options` are the fields of `Crossing`. Raises `MapError` if they admit no world."""
    return _generated(Crossing, seed, per, options)


def barn(seed: int = 0, *, per: str = "study", **options: Any) -> Map:
    """A field as of the BARN challenge; `options` are the fields of `Barn`. Raises `MapError` if they admit none."""
    return _generated(Barn, seed, per, options)


@checked
def _generated(cls: type[WorldGenerator], seed: int, per: str, options: Mapping[str, Any]) -> Map:
    """The world of a generator's class with these fields; some may be distributions.

    Raises
    ------
    MapError
        If a field is unknown, of a wrong value or cannot be drawn, or as for `make_world`.
    """
    fields = describe(cls)
    values, drawn = {}, []
    for name, value in options.items():
        if name not in fields:
            raise MapError(no_such("parameter", name, fields, whose=cls.__name__))
        values[name] = value
        if isinstance(value, Distribution):
            problem = can_be_drawn(fields[name], value)
            if problem:
                raise MapError(f"{cls.__name__}: {name}: {problem}")
            values[name] = middle_of(fields[name], value)
            drawn.append(DrawnParameter(name=name, distribution=value))
    try:
        generator = cls(**values)
        if not drawn and per == "study":
            return make_world(MadeWorld(generator=generator, seed=seed))
        return DrawnWorld(generator=generator, seed=seed, per=per, drawn=tuple(drawn)).make()
    except ParameterError as error:
        raise MapError(f"{cls.__name__}: {error}") from error
    except TypeError as error:  # a required field that is not there
        raise MapError(f"{cls.__name__}: {error}") from error
