"""Line worlds: every statement, every fault, and frames against complex arithmetic."""

from __future__ import annotations

import cmath
import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.maps.wld import Wld
from amorsim.maps.wld_statements import parse_world
from tests.examples import settings


def walls(text: str, **options: str) -> list[list[float]]:
    """The walls [m] of a text that warns of nothing."""
    world = parse_world(text, **options)
    assert world.warnings == ()
    return world.segments.tolist()


# ------------------------------------------------------------------------------------------ statements


def test_wall_is_in_metres() -> None:
    assert walls("0 100 2500 -40") == [[0.0, 0.1, 2.5, -0.04]]


@pytest.mark.parametrize(
    "line",
    [
        "1 2 3 4",
        "  1\t2   3 4 \t ",
        "1 2 3 4;5 6",
        "1 2 3 4 # a wall",
        "1.0 2. 3e0 +4",
        "1 2 3 4 50 2000",
        "1 2 3 4 0 0",
        "1 2 3 4 50 2000 7",
        "1 2 3 4 50 2000 255 128 0",
    ],
)
def test_wall_spellings(line: str) -> None:
    assert walls(line) == [[0.001, 0.002, 0.003, 0.004]]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_blank_lines_and_comments(end: str) -> None:
    text = end.join(["; a world", "", "# another", " \t", "0 0 1 0", "0 0 0 1", ""])
    assert len(walls(text)) == 2


def test_a_missing_last_line_end_loses_nothing() -> None:
    assert walls("0 0 1 0\n0 0 0 1") == [[0, 0, 0.001, 0], [0, 0, 0, 0.001]]


@pytest.mark.parametrize("text", ["width 3000\nheight 2000", "height 2000\nwidth 3000", "floor 3000 2000"])
def test_size_is_the_extent(text: str) -> None:
    world = parse_world(text)
    assert world.extent == (0.0, 0.0, 3.0, 2.0)
    assert world.segments.shape == (0, 4)


def test_extent_takes_in_walls_outside_the_size() -> None:
    assert parse_world("width 3000\nheight 2000\n-500 100 100 2600").extent == (-0.5, 0.0, 3.0, 2.6)


def test_extent_without_a_size_is_that_of_the_walls() -> None:
    assert parse_world("500 100 900 2600").extent == (0.5, 0.1, 0.9, 2.6)


def test_width_alone_says_nothing_of_the_height() -> None:
    assert parse_world("width 2000\n500 100 900 300").extent == (0.0, 0.1, 2.0, 0.3)
    with pytest.raises(MapError, match="no wall, and no width and height"):
        parse_world("width 2000")


def test_width_and_height_come_before_floor() -> None:
    assert parse_world("floor 9 9\nwidth 3000\nheight 2000\nfloor 8 8").extent == (0.0, 0.0, 3.0, 2.0)


def test_origin_is_the_lower_left_corner_of_the_size() -> None:
    world = parse_world("origin -1000 500\nwidth 3000\nheight 2000\n0 600 100 600")
    assert world.extent == (-1.0, 0.5, 2.0, 2.5)
    assert world.segments.tolist() == [[0.0, 0.6, 0.1, 0.6]]


def test_floor_texture_is_passed_over() -> None:
    assert walls("floor_texture my pictures/wood.png\n0 0 1 0") == [[0, 0, 0.001, 0]]


def test_position_is_anticlockwise() -> None:
    world = parse_world("width 3000\nheight 2000\nposition 1500 250 90")
    assert world.start == (1.5, 0.25, math.pi / 2)


def test_no_position_is_no_start() -> None:
    assert parse_world("0 0 1 0").start is None


def test_heading_is_the_half_turn_it_is() -> None:
    for degrees, heading in [
        (180, math.pi),
        (-180, math.pi),
        (540, math.pi),
        (-90, -math.pi / 2),
        (270, -math.pi / 2),
    ]:
        assert parse_world(f"width 9\nheight 9\nposition 0 0 {degrees}").start == (0.0, 0.0, heading)


# -------------------------------------------------------------------------------------------- frames


def test_push_turns_clockwise() -> None:
    assert walls("push 1000 2000 90\n0 0 500 0") == [[1.0, 2.0, 1.0, 1.5]]


def test_push_turns_anticlockwise_when_set() -> None:
    assert walls("push 1000 2000 90\n0 0 500 0", push_sign="anticlockwise") == [[1.0, 2.0, 1.0, 2.5]]


def test_push_composes_with_rotation() -> None:
    # The second frame is 300 mm along the first one's x axis, which points down.
    assert walls("push 1000 2000 90\npush 300 0 -90\n0 0 500 0") == [[1.0, 1.7, 1.5, 1.7]]


def test_pop_goes_back_one_frame() -> None:
    text = "push 1000 0 0\npush 0 1000 30\npop\n0 0 1 0\npop\n0 0 1 0"
    assert walls(text) == [[1.0, 0, 1.001, 0], [0, 0, 0.001, 0]]


def test_right_angles_are_exact() -> None:
    turns = "push 0 0 90\n" * 4 + "push 0 0 -450\n" + "3 0 7 0"
    assert walls(turns) == [[0.0, 0.003, 0.0, 0.007]]


def test_position_is_in_the_current_frame() -> None:
    world = parse_world("width 3000\nheight 3000\npush 1000 2000 90\nposition 500 100 30")
    assert world.start is not None
    assert_allclose(world.start, (1.1, 1.5, math.radians(-60)), atol=1e-15)


def test_frames_open_at_the_end_are_fine() -> None:
    assert len(walls("push 0 0 5\npush 0 0 5\n0 0 1 1")) == 1


def test_pop_without_push_warns() -> None:
    world = parse_world("0 0 1 1\npop\n0 0 2 2")
    assert len(world.segments) == 2
    assert world.warnings == ("line 2: left out 'pop': there is no push to undo",)


def test_words_after_a_pop_do_not_keep_the_frame() -> None:
    world = parse_world("push 1000 0 0\npop now\n0 0 1 1")
    assert world.segments.tolist() == [[0, 0, 0.001, 0.001]]
    assert "line 2" in world.warnings[0]
    assert "'now'" in world.warnings[0]


# ------------------------------------------------------------------------------------------ artifacts


@pytest.mark.parametrize("line", ["WALL 1000 500 90 400", "WALL (7) 1000 500 90 400", "wall 7 1000 500 90 400"])
def test_artifact_wall(line: str) -> None:
    assert walls(line) == [[1.0, 0.3, 1.0, 0.7]]


def test_artifact_corridor_is_two_walls() -> None:
    assert walls("CORRIDOR (1) 1000 500 90 400 200") == [[1.1, 0.3, 1.1, 0.7], [0.9, 0.3, 0.9, 0.7]]


def test_artifact_doors_and_junctions_block_nothing() -> None:
    assert walls("WALL 0 0 0 2\nDOOR (1) 1000 500 90 900\nJUNCTION (2) 1 2 3 4") == [[-0.001, 0, 0.001, 0]]


# ------------------------------------------------------------------------------------------- warnings


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("ush 500 0 -5", "Did you mean 'push'"),
        ("5000 0 0", "4, 6, 7 or 9 numbers, not 3"),
        ("1 2 3 4 5", "not 5"),
        ("1 2 3 4 5 6 7 8", "not 8"),
        ("1 2 3 x", "'x' is not a number"),
        ("1 2 3 4 5_0 6", "'5_0' is not a number"),
        ("١ ٢ ٣ ٤", "not a statement"),
        ("width", "expected WIDTH, got 0 numbers"),
        ("width 5 6", "got 2 numbers"),
        ("width 0", "more than 0"),
        ("height -5", "more than 0"),
        ("floor 0 5", "more than 0"),
        ("push 1 2", "expected X Y TH"),
        ("position 1 2 east", "'east' is not a number"),
        ("origin 1", "expected X Y"),
        ("WALL 1 2 3", "expected X Y TH LENGTH"),
        ("CORRIDOR (2) 1 2 3 4", "expected X Y TH LENGTH WIDTH"),
        ('include "other.wld"', "not a statement"),
    ],
)
def test_what_cannot_be_read_is_left_out_and_said(line: str, reason: str) -> None:
    world = parse_world(f"0 0 100 0\n{line}\t; comment\n0 0 0 100")
    assert world.segments.tolist() == [[0, 0, 0.1, 0], [0, 0, 0, 0.1]]
    assert world.start is None
    (warning,) = world.warnings
    assert warning.startswith(f"line 2: left out {line!r}: ")
    assert reason in warning


def test_a_second_size_or_place_replaces_the_first_and_is_said() -> None:
    world = parse_world(
        "width 10\nheight 10\norigin 0 0\nposition 1 1 0\nwidth 40\nheight 50\norigin 1 2\nposition 3 4 0"
    )
    assert world.extent == (0.001, 0.002, 0.041, 0.052)
    assert world.start == (0.003, 0.004, 0.0)
    assert [warning.split(":")[0] for warning in world.warnings] == ["line 5", "line 6", "line 7", "line 8"]


def test_a_position_outside_is_said() -> None:
    world = parse_world("width 1000\nheight 1000\nposition 500 1500 0")
    assert world.start == (0.5, 1.5, 0.0)
    assert world.warnings == ("the position (0.5 m, 1.5 m) is outside the world",)


# --------------------------------------------------------------------------------------------- errors


@pytest.mark.parametrize("number", ["nan", "inf", "-inf", "Infinity", "1e999", "-1e400", "1e13"])
@pytest.mark.parametrize("line", ["0 0 {} 0", "push 0 {} 0", "position 0 0 {}", "width {}", "WALL 0 0 0 {}"])
def test_numbers_that_are_not_finite_are_refused_by_line(line: str, number: str) -> None:
    with pytest.raises(MapError, match=rf"line 2: '{re.escape(number)}'.*finite"):
        parse_world("0 0 1 1\n" + line.format(number))


def test_pushes_piled_up_to_infinity_are_refused() -> None:
    with pytest.raises(MapError, match="farther out"):
        parse_world("push 9e11 0 0\n" * 2 + "0 0 1 1")


@pytest.mark.parametrize("text", ["", "; nothing\n", "push 0 0 0\npop", "position 0 0 0", "Dear Sir or Madam"])
def test_neither_wall_nor_size_is_an_error(text: str) -> None:
    with pytest.raises(MapError, match="no wall, and no width and height"):
        parse_world(text)


def test_the_error_for_another_kind_of_text_says_what_was_not_understood() -> None:
    with pytest.raises(MapError, match=r"2 lines could not be read; line 1: left out 'type octile'"):
        parse_world("type octile\nmap")


def test_push_sign_is_checked() -> None:
    with pytest.raises(MapError, match="clockwise"):
        parse_world("0 0 1 1", push_sign="clock")
    with pytest.raises(ParameterError, match="push_sign"):
        Wld(push_sign="clock")


# -------------------------------------------------------------------------------------------- loading


def test_load_draws_cells(tmp_path: Path) -> None:
    path = tmp_path / "box.wld"
    path.write_text("width 40\nheight 30\n10 10 20 10\nposition 5 5 90\nfoo")
    loaded = Wld(resolution=0.01).load(path)
    assert isinstance(loaded, Map)
    assert loaded.shape == (3, 4)
    assert loaded.name == "box"
    assert loaded.start == (0.005, 0.005, math.pi / 2)
    assert len(loaded.warnings) == 1
    assert loaded.segments is not None
    assert loaded.segments.tolist() == [[0.01, 0.01, 0.02, 0.01]]
    # A line on the border of two rows of cells touches both.
    assert loaded.to_array()[:, 1].tolist() == [1, 1, 0]


def test_default_cells_are_a_millimetre(tmp_path: Path) -> None:
    path = tmp_path / "box.wld"
    path.write_text("width 40\nheight 30")
    assert Wld().load(path).shape == (30, 40)


@pytest.mark.parametrize(
    "data",
    [
        "; Büro\n0 0 9 0".encode(),
        "; Büro\n0 0 9 0".encode("latin-1"),
        b"\xef\xbb\xbf0 0 9 0\r\n",
        b"0 0 9 0\x1a",
        b"; \x85 \xff\n0 0 9 0\n",
    ],
)
def test_texts_in_old_and_new_encodings(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "a.wld"
    path.write_bytes(data)
    loaded = Wld().load(path)
    assert loaded.segments is not None
    assert loaded.segments.tolist() == [[0, 0, 0.009, 0]]
    assert loaded.warnings == ()


@pytest.mark.parametrize("data", [b"0 0 9 0\n\x00", b"\x89PNG\r\n\x1a\n\x00", "0 0 9 0".encode("utf-16")])
def test_binary_files_are_refused(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "a.wld"
    path.write_bytes(data)
    with pytest.raises(MapError, match=r"a\.wld: byte \d+ is 0x..: this is not a text"):
        Wld().load(path)


def test_errors_name_the_file(tmp_path: Path) -> None:
    with pytest.raises(MapError, match=r"none\.wld: cannot be read"):
        Wld().load(tmp_path / "none.wld")
    with pytest.raises(MapError, match="cannot be read"):
        Wld().load(tmp_path)
    path = tmp_path / "empty.wld"
    path.write_text("")
    with pytest.raises(MapError, match=r"empty\.wld: it has no wall"):
        Wld().load(path)


def test_a_world_too_large_for_its_cells_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "vast.wld"
    path.write_text("width 1e12\nheight 1e12\n0 0 1e12 1e12")
    with pytest.raises(MapError, match=r"vast\.wld: "):
        Wld().load(path)


@pytest.mark.parametrize(
    ("head", "is_world"),
    [
        (b"; EyeBot\n\nwidth 500 ;BIGW\n", True),
        (b"floor 5 5\n", True),
        (b"0 0 0 500 10 20\n", True),
        (b"CORRIDOR (1) 0 0 0 5 5", True),
        (b"; only a comment", False),
        (b"", False),
        (b"2D-Map\n", False),
        (b"type octile\nheight 5\n", False),
        (b"image: a.pgm\nresolution: 0.05\n", False),
        (b"P5\n4 4\n255\n", False),
        (b"BM\x00\x00", False),
        (b"0 0 0 5\n\x00", False),
        (b"1 2 3", False),
    ],
)
def test_sniff(head: bytes, is_world: bool) -> None:
    assert Wld.sniff(head) is is_world


# ---------------------------------------------------------------------------------------- round trips

coordinates = st.integers(-9_999_999, 9_999_999) | st.floats(-1e7, 1e7, allow_subnormal=False).map(
    lambda value: round(value, 3)
)
frames = st.tuples(coordinates, coordinates, st.floats(-720, 720).map(lambda value: round(value, 2)))
statements = st.lists(
    st.tuples(st.just("wall"), st.tuples(coordinates, coordinates, coordinates, coordinates))
    | st.tuples(st.just("push"), frames)
    | st.tuples(st.just("position"), frames)
    | st.tuples(st.just("pop"), st.just(())),
    max_size=30,
)
noise = st.sampled_from(["", "  ; 1 2 3 4", "\t# push", " ", "\t"])


@given(statements, st.data())
def test_what_is_written_is_read(parts: list[tuple[str, tuple[float, ...]]], data: st.DataObject) -> None:
    """Against frames as products of complex numbers, an arithmetic of its own."""
    lines = ["width 5000", "height 4000"]
    stack = [(0j, 1 + 0j)]
    expected, start = [], None
    for word, numbers in parts:
        if word == "pop" and len(stack) == 1:
            continue
        gap = data.draw(st.sampled_from([" ", "\t", "   "]))
        words = [repr(number) for number in numbers]
        lines.append(gap.join(words if word == "wall" else [word, *words]) + data.draw(noise))
        offset, turn = stack[-1]
        if word == "wall":
            ends = [offset + turn * complex(*numbers[i : i + 2]) for i in (0, 2)]
            expected.append([part / 1000 for end in ends for part in (end.real, end.imag)])
        elif word == "push":
            stack.append((offset + turn * complex(*numbers[:2]), turn * cmath.rect(1, -math.radians(numbers[2]))))
        elif word == "position":
            place = offset + turn * complex(*numbers[:2])
            start = (place.real / 1000, place.imag / 1000, turn * cmath.rect(1, math.radians(numbers[2])))
        else:
            stack.pop()
    world = parse_world(data.draw(st.sampled_from(["\n", "\r\n", "\n\n"])).join(lines))
    assert_allclose(world.segments, np.reshape(expected, (-1, 4)), rtol=1e-12, atol=1e-7)
    assert (world.start is None) == (start is None)
    if start is not None and world.start is not None:
        assert_allclose(world.start[:2], start[:2], rtol=1e-12, atol=1e-7)
        assert abs(cmath.rect(1, world.start[2]) - start[2]) < 1e-9
        assert -math.pi < world.start[2] <= math.pi
    every = np.concatenate((world.segments.reshape(-1, 2), [(0, 0), (5, 4)]))
    assert world.extent == (*every.min(axis=0), *every.max(axis=0))
    assert all("replaces" in warning or "outside" in warning for warning in world.warnings)


@given(st.lists(st.tuples(*[st.integers(0, 30_000)] * 4), min_size=1))
def test_whole_millimetres_in_no_frame_are_read_to_the_last_bit(rows: list[tuple[int, ...]]) -> None:
    world = parse_world("\n".join(" ".join(map(str, row)) for row in rows))
    assert_array_equal(world.segments, np.array(rows) / 1000)


KNOWN = ("width", "height", "origin", "position", "push", "pop", "floor", "WALL", "CORRIDOR", "DOOR")
words = st.sampled_from([*KNOWN, ";", "#", "nan", "1e999", "-5", "0", "7", "2500", "(1)", "\n", "\t"])


@settings(max_examples=300)
@given(st.binary(max_size=200) | st.lists(words, max_size=60).map(lambda found: " ".join(found).encode()))
def test_any_bytes_make_a_map_or_a_map_error(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.wld"
    path.write_bytes(data)
    Wld.sniff(data)
    try:
        loaded: Map | MapError = Wld(resolution=0.01).load(path)
    except MapError as error:
        loaded = error
    assert isinstance(loaded, Map) or "any.wld: " in str(loaded)
