"""Running a run again: to the bit, with what came from outside; and where it differs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.recorders.arrays import Arrays
from tests.studies import make_study


@pytest.fixture
def study(tmp_path: Path) -> Path:
    return make_study(tmp_path / "study")


@pytest.fixture
def folder(study: Path, tmp_path: Path) -> Path:
    return am.run(am.load(study), tmp_path / "run", duration=2.0).folder


def change(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def change_about(folder: Path, **changes: Any) -> None:
    about = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(about | changes))


def test_a_run_reproduces(folder: Path) -> None:
    outcome = am.reproduce(folder)
    assert (outcome.is_same, outcome.is_exact, outcome.steps, outcome.notes) == (True, True, 20, ())
    assert str(outcome) == "the same to the bit, over 20 steps"


def test_one_that_is_interrupted_names_no_folder_that_is_gone(folder: Path) -> None:
    def interrupt(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        am.reproduce(folder, progress=interrupt)
    assert getattr(caught.value, "__notes__", []) == []


def test_replicas_reproduce(study: Path, tmp_path: Path) -> None:
    am.run(am.load(study), tmp_path / "run", seed=5, replicas=[2, 40, 7], duration=1.0)
    assert am.reproduce(tmp_path / "run").is_exact


def test_changes_before_the_recording_are_made_before_it_again(study: Path, tmp_path: Path) -> None:
    """And those after its start, at the same tick, after it."""
    simulation = am.Simulation(am.load(study))
    simulation.set_pose("rover", (2.0, 3.0, 0.5))
    with am.record(simulation, tmp_path / "run") as session:
        simulation.set_pose("rover", (2.5, 3.0, 1.0))
        for _ in range(5):
            simulation.step()
            session.keep()
    outcome = am.reproduce(tmp_path / "run")
    assert outcome.is_exact, str(outcome)


@pytest.mark.parametrize("how", ["reset", "reset to a seed", "restore"])
def test_what_begins_again_cannot_be_recorded(study: Path, tmp_path: Path, how: str) -> None:
    simulation = am.Simulation(am.load(study))
    snapshot = simulation.snapshot()
    session = am.record(simulation, tmp_path / "run")
    if how == "restore":
        simulation.restore(snapshot)
    else:
        simulation.reset(3 if how == "reset to a seed" else None)
    simulation.step()
    with pytest.raises(am.RunError, match=r"reset or restored while it was recorded.*a folder of its own"):
        session.keep()


def test_what_a_hand_did_is_done_again(study: Path, tmp_path: Path) -> None:
    simulation = am.Simulation(am.load(study, ["robots.0.controller.use=manual"]), replicas=[3, 7])
    simulation.set("rover", "errors.drive.track.scale", np.float64(1.05))
    with am.record(simulation, tmp_path / "run") as session:
        for step in range(40):
            for replica in (3, 7):
                # Numbers without end, so that nothing but all their digits replays.
                simulation.robot("rover", replica).drive(forward=0.2 + step / 300, turn=np.sin(step / 7 + replica))
            if step == 10:
                simulation.set("rover", "sensors.laser.noise.gaussian.std", 1 / 30, replica=7)
            if step == 20:
                simulation.set_pose("rover", np.array([5.5, 1.0 + 1 / 3, 1 / 7]), replica=3)
            simulation.step()
            session.keep()
    assert session.summary.digests[3] != session.summary.digests[7]
    outcome = am.reproduce(tmp_path / "run")
    assert outcome.is_exact, str(outcome)
    # Each of the three is needed for it.
    change(tmp_path / "run" / "events.csv", "1.05", "1.04")
    assert "replica 3" in am.reproduce(tmp_path / "run").difference


@pytest.mark.parametrize(
    ("file", "old", "new", "tick"),
    [
        ("events.csv", "0.03333333333333333", "0.05333333333333333", 11),
        ("events.csv", "1.3333333333333333", "1.3333433333333333", 21),
        ("commands.csv", "0.1,", "0.2,", None),
    ],
)
def test_a_changed_record_of_a_hand_is_noticed(
    study: Path, tmp_path: Path, file: str, old: str, new: str, tick: int | None
) -> None:
    simulation = am.Simulation(am.load(study, ["robots.0.controller.use=manual"]))
    with am.record(simulation, tmp_path / "run") as session:
        for step in range(22):
            simulation.robot("rover").command(0.1, 0.3 + step / 7)
            if step == 10:
                simulation.set("rover", "sensors.laser.noise.gaussian.std", 1 / 30)
            if step == 20:
                simulation.set_pose("rover", [5.5, 1.0 + 1 / 3, 1 / 7])
            simulation.step()
            session.keep()
    change(tmp_path / "run" / file, old, new)
    outcome = am.reproduce(tmp_path / "run")
    assert not outcome.is_same
    if tick is not None:
        assert (outcome.tick, outcome.robot) == (tick, "rover")


def test_errors_that_are_drawn_can_be_set_and_set_again(study: Path, tmp_path: Path) -> None:
    simulation = am.Simulation(am.load(study), replicas=3)
    drawn = am.Distribution(kind="normal", values=(1.0, 0.1))
    with am.record(simulation, tmp_path / "run") as session:
        for step in range(12):
            if step == 3:
                simulation.set("rover", "errors.drive.wheel_radius_right", am.Deviation(scale=drawn))
            if step == 6:
                simulation.set("rover", "errors.drive.track", {"scale": drawn, "add": 0.01}, replica=1)
            simulation.step()
            session.keep()
    assert am.reproduce(tmp_path / "run").is_exact


def test_chance_of_a_controllers_own_is_named_with_tick_and_robot(tmp_path: Path) -> None:
    code = (
        "import random\nimport amorsim as am\n\n\ndef drive(readings, estimate, clock, speed):\n"
        "    return am.Twist(speed, random.random() if clock.tick >= 7 else 0.0)\n"
    )
    study = make_study(tmp_path / "study", code)
    am.run(am.load(study), tmp_path / "run", duration=2.0)
    outcome = am.reproduce(tmp_path / "run")
    assert not outcome.is_same
    # Asked at tick 7, it led to tick 8.
    assert (outcome.tick, outcome.robot) == (8, "rover")
    assert "in commands.csv" in outcome.difference
    assert any("randomness of its own" in note for note in outcome.notes)


@pytest.mark.parametrize("name", ["poses.csv", "sensors/laser.csv", "estimates/dead_reckoning.csv", "velocities.csv"])
def test_a_result_that_was_changed_after_the_run_is_found(folder: Path, name: str) -> None:
    lines = (folder / name).read_text().splitlines()
    cells = lines[7].split(",")
    cells[-1] = f"{float(cells[-1]) + 0.001:.6f}"
    lines[7] = ",".join(cells)
    (folder / name).write_text("\n".join(lines) + "\n")
    outcome = am.reproduce(folder)
    assert not outcome.is_same
    assert "a file was changed after the run" in outcome.difference
    assert f"in {name}, line 8" in outcome.difference
    assert outcome.tick == 6


@pytest.mark.parametrize("is_text", [True, False])
def test_beliefs_are_kept_and_compared(tmp_path: Path, is_text: bool) -> None:
    also = [Arrays(every=0.2)]
    scenario = attrs.evolve(am.load("landmarks"), recording=am.Recording(picture=False, also=also), resolved=None)
    folder = am.run(scenario, tmp_path / "run", duration=0.4).folder
    assert am.reproduce(folder).is_same
    if is_text:
        path = folder / "beliefs" / "ekf.csv"
        *lines, last = path.read_text().splitlines()
        cells = last.split(",")
        column = lines[0].split(",").index("landmarks_used_0")
        cells[column] = "0.5"
        path.write_text("\n".join([*lines, ",".join(cells)]) + "\n")
    else:
        path = folder / "beliefs" / "ekf" / "000000004.npz"
        with np.load(path) as found:
            whole = dict(found)
        whole["landmarks_used"] = np.where(whole["landmarks_used"] == 1.0, 0.0, whole["landmarks_used"])
        np.savez_compressed(path, **whole)
    outcome = am.reproduce(folder)
    assert not outcome.is_same
    assert path.relative_to(folder).as_posix() in outcome.difference


def test_an_input_that_was_changed_after_the_run_is_named(folder: Path) -> None:
    change(folder / "controller.py", "ahead > 0.8", "ahead > 3.5")
    outcome = am.reproduce(folder)
    assert not outcome.is_same
    assert outcome.notes == ("controller.py has been changed since the run",)


def test_another_version_is_named(folder: Path) -> None:
    change_about(folder, packages={"numpy": "1.26.0"}, python="3.11.0")
    outcome = am.reproduce(folder)
    assert outcome.is_exact
    assert any(note.startswith("numpy was 1.26.0 and is ") for note in outcome.notes)
    assert any(note.startswith("numba was absent and is ") for note in outcome.notes)
    assert any(note.startswith("python was 3.11.0") for note in outcome.notes)


def test_on_another_processor_the_files_are_compared_by_tolerance(folder: Path) -> None:
    change_about(folder, digests={"0": "0" * 32})
    here = am.reproduce(folder)
    assert not here.is_same
    assert "by less than is written" in here.difference
    change_about(folder, processor="x86_64 z80")
    elsewhere = am.reproduce(folder)
    assert (elsewhere.is_same, elsewhere.is_exact) == (True, False)
    assert "the same to 2e-06" in str(elsewhere)
    assert "processor was x86_64 z80" in str(elsewhere)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("", "cannot be read"),
        ("[]", "is damaged"),
        ("{}", "expected a text under 'status'"),
        ('{"status": "finished", "seed": "1", "replicas": [0], "dt": 0.1, "steps": 1}', "a whole number under 'seed'"),
        ('{"status": "running", "seed": 1, "replicas": [0], "dt": 0.1, "steps": 1}', "did not end in order"),
    ],
)
def test_a_damaged_or_unfinished_run_is_refused_in_words(folder: Path, content: str, problem: str) -> None:
    (folder / "run.json").write_text(content)
    with pytest.raises(am.RunError, match=problem):
        am.reproduce(folder)


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    with pytest.raises(am.RunError, match=r"expected the folder of a run, with a run.json in it"):
        am.reproduce(tmp_path)
