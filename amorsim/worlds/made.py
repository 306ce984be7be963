"""Making a world: a generator, its seed, and the map that they give."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.contracts import WorldGenerator
from amorsim.core.draws import Draws, stream_key
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import MapError
from amorsim.core.maps.footprint_room import out_of_reach
from amorsim.core.maps.map import Map

__all__ = ["MadeWorld", "draws_of", "make_world"]

_STREAM = "world"


@attrs.frozen(kw_only=True)
class MadeWorld:
    """The origin of a generated map: the generator with its parameters, the seed, and the stream of draws.

    A map that is the same for all replicas has the draws of replica 0.
    """

    generator: WorldGenerator
    seed: int
    replica: int = 0


def draws_of(seed: int, replica: int = 0) -> Draws:
    """The draws, of one row, from which a replica's world of this seed is made."""
    key = np.array([stream_key(seed, _STREAM)], dtype=np.uint64)
    return Draws(key, np.array([[replica, 0, 0]], dtype=np.uint32))


def make_world(made: MadeWorld) -> Map:
    """The world that a generator gives for a seed; it remembers both as its `source`.

    Raises
    ------
    MapError
        If the parameters admit no world, or the generator fails.
    """
    who = f"{type(made.generator).__name__} with seed {made.seed}{f', replica {made.replica}' if made.replica else ''}"
    try:
        found = made.generator.generate(draws_of(made.seed, made.replica))
    except MapError as error:
        raise MapError(f"{who}: {error}") from error
    except RAISED as error:  # a third party's generator
        raise MapError(f"{who} failed with {error_in_words(error)}") from error
    if not isinstance(found, Map):
        raise MapError(f"{who} gave {found!r}, which is not a map")
    if found.start is None or out_of_reach(found, *found.start[:2]):
        raise MapError(f"{who} gave a map whose start is {found.start}; expected a free place")
    return attrs.evolve(found, source=made)
