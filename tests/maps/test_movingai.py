"""Maps and problems of the MovingAI benchmarks: a letter a cell, from the top; broken rows are named."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import amorsim as am
from amorsim.core.errors import MapError
from amorsim.core.maps.same_cells import have_same_cells
from amorsim.maps.movingai import MovingAI, read_problems
from tests.examples import settings

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps" / "movingai"
NAMES = ("16room_000", "arena", "den000d", "maze-32-32-4")
SMALL = "type octile\nheight 2\nwidth 3\nmap\n@.T\n.SW\n"


def written(folder: Path, text: str, name: str = "a.map") -> Path:
    path = folder / name
    path.write_text(text, newline="")
    return path


@pytest.mark.parametrize("name", NAMES)
def test_real_maps_cell_by_cell(name: str) -> None:
    path = MAPS / f"{name}.map"
    if not path.is_file():
        pytest.skip(f"no {path}")
    lines = path.read_text().split("\n")
    height, width = int(lines[1].split()[1]), int(lines[2].split()[1])
    free = np.array([[letter in ".GS" for letter in line] for line in lines[4 : 4 + height]])
    world = am.load_map(path, resolution=0.5)
    assert world.shape == (height, width)
    assert np.array_equal(world.to_array()[::-1] == 0, free)
    assert not world.warnings


@pytest.mark.parametrize(("name", "rows"), [*zip(NAMES, (1860, 160, 1260, 200), strict=True)])
def test_real_problems_are_on_free_cells(name: str, rows: int) -> None:
    path = MAPS / f"{name}.map.scen"
    if not path.is_file():
        pytest.skip(f"no {path}")
    free = am.load_map(MAPS / f"{name}.map", resolution=1.0).to_array() == 0
    problems = read_problems(path)
    assert len(problems) == rows
    for problem in problems:
        assert (problem.height, problem.width) == free.shape
        assert free[problem.start]
        assert free[problem.goal]
        # No path is shorter than the octile distance.
        far, near = sorted(abs(b - a) for a, b in zip(problem.start, problem.goal, strict=True))[::-1]
        assert problem.optimal >= far - near + math.sqrt(2) * near - 0.005
        assert problem.is_reachable


def test_the_first_row_is_the_top_one_and_options_say_what_is_passable(tmp_path: Path) -> None:
    path = written(tmp_path, SMALL)
    assert MovingAI().load(path).to_array().tolist() == [[0, 0, 1], [1, 0, 1]]
    assert MovingAI(swamp="occupied", water="free").load(path).to_array().tolist() == [[0, 1, 0], [1, 0, 1]]
    world = am.load_map(path)
    assert (world.resolution, world.source.loader.resolution) == (1.0, 1.0)
    assert "a cell is taken for 1 m" in world.warnings[0]


@pytest.mark.parametrize(
    "text",
    [
        SMALL.replace("\n", "\r\n"),
        "type octile\nwidth 3\nheight 2\n\nmap\n@.T  \n.SW",
        "\ufeff" + SMALL,
        SMALL + "\n\n",
    ],
)
def test_what_real_files_do(tmp_path: Path, text: str) -> None:
    world = MovingAI(resolution=1.0).load(written(tmp_path, text))
    assert world.to_array().tolist() == [[0, 0, 1], [1, 0, 1]]
    assert world.warnings == ()


def test_what_follows_the_rows_is_remarked_on(tmp_path: Path) -> None:
    world = MovingAI(resolution=1.0).load(written(tmp_path, SMALL + "...\n...\n"))
    assert world.warnings == ("line 7: what follows the 2 rows is left out",)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (SMALL.replace("@.T", "@.."[:2]), "line 5: the row has 2 cells; expected 3"),
        (SMALL.replace(".SW\n", ""), "line 6: the row has 0 cells; expected 3|line 5: the map ends after 1 rows"),
        (SMALL.replace(".SW", ".SWW"), "line 6: the row has 4 cells; expected 3"),
        (SMALL.replace(".SW", ".xW"), "line 6, column 2: 'x' is not a cell"),
        (SMALL.replace("height 2", "height -2"), "line 2: height is '-2'; expected a whole number above 0"),
        (SMALL.replace("height 2\n", ""), "no line 'height N'"),
        (SMALL.replace("map\n", "maps\n"), "line 4: 'maps' is none of: type octile"),
        (SMALL.replace("height 2", "height 999999999"), "expected 90000000 at most"),
        ("2D-Map\nLineMinPos: 1 2\n", "line 1: '2D-Map' is none of"),
        ("", "no line 'map'"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, text: str, words: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(MapError, match=words) as caught:
        MovingAI().load(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_sniff() -> None:
    assert MovingAI.sniff(SMALL.encode())
    assert not MovingAI.sniff(b"2D-Map\n")
    assert not MovingAI.sniff(b"typewriter octile\n")


def test_problems_count_rows_from_the_bottom(tmp_path: Path) -> None:
    path = written(
        tmp_path, "version 1\n0\tmaps/a b.map\t3\t2\t0\t1\t2\t0\t2.41421\n0\ta.map\t3\t2\t0\t1\t2\t0\t0\n", "a.scen"
    )
    first, second = read_problems(path)
    assert (first.start, first.goal, first.optimal, first.map) == ((0, 0), (1, 2), 2.41421, "maps/a b.map")
    assert first.is_reachable
    assert not second.is_reachable


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("0\ta\t3\t2\t0\t1\t2\t0", "line 2: a row has 8 columns"),
        ("0\ta\t3\t2\t0\t-1\t2\t0\t1", "line 2: '-1' is not a whole number"),
        ("0\ta\t3\t2\t0\t2\t2\t0\t1", "line 2: start or goal is outside the map"),
        ("0\ta\t3\t2\t0\t1\t2\t0\tnan", "line 2: 'nan' is not a length"),
    ],
)
def test_broken_rows_of_problems_are_named(tmp_path: Path, row: str, words: str) -> None:
    path = written(tmp_path, f"version 1\n{row}\n", "a.scen")
    with pytest.raises(MapError, match=words):
        read_problems(path)
    with pytest.raises(MapError, match="line 1: expected 'version 1'"):
        read_problems(written(tmp_path, row))


@settings(max_examples=60, deadline=None)
@given(
    cells=hnp.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9))),
    origin=st.tuples(*[st.floats(-50, 50)] * 3),
)
def test_any_cells_come_back(tmp_path_factory, cells, origin) -> None:
    path = tmp_path_factory.mktemp("maps") / "any.map"
    world = am.Map.from_array(cells, resolution=0.05, origin=origin)
    assert have_same_cells(am.save_map(world, path), world)
