"""What holds for maps of every format: a robot is put on them, and junk is refused."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.core.maps.footprint_room import least_gaps
from amorsim.scenario.reading.read import scenario_for_map
from amorsim.testing import check_component
from tests.fuzz.maps import LOADERS, MAPS

WALLS = [(0, 0, 6, 0), (6, 0, 6, 4), (6, 4, 0, 4), (0, 4, 0, 0), (2.0, 1.0, 2.5, 3.0)]
MAZE = " _ _ _\n|   | |\n| |_  |\n|s|___|\n1000\n"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A room in every format that is written, and a maze."""
    folder = tmp_path_factory.mktemp("rooms")
    room = am.Map.from_segments(WALLS, resolution=0.05)
    found = {}
    for ending in ("wld", "png", "bmp", "pgm", "gif", "tif", "yaml", "map", "svg", "geojson"):
        found[ending] = folder / f"room.{ending}"
        am.save_map(room, found[ending])
    found["maz"] = folder / "room.maz"
    found["maz"].write_text(MAZE)
    found["dxf"] = folder / "room.dxf"
    lines = "".join(f"0\nLINE\n8\n0\n10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n" for a, b, c, d in WALLS)
    found["dxf"].write_text(f"0\nSECTION\n2\nENTITIES\n{lines}0\nENDSEC\n0\nEOF\n")
    return found


@pytest.mark.parametrize(
    "ending", ["wld", "png", "bmp", "pgm", "gif", "tif", "yaml", "map", "svg", "geojson", "maz", "dxf"]
)
def test_a_pioneer_finds_a_place(files: dict[str, Path], ending: str) -> None:
    options = {"resolution": 0.05} if ending == "map" else {"unit": 1.0} if ending == "dxf" else {}
    scenario = scenario_for_map(files[ending], **options)
    robot, pose = scenario.robots[0], scenario.robots[0].pose
    gap = least_gaps(scenario.map, [(robot.shape, (0.0, 0.0, 0.0))], np.array([[pose.x, pose.y, pose.heading]]))
    assert gap[0] >= 0.0
    if ending == "maz":
        assert (pose.x, pose.y) == (0.5, 0.5)


@pytest.mark.parametrize("ending", LOADERS)
def test_the_contract_is_kept(tmp_path: Path, ending: str) -> None:
    from PIL import Image

    Image.new("L", (6, 5), 205).save(tmp_path / "lab.pgm")
    path = tmp_path / f"a.{ending}"
    path.write_bytes(MAPS[ending])
    check_component(LOADERS[ending][0](), path=path)


@pytest.mark.parametrize("ending", LOADERS)
def test_the_first_bytes_tell(tmp_path: Path, ending: str) -> None:
    from amorsim.plugins.manager import make_registry
    from amorsim.scenario.files.maps import find_loader

    path = tmp_path / "world"
    path.write_bytes(MAPS[ending])
    assert find_loader(path, None, make_registry(entry_points=(), disabled=""))[1] is LOADERS[ending][0]


@pytest.mark.parametrize("ending", LOADERS)
def test_other_files_are_refused(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"a.{ending}"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a", "b" * 100)
    with pytest.raises(am.MapError):
        am.load_map(path)
