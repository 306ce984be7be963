"""Moving pictures: frames of the right size, number and length, in which bodies are where they are."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.core.patches import Patch
from amorsim.render.animation import Animation, Shown
from amorsim.runs.film import Film
from tests import building

SQUARE = np.array([(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)])


def reddish(image: Image.Image) -> np.ndarray:
    pixels = np.asarray(image.convert("RGB")).astype(int)
    return (pixels[:, :, 0] > 180) & (pixels[:, :, 1] < 90) & (pixels[:, :, 2] < 90)


def test_the_floor_lies_under_bodies_and_walls(tmp_path: Path) -> None:
    room = building.room(6.0, 4.0)
    patches = [
        Patch(np.array([(1.0, 1.0), (5.0, 1.0)]), 0.2, "#ff0000"),
        Patch(np.array([(2.0, 2.0), (4.0, 2.0), (4.0, 3.0), (2.0, 3.0)]), 0.0, "#ff0000", True),
    ]
    film = Animation(room, [Shown(outline=SQUARE, is_robot=True, colour="#0000ff")], patches=patches, size=316)
    film.add(0.0, np.array([[3.0, 1.0, 0.0]]))
    red = reddish(film.frame(0))
    # 50 px to the metre, from 8 px on; rows count downwards.
    assert red[8 + 150, 8 + 60 : 8 + 130].all()
    assert not red[8 + 150, 8 + 145 : 8 + 155].any()  # the robot
    assert red[8 + 60 : 8 + 90, 8 + 110 : 8 + 190].all()
    assert red.sum() == pytest.approx(50 * 50 * (4.0 * 0.2 - 0.4 * 0.2 + 2.0), rel=0.05)


def test_bodies_are_drawn_where_they_are(tmp_path: Path) -> None:
    room = building.room(6.0, 4.0)
    film = Animation(room, [Shown(outline=SQUARE, is_robot=True, colour="#ff0000")], size=316)
    for step in range(5):
        film.add(0.5 * step, np.array([[1.0 + step, 1.0, 0.3 * step]]))
    film.save(tmp_path / "a.gif", speed=2.0)
    with Image.open(tmp_path / "a.gif") as gif:
        assert gif.n_frames == 5
        assert gif.size[0] == 316
        for step in range(5):
            gif.seek(step)
            assert gif.info["duration"] == (250 if step < 4 else 1000)
            rows, columns = np.nonzero(reddish(gif))
            # 50 px to the metre, from 8 px on; rows count downwards.
            assert columns.mean() == pytest.approx(8 + 50 * (1.0 + step), abs=2)
            assert rows.mean() == pytest.approx(8 + 50 * 3.0, abs=2)


def test_a_turned_map_is_upright() -> None:
    cells = np.zeros((40, 60))
    turned = am.Map.from_array(cells, resolution=0.1, origin=(1.0, 2.0, np.pi / 2))
    film = Animation(turned, [Shown(outline=SQUARE, is_robot=False, colour="#ff0000")], size=316)
    film.add(0.0, np.array([[1.0 - 1.0, 2.0 + 5.0, 0.0]]))  # 5 m along the map's rows, 1 m up
    rows, columns = np.nonzero(reddish(film.frame(0)))
    assert (columns.mean(), rows.mean()) == pytest.approx((8 + 50 * 5.0, 8 + 50 * 3.0), abs=2)


def test_a_film_of_a_run_takes_the_frames_it_needs(tmp_path: Path) -> None:
    sim = am.Simulation(building.scenario())
    film = Film(sim, tmp_path / "run.gif", 100.0, size=200)  # 5 times as fast, so that it takes 20 s
    for _ in range(50):
        sim.step()
        film.keep()
    film.save()
    with Image.open(tmp_path / "run.gif") as gif:
        assert gif.n_frames == 11
        assert gif.info["duration"] == 100


def test_a_video_of_a_run_is_read_back(tmp_path: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    sim = am.Simulation(building.scenario())
    film = Film(sim, tmp_path / "run.mp4", 100.0, size=201, kind="mp4")  # an odd width, which H.264 has not
    for _ in range(50):
        sim.step()
        film.keep()
    film.save()
    command = [ffmpeg.get_ffmpeg_exe(), "-i", str(tmp_path / "run.mp4"), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    read = subprocess.run(command, capture_output=True, check=True)
    assert b"h264" in read.stderr
    assert b"10 fps" in read.stderr
    width, height = (side + side % 2 for side in film.reel.animation.frame(0).size)
    shown = np.frombuffer(read.stdout, np.uint8).reshape(-1, height, width, 3)
    assert len(shown) == 11
    drawn = np.asarray(film.reel.animation.frame(10)).astype(int)
    assert np.abs(shown[10][: len(drawn), : drawn.shape[1]] - drawn).mean() < 4.0  # of 255, after compression
    assert [path.name for path in tmp_path.iterdir()] == ["run.mp4"]


def test_a_video_without_ffmpeg_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(am.RunError, match=r'python -m pip install "amorsim\[video\]"'):
        Film(am.Simulation(building.scenario()), tmp_path / "run.mp4", 10.0, kind="mp4")


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("run.png", {}, "gif: expected the name of a file that ends in .gif"),
        ("run.gif", {"kind": "mp4"}, "mp4: expected the name of a file that ends in .mp4"),
        ("run.gif", {"size": 50}, "gif-size: expected at least 120 pixels and at most 4096, got 50"),
        ("run.gif", {"size": 10_000_000}, "at most 4096, got 10000000"),
        ("folder.gif", {}, "is a folder; name a file"),
        ("run.gif", {"rate": 0.0}, "gif-rate: expected frames a second"),
        ("run.gif", {"speed": -1.0}, "gif-speed: expected a number > 0"),
        ("none/run.gif", {}, "there is no folder"),
    ],
)
def test_what_makes_no_film(tmp_path: Path, name: str, settings: dict[str, Any], message: str) -> None:
    (tmp_path / "folder.gif").mkdir()
    with pytest.raises(am.AmorsimError, match=message):
        Film(am.Simulation(building.scenario()), tmp_path / name, 10.0, **settings)
