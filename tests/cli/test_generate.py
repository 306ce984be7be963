"""amorsim generate: a world in a file, the same one for the same seed, and nothing overwritten."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.core.maps.same_cells import have_same_cells
from amorsim.worlds.drawn import map_of
from tests.cli.conftest import Command


def test_a_world_is_written_as_the_ending_says(amorsim: Command, tmp_path: Path) -> None:
    result = amorsim("generate", "maze", "--seed", 3, "--size", 6, 5, "--set", "loops=0.5", "-o", "maze.yaml")
    assert (result.status, result.err) == (0, "")
    assert result.out.startswith("maze.yaml: 120 x 100 cells of 0.05 m; read back, the cells are the same")
    world = am.worlds.maze(3, size=(6.0, 5.0), loops=0.5)
    assert have_same_cells(am.load_map(tmp_path / "maze.yaml"), world)


def test_a_file_that_is_there_is_replaced_by_force_alone(amorsim: Command, tmp_path: Path) -> None:
    arguments = ("generate", "maze", "--size", 6, 5, "-o", "maze.wld")
    assert amorsim(*arguments).status == 0
    before = (tmp_path / "maze.wld").read_bytes()
    result = amorsim(*arguments, "--seed", 5)
    assert result.status == 2
    assert result.err.endswith("maze.wld is there already; --force replaces it\n")
    assert (tmp_path / "maze.wld").read_bytes() == before
    assert amorsim(*arguments, "--seed", 5, "--force").status == 0
    assert (tmp_path / "maze.wld").read_bytes() != before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("offic", "-o", "a.png"), "Did you mean 'office'?"),
        (("office", "-o", "a.png", "--set", "corridr=2"), "Did you mean 'corridor'?"),
        (("office", "-o", "a.png", "--set", "door=0.4"), "door is 0.4 m"),
        (
            ("maze", "-o", "a.png", "--size", "0", "3"),
            "size=[0.0, 3.0]: size: expected a list of 2, each a number [m] > 0 and <= 10000, got 0.0",
        ),
        (("maze", "-o", "a.png", "--size", "nan", "3"), "size=[nan, 3.0]: size: expected a list of 2"),
        (("office", "-o", "a.xyz"), "no map can be written with this extension"),
    ],
)
def test_a_mistake_is_said_in_words(amorsim: Command, tmp_path: Path, arguments: tuple[str, ...], words: str) -> None:
    result = amorsim("generate", *arguments)
    assert result.status == 2
    assert words in result.err
    assert not list(tmp_path.glob("a.*"))


def test_the_world_of_a_replica_is_written(amorsim: Command, tmp_path: Path) -> None:
    result = amorsim("generate", "forest", "--size", 6, 5, "--seed", 3, "--replica", 5, "-o", "forest.png")
    assert result.status == 0, result.err
    world = am.worlds.forest(3, per="replica", size=(6.0, 5.0))
    written = am.load_map(tmp_path / "forest.png", resolution=0.05)
    assert have_same_cells(written, map_of(world, 5))
    assert not have_same_cells(written, world)
