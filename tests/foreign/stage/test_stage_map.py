"""The walls of Stage worlds: bitmaps over their sizes, boundaries, models that overlap, and how large the map is."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import amorsim as am
from amorsim.core.errors import MapError
from amorsim.foreign.stage.bitmaps import dark_pixels, fill
from amorsim.foreign.stage.geometry import Box, Spot
from amorsim.foreign.stage.map import StageMap
from tests.examples import settings


def bitmap(folder: Path, rows: list[str], name: str = "plan.png") -> Path:
    """A picture of '#' for dark, the first row at the top."""
    pixels = np.array([[0 if pixel == "#" else 255 for pixel in row] for row in rows], dtype=np.uint8)
    Image.fromarray(pixels).save(folder / name)
    return folder / name


def test_a_bitmap_is_stretched_over_its_size_about_its_pose(write, tmp_path) -> None:
    bitmap(tmp_path, ["#..", "..."])
    path = write('floorplan( boundary 0 bitmap "plan.png" size [3 2 1] pose [10 5 0 0] )\nresolution 0.5')
    world = StageMap().load(path)
    assert world.size == (3.0, 2.0)
    assert world.origin == (8.5, 4.0, 0.0)
    assert world.to_array().tolist() == [[0] * 6, [0] * 6, [1, 1, 0, 0, 0, 0], [1, 1, 0, 0, 0, 0]]


def test_a_quarter_turn_is_exact(write, tmp_path) -> None:
    bitmap(tmp_path, ["#..", "..."])
    path = write('floorplan( boundary 0 bitmap "plan.png" size [3 2 1] pose [0 0 0 90] )\nresolution 0.5')
    world = StageMap().load(path)
    assert world.size == (2.0, 3.0)  # the dark pixel, top left, is now bottom left
    assert world.to_array().tolist() == [[1, 1, 0, 0]] * 2 + [[0] * 4] * 4


def test_the_dark_part_alone_fills_the_size_if_that_is_asked_for(write, tmp_path) -> None:
    bitmap(tmp_path, ["....", ".#.#", "...."])
    path = write('floorplan( boundary 0 bitmap "plan.png" size [3 1 1] )\nresolution 0.5')
    assert StageMap(crop_bitmaps=True).load(path).to_array().tolist() == [[1, 1, 0, 0, 1, 1]] * 2


def test_a_boundary_is_a_wall_round_the_size(write) -> None:
    world = StageMap(resolution=0.25).load(write("floorplan( size [2 1 1] )"))
    cells = world.to_array()
    assert cells.shape == (4, 8)
    assert cells[[0, -1]].all()
    assert cells[:, [0, -1]].all()
    assert not cells[1:-1, 1:-1].any()


@given(
    pixels=st.lists(st.lists(st.booleans(), min_size=7, max_size=7), min_size=5, max_size=5),
    side=st.sampled_from((0.03, 0.1, 0.2, 0.5, 1.3)),
    degrees=st.sampled_from((0.0, 90.0, 33.0, -120.0)),
)
@settings(max_examples=60)
def test_no_dark_pixel_is_lost_and_nothing_grows_by_more_than_half_a_cell(pixels, side, degrees) -> None:
    dark = np.array(pixels)
    box = Box(Spot(0.4, -0.3, degrees), 2.1, 1.5)  # pixels of 0.3 m
    cells = np.zeros((math.ceil(6 / side), math.ceil(6 / side)), dtype=np.uint8)
    low = (-3.0, -3.0)
    fill(cells, side, low, dark, box)
    place = [
        box.spot.point((col + 0.5) * 0.3 - 1.05, (row + 0.5) * 0.3 - 0.75)
        for row, col in zip(*np.nonzero(dark), strict=True)
    ]
    for x, y in place:
        assert cells[int((y + 3.0) / side), int((x + 3.0) / side)]
    back = Spot(degrees=-degrees)
    for row, col in zip(*np.nonzero(cells), strict=True):
        x, y = (col + 0.5) * side - 3.0, (row + 0.5) * side - 3.0
        u, v = back.point(x - 0.4, y + 0.3)
        gaps = [
            max(abs(u + 1.05 - (c + 0.5) * 0.3), abs(v + 0.75 - (r + 0.5) * 0.3)) - 0.15
            for r, c in zip(*np.nonzero(dark), strict=True)
        ]
        assert min(gaps) <= side / math.sqrt(2.0) + 1e-9


def test_models_that_overlap_or_stand_in_a_bitmap_are_walls(write, tmp_path) -> None:
    bitmap(tmp_path, ["#...", "....", "....", "...."])
    path = write(
        'floorplan( boundary 0 bitmap "plan.png" size [8 8 1] )\n'
        "model( size [1 1 1] pose [2 2 0 0] )\n"
        "model( size [1 1 1] pose [2.5 2 0 0] )\n"
        "model( size [1 1 1] pose [-2 3 0 0] )\n"  # within the dark corner's reach
        "model( size [1 1 1] pose [0 -3 0 0] )\n"
    )
    scenario = am.load(path)
    assert len(scenario.obstacles) == 1
    assert scenario.obstacles[0].pose.y == -3.0
    assert scenario.map.occupied([[1.5, 2.0], [3.0, 2.2], [-2.5, 3.0], [0.0, -3.0]]).tolist() == [
        True,
        True,
        True,
        False,
    ]


def test_a_world_without_a_floor_plan_ends_beyond_its_models(write) -> None:
    world = StageMap().load(write("position( pose [1 2 0 0] )"))
    assert world.size == (10.0, 10.0)
    assert world.origin[:2] == (-4.0, -3.0)
    assert "no floor plan" in world.warnings[0]


def test_what_stands_outside_the_floor_plan_is_in_the_map(write) -> None:
    world = StageMap().load(write("floorplan( size [4 4 1] ) position( pose [5 0 0 0] )"))
    assert world.size == (8.0, 4.0 + 0.0)
    assert not world.occupied([[5.0, 0.0]])[0]


@pytest.mark.long
def test_too_fine_a_resolution_is_coarsened_with_a_remark(write, tmp_path) -> None:
    bitmap(tmp_path, ["#.", ".."])
    path = write('floorplan( boundary 0 bitmap "plan.png" size [1000 700 1] )')
    world = StageMap().load(path)
    assert world.resolution == 0.1
    assert "1.75e+09 cells, is taken as 0.1 m" in world.warnings[0]
    with pytest.raises(MapError, match=r"1\.75e\+09 cells of 0\.02 m; expected 1e\+08 at most"):
        StageMap(resolution=0.02).load(path)


def test_a_missing_bitmap_is_remarked_on_and_a_broken_one_is_a_fault(write, tmp_path) -> None:
    world = StageMap().load(write('floorplan( size [2 2 1]\n bitmap "none.png" )'))
    assert world.size == (2.0, 2.0)
    assert world.warnings == ("lab.world:2: there is no bitmap 'none.png': nothing of it is in the map",)
    (tmp_path / "bad.png").write_bytes(b"\x89PNG\r\n\x1a\nnothing")
    with pytest.raises(MapError, match=r"lab\.world:2: bitmap: .*bad\.png: it is no"):
        StageMap().load(write('floorplan( size [2 2 1]\n bitmap "bad.png" )'))


def test_a_picture_of_a_thousand_million_pixels_is_not_unpacked(tmp_path) -> None:
    path = tmp_path / "huge.bmp"
    Image.new("1", (8, 8)).save(path)
    data = bytearray(path.read_bytes())
    data[18:26] = (40_000).to_bytes(4, "little") * 2
    path.write_bytes(data)
    with pytest.raises(MapError, match="pixels"):
        dark_pixels(path)


def test_companions_are_the_includes_and_the_bitmaps(write, tmp_path) -> None:
    bitmap(tmp_path, ["#."])
    path = write('include "a.inc" floorplan( bitmap "plan.png" ) floorplan( bitmap "none.png" )', a="resolution 0.1")
    assert StageMap().companions(path) == (tmp_path / "a.inc", tmp_path / "plan.png")


def test_the_cave_is_16_m_wide_and_its_walls_stand_where_the_picture_has_them(real) -> None:
    world = StageMap().load(real("simple.world"))
    assert world.size == (16.0, 16.0)
    assert world.origin == (-8.0, -8.0, 0.0)
    dark = dark_pixels(real("bitmaps/cave.png"))
    rows, cols = np.indices(dark.shape)
    places = np.stack([(cols + 0.5) * 0.032 - 8.0, (rows + 0.5) * 0.032 - 8.0], axis=-1).reshape(-1, 2)
    # A pixel is 1.6 cells wide, so the cell at its middle has its middle in the pixel, or the pixel's in it.
    inside = np.abs(places).max(axis=1) < 7.95
    assert not (dark.reshape(-1) & ~world.occupied(places))[inside].any()
    free = ~dark
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        free &= np.roll(~dark, step, axis=axis)
    assert not (world.occupied(places) & free.reshape(-1))[inside].any()


@pytest.mark.parametrize("name", ["cave.world", "hospital.world"])
def test_worlds_whose_bitmap_is_not_there_have_its_size(real, name: str) -> None:
    world = StageMap().load(real(f"benchmark/{name}"))
    assert world.size == {"cave.world": (16.0, 16.0), "hospital.world": (140.0, 60.0)}[name]
