"""Making a world: a generator, its seed, and the map that they give."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from amorsim.contracts import WorldGenerator
from amorsim.core.draws import Draws, stream_key
from amorsim.core.errors import MapError, did_you_mean
from amorsim.core.map import Map
from amorsim.core.parameters import ParameterError, describe
from amorsim.core.starts import out_of_reach

__all__ = ["MadeWorld", "draws_of", "generated", "make_world"]

_STREAM = "world"


@attrs.frozen(kw_only=True)
class MadeWorld:
    """The origin of a generated map: the generator, which holds the parameters, and the seed."""

    generator: WorldGenerator
    seed: int


def draws_of(seed: int) -> Draws:
    """The draws, of one row, from which a world of this seed is made."""
    return Draws(np.array([stream_key(seed, _STREAM)], dtype=np.uint64), np.zeros((1, 3), dtype=np.uint32))


def make_world(made: MadeWorld) -> Map:
    """The world that a generator gives for a seed; it remembers both as its `source`.

    Raises
    ------
    MapError
        If the parameters admit no world, or the generator fails.
    """
    who = type(made.generator).__name__
    try:
        found = made.generator.generate(draws_of(made.seed))
    except MapError as error:
        raise MapError(f"{who} with seed {made.seed}: {error}") from error
    except Exception as error:  # a third party's generator
        raise MapError(f"{who} with seed {made.seed} failed with {type(error).__name__}: {error}") from error
    if not isinstance(found, Map):
        raise MapError(f"{who} with seed {made.seed} gave {found!r}, which is no map")
    if found.start is None or out_of_reach(found, *found.start[:2]):
        raise MapError(f"{who} with seed {made.seed} gave a map whose start is {found.start}; expected a free place")
    return attrs.evolve(found, source=made)


def generated(cls: type[WorldGenerator], seed: int, options: dict[str, Any]) -> Map:
    """The world of a generator's class with these fields.

    Raises
    ------
    MapError
        If a field is unknown or of a wrong value, or as for `make_world`.
    """
    fields = describe(cls)
    for option in options:
        if option not in fields:
            known = ", ".join(fields) or "none"
            raise MapError(f"{cls.__name__} has no parameter {option!r}, but: {known}.{did_you_mean(option, fields)}")
    try:
        generator = cls(**options)
    except ParameterError as error:
        raise MapError(f"{cls.__name__}: {error}") from error
    except TypeError as error:  # a required field that is not there
        raise MapError(f"{cls.__name__}: {error}") from error
    return make_world(MadeWorld(generator=generator, seed=seed))
