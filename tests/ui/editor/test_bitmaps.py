"""Painting on bitmap worlds: the text of runs against plain arrays, and the Editor's commands."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

import amorsim as am
from amorsim.core.errors import AmorsimError
from amorsim.ui.editor.inspectors.walls import WallsError
from amorsim.ui.editor.session import EditSession
from amorsim.ui.editor.storage.bitmaps import cropped, decode, encode, filled, painted, shape_of
from tests.ui.editor.talking import do, drawn, talk


def some_levels() -> Any:
    levels = np.where(np.random.default_rng(3).random((40, 60)) < 0.4, 0, 255).astype(np.uint8)
    levels[10:20, 10:50] = 255
    return levels


def text_of(levels: Any) -> str:
    data = io.BytesIO()
    Image.fromarray(levels).save(data, format="PNG")
    return decode(data.getvalue(), "x.png", has_threshold=False)


def levels_of(text: str) -> Any:
    return np.asarray(Image.open(io.BytesIO(encode(text, ".png"))).convert("L"))


def test_a_picture_is_the_same_after_reading_and_writing() -> None:
    levels = some_levels()
    text = text_of(levels)
    assert shape_of(text) == levels.shape
    assert (levels_of(text) == levels).all()


@pytest.mark.parametrize("is_occupied", [True, False])
def test_spans_are_painted_and_what_lies_outside_is_left_out(is_occupied: bool) -> None:
    levels = some_levels()
    text = painted(
        text_of(levels), [[3, 5, 9], [-1, 0, 5], [39, 55, 99], [40, 0, 9], [7, -4, 2]], is_occupied=is_occupied
    )
    grey = 0 if is_occupied else 255
    levels[3, 5:9] = levels[39, 55:] = levels[7, :2] = grey
    assert (levels_of(text) == levels).all()


@pytest.mark.parametrize("place", [(12, 30), (0, 0), (39, 59), (25, 7)])
def test_an_area_is_filled_as_far_as_it_is_joined_over_edges(place: tuple[int, int]) -> None:
    levels = some_levels()
    labels, _ = ndimage.label(levels == levels[place])
    wanted = np.where(labels == labels[place], 0, levels)
    assert (levels_of(filled(text_of(levels), *place, is_occupied=True)) == wanted).all()


def test_a_part_is_kept() -> None:
    levels = some_levels()
    assert (levels_of(cropped(text_of(levels), 5, 10, 30, 99)) == levels[5:30, 10:]).all()
    with pytest.raises(AmorsimError, match="nothing of the world"):
        cropped(text_of(levels), 50, 0, 60, 10)


def test_colours_and_greys_are_refused() -> None:
    data = io.BytesIO()
    Image.new("RGB", (4, 4), "red").save(data, format="PNG")
    with pytest.raises(WallsError, match="has colours"):
        decode(data.getvalue(), "x.png", has_threshold=False)
    data = io.BytesIO()
    Image.fromarray(np.arange(16, dtype=np.uint8).reshape(4, 4)).save(data, format="PNG")
    with pytest.raises(WallsError, match="threshold"):
        decode(data.getvalue(), "x.png", has_threshold=False)
    assert shape_of(decode(data.getvalue(), "x.png", has_threshold=True)) == (4, 4)


@pytest.mark.long
def test_a_bitmap_world_is_painted_cropped_undone_and_saved(tmp_path: Path) -> None:
    levels = np.full((80, 120), 255, dtype=np.uint8)
    levels[0], levels[-1], levels[:, 0], levels[:, -1] = 0, 0, 0, 0
    Image.fromarray(levels).convert("1").save(tmp_path / "room.png")
    before = (tmp_path / "room.png").read_bytes()
    file = tmp_path / "mine.toml"
    file.write_text(
        'format = 1\n[world]\nmap = "room.png"\nresolution = 0.1\n'
        '[[robots]]\nname = "one"\nmodel = "pioneer2dx"\npose = { x = 4.0, y = 4.0 }\n'
    )

    async def say(session: EditSession) -> None:
        assert session.state()["cells"] == [80, 120]
        assert (await drawn(session))["faults"] == []
        spans = [[40, 20, 30], [41, 20, 30]]
        await do(session, do="edit", label="paint", changes=[{"op": "paint", "spans": spans, "occupied": True}])
        (journalled,) = session.work.steps.history.done
        assert sum(len(patch.new) for patch in journalled.patches.values()) < 60  # a stroke, not a picture
        assert (tmp_path / "room.png").read_bytes() == before
        await drawn(session)
        await do(session, do="save")
        world = am.load(file).map
        assert world.occupied(np.array([[2.55, 3.95]])).tolist() == [True]  # row 40 of 80 from the top
        assert world.occupied(np.array([[2.55, 4.25]])).tolist() == [False]
        await do(session, do="edit", label="crop", changes=[{"op": "crop", "box": [30, 10, 60, 90]}])
        assert session.state()["cells"] == [30, 80]
        assert session.work.document.get("world.origin_x") == 1.0
        assert session.work.document.get("world.origin_y") == 2.0
        await do(session, do="save")
        world = am.load(file).map
        assert world.occupied(np.array([[2.55, 3.95]])).tolist() == [True]
        for _ in range(2):
            await do(session, do="undo")
        await do(session, do="save")

    talk(str(file), tmp_path, say)
    assert (np.asarray(Image.open(tmp_path / "room.png").convert("L")) == levels).all()


def test_the_clearance_of_a_point_is_that_to_the_nearest_occupied_cell(tmp_path: Path) -> None:
    levels = np.full((40, 60), 255, dtype=np.uint8)
    levels[:, 0] = 0
    Image.fromarray(levels).save(tmp_path / "m.png")
    file = tmp_path / "m.toml"
    file.write_text('format = 1\n[world]\nmap = "m.png"\nresolution = 0.1\n')

    async def say(session: EditSession) -> None:
        await drawn(session)
        assert (await do(session, do="clearance", x=2.0, y=2.0))["gap"] == pytest.approx(1.9, abs=1e-4)
        assert (await do(session, do="clearance", x=0.05, y=2.0))["gap"] == 0.0
        assert not (await session.request({"do": "clearance", "x": "far", "y": 2.0}))["ok"]

    talk(str(file), tmp_path, say)
