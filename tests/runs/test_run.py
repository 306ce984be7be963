"""A run and its folder: whole, on its own feet, and given back where it did not begin."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import attrs
import numpy as np
import pytest
from PIL import Image

import amorsim as am
from amorsim.runs.folder import RunFolder, new_folder
from tests import building
from tests.disks import small_disk
from tests.studies import make_study

FILES = {
    "scenario.toml",
    "rooms.wld",
    "controller.py",
    "run.json",
    "poses.csv",
    "velocities.csv",
    "commands.csv",
    "events.csv",
    "picture.png",
    *(f"sensors/{name}.csv" for name in ("compass", "encoder", "gyro", "laser", "sonar")),
    "estimates/dead_reckoning.csv",
}


def files_of(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def about(folder: Path) -> dict[str, object]:
    read: dict[str, object] = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    return read


@pytest.fixture
def study(tmp_path: Path) -> Path:
    return make_study(tmp_path / "study")


@pytest.mark.pictures
def test_a_run_leaves_its_folder(study: Path, tmp_path: Path) -> None:
    simulation = am.Simulation(am.load(study))
    summary = am.run(simulation.scenario, tmp_path / "run", duration=2.0, simulation=simulation)
    assert files_of(tmp_path / "run") == FILES
    record = about(tmp_path / "run")
    assert (record["status"], record["seed"], record["steps"], record["steps_done"]) == ("finished", 1, 20, 20)
    assert record["digests"] == {"0": simulation.digest(0)}
    assert summary.is_complete
    assert summary.digests == {0: simulation.digest(0)}
    off = np.hypot(*(simulation.true_pose - simulation.estimated_pose)[0, :2])
    assert summary.final_error["rover"] == pytest.approx(off)
    with Image.open(tmp_path / "run" / "picture.png") as picture:
        assert min(picture.size) > 500


def test_the_folder_runs_again_as_it_is_wherever_it_lies(study: Path, tmp_path: Path) -> None:
    first = am.run(am.load(study), tmp_path / "run", seed=9, duration=2.0)
    (tmp_path / "run").rename(tmp_path / "moved")
    for name in ("rooms.wld", "controller.py"):
        (study.parent / name).unlink()
    again = am.run(am.load(tmp_path / "moved" / "scenario.toml"), tmp_path / "again")
    assert again.digests == first.digests
    assert (tmp_path / "again" / "poses.csv").read_bytes() == (tmp_path / "moved" / "poses.csv").read_bytes()


def test_replica_37_of_many_writes_the_files_that_it_writes_alone(study: Path, tmp_path: Path) -> None:
    scenario = am.load(study, ["recording.sensors=all"])
    many = am.run(scenario, tmp_path / "many", replicas=40, duration=0.5)
    alone = am.run(scenario, tmp_path / "alone", replicas=[37], duration=0.5)
    assert alone.digests[37] == many.digests[37]
    tables = [name for name in files_of(tmp_path / "alone") if name.endswith(".csv")]
    assert len(tables) == 10
    for name in tables:
        lines = (tmp_path / "many" / name).read_text().splitlines()
        assert lines[0].startswith("replica,")
        own = [line.removeprefix("37,") for line in lines[1:] if line.startswith("37,")]
        assert own == (tmp_path / "alone" / name).read_text().splitlines()[1:], name


def test_sensors_of_very_many_replicas_are_left_out_unless_asked_for(study: Path, tmp_path: Path) -> None:
    am.run(am.load(study), tmp_path / "32", replicas=32, duration=0.1)
    assert (tmp_path / "32" / "sensors" / "laser.csv").exists()
    am.run(am.load(study), tmp_path / "33", replicas=33, duration=0.1)
    assert not (tmp_path / "33" / "sensors").exists()


def test_the_distance_is_what_was_driven_not_where_the_robot_was_put(tmp_path: Path, study: Path) -> None:
    simulation = am.Simulation(am.load(study, ["robots.0.controller.use=manual", "robots.0.errors={}"]))
    with am.record(simulation, tmp_path / "run") as session:
        for step in range(20):
            if step == 10:
                simulation.set_pose("rover", (6.0, 1.0, 0.0))
            simulation.robot("rover").drive(forward=0.2)
            simulation.step()
            session.keep()
    travel = np.loadtxt(tmp_path / "run" / "velocities.csv", delimiter=",", skiprows=1, usecols=2).sum() * 0.1
    assert session.summary.distance["rover"] == pytest.approx(travel, abs=1e-5)
    assert 0.3 < travel < 0.4


def test_collisions_are_events_and_counted(study: Path, tmp_path: Path) -> None:
    simulation = am.Simulation(am.load(study, ["robots.0.controller.use=manual"]))
    with am.record(simulation, tmp_path / "run") as session:
        for _ in range(150):
            simulation.robot("rover").drive(forward=0.5)
            simulation.step()
            session.keep()
    assert session.summary.collisions == {"rover": 1}
    events = (tmp_path / "run" / "events.csv").read_text().splitlines()
    assert [line.split(",")[2] for line in events] == ["kind", "collision", "controller_ended"]
    _, _, _, other, x, _, speed, *_ = events[1].split(",")
    assert other == "wall"
    assert float(x) == pytest.approx(4.0, abs=0.002)
    assert float(speed) == pytest.approx(0.5, rel=0.02)


# ------------------------------------------------------------------------------------------------------ no folder


def test_a_folder_that_holds_something_is_left_alone(study: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("all of it")
    with pytest.raises(am.RunError, match=r"mine: the folder holds files already, such as thesis\.txt;"):
        am.run(am.load(study), tmp_path / "mine")
    assert files_of(tmp_path / "mine") == {"thesis.txt"}
    with pytest.raises(am.RunError, match=r"thesis.txt: is a file"):
        am.run(am.load(study), tmp_path / "mine" / "thesis.txt")


def test_what_cannot_be_written_into_a_file_leaves_no_folder(tmp_path: Path) -> None:
    def drive(readings, estimate, clock):
        return am.Twist(0.1, 0.0)

    robot = building.robot(controller=drive)
    with pytest.raises(am.ScenarioError, match="given as an object, so a file cannot name it"):
        am.run(building.scenario(robot), tmp_path / "deep" / "run", duration=1.0)
    assert not (tmp_path / "deep").exists()


@pytest.mark.parametrize("made_from", ["lines", "cells"])
def test_a_map_made_in_python_is_written_down_and_reproduces(tmp_path: Path, made_from: str) -> None:
    world = building.room(resolution=0.01)
    if made_from == "cells":
        world = am.Map.from_array(world.to_array(), resolution=0.01, origin=(-1.0, -0.5, 0.1))
    robot = attrs.evolve(building.robot(), knowledge=am.Knowledge(map=world))
    scenario = building.scenario(robot, map=world)
    summary = am.run(scenario, tmp_path / "run", duration=1.0)
    assert files_of(tmp_path / "run") >= {f"{world.name or 'map'}.{'wld' if made_from == 'lines' else 'png'}"}
    assert am.reproduce(tmp_path / "run").is_same
    simulation = am.Simulation(scenario)
    simulation.run(1.0)
    assert simulation.digest(0) == summary.digests[0]


def test_a_run_that_cannot_begin_gives_its_folder_back(study: Path, tmp_path: Path) -> None:
    scenario = am.load(study)
    simulation = am.Simulation(scenario)
    (study.parent / "rooms.wld").unlink()  # it cannot be copied any more
    (tmp_path / "empty").mkdir()
    for folder in (tmp_path / "deep" / "run", tmp_path / "empty"):
        with pytest.raises(am.RunError, match=r"rooms.wld: cannot be copied"):
            am.run(scenario, folder, simulation=simulation)
    assert not (tmp_path / "deep").exists()
    assert list((tmp_path / "empty").iterdir()) == []


def test_a_controller_that_fails_at_once_leaves_no_folder(tmp_path: Path) -> None:
    study = make_study(tmp_path / "study", "def drive(readings, estimate, clock, speed):\n    return 'left'\n")
    with pytest.raises(am.ControllerError, match="returned 'left'"):
        am.run(am.load(study), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_two_runs_that_begin_together_get_folders_of_their_own(tmp_path: Path) -> None:
    assert [new_folder("demo", tmp_path).name for _ in range(3)] == ["demo-001", "demo-002", "demo-003"]


@pytest.mark.parametrize("duration", [0.0, -1.0, float("nan"), float("inf"), 1e300])
def test_a_duration_that_no_run_can_have_is_refused(study: Path, tmp_path: Path, duration: float) -> None:
    with pytest.raises((am.RunError, am.ParameterError), match="duration: expected a number"):
        am.run(am.load(study), tmp_path / "run", duration=duration)
    assert not (tmp_path / "run").exists()


# ------------------------------------------------------------------------------------------------------ broken off


def test_a_controller_that_fails_later_leaves_whole_files_up_to_there(tmp_path: Path) -> None:
    code = "def drive(readings, estimate, clock, speed):\n    return [1.0 / (1.0 - clock.time), 1.0]\n"
    study = make_study(tmp_path / "study", code)
    with pytest.raises(am.ControllerError, match="ZeroDivisionError") as caught:
        am.run(am.load(study), tmp_path / "run")
    assert f"the files up to 1 s are in {tmp_path / 'run'}" in caught.value.__notes__
    record = about(tmp_path / "run")
    assert (record["status"], record["steps_done"]) == ("broken off", 10)
    for table in (tmp_path / "run").rglob("*.csv"):
        text = table.read_text()
        assert text.endswith("\n")
        if table.name != "events.csv":
            assert text.splitlines()[-1].startswith("1.000000,"), table
    # What was done can be done again.
    assert str(am.reproduce(tmp_path / "run")) == "the same to the bit, over 10 steps"


def test_a_disk_that_is_full_is_reported_once_and_no_more_is_claimed_than_there_is(study: Path, tmp_path: Path) -> None:
    simulation = am.Simulation(am.load(study))
    session = am.record(simulation, tmp_path / "run")

    def fill_the_disk() -> None:
        with session, small_disk(20_000):
            for _ in range(1000):
                simulation.step()
                session.keep()

    with pytest.raises(am.RunError, match=r"laser\.csv: cannot be written \(File too large\)") as caught:
        fill_the_disk()
    ends = []
    for name in files_of(tmp_path / "run"):
        if name.endswith(".csv") and name != "events.csv":
            text = (tmp_path / "run" / name).read_text()
            assert text.endswith("\n")
            ends.append(float(text.splitlines()[-1].split(",")[0]))
    end, simulated = min(ends), session.steps * simulation.dt
    assert 0.0 < end < 10 * simulation.dt < simulated
    words = f"end early, the first of them at {end:g} s, though {simulated:g} s were simulated"
    assert caught.value.__notes__ == [f"the files in {tmp_path / 'run'} {words}"]
    record = about(tmp_path / "run")
    assert (record["status"], record["steps_done"], record["digests"]) == ("broken off", round(end / simulation.dt), {})
    assert record["problem"] == str(caught.value)
    assert session.summary.steps == record["steps_done"]
    with pytest.raises(am.RunError, match="has no digests"):
        am.reproduce(tmp_path / "run")


def test_a_recorder_of_ones_own_that_fails_leaves_the_other_files_whole(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = am.record(simulation := am.Simulation(am.load(study)), tmp_path / "run")

    class Failing:
        def close(self) -> None:
            raise ValueError("nothing to count")

    monkeypatch.setattr(session, "_recorders", [*session._recorders, Failing()])
    simulation.step()
    monkeypatch.setattr(Failing, "write", lambda *_: None, raising=False)
    monkeypatch.setattr(Failing, "write_obstacles", lambda *_: None, raising=False)
    session.keep()
    with pytest.raises(am.ComponentError, match=r"Failing: close\(\) raised ValueError: nothing to count") as caught:
        session.close()
    assert caught.value.__notes__ == [f"the files up to 0.1 s are in {tmp_path / 'run'}"]
    assert about(tmp_path / "run")["digests"] == {"0": simulation.digest(0)}


def test_the_first_that_a_run_writes_is_a_whole_account_of_it(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def look(scenario: am.Scenario, folder: Path) -> None:
        seen.append((files_of(folder), about(folder)["status"]))
        raise am.RunError("enough")

    monkeypatch.setattr("amorsim.runs.session.with_copies", look)
    with pytest.raises(am.RunError, match="enough"):
        am.run(am.load(study), tmp_path / "run")
    assert seen == [({"run.json"}, "running")]
    assert not (tmp_path / "run").exists()


def test_of_two_runs_that_begin_in_one_empty_folder_one_is_refused(tmp_path: Path) -> None:
    first = RunFolder(tmp_path, "run", {"first": True})
    with pytest.raises(am.RunError, match="holds files already"):
        RunFolder(tmp_path, "run", {})
    with pytest.raises(am.RunError, match="holds files already"):  # one that found it empty a moment ago
        first._claim({})
    assert about(tmp_path) == {"first": True}
    assert files_of(tmp_path) == {"run.json"}


KILLED = """
import os, signal, sys
from amorsim.runs.folder import RunFolder
os.link = lambda *_: os.kill(os.getpid(), signal.SIGKILL)  # what claims the folder
RunFolder(sys.argv[1], "run", {})
"""


def test_a_run_that_was_killed_in_its_first_moment_leaves_its_folder_free(tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-c", KILLED, str(tmp_path)], check=False)
    assert len(list(tmp_path.iterdir())) == 1
    RunFolder(tmp_path, "run", {"second": True})
    assert [path.name for path in tmp_path.iterdir()] == ["run.json"]
    assert about(tmp_path) == {"second": True}


def test_room_is_kept_for_the_last_word(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = RunFolder(tmp_path, "run", {})
    folder.set_room_aside(100)
    (room,) = tmp_path.glob(".amorsim-*-room")
    assert room.stat().st_size > 100
    seen = []
    monkeypatch.setattr("amorsim.runs.folder.write_text", lambda *_: seen.append(files_of(tmp_path)))
    folder.write_end({})
    assert seen == [{"run.json"}]


def test_ctrl_c_ends_a_run_between_two_steps(study: Path, tmp_path: Path) -> None:
    def press(share: float) -> None:
        if share > 0.5:
            signal.raise_signal(signal.SIGINT)

    summary = am.run(am.load(study), tmp_path / "run", duration=2.0, progress=press)
    assert (summary.is_complete, summary.steps) == (False, 11)
    assert about(tmp_path / "run")["status"] == "interrupted"
    assert (tmp_path / "run" / "picture.png").exists()
    assert am.reproduce(tmp_path / "run").is_exact
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_in_a_script_of_ones_own_ends_its_session_in_order(study: Path, tmp_path: Path) -> None:
    simulation = am.Simulation(am.load(study))
    session = am.record(simulation, tmp_path / "run")

    def drive_until_pressed() -> None:
        with session:
            simulation.step()
            session.keep()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        drive_until_pressed()
    assert about(tmp_path / "run")["status"] == "interrupted"
    assert not session.summary.is_complete


# ------------------------------------------------------------------------------------------------------ a session


def test_every_step_of_a_session_is_to_be_kept_once(study: Path, tmp_path: Path) -> None:
    simulation = am.Simulation(am.load(study))
    session = am.record(simulation, tmp_path / "run")
    with pytest.raises(am.RunError, match=r"expected one step after tick 0.*got tick 0; call keep\(\) after"):
        session.keep()
    simulation.step()
    session.keep()
    with pytest.raises(am.RunError, match="has not been closed"):
        _ = session.summary
    simulation.step()
    simulation.step()
    with pytest.raises(am.RunError, match=r"expected one step after tick 1.*got tick 3"):
        session.keep()
    assert session.close().steps == 1
    assert session.close() is session.summary
    with pytest.raises(am.RunError, match="has been closed"):
        session.keep()
    # The files end before the simulation does, so there is nothing to compare a digest with.
    assert session.summary.digests == {}
    with pytest.raises(am.RunError, match="has no digests"):
        am.reproduce(tmp_path / "run")


def test_only_a_simulation_at_its_very_start_can_be_recorded(study: Path, tmp_path: Path) -> None:
    simulation = am.Simulation(am.load(study))
    simulation.step()
    with pytest.raises(am.RunError, match="no step was made"):
        am.record(simulation, tmp_path / "run")
    simulation.reset()  # another episode, whose draws a new simulation does not make
    with pytest.raises(am.RunError, match="no step was made"):
        am.record(simulation, tmp_path / "run")
    simulation.reset(seed=4)
    am.record(simulation, tmp_path / "run").close()
    assert about(tmp_path / "run")["seed"] == 4
