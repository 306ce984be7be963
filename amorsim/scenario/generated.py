"""Generated worlds in documents: ``map = { generate = "office", seed = 7, size = [40, 25] }``."""

from __future__ import annotations

from typing import Any

from amorsim.core.errors import PluginError
from amorsim.plugins.registry import Registry
from amorsim.scenario.faults import Node
from amorsim.scenario.fields import read_component, write_fields
from amorsim.worlds.made import MadeWorld

__all__ = ["read_generated", "write_generated"]

_BESIDE = ("generate", "seed")
_MOST = 2**63 - 1


def read_generated(node: Node, registry: Registry) -> MadeWorld | None:
    """The generator and the seed in a table, or None after faults; nothing is generated."""
    if "generate" not in node:
        node.child("generate").fault(
            f"missing; expected the name of a world generator: {', '.join(registry.names('world_generator'))}"
        )
        return None
    name = node.child("generate").text("the name of a world generator")
    seed = node.value.get("seed", 0)
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed <= _MOST:
        node.child("seed").fault(f"expected a whole number from 0 to {_MOST}, got {seed!r}")
        return None
    if name is None:
        return None
    try:
        cls = registry.get("world_generator", name)
    except PluginError as error:
        node.child("generate").fault(str(error))
        return None
    generator = read_component(cls, node, beside=_BESIDE)
    return None if generator is None else MadeWorld(generator=generator, seed=int(seed))


def write_generated(made: MadeWorld, name: str) -> dict[str, Any]:
    """The table that `read_generated` reads, for a generator that is registered under `name`."""
    return {"generate": name, "seed": made.seed, **write_fields(made.generator)}
