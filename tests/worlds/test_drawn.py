"""Worlds that replicas draw: a property of every kind, and digests of the cells of some replicas."""

from __future__ import annotations

import hashlib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.worlds.drawn import DrawnWorld, map_of
from tests.examples import settings
from tests.worlds.test_worlds import NAMES, PARAMETERS, check, make

# A parameter of each kind, and what it may be drawn from.
DRAWN = {
    "barn": ("fill", (0.1, 0.3)),
    "cave": ("fill", (0.2, 0.42)),
    "crossing": ("yards", (0.0, 1.0)),
    "forest": ("density", (0.0, 0.4)),
    "maze": ("loops", (0.0, 1.0)),
    "office": ("furniture", (0.0, 3.0)),
    "warehouse": ("empty", (0.0, 1.0)),
}
# Of the cells of replica 37 with seed 7 and the parameter drawn.
DIGESTS = {
    "barn": "91886f4702dcc7d3",
    "cave": "8c7d44272be6092d",
    "crossing": "366268b974e3b786",
    "forest": "bb102026436fb3b7",
    "maze": "2684d19921aa5e29",
    "office": "548ed4c7cea15032",
    "warehouse": "1b4d7c8c9c05fa3d",
}


def drawn(name: str, seed: int, options: dict[str, Any] | None = None) -> am.Map:
    parameter, ends = DRAWN[name]
    values = {**(options or {}), parameter: am.Distribution(kind="uniform", values=ends)}
    return make(name, {"seed": seed, "per": "replica", **values})


def replicas(name: str) -> st.SearchStrategy[tuple[am.Map, int]]:
    fixed = {key: value for key, value in PARAMETERS[name].items() if key != DRAWN[name][0]}
    options = st.fixed_dictionaries({}, optional=fixed)
    made = st.builds(lambda seed, some: drawn(name, seed, some), st.integers(0, 2**63 - 1), options)
    return st.tuples(made, st.integers(0, 2**32 - 2))


def check_replica(world: am.Map, replica: int) -> None:
    mine = map_of(world, replica)
    assert isinstance(mine.source, DrawnWorld)
    assert mine.source.replica == replica
    assert map_of(world, replica) == mine
    check(mine, mine.source.made().generator)


@pytest.mark.parametrize("name", NAMES)
def test_the_world_of_a_replica_is_free_and_connected(name: str) -> None:
    @settings(max_examples=3, deadline=None, derandomize=True, database=None)
    @given(of=replicas(name))
    def holds(of: tuple[am.Map, int]) -> None:
        check_replica(*of)

    holds()


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_the_worlds_of_many_replicas_are_free_and_connected(name: str) -> None:
    @settings(max_examples=200, deadline=None, database=None)
    @given(of=replicas(name))
    def holds(of: tuple[am.Map, int]) -> None:
        check_replica(*of)

    holds()


@pytest.mark.parametrize("name", NAMES)
def test_a_replica_has_the_same_cells_on_every_machine(name: str) -> None:
    world = map_of(drawn(name, 7), 37)
    assert hashlib.sha256(world.to_array().tobytes()).hexdigest()[:16] == DIGESTS[name]
