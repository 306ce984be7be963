"""Maps of several files: a run's folder gets all of them, and runs again where they were."""

from __future__ import annotations

import types
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.plugins import manager
from amorsim.scenario.files.maps import MapFile, companions_of
from amorsim.scenario.files.write import with_copies

ROOM = "######\n#    #\n#    #\n######\n"
SCENARIO = """
format = 1
[world]
map = "{map}"
[simulation]
duration = 0.3
[[robots]]
name = "rover"
model = "pioneer2dx"
pose = {{ x = 2.0, y = 2.0 }}
controller = {{ use = "manual" }}
"""


@attrs.frozen(kw_only=True)
class Sheet(am.MapLoader):
    """A text that names the file of its cells."""

    extensions: ClassVar[tuple[str, ...]] = (".sheet",)

    def _cells(self, path: Path) -> Path:
        try:
            return path.parent / path.read_text(encoding="utf-8").strip()
        except (OSError, ValueError) as error:
            raise am.MapError(f"{path}: cannot be read: {error}") from error

    def load(self, path: Path) -> am.Map:
        """The map."""
        try:
            lines = self._cells(path).read_text(encoding="utf-8").splitlines()
        except (OSError, ValueError) as error:
            raise am.MapError(f"{path}: its cells cannot be read: {error}") from error
        return am.Map.from_array(np.array([[c == "#" for c in line] for line in reversed(lines)]), resolution=1.0)

    def companions(self, path: Path) -> Sequence[Path]:
        """The file of the cells."""
        return [self._cells(path)]

    @classmethod
    def save(cls, world: am.Map, path: Path) -> am.MapLoader:
        """Write both files."""
        rows = ["".join("# "[not cell] for cell in row) for row in world.to_array()[::-1].tolist()]
        path.with_suffix(".cells").write_text("\n".join(rows) + "\n", encoding="utf-8")
        path.write_text(path.with_suffix(".cells").name, encoding="utf-8")
        return cls()


@attrs.frozen(kw_only=True)
class Forgetful(Sheet):
    """Names no companions."""

    def companions(self, path: Path) -> Sequence[Path]:
        """None."""
        return ()


@pytest.fixture(autouse=True)
def _sheets(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    def amorsim_register(registry: am.Registry) -> None:
        registry.map_loader("sheet", Sheet)

    plugin = types.ModuleType("sheets")
    plugin.amorsim_register = am.hookimpl(amorsim_register)  # type: ignore[attr-defined]
    registry = manager.make_registry({"sheets": plugin}, entry_points=(), disabled="")
    monkeypatch.setattr(manager, "make_registry", lambda: registry)
    manager.default_registry.cache_clear()
    yield
    manager.default_registry.cache_clear()


def make(folder: Path, sheet: str, cells: str, named: str) -> Path:
    """A scenario whose map is a sheet."""
    for name, text in ((sheet, named), (cells, ROOM), ("scenario.toml", SCENARIO.format(map=sheet))):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder / "scenario.toml"


@pytest.mark.parametrize(
    ("sheet", "cells", "named", "copies"),
    [
        ("room.sheet", "room.cells", "room.cells", {"room/room.sheet", "room/room.cells"}),
        ("room.sheet", "parts/a.cells", "parts/a.cells", {"room/room.sheet", "room/parts/a.cells"}),
        ("maps/room.sheet", "cells/a", "../cells/a", {"room/maps/room.sheet", "room/cells/a"}),
    ],
)
def test_a_run_keeps_all_files_of_its_map_and_reproduces(
    tmp_path: Path, sheet: str, cells: str, named: str, copies: set[str]
) -> None:
    scenario = make(tmp_path / "study", sheet, cells, named)
    am.run(am.load(scenario), tmp_path / "run")
    (tmp_path / "study").rename(tmp_path / "elsewhere")
    room = tmp_path / "run" / "room"
    assert {path.relative_to(tmp_path / "run").as_posix() for path in room.rglob("*") if path.is_file()} == copies
    assert am.reproduce(tmp_path / "run").is_exact
    am.run(am.load(tmp_path / "run" / "scenario.toml"), tmp_path / "again")
    assert {path.relative_to(tmp_path / "again").as_posix() for path in (tmp_path / "again").rglob("room/**/*.*")} >= {
        copy for copy in copies if "." in copy
    }


def test_a_folder_that_is_named_from_the_present_one_keeps_them_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = make(tmp_path / "study", "room.sheet", "room.cells", "room.cells")
    monkeypatch.chdir(tmp_path)
    am.run(am.load(scenario), "run")
    assert (tmp_path / "run" / "room" / "room.cells").is_file()


def test_two_maps_with_companions_of_one_name_are_both_kept(tmp_path: Path) -> None:
    scenario = make(tmp_path / "study", "room.sheet", "cells", "cells")
    make(tmp_path / "study" / "old", "room.sheet", "cells", "cells")
    (tmp_path / "study" / "old" / "cells").write_text(ROOM.replace("#    #", "# #  #"))
    with scenario.open("a") as file:
        file.write('knowledge.map = "old/room.sheet"\n')
    read = am.load(scenario)
    (tmp_path / "copy").mkdir()
    document = with_copies(read, tmp_path / "copy")
    assert (document["world"]["map"], document["robots"][0]["knowledge"]["map"]) == (
        "room/room.sheet",
        "room_2/room.sheet",
    )
    assert am.load_map(tmp_path / "copy" / "room_2" / "room.sheet") == read.robots[0].knowledge.map


@pytest.mark.parametrize("folder", ["study", "pictures"])
def test_a_picture_of_ros_that_is_named_by_its_whole_path_is_copied_too(tmp_path: Path, folder: str) -> None:
    (tmp_path / "study").mkdir()
    (tmp_path / folder).mkdir(exist_ok=True)
    room = np.array([[c == "#" for c in line] for line in ROOM.splitlines()])
    am.save_map(am.Map.from_array(room, resolution=1.0), tmp_path / folder / "room.yaml")
    text = (tmp_path / folder / "room.yaml").read_text()
    whole = tmp_path / folder / "room.pgm"
    (tmp_path / "study" / "room.yaml").write_text(text.replace("'room.pgm'", str(whole)))
    (tmp_path / "study" / "scenario.toml").write_text(SCENARIO.format(map="room.yaml"))
    am.run(am.load(tmp_path / "study" / "scenario.toml"), tmp_path / "run")
    (picture,) = (tmp_path / "run").rglob("*.pgm")
    assert picture.read_bytes() == whole.read_bytes()
    whole.unlink()
    assert am.load(tmp_path / "run" / "scenario.toml").map.to_array().tolist() == room.astype(int).tolist()


def test_a_map_that_names_its_companion_by_its_whole_path_is_refused(tmp_path: Path) -> None:
    scenario = make(tmp_path / "study", "room.sheet", "cells", str(tmp_path / "study" / "cells"))
    with pytest.raises(am.RunError, match=r"room\.sheet: its copy would still read .*study/cells; name .* relative"):
        am.run(am.load(scenario), tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("answer", "problem"),
    [
        (None, "Sheet.companions gave None; expected a list of paths"),
        (["cells"], "expected a list of paths"),
        ([Path("gone")], r"gone, which it should read, is not a file"),
    ],
)
def test_companions_that_are_none_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answer: object, problem: str
) -> None:
    make(tmp_path, "room.sheet", "cells", "cells")
    monkeypatch.setattr(Sheet, "companions", lambda *_: answer)
    with pytest.raises(am.MapError, match=problem):
        companions_of(MapFile(path=tmp_path / "room.sheet", loader=Sheet()))


def test_a_map_of_two_files_is_saved_with_both(tmp_path: Path) -> None:
    plan = am.Map.from_array(np.eye(3), resolution=1.0)
    again = am.save_map(plan, tmp_path / "plan.sheet")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plan.cells", "plan.sheet"]
    assert am.load_map(tmp_path / "plan.sheet") == again
    assert again.source.path == tmp_path / "plan.sheet"


def test_the_check_of_loaders_finds_a_companion_that_is_not_named(tmp_path: Path) -> None:
    from amorsim.testing import check_component

    make(tmp_path, "room.sheet", "cells", "cells")
    check_component(Sheet(), path=tmp_path / "room.sheet")
    with pytest.raises(am.ComponentError, match=r"companions.*a copy of room.sheet and its companions.*cannot be read"):
        check_component(Forgetful(), path=tmp_path / "room.sheet")
