"""Maps: where their cells lie in the world, what they answer, and what they refuse."""

from __future__ import annotations

import copy
import functools
import itertools
import math
import pickle
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim.core.maps.map as map_module
from amorsim.core.errors import MapError
from amorsim.core.maps.free_places import freest_place
from amorsim.core.maps.map import Map
from amorsim.kernels.grid.outlines import outline_lines

ROOM = np.array([[0, 0, 4, 0], [4, 0, 4, 3], [4, 3, 0, 3], [0, 3, 0, 0]], dtype=float)


def test_covers_all_walls_outward_to_whole_cells() -> None:
    world = Map.from_segments([[0.26, -0.11, 1.31, 0.72]], resolution=0.1)
    assert world.origin == pytest.approx((0.2, -0.2, 0.0))
    assert world.shape == (10, 12)
    assert world.size == pytest.approx((1.2, 1.0))
    # Borders that lie on cell borders as far as doubles tell add no cell: 0.7 / 0.1 is 6.999999999999999.
    assert Map.from_segments([[0.3, 0.0, 0.7, 0.6]], resolution=0.1).shape == (6, 4)


def test_covers_the_extent_as_well() -> None:
    world = Map.from_segments([[1, 1, 2, 5]], extent=(-1, 0, 3, 2), resolution=0.5)
    assert world.origin == (-1.0, 0.0, 0.0)
    assert world.size == (4.0, 5.0)


def test_an_extent_alone_is_an_empty_room() -> None:
    world = Map.from_segments([], extent=(-1, -2, 3, 4), resolution=0.1)
    assert world.shape == (60, 40)
    assert not world.to_array().any()
    np.testing.assert_allclose(world.cast_rays([[0, 0, 0]], [0, np.pi / 2, np.pi], 10), [[3, 4, 1]])


def test_a_point_makes_one_cell() -> None:
    assert Map.from_segments([[1, 1, 1, 1]]).shape == (1, 1)


def test_walls_fill_what_they_touch_in_the_world() -> None:
    world = Map.from_segments([*ROOM, [1.009, 1, 1.009, 2]], start=(2, 1, 0.5), warnings=["odd"], name="lab")
    assert world.occupied([[1.0085, 1.5], [1.0095, 1.5]]).all()
    assert not world.occupied([[1.0075, 1.5], [1.0105, 1.5], [1.009, 2.0015]]).any()
    assert (world.start, world.warnings, world.name) == ((2.0, 1.0, 0.5), ("odd",), "lab")
    assert world.cast_rays([[2, 1.5, math.pi]], [0.0], 9)[0, 0] == pytest.approx(2 - 1.01)


def test_outside_and_nowhere_are_occupied() -> None:
    world = Map.from_segments(ROOM)
    points = [[-0.001, 1], [4.0, 1], [1, 3.0], [1e300, 0], [np.nan, 1], [2, 1]]
    assert world.occupied(points).tolist() == [True] * 5 + [False]
    with pytest.raises(MapError, match=r"\(M, 2\)"):
        world.occupied([1.0, 2.0])


def test_arrays_come_back_as_they_were_given() -> None:
    cells = np.random.default_rng(0).random((37, 91)) < 0.2
    for kind in (bool, np.uint8, np.int32, np.float64):
        np.testing.assert_array_equal(Map.from_array(cells.astype(kind), resolution=0.05).to_array(), cells)
    # What is not zero is occupied, whatever its last eight bits.
    assert Map.from_array(np.full((2, 2), 256), resolution=1.0).to_array().all()
    assert Map.from_array(np.asfortranarray(cells), resolution=0.05).to_array().sum() == cells.sum()


def test_a_turned_array_lies_where_its_origin_says() -> None:
    cells = np.zeros((5, 8))
    cells[3, 6] = 1
    yaw = 0.4
    world = Map.from_array(cells, resolution=0.5, origin=(10, -3, yaw))
    x, y = 3.25, 1.75
    place = [10 + math.cos(yaw) * x - math.sin(yaw) * y, -3 + math.sin(yaw) * x + math.cos(yaw) * y]
    assert world.occupied([place]).all()
    beside = [place[0] - 0.5 * math.cos(yaw), place[1] - 0.5 * math.sin(yaw)]
    assert not world.occupied([beside]).any()
    assert world.cast_rays([[*beside, yaw]], [0.0], 5.0)[0, 0] == pytest.approx(0.25)


def test_windows_and_coarser_cells() -> None:
    cells = (np.random.default_rng(1).random((60, 90)) < 0.02).astype(np.uint8)
    world = Map.from_array(cells, resolution=0.1)
    np.testing.assert_array_equal(world.to_array((0.3, 1.2, 2.7, 4.4)), cells[12:44, 3:27])
    coarse = world.to_array(resolution=0.3)
    np.testing.assert_array_equal(coarse, cells.reshape(20, 3, 30, 3).max(axis=(1, 3)))
    # Coarse cells need not divide the map: those at its edge count what of them is in it.
    uneven = world.to_array(resolution=0.7)
    assert uneven.shape == (9, 13)
    assert uneven[8, 12] == cells[56:, 84:].max()
    # Beyond the map it is occupied.
    beyond = world.to_array((-0.5, -0.2, 9.3, 6.1))
    assert beyond.shape == (63, 98)
    np.testing.assert_array_equal(beyond[2:62, 5:95], cells)
    assert beyond[:2].all()
    assert beyond[62:].all()
    assert beyond[:, :5].all()
    assert beyond[:, 95:].all()


@pytest.mark.parametrize("resolution", [10.0, 1e7, 1e8, 1e20, 1e308])
def test_a_cell_larger_than_the_map_is_one(resolution):
    for cells in ([[0, 0, 0], [0, 1, 0]], [[0, 0, 0], [0, 0, 0]]):
        world = Map.from_array(cells, resolution=0.01)
        assert world.to_array(resolution=resolution).tolist() == [[np.max(cells)]]


def test_a_finer_array_repeats_cells() -> None:
    world = Map.from_array([[0, 1], [1, 0]], resolution=1.0)
    np.testing.assert_array_equal(world.to_array(resolution=0.5), np.kron([[0, 1], [1, 0]], np.ones((2, 2))))


def test_too_large_an_array_is_refused_with_what_to_pass() -> None:
    world = Map.from_segments([[0, 0, 500, 0]], extent=(0, 0, 500, 500))
    with pytest.raises(MapError, match=r"1 GB; pass a smaller window \[m\], or a resolution of 0\.0158 m or coarser"):
        world.to_array()
    assert world.to_array(resolution=0.5).shape == (1000, 1000)
    assert world.to_array((0, 0, 1, 1)).shape == (1000, 1000)


def test_rays_are_those_of_the_definition() -> None:
    world = Map.from_segments(ROOM)
    out = world.cast_rays([[1, 1, 0], [1, 1, math.pi / 2], [-5, 0, 0], [np.nan, 1, 0]], [0.0, math.pi], 2.5)
    # Walls are drawn on grid lines, so their inner cells begin 1 mm before them.
    np.testing.assert_allclose(out, [[np.inf, 0.999], [1.999, 0.999], [0, 0], [np.nan, np.nan]])
    assert world.cast_rays(np.empty((0, 3)), [0.0], 1.0).shape == (0, 1)
    assert np.isnan(world.cast_rays([[1, 1, 0]], [np.inf], 2.5)).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0, 2.0, 3.0], [0.0], 1.0), r"poses have shape \(3,\); expected \(N, 3\)"),
        (([[1.0, 2.0, 3.0]], 0.0, 1.0), r"bearings have shape \(\); expected \(k,\)"),
        (([[1.0, 2.0, 3.0]], [0.0], -1.0), "range_max is -1.0 m; expected 0 or more"),
        (([[1.0, 2.0, 3.0]], [0.0], math.nan), "range_max is nan m; expected 0 or more"),
    ],
)
def test_rays_of_no_meaning_are_refused(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(MapError, match=message):
        Map.from_segments(ROOM).cast_rays(*arguments)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"segments": []}, "no wall and no extent"),
        ({"segments": [[0, 0, 1, math.nan]]}, r"segment 0 is \(0.0, 0.0, 1.0, nan\); expected finite"),
        ({"segments": [1, 2, 3]}, r"shape \(3,\); expected \(M, 4\)"),
        ({"segments": [["a", 0, 1, 1]]}, "segments are not numbers"),
        ({"segments": ROOM, "resolution": 0}, "resolution is 0; expected a positive number"),
        ({"segments": ROOM, "resolution": math.inf}, "resolution is inf; expected a positive number"),
        ({"segments": ROOM, "resolution": "fine"}, "resolution is 'fine'; expected a positive number"),
        ({"segments": ROOM, "extent": (0, 0, math.inf, 1)}, "extent is .*; expected 4 finite numbers"),
        ({"segments": ROOM, "extent": (2, 0, 1, 1)}, "extent .* is empty; expected xmin"),
        ({"segments": ROOM, "start": (1, 2)}, "start is .*; expected 3 finite numbers"),
        ({"segments": [[0, 0, 1e9, 1]]}, "too large for cells of 0.001 m; pass a coarser resolution"),
        ({"segments": [[0, 0, 1e308, 1]], "resolution": 1e-9}, "too large for cells"),
        ({"segments": [[1e12, 0, 1e12, 1]]}, "reaches to 1e.12 m from the world's origin"),
        (
            {"segments": np.tile([0.0, 0, 1000, 1000], (1000, 1))},
            "about 21 GB .* pass a resolution of 0.0222 m or coarser",
        ),
        # 100 km in pages of 64 cells of 1 mm are 1 GB, and in tables of 4096 cells 0.4 GB.
        ({"segments": [[0.0, 0, 1e5, 0]]}, "1 walls of 100000 m .* about 1.4 GB in cells of 0.001 m; pass .* of 0.00"),
        ({"segments": [], "extent": (0.0, 0, 1.3e5, 1)}, "0 walls of 0 m .* 130000 m x 1 m, would take about"),
    ],
)
def test_nonsense_in_segments_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(MapError, match=message):
        Map.from_segments(**given)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"array": np.zeros((0, 5))}, r"shape \(0, 5\); expected \(rows, cols\), at least one"),
        ({"array": np.zeros(5)}, r"shape \(5,\)"),
        ({"array": [[0, 1]], "origin": (1e300, 0, 0)}, r"reaches to 1e\+300 m from the world's origin"),
        ({"array": [[0, 1]], "origin": (0, -1e14, 0)}, r"reaches to 1e\+14 m from the world's origin"),
        ({"array": [[0.0, math.nan]]}, "the array has nan in it"),
        ({"array": [[0, [1]]]}, "the array has rows of different lengths; expected"),
        ({"array": [[0, 1], [0]]}, "the array has rows of different lengths; expected"),
        ({"array": [[0]], "unknown": [[0], []]}, "the array of unknown cells has rows of different lengths"),
        ({"array": [["wall"]]}, "expected numbers, 0 where a cell is free"),
        ({"array": [[0]], "resolution": -1.0}, "resolution is -1.0"),
        ({"array": [[0]], "origin": (0, 0, math.nan)}, "origin is .*; expected 3 finite numbers"),
    ],
)
def test_nonsense_in_arrays_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(MapError, match=message):
        Map.from_array(**{"resolution": 1.0, **given})


def test_noise_that_takes_more_memory_than_a_plan_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(map_module, "outline_lines", functools.partial(outline_lines, most=100))
    noise = np.random.default_rng(1).random((60, 60)) < 0.5
    with pytest.raises(MapError, match=r"alternate as in noise: .* smooth or shrink the picture, or choose another th"):
        Map.from_array(noise, resolution=1.0)


def test_pickles_copies_and_compares() -> None:
    world = Map.from_segments(ROOM, name="lab")
    again = pickle.loads(pickle.dumps(world))
    assert again == world
    assert hash(again) == hash(world)
    assert copy.copy(world) is world
    assert copy.deepcopy(world) is world
    poses = [[1, 1, 0.3]]
    assert again.cast_rays(poses, [0.0], 9) == world.cast_rays(poses, [0.0], 9)
    assert world != Map.from_segments(ROOM, name="other")
    assert world != Map.from_segments([*ROOM, [1, 1, 2, 2]], name="lab")
    assert world != Map.from_array(world.to_array(), resolution=0.001, name="lab")
    assert world != "lab"


def test_walls_given_stay_the_callers() -> None:
    given = ROOM.copy()
    world = Map.from_segments(given)
    given[:] = 0
    assert world.segments is not None
    np.testing.assert_array_equal(world.segments, ROOM)
    with pytest.raises(ValueError, match="read-only"):
        world.segments[0, 0] = 1.0


def test_a_map_of_a_square_kilometre_is_cheap() -> None:
    rng = np.random.default_rng(0)
    start = rng.random((100, 2)) * 900
    walls = np.c_[start, start + rng.random((100, 2)) * 10]
    world = Map.from_segments(walls, extent=(0, 0, 1000, 1000))
    assert world.shape == (1_000_000, 1_000_000)
    assert not world.occupied([freest_place(world)]).any()
    x, y = walls[0, :2]
    assert world.occupied([[x, y]]).all()


# ------------------------------------------------------------------------------------------ unknown cells


def test_unknown_cells_are_kept_and_change_no_ray() -> None:
    cells = np.zeros((3, 5), np.uint8)
    cells[:, 4] = 1
    unknown = np.zeros((3, 5), bool)
    unknown[1, 2:] = True
    plain = Map.from_array(cells, resolution=1.0)
    world = Map.from_array(cells, unknown=unknown, resolution=1.0)
    assert world.unknown_array().tolist() == unknown.astype(int).tolist()
    assert world.to_array().tolist() == cells.tolist()
    assert world.cast_rays([(0.5, 1.5, 0.0)], [0.0], 9.0).tolist() == [[3.5]]
    assert not plain.unknown_array().any()
    assert plain.unknown_array().shape == (3, 5)
    assert world != plain
    assert world == Map.from_array(cells, unknown=unknown, resolution=1.0)
    assert pickle.loads(pickle.dumps(world)) == world


def test_a_coarser_cell_is_unknown_if_a_part_of_it_is() -> None:
    unknown = np.zeros((4, 4))
    unknown[0, 3] = 1
    world = Map.from_array(np.zeros((4, 4)), unknown=unknown, resolution=0.5)
    assert world.unknown_array(resolution=1.0).tolist() == [[0, 1], [0, 0]]
    assert world.unknown_array((1.0, 0.0, 2.0, 1.0)).tolist() == [[0, 1], [0, 0]]


def test_unknown_cells_have_the_shape_of_the_cells() -> None:
    with pytest.raises(MapError, match=r"unknown cells has shape \(2, 3\); expected that of the cells, \(3, 2\)"):
        Map.from_array(np.zeros((3, 2)), unknown=np.zeros((2, 3)), resolution=1.0)
    assert Map.from_array(np.zeros((3, 2)), unknown=np.zeros((3, 2)), resolution=1.0).unknown is None


def test_an_array_is_neither_changed_nor_kept() -> None:
    cells = np.zeros((3, 3), np.uint8)
    world = Map.from_array(cells, resolution=1.0)
    cells[:] = 1
    assert not world.to_array().any()
    frozen = np.ones((2, 2), bool)
    frozen.flags.writeable = False
    assert Map.from_array(frozen, resolution=1.0).to_array().all()


def test_maps_are_equal_that_have_the_same_walls_and_cells() -> None:
    walls = [[0.0, 0.0, 4.0, 0.0], [4.0, 0.0, 4.0, 3.0]]
    world = Map.from_segments(walls, resolution=0.01)
    assert world == Map.from_segments(np.array(walls) - 0.0, resolution=0.01)
    assert world == Map.from_segments([[-0.0, 0.0, 4.0, -0.0], walls[1]], resolution=0.01)
    cells = np.zeros((40, 50))
    cells[7, 9] = 1.0
    drawn, again = (Map.from_array(cells, resolution=0.1) for _ in range(2))
    assert drawn == again
    assert len({drawn, again, world}) == 2
    others = [
        Map.from_segments([walls[0], [4.0, 0.0, 4.0, 2.995]], resolution=0.01),  # a wall within the same cells
        Map.from_segments(walls[::-1], resolution=0.01),
        Map.from_segments(walls, resolution=0.02),
        Map.from_segments(walls, resolution=0.01, name="other"),
        attrs.evolve(world, segments=None),
        attrs.evolve(world, unknown=world.grid),
        Map.from_array(cells.T, resolution=0.1),
        Map.from_array(np.roll(cells, 1), resolution=0.1),
    ]
    for one, other in itertools.permutations([world, drawn, *others], 2):
        assert one != other
    assert world != "a map"
