"""Real files, which others drew: all of them load, and those with a known reading match it cell by cell."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import amorsim as am
from amorsim.core.maps.footprint_room import least_gaps
from amorsim.runs.scenario_argument import read_scenario
from amorsim.scenario.files.foreign import find_scenario_loader

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps"
TOO_SMALL = {"serp-sm.wld"}  # for a Pioneer
_ENDINGS = {".wld", ".map", ".yaml", ".world", ".png", ".pgm"}

pytestmark = pytest.mark.skipif(not MAPS.is_dir(), reason="the shared maps are not here")


def files(*endings: str) -> list[str]:
    found = sorted(path for path in MAPS.rglob("*") if path.suffix in endings) if MAPS.is_dir() else []
    return [path.relative_to(MAPS).as_posix() for path in found]


@pytest.mark.parametrize("name", files(*_ENDINGS) or ["none"])
def test_a_robot_is_put_on_it(name: str) -> None:
    path = MAPS / name
    threshold = ["world.threshold=0.5"] if path.suffix in (".png", ".pgm") else []
    if path.name in TOO_SMALL:
        with pytest.raises(am.ScenarioError, match="the map has no place where a footprint"):
            read_scenario(str(path))
        return
    scenario = read_scenario(str(path), changes=threshold)
    assert scenario.robots
    for robot in scenario.robots[:20]:
        assert robot.pose is not None
        pose = np.array([[robot.pose.x, robot.pose.y, robot.pose.heading]])
        assert least_gaps(scenario.map, [(robot.shape, (0.0, 0.0, 0.0))], pose)[0] >= 0.0


def test_all_formats_with_robots_are_found() -> None:
    from amorsim.plugins.manager import make_registry

    registry = make_registry(entry_points=())
    for name in files(".world", ".map"):
        is_movingai = name.startswith("movingai")
        assert (find_scenario_loader(MAPS / name, registry) is None) == is_movingai


# --------------------------------------------------------------------------------------------------- ROS


def plain_pgm(path: Path) -> npt.NDArray[np.uint8]:
    """A binary PGM, read as its definition says: header words, comments up to a line's end, one blank, the pixels."""
    data = path.read_bytes()
    words: list[bytes] = []
    at = 0
    while len(words) < 4:
        if data[at : at + 1] == b"#":
            at = data.index(b"\n", at)
        elif data[at : at + 1].isspace():
            at += 1
        else:
            end = at
            while not data[end : end + 1].isspace():
                end += 1
            words.append(data[at:end])
            at = end
    assert words[0] == b"P5"
    assert int(words[3]) == 255
    width, height = int(words[1]), int(words[2])
    return np.frombuffer(data, np.uint8, width * height, at + 1).reshape(height, width)


def plain_yaml(path: Path) -> dict[str, str]:
    lines = (line.partition("#")[0] for line in path.read_text().splitlines())
    return {key.strip(): value.strip() for key, colon, value in (line.partition(":") for line in lines) if colon}


@pytest.mark.parametrize("name", files(".yaml") or ["none"])
def test_maps_of_ros_are_read_as_map_server_reads_them(name: str) -> None:
    said = plain_yaml(MAPS / name)
    pixels = plain_pgm((MAPS / name).with_name(said["image"]))[::-1]  # row 0 lowest
    grey = pixels / 255.0 if int(said["negate"]) else (255.0 - pixels) / 255.0
    occupied = grey > float(said["occupied_thresh"])
    unknown = ~occupied & ~(grey < float(said["free_thresh"]))
    world = am.load_map(MAPS / name)
    assert np.array_equal(world.to_array() != 0, occupied)
    assert np.array_equal(world.unknown_array() != 0, unknown)
    assert world.resolution == float(said["resolution"])
    assert list(world.origin) == [float(part) for part in said["origin"].strip("[]").split(",")]


# ---------------------------------------------------------------------------------------------- MovingAI


@pytest.mark.parametrize("name", [name for name in files(".map") if name.startswith("movingai")] or ["none"])
def test_maps_of_movingai_have_as_many_passable_cells(name: str) -> None:
    lines = (MAPS / name).read_text().splitlines()
    assert lines[0] == "type octile"
    height, width = int(lines[1].split()[1]), int(lines[2].split()[1])
    rows = lines[4 : 4 + height]
    passable = np.array([[letter in ".G" for letter in row[:width]] for row in rows])
    world = am.load_map(MAPS / name, resolution=1.0)
    assert world.shape == (height, width)
    assert np.array_equal(world.to_array()[::-1] == 0, passable)


@pytest.mark.parametrize("name", [name for name in files(".map") if name.startswith("movingai")] or ["none"])
def test_starts_and_goals_of_movingai_are_free(name: str) -> None:
    world = am.load_map(MAPS / name, resolution=1.0)
    rows = [line.split("\t") for line in (MAPS / f"{name}.scen").read_text().splitlines()[1:]]
    places = np.array([[float(number) for number in row[4:8]] for row in rows])
    height = world.shape[0]
    for x, y in ((places[:, 0], places[:, 1]), (places[:, 2], places[:, 3])):
        assert not world.occupied(np.stack((x + 0.5, height - y - 0.5), axis=1)).any()


# ------------------------------------------------------------------------------------------------- Stage


def test_the_worlds_of_stage_have_their_size_and_robots() -> None:
    scenario = am.load(MAPS / "stage" / "simple.world")
    assert scenario.map.size == pytest.approx((16.0, 16.0), abs=2 * 0.02)
    assert scenario.map.resolution == 0.02
    poses = {robot.name: robot.pose for robot in scenario.robots}
    assert list(poses) == ["r0", "r1"] or len(poses) >= 1
    first = poses["r0"]
    assert first is not None
    # The pose of a model is that of its origin, which in pioneer.inc lies 4 cm ahead of the middle.
    assert (first.x, first.y) == pytest.approx((-6.946, -6.947), abs=0.05)
    assert first.heading == pytest.approx(math.radians(45.0))


# -------------------------------------------------------------------------------------------- MobileSim, wld


@pytest.mark.parametrize("name", files(".wld") or ["none"])
def test_line_worlds_have_the_lines_of_their_file(name: str) -> None:
    text = (MAPS / name).read_text(errors="replace")
    count = 0
    for line in text.splitlines():
        words = line.replace("#", ";").partition(";")[0].split()
        count += len(words) in (4, 6, 9) and not words[0][:1].isalpha()
    world = am.load_map(MAPS / name, resolution=0.02)
    assert world.segments is not None
    assert len(world.segments) == count


@pytest.mark.parametrize("name", [name for name in files(".map") if name.startswith("mobilesim")] or ["none"])
def test_maps_of_mobilesim_have_the_lines_of_their_file(name: str) -> None:
    lines = [line.split() for line in (MAPS / name).read_text(errors="replace").splitlines()]
    first = next(number for number, words in enumerate(lines) if words == ["LINES"])
    rows = []
    for words in lines[first + 1 :]:
        if words == ["DATA"]:
            break
        if len(words) == 4:
            rows.append([float(word) / 1000.0 for word in words])
    world = am.load(MAPS / name).map
    assert world.segments is not None
    np.testing.assert_allclose(world.segments, rows, atol=1e-12)
