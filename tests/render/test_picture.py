"""The picture of a run: the right colours at the right places."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image, ImageColor

from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.patches import DROP, Patch
from amorsim.render.marks import COLOURS
from amorsim.render.obstacles import Thing
from amorsim.render.picture import draw_map, draw_run
from amorsim.render.robot_paths import RobotPath
from tests.examples import settings

NEAR = 70  # of 441: how far apart colours of a smoothed edge and a pure one may be


@pytest.fixture(scope="module")
def room() -> Map:
    """A room of 10 m x 6 m with a wall across at x = 6 m, from the bottom to y = 3 m."""
    edge = [(0, 0, 10, 0), (10, 0, 10, 6), (10, 6, 0, 6), (0, 6, 0, 0)]
    return Map.from_segments([*edge, (6, 0, 6, 3)], resolution=0.001)


def distance(image: Image.Image, colour: str) -> np.ndarray:
    """How far each pixel is from a colour, (rows, columns)."""
    red, green, blue = (
        np.asarray(part, np.float32) - one for part, one in zip(image.split(), ImageColor.getrgb(colour), strict=True)
    )
    return np.asarray(np.sqrt(red**2 + green**2 + blue**2))


def has(image: Image.Image, colour: str) -> np.ndarray:
    return distance(image, colour) < NEAR


class Places:
    """Where metres of the map's frame are in a picture, found from the map's white and its walls alone."""

    def __init__(self, image: Image.Image, size: tuple[float, float]) -> None:
        walls = has(image, COLOURS["wall"])
        # Long dark rows and columns are walls; words and the scale bar are short.
        columns = np.flatnonzero(walls.sum(axis=0) > 0.3 * image.height)
        rows = np.flatnonzero(walls.sum(axis=1) > 0.3 * image.width)
        self.left, self.right, self.top, self.bottom = columns[0], columns[-1], rows[0], rows[-1]
        self.scale = (self.right - self.left) / size[0]
        self.size = size

    def __call__(self, x: float, y: float) -> tuple[int, int]:
        return round(self.left + x * self.scale), round(self.bottom - y * self.scale)


def around(mask: np.ndarray, place: tuple[int, int], reach: int = 2) -> np.ndarray:
    x, y = place
    return np.asarray(mask[y - reach : y + reach + 1, x - reach : x + reach + 1])


# -------------------------------------------------------------------------------------------- the map


@pytest.mark.parametrize("size", [240, 501, 1600])
def test_size_is_the_longer_side(room: Map, size: int) -> None:
    image = draw_map(room, size=size)
    assert image.mode == "RGB"
    assert image.width == size > image.height
    tall = draw_map(Map.from_segments([(0, 0, 1, 9)], resolution=0.01), size=size)
    assert abs(tall.height - size) <= 1
    assert tall.width < size


def test_size_has_a_least(room: Map) -> None:
    with pytest.raises(ParameterError, match="size: expected at least 240"):
        draw_map(room, size=239)


def test_walls_are_dark_and_the_rest_is_white(room: Map) -> None:
    image = draw_map(room)
    at = Places(image, room.size)
    assert abs((at.bottom - at.top) - 6 * at.scale) <= 2
    walls, free = has(image, COLOURS["wall"]), has(image, "white")
    for y in (0.5, 1.7, 2.9):
        assert around(walls, at(6, y)).any()
        assert around(free, at(6 - 0.1, y)).all()
    assert around(free, at(6, 3.2)).all()
    assert around(free, at(2, 2)).all()
    # Walls of 1 mm are drawn as thick as can be seen.
    assert walls[at(6, 1.5)[1]].sum() >= 3 * 2


def test_beyond_the_map_is_neither_wall_nor_free(room: Map) -> None:
    image = draw_map(room)
    at = Places(image, room.size)
    assert around(has(image, COLOURS["outside"]), at(-0.06, 3), 1).all()


def test_cells_that_can_be_seen_keep_their_size() -> None:
    occupied = np.zeros((20, 30))
    occupied[4:8, 10:20] = 1
    image = draw_map(Map.from_array(occupied, resolution=0.5), size=1000)
    walls = has(image, COLOURS["wall"])[: round(0.9 * image.height)]
    rows, columns = np.nonzero(walls)
    wide, high = np.ptp(columns) + 1, np.ptp(rows) + 1
    assert abs(wide / high - 10 / 4) < 0.05
    assert abs(walls.sum() - wide * high) <= 2 * (wide + high)


def test_a_turned_map_lies_straight() -> None:
    occupied = np.zeros((60, 100))
    occupied[0] = occupied[-1] = 1
    occupied[:, 0] = occupied[:, -1] = 1
    yaw, x, y = 0.7, 3.0, -2.0
    turned = Map.from_array(occupied, resolution=0.1, origin=(x, y, yaw))
    straight = Map.from_array(occupied, resolution=0.1)
    local = np.array([(1.0, 1.0), (8.0, 1.5), (9.0, 5.0)])
    turn = np.array([(math.cos(yaw), -math.sin(yaw)), (math.sin(yaw), math.cos(yaw))])
    world = local @ turn.T + (x, y)
    pictures = [
        np.asarray(draw_run(one, [RobotPath(name="a", true=path)], size=600), np.int16)
        for one, path in ((turned, world), (straight, local))
    ]
    assert pictures[0].shape == pictures[1].shape
    assert np.abs(pictures[0] - pictures[1]).max(axis=2).mean() < 0.1


# ------------------------------------------------------------------------------------------- the paths


def test_true_path_is_a_solid_line(room: Map) -> None:
    image = draw_run(room, [RobotPath(name="rover", true=[(1, 1), (5, 1), (5, 5)])])
    at = Places(image, room.size)
    green = has(image, COLOURS["true"])
    for place in [*((x, 1.0) for x in np.linspace(1.3, 5, 60)), *((5.0, y) for y in np.linspace(1, 4.7, 60))]:
        assert around(green, at(*place), 1).all(), place
    assert not around(green, at(3, 3), 20).any()


def test_estimated_path_is_dashed(room: Map) -> None:
    image = draw_run(room, [RobotPath(name="rover", true=[(1, 5), (5, 5)], estimated=[(1, 1), (5, 1)])])
    at = Places(image, room.size)
    row = at(0, 1)[1]
    blue = has(image, COLOURS["estimated"])[row, at(1.1, 1)[0] : at(4.8, 1)[0]]
    changes = np.count_nonzero(np.diff(blue.astype(int)))
    assert changes > 30
    assert 0.4 < blue.mean() < 0.8
    green = has(image, COLOURS["true"])[at(0, 5)[1], at(1.2, 1)[0] : at(4.8, 1)[0]]
    assert green.all()


def test_zones_are_hatched_below_the_paths(room: Map) -> None:
    square = [(2.0, 2.0), (4.0, 2.0), (4.0, 4.0), (2.0, 4.0)]
    path = RobotPath(name="rover", true=[(1, 3), (5, 3)])
    image = draw_run(room, [path], zones=[square])
    plain = draw_run(room, [path])
    at = Places(image, room.size)
    assert image.size == plain.size
    changed = np.any(np.asarray(image) != np.asarray(plain), axis=2)
    (left, top), (right, bottom) = at(2, 4), at(4, 2)
    inside = changed[top + 5 : bottom - 5, left + 5 : right - 5]
    assert inside.mean() > 0.9  # all of it is tinted, but for the path
    lines = has(image, COLOURS["zone"])[top + 5 : bottom - 5, left + 5 : right - 5]
    assert 0.02 < lines.mean() < 0.3
    legend = round(at(0, 0)[1] + 0.5 * (image.size[1] - at(0, 0)[1]))
    outside = changed.copy()
    outside[top - 5 : bottom + 5, left - 5 : right + 5] = False
    assert not outside[: at(0, 0)[1]].any()
    assert outside[legend - 60 :].any()  # it says what that is
    assert around(has(image, COLOURS["true"]), at(3, 3), 1).any()


def test_markings_and_drops_are_painted_on_the_floor_below_walls_and_paths(room: Map) -> None:
    line = Patch(np.array([(1.0, 1.0), (5.0, 1.0), (5.0, 3.0)]), 0.2, "#ff00ff")
    hole = Patch(np.array([(2.0, 2.0), (3.0, 2.0), (3.0, 3.0), (2.0, 3.0)]), 0.0, DROP, True)
    path = RobotPath(name="rover", true=[(1.5, 0.5), (1.5, 3.0)])
    image = draw_run(room, [path], patches=[line, hole])
    at = Places(image, room.size)
    magenta, dark = has(image, "#ff00ff"), has(image, DROP)
    for place in ((1.2, 1.0), (3.0, 1.09), (3.0, 0.91), (5.0, 2.5)):
        assert around(magenta, at(*place), 0).all(), place
    assert not around(magenta, at(3.0, 1.12), 0).any()
    (left, top), (right, bottom) = at(2.0, 3.0), at(3.0, 2.0)
    assert 0.6 < dark[top + 3 : bottom - 3, left + 3 : right - 3].mean() < 1.0  # hatched
    assert around(has(image, COLOURS["true"]), at(1.5, 1.0), 0).all()
    assert magenta[: at(0, 0)[1]].sum() == magenta.sum()  # the legend's sample is black
    assert dark[at(0, 0)[1] :].any()


def test_things_stand_where_they_are_in_their_colours(room: Map) -> None:
    box = [(2.0, 2.0), (2.6, 2.0), (2.6, 2.6), (2.0, 2.6)]
    things = [
        Thing(kind="landmark", place=(4.0, 4.0), radius=0.1, colour="#ff00ff", label="7"),
        Thing(kind="lamp", place=(5.0, 1.0)),
        Thing(kind="obstacle", place=(2.0, 2.0), outline=box, colour="#00ffff"),
    ]
    path = RobotPath(name="rover", true=[(1, 3), (1.5, 3)])
    image, plain = draw_run(room, [path], things=things), draw_run(room, [path])
    at = Places(image, room.size)
    assert around(has(image, "#ff00ff"), at(4.0, 4.0), 3).all()
    assert not around(has(image, "#ff00ff"), at(4.3, 4.0), 3).any()  # as large as it is
    assert around(has(image, "#f2b705"), at(5.0, 1.0), 2).all()
    corner = np.asarray(image)[at(2.3, 2.3)[1], at(2.3, 2.3)[0]]
    assert corner[0] < 100 < corner[1]  # cyan, a little of the floor showing through
    for place in ((2.0, 2.3), (2.6, 2.3)):
        assert around(has(image, "#3d444d"), at(*place), 3).any()
    assert not has(plain, "#f2b705").any()
    with pytest.raises(ParameterError, match="kind"):
        Thing(kind="tree", place=(0, 0))


def test_marks_of_start_and_end(room: Map) -> None:
    path = RobotPath(name="rover", true=[(1, 1), (5, 1)], estimated=[(1, 1), (5, 2)])
    image = draw_run(room, [path])
    at = Places(image, room.size)
    green = has(image, COLOURS["true"])
    assert around(has(image, "white"), at(1, 1)).all()  # the hole of the ring
    assert around(green, (at(1, 1)[0], at(1, 1)[1] - 7), 1).any()
    assert around(green, at(5, 1), 4).all()
    assert around(has(image, COLOURS["estimated"]), at(5, 2), 3).all()


def test_outline_is_where_the_body_ended(room: Map) -> None:
    body = [(4.7, 0.8), (5.3, 0.8), (5.3, 1.2), (4.7, 1.2)]
    image = draw_run(room, [RobotPath(name="rover", true=[(1, 1), (5, 1)], outline=body)])
    at = Places(image, room.size)
    green = has(image, COLOURS["true"])
    for x, y in [(5.3, 1.1), (5.0, 1.2), (5.1, 0.8)]:
        assert around(green, at(x, y)).any()
    assert not around(green, at(5.2, 1.1), 1).any()
    tint = np.asarray(image)[at(5.2, 1.1)[1], at(5.2, 1.1)[0]]
    assert tint[1] > tint[0] + 20
    assert tint[1] > tint[2] + 5


def test_collisions_are_crosses(room: Map) -> None:
    image = draw_run(room, [RobotPath(name="rover", true=[(1, 1), (5, 1)], collisions=[(5, 4), (2, 3)])])
    at = Places(image, room.size)
    red = has(image, COLOURS["collision"])
    for x, y in [(5, 4), (2, 3)]:
        column, row = at(x, y)
        assert red[row, column]
        for arm in (-6, 6):
            assert around(red, (column + arm, row + arm), 1).any()
            assert around(red, (column + arm, row - arm), 1).any()
            assert not red[row, column + 2 * arm]
            assert not red[row + arm, column]
    assert not around(red, at(4, 4), 10).any()


def test_a_thousand_touches_of_one_place_are_one_cross(room: Map) -> None:
    once = RobotPath(name="rover", true=[(1, 1), (5, 1)], collisions=[(5, 4)])
    often = RobotPath(name="rover", true=[(1, 1), (5, 1)], collisions=[(5, 4)] * 20_000)
    began = time.perf_counter()
    image = draw_run(room, [often], size=800)
    assert time.perf_counter() - began < 5
    plot = (0, 0, 800, 400)  # without the legend, which counts them
    assert image.crop(plot).tobytes() == draw_run(room, [once], size=800).crop(plot).tobytes()


# ----------------------------------------------------------------------------------------- odd paths


def test_empty_paths_leave_the_map(room: Map) -> None:
    image = draw_run(room, [RobotPath(name="rover", true=[])])
    for colour in ("true", "estimated", "collision"):
        assert distance(image, COLOURS[colour]).min() > 20
    assert has(image, COLOURS["wall"]).any()


def test_one_point_is_a_mark(room: Map) -> None:
    image = draw_run(room, [RobotPath(name="rover", true=[(3, 3)])])
    assert around(has(image, COLOURS["true"]), Places(image, room.size)(3, 3), 3).all()


def test_points_that_are_not_finite_interrupt_the_line(room: Map) -> None:
    true = [(np.nan, 1), (1, 1), (2, 1), (np.inf, 1), (4, 1), (5, 1), (np.nan, np.nan)]
    image = draw_run(room, [RobotPath(name="rover", true=true, collisions=[(np.nan, 1)])])
    at = Places(image, room.size)
    green = has(image, COLOURS["true"])
    assert around(green, at(1.5, 1), 1).all()
    assert around(green, at(4.5, 1), 1).all()
    assert not around(green, at(3, 1), 10).any()
    assert around(green, at(5, 1), 3).all()  # the last finite one is the end
    assert not has(image, COLOURS["collision"])[: at(0, 0)[1]].any()


def test_the_picture_grows_with_paths_outside(room: Map) -> None:
    inside = draw_run(room, [RobotPath(name="rover", true=[(1, 1), (5, 1)])])
    outside = draw_run(room, [RobotPath(name="rover", true=[(1, 1), (5, 7.5)])])
    assert outside.height > inside.height
    assert outside.width == inside.width
    at = Places(outside, room.size)
    assert around(has(outside, COLOURS["true"]), at(5, 7.5), 2).all()


def test_a_path_far_away_is_cut_off(room: Map) -> None:
    """The picture grows by a quarter of the map's longer side and no more; the scale stays of use."""
    for far in (20.0, 1e5, 1e12, 1e300):
        image = draw_run(room, [RobotPath(name="rover", true=[(1, 1), (1, far)], estimated=[(1, 1), (far, 1)])])
        at = Places(image, room.size)
        assert at.scale > image.width / 10 / 1.5
        green = has(image, COLOURS["true"])
        assert around(green, at(1, 8.3), 1).any()
        assert not around(green, at(1, 8.8), 3).any()


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.floats(), st.floats()), max_size=8), st.booleans())
def test_any_path_makes_a_picture(room: Map, points: list[tuple[float, float]], is_estimated: bool) -> None:
    path = RobotPath(
        name="rover",
        true=[] if is_estimated else points,
        estimated=points if is_estimated else [],
        outline=points,
        collisions=points,
    )
    with np.errstate(over="raise", invalid="raise"):
        image = draw_run(room, [path], size=240)
    assert max(image.size) == 240


@pytest.mark.parametrize("name", ["true", "estimated", "outline", "collisions"])
def test_points_of_another_shape_are_refused(name: str) -> None:
    with pytest.raises(ParameterError, match=rf"{name}: expected points \(T, 2\)"):
        RobotPath(**{"name": "rover", "true": [], name: [(1, 2, 3)]})


def test_a_path_is_a_copy() -> None:
    true = np.ones((3, 2))
    path = RobotPath(name="rover", true=true)
    true[:] = 7
    assert np.all(path.true == 1)


@pytest.mark.long
def test_long_paths_are_drawn_too(room: Map) -> None:
    rng = np.random.default_rng(1)
    true = np.cumsum(rng.normal(0, 0.02, (100_000, 2)), axis=0) % (10, 6)
    path = RobotPath(name="rover", true=true, estimated=true + 0.05)
    image = np.asarray(draw_run(room, [path]).convert("RGB")).astype(int)
    assert (np.ptp(image, axis=-1) > 30).mean() > 0.1  # paths alone are coloured


# ------------------------------------------------------------------------------------------- the words


def test_title_stands_above_the_map(room: Map) -> None:
    plain, titled = draw_map(room), draw_map(room, title="A room")
    assert titled.height > plain.height
    above = np.asarray(titled)[: Places(titled, room.size).top - 20]
    assert (above < 100).any()
    assert (np.asarray(plain)[: Places(plain, room.size).top - 20] >= 100).all()


@pytest.mark.long
def test_a_long_title_is_cut_to_the_page(room: Map) -> None:
    image = draw_map(room, title="very " * 200, size=600)
    assert image.width == 600
    assert (np.asarray(image)[:, -8:] > 200).all()


def test_scale_bar_has_the_length_it_says(room: Map) -> None:
    image = draw_map(room)
    at = Places(image, room.size)
    below = has(image, COLOURS["text"])[at.bottom + 20 :]
    longest = max(
        int(np.diff(np.flatnonzero(np.diff(np.concatenate(([0], row, [0])))))[::2].max(initial=0)) for row in below
    )
    assert abs(longest - 1.0 * at.scale) < 8  # 1 m is the round length for a seventh of ten metres


def test_legend_explains_what_is_there(room: Map) -> None:
    def below(path: RobotPath) -> np.ndarray:
        image = draw_run(room, [path])
        return np.asarray(image)[Places(image, room.size).bottom + 25 :]

    def shown(pixels: np.ndarray, colour: str) -> bool:
        return bool(distance(Image.fromarray(pixels), COLOURS[colour]).min() < 20)

    alone = below(RobotPath(name="rover", true=[(1, 1), (2, 2)]))
    assert shown(alone, "true")
    assert not shown(alone, "estimated")
    assert not shown(alone, "collision")
    both = below(RobotPath(name="rover", true=[(1, 1), (2, 2)], estimated=[(1, 1), (2, 1)], collisions=[(2, 2)]))
    assert shown(both, "estimated")
    assert shown(both, "collision")


def test_several_robots_are_labelled_where_they_ended(room: Map) -> None:
    paths = [RobotPath(name=f"robot {i}", true=[(1, 1 + i), (4, 1 + i)]) for i in range(3)]
    image = draw_run(room, paths)
    at = Places(image, room.size)
    text = distance(image, COLOURS["text"]) < 40
    for i in range(3):
        column, row = at(4, 1 + i)
        beside = text[row - 60 : row + 61, column - 180 : column + 181]
        assert beside.sum() > 50
    single = draw_run(room, paths[:1])
    column, row = Places(single, room.size)(4, 1)
    assert not (distance(single, COLOURS["text"]) < 40)[row - 60 : row + 61, column - 180 : column + 181].any()


def test_many_robots_with_long_names(room: Map) -> None:
    paths = [RobotPath(name=f"a rather long name for robot {i}", true=[(9.9, 5.9)]) for i in range(40)]
    image = draw_run(room, paths, size=500)
    assert max(image.size) == 500
    assert (np.asarray(image)[:, -6:] > 180).all()
