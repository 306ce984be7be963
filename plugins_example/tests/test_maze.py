"""The maze's squares in the world, and what is said of a bad file."""

import math
from pathlib import Path

import amorsim_example as example
import numpy as np
import pytest

import amorsim as am

TEXT = """\
####
#.^#
#
####
"""


@pytest.fixture
def maze(tmp_path: Path) -> Path:
    path = tmp_path / "small.maze"
    path.write_text(TEXT, encoding="utf-8")
    return path


def test_squares_are_where_they_are_drawn(maze: Path) -> None:
    found = example.Maze(resolution=2.0).load(maze)
    assert found.origin == (0.0, 0.0, 0.0)
    assert found.size == (8.0, 8.0)
    # Row 0 is the lowest; the third line of the text ends early, and is free from there on.
    expected = [[1, 1, 1, 1], [1, 0, 0, 0], [1, 0, 0, 1], [1, 1, 1, 1]]
    np.testing.assert_array_equal(found.to_array(), expected)
    assert found.start == (5.0, 5.0, math.pi / 2)
    assert found.name == "small.maze"


def test_rays_meet_the_walls(maze: Path) -> None:
    found = example.Maze(resolution=2.0).load(maze)
    ranges = found.cast_rays([[5.0, 5.0, 0.0]], np.array([0.0, 0.5, 1.0, 1.5]) * np.pi, 100.0)
    np.testing.assert_allclose(ranges, [[1.0, 1.0, 3.0, 3.0]])


@pytest.mark.parametrize(("character", "heading"), [(">", 0.0), ("<", math.pi), ("v", -math.pi / 2)])
def test_the_start_says_where_the_robot_looks(tmp_path: Path, character: str, heading: float) -> None:
    path = tmp_path / "a.maze"
    path.write_text(f"#.{character}\n", encoding="utf-8")
    assert example.Maze().load(path).start == (1.25, 0.25, heading)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"###\n#x#\n", r"line 2, character 2: expected '#', .* got 'x'"),
        (b"#>#\n#^#\n", r"line 1, character 2: a second start, '>'"),
        (b"", "the maze is empty"),
        (b"\n\n", "the maze is empty"),
        (b"\xff\xfe", "cannot be read as text"),
    ],
)
def test_a_bad_file_is_refused_with_the_place(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "bad.maze"
    path.write_bytes(content)
    with pytest.raises(am.MapError, match=message) as caught:
        example.Maze().load(path)
    assert str(path) in str(caught.value)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(am.MapError, match=r"none\.maze: cannot be read"):
        example.Maze().load(tmp_path / "none.maze")
