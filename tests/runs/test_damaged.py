"""Run folders that were edited or damaged: `reproduce` names the file, and the line and column, or the key."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from tests.studies import make_study


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of eight steps in two replicas, driven by hand, in which all that can be changed was changed."""
    base = tmp_path_factory.mktemp("driven")
    simulation = am.Simulation(am.load(make_study(base / "study"), ["recording.picture=false"]), replicas=[3, 7])
    with am.record(simulation, base / "run") as session:
        for step in range(8):
            if step == 2:
                simulation.hand_over("rover", replica=3)
                simulation.set("rover", "errors.drive.track.scale", 1.05, replica=7)
            if step == 3:
                simulation.set_pose("rover", (5.5, 1.0, 0.25), replica=7)
            if step >= 2:
                simulation.robot("rover", 3).drive(forward=0.2, turn=0.1 * step)
            simulation.step()
            session.keep()
    return base / "run"


@pytest.fixture
def folder(driven: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(driven, tmp_path / "run"))


def test_undamaged_it_reproduces(folder: Path) -> None:
    assert am.reproduce(folder).is_exact


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("seed", True),
        ("seed", -1),
        ("seed", 10**400),
        ("replicas", []),
        ("replicas", [3, 3]),
        ("replicas", ["3", 7]),
        ("replicas", [3, 2**40]),
        ("dt", 0.0),
        ("dt", float("nan")),
        ("dt", "0.1"),
        ("dt", 1e-300),
        ("dt", 10**400),
        ("duration", 1e300),
        ("seconds", 10**400),
        ("distance", {"rover": "x"}),
        ("collisions", {"rover": 10**400}),
        ("status", "\ud800"),
        ("steps", 8.0),
        ("steps_done", None),
        ("steps_done", 10**9),
        ("steps_done", 7),
        ("inputs", ["scenario.toml"]),
        ("inputs", {"scenario.toml": 5}),
        ("inputs", {"../../elsewhere": "ab"}),
        ("inputs", {"/dev/zero": "ab"}),
        ("digests", {"3": "ab"}),
        ("digests", ["ab"]),
        ("packages", {"numpy": [1, 26]}),
        ("processor", {}),
        ("format", "2"),
        ("dt", 0.2),
    ],
)
def test_a_value_of_the_wrong_kind_in_run_json_is_named(folder: Path, key: str, value: Any) -> None:
    about = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(about | {key: value}))
    with pytest.raises(am.RunError, match=rf"run.json: is damaged: .*'{key}'"):
        am.reproduce(folder)


def test_a_folder_of_another_version_says_so(folder: Path) -> None:
    about = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(about | {"format": 2, "amorsim": "9.0"}))
    with pytest.raises(am.RunError, match=r"is in format 2, of another version of amorsim \(9.0\); this one reads"):
        am.reproduce(folder)


@pytest.mark.parametrize("text", ["[" * 100_000, '{"status": ' * 900 + "1" + "}" * 900])
def test_nesting_without_end_is_refused(folder: Path, text: str) -> None:
    (folder / "run.json").write_text(text)
    with pytest.raises(am.RunError, match=r"run.json: is damaged"):
        am.reproduce(folder)


@pytest.mark.parametrize(
    ("file", "old", "new", "problem"),
    [
        ("events.csv", '"[5.5, 1.0, 0.25]"', "5", r"line 4, value: expected a pose of three finite numbers, got 5"),
        ("events.csv", "[5.5, 1.0, 0.25]", "[5.5, NaN, 0.25]", r"line 4, value: expected a pose of three finite"),
        ("events.csv", "[5.5, 1.0, 0.25]", "[5.5, 1.0", r"line 4, value: expected a value as JSON"),
        ("events.csv", '"[5.5, 1.0, 0.25]"', "[" * 5000, r"line 4, value: .*nested too deeply"),
        ("events.csv", "[5.5, 1.0, 0.25]", "[1e9, 1.0, 0.25]", r"line 4, value: robot 'rover' cannot stand at"),
        ("events.csv", "1.05", "[1.05]", r"line 3, value: "),
        ("events.csv", "1.05", '"{""values"": 3, ""kind"": ""normal""}"', r"line 3, value: expected a value as JSON"),
        ("events.csv", '""hand""', '""foot""', r"line 2, value: .*expected to hand it over to 'hand'"),
        ("events.csv", "track.scale", "trak.scale", r"line 3, value: .*trak"),
        ("events.csv", "7,0.200000,rover,parameter_set", "7,0.200000,rove,parameter_set", r"line 3, value: .*'rove'"),
        ("events.csv", "7,0.200000,rover,parameter_set", "8,0.200000,rover,parameter_set", r"line 3, replica: "),
        ("events.csv", ",2\n", ",two\n", r"line 2, tick: expected a whole number >= 0, got 'two'"),
        ("events.csv", "kind", "kinds", r"line 1: is damaged: no column 'kind'"),
        ("commands.csv", "\n3,0.300000", "\n3,nan", r"line 8, time: expected a finite number, got 'nan'"),
        ("commands.csv", "\n3,0.300000,rover,", "\n3,0.300000,rover,x", r"line 8, left: expected a finite number"),
        ("commands.csv", "\n3,0.300000,", "\n5,0.300000,", r"line 8, replica: there is no replica 5"),
        ("commands.csv", "left", "levt", r"line 1: is damaged: no column 'left'.* Did you mean 'levt'"),
        ("commands.csv", "\n3,0.300000,rover,", "\n3,0.300000,", r"line 8: is damaged: expected 5 cells, got 4"),
    ],
)
def test_what_is_given_again_is_checked(folder: Path, file: str, old: str, new: str, problem: str) -> None:
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1))
    with pytest.raises(am.RunError, match=rf"{file}, {problem}"):
        am.reproduce(folder)


@pytest.mark.parametrize("name", ["poses.csv", "velocities.csv", "sensors/laser.csv", "estimates/dead_reckoning.csv"])
@pytest.mark.parametrize("cell", [b"nan", b"inf", b"1e400", b"\xff", b"x" * 200_000, b'"'])
def test_a_damaged_result_is_a_difference(folder: Path, name: str, cell: bytes) -> None:
    lines = (folder / name).read_bytes().split(b"\n")
    cells = lines[3].split(b",")
    cells[1] = cell  # the time
    lines[3] = b",".join(cells)
    (folder / name).write_bytes(b"\n".join(lines))
    outcome = am.reproduce(folder)
    assert not outcome.is_same
    assert f"in {name}, line 4" in outcome.difference
    assert len(outcome.difference) < 1000


def test_a_result_that_is_no_file_is_named(folder: Path) -> None:
    (folder / "velocities.csv").unlink()
    (folder / "velocities.csv").symlink_to("/dev/zero")
    with pytest.raises(am.RunError, match=r"velocities.csv: cannot be read \(it is not a regular file\)"):
        am.reproduce(folder)


def test_an_input_that_is_no_file_is_named(folder: Path) -> None:
    (folder / "controller.py").unlink()
    (folder / "controller.py").symlink_to("/dev/zero")
    with pytest.raises(am.RunError, match=r"controller.py: cannot be read \(it is not a regular file\)"):
        am.reproduce(folder)
