"""The worlds of a run whose replicas have different ones: their digests in ``run.json``, and a comparison.

A folder does not hold the cells, which would be a file for each replica. The scenario names the generator and what is
drawn, and ``run.json`` has a digest of each world.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from amorsim.core.maps.map import Map
from amorsim.simulation.simulation import Simulation
from amorsim.worlds.drawn import origin_of

__all__ = ["different_world", "fingerprints_of_worlds", "world_fingerprint"]

KEY = "worlds"


def world_fingerprint(world: Map) -> str:
    """A digest of a map: of its pose and its walls, or else its cells."""
    text = repr((world.resolution, world.shape, world.origin))
    # Walls decide the cells, and there may be far more cells than can be made into an array.
    held = world.to_array() if world.segments is None else np.ascontiguousarray(world.segments)
    return hashlib.blake2b(text.encode() + held.tobytes(), digest_size=8).hexdigest()


def fingerprints_of_worlds(simulation: Simulation) -> dict[str, Any]:
    """``{"worlds": {"0": digest, ...}}``; empty if all replicas have the scenario's map."""
    if origin_of(simulation.scenario.map) is None:
        return {}
    return {KEY: {str(replica): world_fingerprint(simulation.map_of(replica)) for replica in simulation.replicas}}


def different_world(about: Mapping[str, Any], simulation: Simulation) -> str:
    """The fault, in words, if a replica's world is not that of the run of this ``run.json``; else empty."""
    then = about.get(KEY, {})
    now = fingerprints_of_worlds(simulation).get(KEY, {}) if then else {}
    others = [replica for replica, digest in then.items() if now.get(replica) != digest]
    if not others:
        return ""
    origin = origin_of(simulation.scenario.map)
    who = "the map" if origin is None else f"the generator {type(origin.generator).__name__}"
    return f"{who} gives replica {others[0]} another world than in that run; it has been changed since"
