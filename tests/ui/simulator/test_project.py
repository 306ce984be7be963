"""Where windows may save: in the project's folder, and nowhere else; and what is said where they cannot."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.core.errors import AmorsimError
from amorsim.ui.simulator.frames.messages import COMMANDS, check
from amorsim.ui.simulator.project import Saver, place_for
from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.saved_scenario import _copying
from tests import building
from tests.ui.aside import aside
from tests.ui.sessions import Make, write_project


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with links that lead out of it, in all ways."""
    folder = tmp_path / "project"
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "there.toml").touch()
    (folder / "runs").mkdir(parents=True)
    (folder / "out").symlink_to("../elsewhere")
    (folder / "there.toml").symlink_to("../elsewhere/there.toml")
    (folder / "dangling.toml").symlink_to("../elsewhere/nothing.toml")
    (folder / "round").symlink_to("round")
    (folder / "near.toml").symlink_to("runs/kept.toml")
    return folder


@pytest.mark.parametrize("name", ["new", "new.toml", "runs/new", "a/b/c/d/e", "near", "x.y (2)", "_"])
def test_names_in_the_folder_are_taken(project: Path, name: str) -> None:
    place = place_for(project, name, ".toml")
    assert place.suffix == ".toml"
    assert place.resolve().is_relative_to(project)


OUTSIDE = ["../new", "/tmp/new", "runs/../../new", ".", "..", "~", "~/new", "a\\..\\b", "C:new", "\\\\host\\share"]
ODD = [".git/hooks", "-x", "a//b", "a/b/c/d/e/f", "new\0", "new\n", "a./b", "a /b", "neü", "", "x" * 101]
NO_NAMES = [None, 7, ["new"], {"new": 1}]


@pytest.mark.parametrize("name", [*OUTSIDE, *ODD, *NO_NAMES], ids=repr)
def test_other_names_are_refused(project: Path, name: Any) -> None:
    with pytest.raises(AmorsimError, match="expected a name"):
        place_for(project, name, ".toml")


@pytest.mark.parametrize(
    ("name", "suffix"), [("out", ""), ("out/new", ".toml"), ("out/new", ""), ("there", ".toml"), ("dangling", ".toml")]
)
def test_links_that_lead_out_are_refused(project: Path, name: str, suffix: str) -> None:
    with pytest.raises(AmorsimError, match="is not in the project's folder"):
        place_for(project, name, suffix)


def test_links_that_lead_to_each_other_are_an_error_of_ours(project: Path) -> None:
    with pytest.raises(AmorsimError, match="round/new: cannot be looked at"):
        place_for(project, "round/new", ".toml")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may do anything")
def test_a_folder_that_may_not_be_looked_into_is_an_error_of_ours(project: Path) -> None:
    (project / "runs").chmod(0)
    try:
        with pytest.raises(AmorsimError, match="runs/new: cannot be looked at"):
            place_for(project, "runs/new", ".toml")
    finally:
        (project / "runs").chmod(0o755)


def test_what_may_not_be_looked_into_is_an_error_of_ours(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def exists(path: Path) -> bool:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "exists", exists)
    with pytest.raises(AmorsimError, match=r"runs/new: cannot be looked at \(Permission denied\)"):
        place_for(project, "runs/new", ".toml")


@pytest.mark.long
def test_a_run_that_cannot_be_written_says_why(project: Path, tmp_path: Path) -> None:
    scenario = write_project(tmp_path)
    (project / "taken").touch()
    saver = Saver(project, Recipe(name=str(scenario)))
    job = {"inputs": [], "tick": 1, "digest": None}
    for name, says in (("taken", "taken"), ("taken/new", "taken/new: cannot make this folder")):
        with pytest.raises(AmorsimError, match=says) as caught:
            aside(saver.save(job, name, "scenario"))
        assert "Traceback" not in str(caught.value)
    (project / "amorsim-runs").touch()
    with pytest.raises(AmorsimError, match="is in the way"):
        aside(saver.save(job, None, "scenario"))


def test_a_scenario_that_cannot_be_written_says_why(start: Make, tmp_path: Path) -> None:
    session = start()
    (tmp_path / "file").touch()
    (tmp_path / "there.toml").mkdir()
    for name, more, says in (
        ("file/new", {}, "cannot be written"),
        ("there", {}, "is there already"),
        ("there", {"overwrite": True}, "cannot be written"),
        ("nothing/new", {}, "cannot be written"),
    ):
        answer = session.request({"do": "save_scenario", "name": name, **more})
        assert not answer["ok"], name
        assert says in answer["error"], name
        assert "Traceback" not in answer["error"]
    assert sorted(path.name for path in tmp_path.rglob("*.toml")) == ["scenario.toml", "there.toml"]


def test_a_map_is_copied_beside_nothing_that_is_there(tmp_path: Path) -> None:
    (tmp_path / "passing").mkdir()
    text = "0 0 1000 0\n0 0 0 1000\n"
    (tmp_path / "passing" / "map.wld").write_text(text)
    (tmp_path / "saved.wld").symlink_to(tmp_path / "elsewhere.wld")  # which is not there
    (tmp_path / "saved-2.wld").write_text("kept")
    scenario = building.scenario(map=am.load_map(tmp_path / "passing" / "map.wld"))
    copy_of = _copying(scenario, [tmp_path / "passing"], tmp_path / "saved.toml")
    assert copy_of(str(tmp_path / "passing" / "map.wld")) == str(tmp_path / "saved-3.wld")
    assert (tmp_path / "saved-3.wld").read_text() == text
    assert (tmp_path / "saved-2.wld").read_text() == "kept"
    assert not (tmp_path / "elsewhere.wld").exists()


def test_no_other_command_names_a_file() -> None:
    named = {
        name for name, shape in COMMANDS.items() if {"name", "file", "path", "folder"} & {*shape.needs, *shape.may}
    }
    # Pictures of maps and manuals are looked up by name, and the path of a parameter is none of files.
    assert named == {"save_scenario", "save_run", "image", "manual", "set", "restore", "add", "remove", "noises"}
    with pytest.raises(AmorsimError):
        check({"do": "write_scenario", "file": "/tmp/x"})
