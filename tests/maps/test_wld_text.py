"""Walls drawn, moved and deleted in the text of a line world."""

from __future__ import annotations

from importlib import resources

import numpy as np
import pytest

from amorsim.core.errors import MapError
from amorsim.maps.wld_statements import parse_world
from amorsim.maps.wld_text import with_walls

FRAMES = "\r\n".join(
    (
        "width 9000",
        "0 0 1000 0 ; south",
        "push 1000 2000 90",
        "  0 0 500 0 3 4",
        "pop",
        "CORRIDOR 4000 4000 0 1000 600",
        "",
    )
)
OFFICE = resources.files("amorsim.scenarios").joinpath("office.wld").read_text()


def walls(text: str) -> list[list[float]]:
    return parse_world(text).segments.round(9).tolist()


def test_a_new_wall_is_one_more_line() -> None:
    text = with_walls(OFFICE, add=[[1.0, 2.0, 3.5, 2.0]])
    assert text == OFFICE + "1000 2000 3500 2000\n"
    assert walls(text)[-1] == [1.0, 2.0, 3.5, 2.0]


def test_a_new_wall_stands_outside_of_frames_that_are_open() -> None:
    text = with_walls("0 0 1000 0\npush 1000 2000 90\n0 0 500 0", add=[[1.0, 2.0, 3.0, 2.0]])
    assert text == "0 0 1000 0\n1000 2000 3000 2000\npush 1000 2000 90\n0 0 500 0"
    assert [1.0, 2.0, 3.0, 2.0] in walls(text)
    assert with_walls("0 0 1 0", add=[[1.0, 0.0, 1.0, 1.0]]) == "0 0 1 0\n1000 0 1000 1000\n"


@pytest.mark.parametrize("number", range(4))
def test_a_wall_moves_in_its_line_and_in_its_frame(number: int) -> None:
    before = walls(FRAMES)
    other = [0.5, 0.25, 7.0, 3.0]
    text = with_walls(FRAMES, change={number: other})
    assert walls(text)[: number + 1] == [*before[:number], other]
    assert sorted(walls(text)) == sorted([*before[:number], other, *before[number + 1 :]])
    if number < 2:
        kept = [line for line in text.split("\r\n") if line in FRAMES.split("\r\n")]
        assert len(kept) == len(FRAMES.split("\r\n")) - 1
        assert text.split("\r\n")[3 if number else 1].endswith(" 3 4" if number else " ; south")


@pytest.mark.parametrize("number", range(4))
def test_a_wall_that_is_removed_is_gone_and_no_other(number: int) -> None:
    before = walls(FRAMES)
    assert sorted(walls(with_walls("height 9\n" + FRAMES, remove=[number]))) == sorted(
        before[:number] + before[number + 1 :]
    )


def test_every_wall_of_the_office_can_be_changed_and_changed_back() -> None:
    world = parse_world(OFFICE)
    shifted = {n: (wall + 1.0).tolist() for n, wall in enumerate(world.segments)}
    there = with_walls(OFFICE, change=shifted)
    np.testing.assert_allclose(parse_world(there).segments, world.segments + 1.0, atol=1e-6)
    assert with_walls(OFFICE) == OFFICE


def test_a_world_without_walls_and_size_is_refused() -> None:
    with pytest.raises(MapError, match="no wall"):
        with_walls("0 0 1 0", remove=[0])
