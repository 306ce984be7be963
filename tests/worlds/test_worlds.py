"""Generated worlds: free at the start, connected for the robot, the same for the same seed, and clear in refusals."""

from __future__ import annotations

import hashlib
import inspect
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

import amorsim as am
from amorsim.core.maps.footprint_room import wall_gaps
from amorsim.plugins.manager import make_registry
from amorsim.worlds.cells import CellWorld
from amorsim.worlds.made import MadeWorld, make_world
from tests.examples import settings

Options = dict[str, Any]

# Of the cells of the world with seed 7 and all parameters as they come.
DIGESTS = {
    "barn": "db0f4dd828b9ddeb",
    "cave": "05e6c414beb9fa70",
    "crossing": "71bd0c9a5edba7b4",
    "forest": "40f2fc26307665ca",
    "maze": "b269ab19d17b5aef",
    "office": "da7f05b64426cd7e",
    "warehouse": "292f9a6b6d1dde7f",
}


def number(low: float, high: float) -> st.SearchStrategy[float]:
    return st.integers(0, 20).map(lambda step: low + (high - low) * step / 20)


SIZES = st.tuples(number(8.0, 22.0), number(8.0, 18.0))
# Within what the generators can do: every one of these must give a world.
PARAMETERS: dict[str, dict[str, st.SearchStrategy[Any]]] = {
    "office": {"size": SIZES, "door": number(0.9, 1.3), "furniture": number(0.0, 3.0), "side_doors": number(0.0, 1.0)},
    "maze": {"size": SIZES, "corridor": number(0.9, 2.0), "wall": number(0.05, 0.5), "loops": number(0.0, 1.0)},
    "cave": {"size": SIZES, "fill": number(0.2, 0.42), "grain": number(0.3, 0.8)},
    "forest": {"size": SIZES, "density": number(0.0, 0.4)},
    "warehouse": {"size": SIZES, "aisle": number(0.9, 2.0), "empty": number(0.0, 1.0), "block": st.integers(1, 5)},
    "crossing": {
        "size": st.tuples(number(14.0, 22.0), number(14.0, 18.0)),
        "street": number(0.9, 2.5),
        "yards": number(0.0, 1.0),
        "across": st.integers(1, 3),
    },
    "barn": {"fill": number(0.1, 0.35), "rounds": st.integers(0, 4), "clearance": number(0.15, 0.35)},
}
NAMES = sorted(PARAMETERS)


def made(name: str) -> st.SearchStrategy[Options]:
    return st.fixed_dictionaries({"seed": st.integers(0, 2**63 - 1)}, optional=PARAMETERS[name])


def generator_of(world: am.Map) -> CellWorld:
    assert isinstance(world.source, MadeWorld)
    assert isinstance(world.source.generator, CellWorld)
    return world.source.generator


def free_places(world: am.Map, clearance: float) -> np.ndarray:
    """Cells whose middle is at least so far [m] from each occupied cell and from the border: a plain twin."""
    side = world.resolution
    padded = np.pad(world.to_array() != 0, 1, constant_values=True)
    reach = math.ceil(clearance / side) + 1
    steps = np.maximum(np.abs(np.arange(-reach, reach + 1)) - 0.5, 0.0)
    near = (steps[:, None] ** 2 + steps[None, :] ** 2) < (clearance / side) ** 2
    return ~ndimage.binary_dilation(padded, near, border_value=1)[1:-1, 1:-1]


def check(world: am.Map, generator: CellWorld | None = None) -> None:
    clearance = (generator or generator_of(world)).clearance
    places = free_places(world, clearance + world.resolution / 2)
    _, parts = ndimage.label(places)
    assert parts == 1
    assert world.start is not None
    x, y, _ = world.start
    assert places[int(y / world.resolution), int(x / world.resolution)]
    # The engine's own test for a round robot, at the start and at some of the other places.
    rows, cols = np.nonzero(places)
    some = slice(None, None, max(1, len(rows) // 50))
    poses = np.column_stack((cols[some] + 0.5, rows[some] + 0.5, np.zeros(len(rows[some])))) * world.resolution
    poses = np.vstack(([[x, y, 0.0]], poses))
    disc = am.Shape.circle(clearance)
    assert (wall_gaps(world, [disc] * len(poses), poses)[0] >= 0.0).all()


def make(name: str, options: Options) -> am.Map:
    maker: Callable[..., am.Map] = getattr(am.worlds, name)
    return maker(**options)


@pytest.mark.parametrize("name", NAMES)
def test_a_world_is_free_at_its_start_and_connected(name: str) -> None:
    @settings(max_examples=6, deadline=None, derandomize=True, database=None)
    @given(options=made(name))
    def holds(options: Options) -> None:
        check(make(name, options))

    check(make(name, {}))
    holds()


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_many_worlds_are_free_at_their_start_and_connected(name: str) -> None:
    @settings(max_examples=400, deadline=None, database=None)
    @given(options=made(name))
    def holds(options: Options) -> None:
        check(make(name, options))

    holds()


# Tiny ones, long and thin ones, and robots that are wide for the streets, doors and corridors as they come.
EDGES: list[Options] = [
    {"size": (0.05, 0.05)},
    {"size": (0.7, 0.7)},
    {"size": (2.0, 2.0)},
    {"size": (0.9, 30.0)},
    {"size": (30.0, 0.9)},
    {"size": (30.0, 3.0)},
    {"size": (6.0, 25.0)},
    {"clearance": 0.01},
    {"clearance": 0.6},
    {"clearance": 100.0},
]


def made_or_refused(name: str, options: Options) -> am.Map | str:
    try:
        return make(name, options)
    except am.MapError as error:
        return str(error)


@pytest.mark.parametrize("name", NAMES)
def test_at_the_edges_a_world_is_connected_or_refused(name: str) -> None:
    found = [made_or_refused(name, {"seed": seed, **options}) for seed, options in enumerate(EDGES)]
    for world in found:
        if isinstance(world, str):
            assert "size" in world or "clearance" in world
        else:
            check(world)
    assert sum(isinstance(world, am.Map) for world in found) > 1


def test_a_size_that_holds_no_robot_is_named() -> None:
    for size in ((0.5, 0.5), (0.75, 20.0)):
        with pytest.raises(
            am.MapError, match=r"size is .*; a cave for a robot with a clearance of 0.35 m needs at least \(1, 1\) m"
        ):
            am.worlds.cave(1, size=size)


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_gives_the_same_cells_on_every_machine(name: str) -> None:
    world = make(name, {"seed": 7})
    assert hashlib.sha256(world.to_array().tobytes()).hexdigest()[:16] == DIGESTS[name]
    assert make_world(world.source) == world
    assert make(name, {"seed": 8}) != world


def test_a_cave_without_room_is_drawn_again() -> None:
    check(make("cave", {"seed": 585721, "size": (8.0, 8.0)}))


def test_every_generator_has_a_function_and_a_test() -> None:
    assert sorted(DIGESTS) == NAMES == list(make_registry(entry_points=[]).names("world_generator"))
    for name in NAMES:
        assert inspect.isfunction(getattr(am.worlds, name))


REFUSED = [
    ("office", {"door": 0.6}, "door is 0.6 m, but a robot with a clearance of 0.35 m needs 0.8 m"),
    ("office", {"corridor": 0.5}, "corridor is 0.5 m"),
    ("office", {"size": (3.0, 2.0)}, "needs at least"),
    ("office", {"size": (10_000.0, 10_000.0)}, "coarser resolution"),
    ("office", {"corridr": 1.0}, "Did you mean 'corridor'"),
    ("office", {"corridor": -1.0}, "corridor: expected a number"),
    ("maze", {"corridor": 0.5}, "corridor is 0.5 m"),
    ("maze", {"size": (1.0, 1.0)}, "a maze of one cell needs at least"),
    ("cave", {"fill": 0.8}, "fill = 0.8 leaves less than 10% of the area"),
    ("forest", {"density": 50.0}, "50 per m\\^2 is too high: .* 0.1 m cannot lie side by side"),
    ("forest", {"density": 28.0}, "28 per m\\^2 is too high: .* found a place that no other has"),
    ("forest", {"density": 2.0, "largest_radius": 0.11}, "the trunks part the forest"),
    ("forest", {"least_radius": 0.5}, "swap them"),
    ("warehouse", {"aisle": 0.3}, "aisle is 0.3 m"),
    ("warehouse", {"size": (3.0, 3.0)}, "needs at least"),
    ("crossing", {"street": 0.3}, "street is 0.3 m"),
    ("crossing", {"across": 50}, "50 streets across 2 needs at least"),
    ("barn", {"size": (0.8, 9.5)}, "a field needs a width"),
    ("barn", {"clearance": 3.0}, "approach is 2.5 m"),
]


@pytest.mark.parametrize(("name", "options", "words"), REFUSED)
def test_what_cannot_be_is_refused_in_words(name: str, options: Options, words: str) -> None:
    with pytest.raises(am.MapError, match=words):
        make(name, options)


def test_furniture_bars_no_room() -> None:
    """Were a room barred, all of it would be filled in; furniture covers far less."""
    for seed in range(20):
        bare, full = am.worlds.office(seed, furniture=0.0), am.worlds.office(seed, furniture=5.0, side_doors=0.0)
        assert bare.to_array().mean() < 0.1
        assert full.to_array().mean() < 0.35


def test_loops_open_walls() -> None:
    perfect, open_ = am.worlds.maze(3), am.worlds.maze(3, loops=1.0)
    assert open_.to_array().sum() < perfect.to_array().sum()


def test_a_barn_leads_from_the_start_to_the_other_end() -> None:
    for seed in range(10):
        world = am.worlds.barn(seed, fill=0.4)
        assert not world.occupied([(2.25, 9.0)])[0]
        assert not world.occupied([world.start[:2]])[0]
        assert world.start[1] < 2.5
