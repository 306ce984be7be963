"""A world in Python: the class of a generator, and its parameters by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from amorsim.contracts import WorldGenerator
from amorsim.core.arguments import checked
from amorsim.core.distributions import Distribution
from amorsim.core.errors import MapError
from amorsim.core.map import Map
from amorsim.core.parameters import ParameterError, describe
from amorsim.core.unknown_names import no_such
from amorsim.worlds.drawn import DrawnParameter, DrawnWorld, can_be_drawn, middle_of
from amorsim.worlds.made import MadeWorld, make_world

__all__ = ["generated"]


@checked
def generated(cls: type[WorldGenerator], seed: int, per: str, options: Mapping[str, Any]) -> Map:
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
