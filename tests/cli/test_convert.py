"""amorsim convert: every format that can be written, what is lost, and that nothing is overwritten."""

from __future__ import annotations

import errno
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.core.files import atomic_files
from amorsim.core.maps.same_cells import have_same_cells
from tests.cli.conftest import Command

WALLS = [(0, 0, 6, 0), (6, 0, 6, 4), (6, 4, 0, 4), (0, 4, 0, 0), (2.0, 1.0, 2.5, 3.25)]


@pytest.fixture
def room(tmp_path: Path) -> Path:
    am.save_map(am.Map.from_segments(WALLS, resolution=0.01), tmp_path / "room.wld")
    return tmp_path / "room.wld"


@pytest.mark.parametrize("ending", ["wld", "png", "pgm", "bmp", "yaml", "map"])
def test_the_cells_are_the_same(amorsim: Command, room: Path, ending: str) -> None:
    result = amorsim("convert", room, f"out.{ending}", "--resolution", 0.1)
    assert (result.status, result.err) == (0, "")
    lines = result.out.splitlines()
    assert lines[0] == f"out.{ending}: 60 x 40 cells of 0.1 m; read back, the cells are the same"
    is_stated = ending in ("yaml",)
    assert lines[1:] == ([] if is_stated else ["the file does not say it: read it with resolution = 0.1"])
    options = {} if is_stated else {"resolution": 0.1}
    again = am.load_map(room.with_name(f"out.{ending}"), **options)
    assert have_same_cells(again, am.load_map(room, resolution=0.1))


def test_what_is_lost_is_said_in_numbers(amorsim: Command, tmp_path: Path) -> None:
    unknown = np.zeros((4, 6))
    unknown[0] = 1
    world = am.Map.from_array(
        np.eye(4, 6)[::-1] * (unknown == 0), unknown=unknown, resolution=0.5, origin=(0.1, 0.0, 0.0)
    )
    am.save_map(world, tmp_path / "lab.yaml")
    result = amorsim("convert", "lab.yaml", "lab.wld")
    assert "walls are off by 0.1 m at most, 6 unknown cells are no longer known as such" in result.out


def test_nothing_is_overwritten_without_force(amorsim: Command, room: Path) -> None:
    before = room.read_bytes()
    result = amorsim("convert", room, room)
    assert result.status == 2
    assert "room.wld is there already; --force" in result.err
    # The picture beside it is as much a file that is there.
    picture = room.with_name("lab.pgm")
    picture.write_bytes(b"mine")
    result = amorsim("convert", room, "lab.yaml", "--resolution", 0.05)
    assert (result.status, picture.read_bytes(), room.read_bytes()) == (2, b"mine", before)
    assert "lab.pgm is there already" in result.err
    assert not room.with_name("lab.yaml").exists()
    assert amorsim("convert", room, "lab.yaml", "--resolution", 0.05, "--force").status == 0
    assert picture.read_bytes().startswith(b"P5")
    assert sorted(file.name for file in room.parent.iterdir()) == ["lab.pgm", "lab.yaml", "room.wld"]


def test_options_are_those_of_a_world(amorsim: Command, tmp_path: Path) -> None:
    from PIL import Image

    Image.fromarray(np.array([[0, 100, 255]], np.uint8)).save(tmp_path / "grey.png")
    assert "3 colours" in amorsim("convert", "grey.png", "a.map").err
    result = amorsim("convert", "grey.png", "a.map", "--set", "world.threshold=0.5", "--resolution", 1)
    assert result.status == 0
    assert (tmp_path / "a.map").read_text().endswith("map\n@@.\n")
    assert "Did you mean" in amorsim("convert", "grey.png", "b.map", "--set", "world.treshold=0.5").err


@pytest.mark.long
def test_a_scenario_gives_its_map(amorsim: Command, study: Path, tmp_path: Path) -> None:
    result = amorsim("convert", study, "study.png")
    assert result.status == 0
    assert (tmp_path / "study.png").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("none.wld", "a.png"), "none.wld: there is no such file"),
        (("room.wld", "a.xyz"), "no map can be written with this extension"),
        (("room.wld", "a.jpg"), "a JPEG blurs"),
    ],
)
def test_mistakes_are_reported(amorsim: Command, room: Path, arguments: tuple[str, str], words: str) -> None:
    result = amorsim("convert", *arguments)
    assert result.status == 2
    assert words in result.err


def test_every_extension_that_is_offered_can_be_written(amorsim: Command, room: Path) -> None:
    offered = amorsim("convert", room, "a.xyz").err.strip().partition("those that can: ")[2].split(", ")
    assert {".wld", ".png", ".yaml"} <= set(offered)
    for extension in offered:
        result = amorsim("convert", room, f"a{extension}", "--resolution", 0.05)
        assert result.status == 0, result.err
        (room.parent / f"a{extension}").unlink()
        (room.parent / "a.pgm").unlink(missing_ok=True)


# ------------------------------------------------------------------------------------------- scenarios, and by name


def test_a_map_becomes_a_scenario_that_runs(amorsim: Command, room: Path, tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    result = amorsim("convert", room, "deep/room.toml", "--resolution", 0.05)
    assert (result.status, result.err) == (0, "")
    assert "120 x 80 cells of 0.05 m, 1 robot, 0 obstacles; read back, the cells are the same" in result.out
    scenario = am.load(tmp_path / "deep" / "room.toml")
    assert 'map = "../room.wld"' in (tmp_path / "deep" / "room.toml").read_text()
    assert have_same_cells(scenario.map, am.load_map(room, resolution=0.05))
    assert scenario.robots[0].model == "pioneer2dx"
    again = amorsim("convert", room, "deep/room.toml")
    assert (again.status, "room.toml is there already; --force" in again.err) == (2, True)
    assert amorsim("convert", room, "deep/room.toml", "--force").status == 0


def test_another_programs_robots_are_in_the_scenario(amorsim: Command, tmp_path: Path) -> None:
    from tests.fuzz.foreign import ARIA

    (tmp_path / "lab.map").write_text(ARIA)
    result = amorsim("convert", "lab.map", "lab.toml", "--set", "robots.rover.controller.speed=0.1")
    assert result.status == 0, result.err
    assert "1 robot, 1 obstacle; read back, the cells are the same" in result.out
    before, after = am.load(tmp_path / "lab.map"), am.load(tmp_path / "lab.toml")
    assert [robot.pose for robot in after.robots] == [robot.pose for robot in before.robots]
    assert after.robots[0].controller.speed == 0.1
    assert [zone.name for zone in after.zones] == [zone.name for zone in before.zones]
    refused = amorsim("convert", "lab.map", "lab2.toml", "--set", "loader.x=1")
    assert refused.status == 2


@pytest.mark.parametrize(("ending", "use"), [("map", "mobilesim"), ("world", "stage"), ("txt", "geojson")])
def test_a_format_may_be_named(amorsim: Command, room: Path, tmp_path: Path, ending: str, use: str) -> None:
    result = amorsim("convert", room, f"out.{ending}", "--use", use, "--resolution", 0.1)
    assert result.status == 0, result.err
    assert "read back, the cells are the same" in result.out
    again = am.load_map(tmp_path / f"out.{ending}", use=use, resolution=0.1)
    assert have_same_cells(again, am.load_map(room, resolution=0.1))


def test_a_format_that_is_not_known_is_refused(amorsim: Command, room: Path) -> None:
    result = amorsim("convert", room, "out.map", "--use", "mobilesin")
    assert result.status == 2
    assert "Did you mean 'mobilesim'?" in result.err


def test_a_scenario_becomes_a_world_of_stage_with_its_bodies(amorsim: Command, tmp_path: Path) -> None:
    result = amorsim("convert", "landmarks", "marks.world", "--set", "world.resolution=0.05")
    assert result.status == 0, result.err
    assert "robot 'rover': the estimator 'ekf' (ekf) is left out" in result.err
    assert "1 robot, 0 obstacles, 12 landmarks; with these read back, the cells are the same" in result.out
    before, after = am.load("landmarks"), am.load(tmp_path / "marks.world")
    assert [(mark.id, mark.x, mark.y) for mark in after.landmarks] == [(m.id, m.x, m.y) for m in before.landmarks]
    assert after.robots[0].pose == before.robots[0].pose
    again = amorsim("convert", "landmarks", "marks.world", "--set", "world.resolution=0.05")
    assert (again.status, "marks.world is there already; --force" in again.err) == (2, True)


def test_a_world_of_stage_comes_whole_with_its_bodies_or_not_at_all(
    amorsim: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "marks.world"
    target.write_text("as it was")
    seen: list[str] = []

    def no_space(folder: Path) -> None:
        if (folder / target.name).is_file():
            seen.append((folder / target.name).read_text())
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(atomic_files, "_sync_all", no_space)
    result = amorsim("convert", "landmarks", "marks.world", "--set", "world.resolution=0.05", "--force")
    assert result.status == 2, result.err
    assert "No space left on device" in result.err
    (text,) = seen
    assert "position" in text
    assert target.read_text() == "as it was"
