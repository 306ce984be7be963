"""Mazes of EyeSim: walls by letters, starts by letters, broken lines named."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.core.errors import MapError
from amorsim.maps.maz import Maz
from tests.examples import settings

MAZE = " _ _ _\n|   | |\n| |_  |\n|S|___|\n360\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "a.maz"
    path.write_text(text, newline="")
    return path


def test_a_small_maze(tmp_path: Path) -> None:
    world = Maz().load(written(tmp_path, MAZE))
    side = 0.36
    assert world.size == pytest.approx((3 * side, 3 * side), abs=0.002)
    walls = {tuple(round(number / side) for number in wall) for wall in world.segments.tolist()}
    border = {(0, 3, 3, 3), (0, 0, 0, 3), (3, 0, 3, 3), (0, 0, 3, 0)}
    assert walls == border | {(1, 0, 1, 2), (2, 2, 2, 3), (1, 1, 2, 1)}
    assert world.start == pytest.approx((0.5 * side, 0.5 * side, math.pi / 2))
    assert world.warnings == ()


@pytest.mark.parametrize(
    ("letter", "degrees"), [("S", 90), ("u", 90), ("D", -90), ("l", 180), ("L", 180), ("R", 0), ("r", 0)]
)
def test_starts(tmp_path: Path, letter: str, degrees: float) -> None:
    world = Maz(cell=1.0, resolution=0.1).load(written(tmp_path, f" _\n|{letter}|\n| |\n"))
    assert math.degrees(world.start[2]) % 360 == pytest.approx(degrees % 360)
    assert world.start[:2] == (0.5, 1.5)
    assert world.occupied([(0.5, 1.0)])[0] == letter.isupper()


def test_the_size_of_a_cell(tmp_path: Path) -> None:
    assert Maz().load(written(tmp_path, " _\n|_|\n\x1d180\n")).size[0] == pytest.approx(0.18, abs=0.002)
    assert Maz().load(written(tmp_path, " _\n|_|\n")).size[0] == pytest.approx(0.36, abs=0.002)
    assert Maz().load(written(tmp_path, " _\r\n|_|\r\n180\r\n\r\n")).size[0] == pytest.approx(0.18, abs=0.002)
    assert Maz(cell=0.5).load(written(tmp_path, " _\n|_|\n180")).size[0] == pytest.approx(0.5, abs=0.002)


def test_a_second_start_is_remarked_on(tmp_path: Path) -> None:
    world = Maz().load(written(tmp_path, " _ _\n|s s|\n"))
    assert world.warnings == ("it has 2 starts; the robot is at the first",)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (" _\n|x|\n", "line 2, column 2: 'x' is none of a maze's"),
        (" _\n |_|\n", r"line 2, column 2: '\|' cannot be here"),
        (" _\n|_|\n0\n", "line 3: a cell is 0 mm"),
        ("", "no wall"),
        ("\n\n360", "no wall"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, text: str, words: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(MapError, match=words) as caught:
        Maz().load(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_sniff() -> None:
    assert Maz.sniff(MAZE.encode())
    assert not Maz.sniff(b"0 0 10 0\n0 0 10 0\n0 0 1 1\n")


@settings(max_examples=60, deadline=None)
@given(data=st.data(), rows=st.integers(1, 5), cols=st.integers(1, 6))
def test_any_walls(tmp_path_factory, data, rows, cols) -> None:
    """Every side of every cell, against what its letter says."""
    upright = [[data.draw(st.booleans()) for _ in range(cols + 1)] for _ in range(rows)]
    floors = [[data.draw(st.booleans()) for _ in range(cols)] for _ in range(rows + 1)]
    floors[0][-1] = floors[-1][0] = True  # or blanks at the ends would make it smaller
    lines = ["".join(" _"[0] + " _"[floor] for floor in floors[0])]
    for walls, below in zip(upright, floors[1:], strict=True):
        lines.append("".join(" |"[wall] + " _"[floor] for wall, floor in zip(walls, [*below, 0], strict=True)))
    path = written(tmp_path_factory.mktemp("maz"), "\n".join(lines) + "\n360\n")
    world = Maz(cell=1.0, resolution=0.125).load(path)
    assert world.size == (cols, rows)
    # A point a little inside of the middle of each side of a cell, so that it is in no other wall.
    for r in range(rows):
        places = [(min(max(c, 0.01), cols - 0.01), rows - r - 0.45) for c in range(cols + 1)]
        assert world.occupied(places).tolist() == upright[r]
    for r in range(rows + 1):
        places = [(c + 0.45, min(max(rows - r, 0.01), rows - 0.01)) for c in range(cols)]
        assert world.occupied(places).tolist() == floors[r]
