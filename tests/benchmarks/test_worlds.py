"""The worlds of the benchmarks: of the sizes that their names say, and the same for all sides."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from benchmarks import plain, worlds
from benchmarks.rays import same_bits
from tests import naive

BEARINGS = np.linspace(-math.pi / 2.0, math.pi / 2.0, 31)


def test_room_has_forty_walls_inside_ten_metres() -> None:
    walls = worlds.room_walls()
    assert walls.shape == (40, 4)
    assert walls.min() == 0.0
    assert walls.max() == 10.0


@pytest.mark.long
def test_room_without_lines_has_the_same_cells() -> None:
    lines, bitmap = worlds.line_room(), worlds.bitmap_room()
    assert bitmap.map.segments is None
    assert bitmap.map.resolution == lines.map.resolution == 0.001
    poses = worlds.places(lines, 40, 0.1)
    np.testing.assert_array_equal(bitmap.map.cast_rays(poses, BEARINGS, 8.0), lines.map.cast_rays(poses, BEARINGS, 8.0))


def test_office_is_a_thousand_cells_wide_and_closed() -> None:
    office = worlds.office()
    assert office.cells.shape == (1000, 1000)
    assert office.map.resolution == 0.05
    border = np.concatenate([office.cells[0], office.cells[-1], office.cells[:, 0], office.cells[:, -1]])
    assert border.all()


@pytest.mark.parametrize("world", [worlds.office, worlds.furnished_office])
def test_every_room_of_an_office_is_reached_through_doors(world: Callable[[], worlds.World]) -> None:
    ndimage = pytest.importorskip("scipy.ndimage")
    free = world().cells == 0
    label, _ = ndimage.label(free)
    # But for the room between a desk and its stools all is one.
    assert np.bincount(label[free]).max() > 0.99 * free.sum()
    assert free.mean() > 0.75


def test_the_furnished_office_has_all_of_the_bare_one_and_more() -> None:
    bare, furnished = worlds.office().cells, worlds.furnished_office().cells
    assert (furnished >= bare).all()
    assert len(worlds.furnished_office().walls) > 4 * len(worlds.office().walls)


def test_the_hall_is_free_and_the_rest_of_the_office_is_as_it_was() -> None:
    bare, made = worlds.office().cells, worlds.office_with_hall().cells
    x0, y0, x1, y1 = (round(value / 0.05) for value in worlds.HALL)
    assert not made[y0 + 1 : y1, x0 + 1 : x1].any()
    changed = np.argwhere(bare != made)
    assert changed.min() > x0
    assert changed.max() < x1


def test_borders_of_a_bitmap_are_what_its_rays_meet() -> None:
    """Peers get the office as these segments: rays against them end where rays against the cells do."""
    office = worlds.office(20.0)
    poses = worlds.places(office, 20, 0.2)
    expected = office.map.cast_rays(poses, BEARINGS, 8.0)
    x0, y0, x1, y1 = office.walls.T
    for pose, scan in zip(poses, expected, strict=True):
        for bearing, wanted in zip(BEARINGS, scan, strict=True):
            dx, dy = math.cos(pose[2] + bearing), math.sin(pose[2] + bearing)
            ex, ey = x1 - x0, y1 - y0
            with np.errstate(divide="ignore", invalid="ignore"):
                cross = dx * ey - dy * ex
                along = ((x0 - pose[0]) * ey - (y0 - pose[1]) * ex) / cross
                share = ((x0 - pose[0]) * dy - (y0 - pose[1]) * dx) / cross
            hits = along[(along >= 0.0) & (share >= -1e-9) & (share <= 1.0 + 1e-9)]
            nearest = hits.min(initial=math.inf)
            assert (nearest if nearest <= 8.0 else math.inf) == pytest.approx(wanted, abs=1e-9)


def test_a_kilometre_of_city_has_twenty_kilometres_of_walls() -> None:
    walls = worlds.city_walls(1000.0)
    length = np.hypot(walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]).sum()
    assert length == pytest.approx(20_000.0, rel=1e-9)
    assert walls.min() == 0.0
    assert walls.max() == 1000.0


def test_walls_written_are_walls_read(tmp_path: Path) -> None:
    walls = worlds.city_walls(50.0)
    worlds.write_wld(walls, 50.0, tmp_path / "city.wld")
    read = am.load_map(tmp_path / "city.wld")
    np.testing.assert_allclose(read.segments, walls, atol=0.0005 + 1e-9)
    assert read.resolution == 0.001


def test_places_are_free_and_apart() -> None:
    office = worlds.office(20.0)
    poses = worlds.places(office, 30, 0.45, 0.85)
    gaps = np.hypot(*(poses[:, None, :2] - poses[None, :, :2]).transpose(2, 0, 1)) + 10.0 * np.eye(30)
    assert gaps.min() >= 0.85
    turns = np.linspace(0.0, 2.0 * math.pi, 500)
    for radius in (0.1, 0.2, 0.3, 0.4):
        ring = poses[:, None, :2] + radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        assert not office.map.occupied(ring.reshape(-1, 2)).any()


def test_too_many_places_are_refused() -> None:
    with pytest.raises(ValueError, match="room for"):
        worlds.places(worlds.line_room(0.01), 500, 0.3, 0.6)


@pytest.mark.parametrize("resolution", [0.05, 0.01])
def test_plain_traversal_is_exact(resolution: float) -> None:
    """The yardstick is of the same definition as the twin of the tests: it has no easier task."""
    room = worlds.line_room(resolution)
    poses = worlds.places(room, 30, 0.1)
    got = plain.cast(room.cells, resolution, poses, BEARINGS, 8.0)
    expected = naive.cast(
        room.cells,
        resolution,
        (0.0, 0.0, 0.0),
        poses,
        np.cos(BEARINGS)[None],
        np.sin(BEARINGS)[None],
        np.array([8.0]),
    )
    assert same_bits(got, expected) == 1.0


def test_same_bits_sees_three_units_in_the_last_place() -> None:
    a = np.array([[1.0, 2.0, math.inf, math.inf]])
    b = np.array([[1.0 + 3.0 * np.spacing(1.0), 2.0, math.inf, 4.0]])
    assert same_bits(a, a) == 1.0
    assert same_bits(a, b) == 0.5
