"""How generators of worlds are tried."""

from __future__ import annotations

import warnings

from amorsim.contracts import WorldGenerator
from amorsim.core.maps.map import Map
from amorsim.testing.failure import Who
from amorsim.worlds.made import draws_of

__all__ = ["check_world_generator"]

_SEEDS = 4


def check_world_generator(who: Who, generator: WorldGenerator) -> None:
    """Generate some worlds, each twice: they are maps with a free start, and the same for the same seed.

    There is a warning if all seeds give one world, as it has then not been tried what the generator draws.
    """
    worlds = []
    for seed in range(_SEEDS):
        what = f"generate() with seed {seed}"
        with who.calling("generate"):
            first, second = generator.generate(draws_of(seed)), generator.generate(draws_of(seed))
        who.require(isinstance(first, Map), "generate", what, "a Map", type(first).__name__)
        who.require(first == second, "determinism", f"a second {what}", "the same map", "another one")
        who.require(first.start is not None, "start", what, "a map with a start", "none")
        assert first.start is not None
        who.require(not first.occupied([first.start[:2]])[0], "start", what, "a free place", first.start)
        worlds.append(first)
    if all(world == worlds[0] for world in worlds):
        warnings.warn(
            f"{who}: seeds 0 to {_SEEDS - 1} gave the same world, so nothing was proven of what it draws; give "
            "check_component one whose parameters leave something to be drawn",
            stacklevel=3,
        )
