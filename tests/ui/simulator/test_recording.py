"""A recorded run as a source of frames: they show what its files say, and nothing is simulated."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.analysis.run_files import RunFiles
from amorsim.recorders.arrays import Arrays
from amorsim.scenario.colours import robot_colours
from amorsim.scenario.spec import Recording as What
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.frames.packing import Dynamic, RobotFlag
from amorsim.ui.simulator.process.replaying import Replaying
from amorsim.ui.simulator.sources.player import Player
from amorsim.ui.simulator.sources.recording import Recording
from tests import building
from tests.golden.digests import SCENARIOS

Open = Callable[..., Recording]


@pytest.fixture
def opened() -> Iterator[Open]:
    """Opens folders, and closes their files at the end."""
    recordings = []

    def open_one(folder: Path) -> Recording:
        recordings.append(Recording(folder))
        return recordings[-1]

    yield open_one
    for recording in recordings:
        recording.close()


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot with all sensors that drives into a wall, and one that stands; with an obstacle that moves."""
    driving = building.robot(name="rover", pose=am.Pose(x=4.9, y=2.5), sensors=building.all_sensors())
    standing = building.robot(name="other", pose=am.Pose(x=1.0, y=1.0))
    scenario = building.scenario(standing, driving, recording=What(picture=False))
    simulation = am.Simulation(scenario, seed=3)
    folder = tmp_path_factory.mktemp("run") / "run"
    with am.record(simulation, folder, duration=5.0) as session:
        for step in range(40):
            simulation.robot("rover").drive(forward=0.6, turn=0.1)
            if step == 10:
                simulation.hand_over("rover", "hand")
            if step == 25:
                simulation.set("other", "drive.track", 0.4)
            simulation.step()
            session.keep()
    return folder


@pytest.fixture
def folder(run_folder: Path, tmp_path: Path) -> Path:
    """A copy that may be damaged."""
    return Path(shutil.copytree(run_folder, tmp_path / "run"))


def frame(recording: Recording, tick: int | None = None, robot: int = 0) -> Dynamic:
    if tick is not None:
        assert recording.scrub(tick) == tick
    recording.watched = (robot,)
    return recording.frames(version=1, number=1, speed=1.0, achieved=1.0, flags=0)[0]


def test_the_poses_shown_are_exactly_those_recorded(opened: Open, run_folder: Path) -> None:
    recording = opened(run_folder)
    poses = RunFiles(run_folder).arrays("poses")
    assert recording.names == ["other", "rover"]
    assert (recording.newest, recording.last, recording.dt) == (40, 40, 0.1)
    for tick in [*range(41), 7, 33, 0]:
        shown = frame(recording, tick)
        np.testing.assert_array_equal(shown.true_pose, poses["true_pose"][tick])
        np.testing.assert_array_equal(shown.estimated_pose, poses["estimated_pose"][tick])
        assert (shown.tick, shown.newest) == (tick, 40)
        assert shown.time == pytest.approx(tick * 0.1)


def test_a_replay_shows_what_the_window_showed(opened: Open, tmp_path: Path) -> None:
    """But for the sixth decimal, to which files are written."""
    robot = building.robot(sensors=building.all_sensors(), controller=am.controllers.Wander(speed=0.4))
    scenario = building.scenario(robot, recording=What(picture=False))
    player = Player(Simulation(scenario, seed=5), out=tmp_path / "run")
    live = [player.frames(version=1, number=1, speed=1.0, achieved=1.0, flags=0)[0]]
    for _ in range(30):
        assert player.step()
        live.append(player.frames(version=1, number=1, speed=1.0, achieved=1.0, flags=0)[0])
    player.close()
    recording = opened(tmp_path / "run")
    for tick, was in enumerate(live):
        shown = frame(recording, tick)
        for name in ("true_pose", "estimated_pose", "covariance", "obstacle_pose"):
            np.testing.assert_allclose(getattr(shown, name), getattr(was, name), rtol=0.0, atol=6e-7, err_msg=name)
        for name in ("true", "measured", "age", "true_rates", "true_twist", "estimated_twist", "command"):
            now, then = getattr(shown.selected, name), getattr(was.selected, name)
            if name in ("true", "measured"):  # before its first reading has arrived, a sensor has nothing to show
                then = np.where(np.isnan(now), np.nan, then)
                assert tick < 5 or not np.isnan(now).any()
            if name == "age":
                then = np.where(np.isnan(now), np.nan, then)
            np.testing.assert_allclose(now, then, rtol=0.0, atol=2e-6, err_msg=f"{name} at {tick}")
    track = recording.track(0, 1000)
    assert track.ticks == list(range(31)) == track.past["ticks"]
    assert len(track.past["values"]) == len(player.pasts.of(0, 1000)["values"])


def test_time_goes_on_back_and_ends(opened: Open, run_folder: Path) -> None:
    recording = opened(run_folder)
    assert recording.step()
    assert recording.tick == 1
    assert recording.scrub(None) == recording.scrub(1000) == 40
    assert not recording.step()
    recording.begin_playing()  # again from the start
    assert recording.tick == 0


def test_robots_have_the_colours_of_the_run(opened: Open, tmp_path: Path) -> None:
    robots = [building.robot(name=name, pose=am.Pose(x=x, y=1.0)) for name, x in (("b", 1.0), ("a", 2.0), ("c", 3.0))]
    scenario = building.scenario(*robots, recording=What(picture=False))
    simulation = am.Simulation(scenario)
    with am.record(simulation, tmp_path / "run") as session:
        simulation.step()
        session.keep()
    shown = opened(tmp_path / "run").scene["robots"]
    assert [robot["name"] for robot in shown] == ["a", "b", "c"]
    assert {robot["name"]: robot["colour"] for robot in shown} == robot_colours(scenario.robots)


def test_events_are_listed_and_flag_their_robots(opened: Open, run_folder: Path) -> None:
    recording = opened(run_folder)
    events = recording.events()
    kinds = [event["kind"] for event in events]
    assert "collision" in kinds
    assert "parameter_set" in kinds
    hit = next(event for event in events if event["kind"] == "collision")
    assert hit["robot"] == "rover"
    assert "met wall at" in hit["text"]
    assert hit["point"] is not None
    assert not frame(recording, hit["tick"] - 1).robot_flags[1] & RobotFlag.TOUCHING
    assert frame(recording, hit["tick"]).robot_flags[1] & RobotFlag.TOUCHING
    assert recording.by_hand == ["rover"]
    recording.scrub(9)
    assert recording.by_hand == []


def test_nothing_of_a_recorded_run_can_be_changed(opened: Open, run_folder: Path) -> None:
    does = Replaying(opened(run_folder))
    for name in ("reset", "set", "drive", "hand_over", "continue", "parameters", "job", "write_scenario"):
        said = does.carry_out({"do": name, "robot": "rover", "path": "drive.track", "value": 1.0})
        assert not said["ok"]
    assert "cannot be changed" in does.carry_out({"do": "reset"})["error"]
    assert does.carry_out({"do": "scrub", "tick": 12})["tick"] == 12
    assert does.carry_out({"do": "step"}) == {"ok": True, "tick": 13, "steps": 1}
    state = does.carry_out({"do": "state"})
    assert (state["status"], state["tick"], state["newest"]) == ("paused", 13, 40)
    assert len(does.carry_out({"do": "history", "robot": 1})["ticks"]) == 41


def test_replicas_are_shown_one_at_a_time(opened: Open, tmp_path: Path) -> None:
    robot = building.robot(sensors=building.all_sensors(), controller=am.controllers.Wander(speed=0.4))
    scenario = building.scenario(
        robot, building.robot(name="z", pose=am.Pose(x=1.0, y=1.0)), recording=What(picture=False), duration=2.0
    )
    simulation = am.Simulation(scenario, seed=5, replicas=[4, 0, 17])
    am.run(scenario, tmp_path / "run", simulation=simulation)
    recording = opened(tmp_path / "run")
    does = Replaying(recording)
    assert recording.scene["recorded"]["replicas"] == [4, 0, 17]
    assert recording.replica == 4
    poses = RunFiles(tmp_path / "run").arrays("poses")["true_pose"].reshape(21, 3, 2, 3)
    recording.scrub(13)
    epoch, version = recording.epoch, recording.scene["version"]
    for place, replica in enumerate([4, 0, 17]):
        said = does.carry_out({"do": "replica", "number": replica})
        assert said["scene"]["recorded"]["replica"] == replica
        assert recording.tick == 13
        shown = frame(recording)
        np.testing.assert_array_equal(shown.true_pose, poses[13, place])
        assert not np.isnan(shown.selected.measured).any()
    assert recording.epoch > epoch
    assert recording.scene["version"] > version
    assert "no replica 5; known replicas: 4, 0, 17" in does.carry_out({"do": "replica", "number": 5})["error"]


def test_beliefs_are_those_of_the_last_file(opened: Open, tmp_path: Path) -> None:
    sensors = building.all_sensors()
    estimators = {"cloud": am.estimators.MonteCarlo(wheel_variance=1e-3, particles_min=50, particles_max=60)}
    knows = am.Knowledge(map=building.room())
    robot = building.robot(sensors=sensors, estimators=estimators, knowledge=knows)
    what = What(picture=False, also=[Arrays(every=0.5)])
    scenario = building.scenario(robot, recording=what, duration=1.2)
    am.run(scenario, tmp_path / "run")
    recording = opened(tmp_path / "run")
    assert recording.scene["recorded"]["lacks"] == []
    for tick, file in ((0, 0), (4, 0), (5, 5), (9, 5), (12, 10)):
        with np.load(tmp_path / "run" / "beliefs" / "cloud" / f"{file:09d}.npz") as whole:
            table = np.column_stack((whole["particles"][0], whole["weights"][0]))
        table = table[np.isfinite(table).all(axis=1)]
        np.testing.assert_array_equal(frame(recording, tick).selected.particles, table.reshape(-1))
    shutil.rmtree(tmp_path / "run" / "beliefs" / "cloud")
    recording = opened(tmp_path / "run")
    assert not len(frame(recording, 5).selected.particles)
    (lack,) = recording.scene["recorded"]["lacks"]
    assert 'recording = { also = [{ use = "arrays" }] }' in lack


# ---------------------------------------------------------------------------------------------------- damaged folders


def test_what_a_folder_lacks_is_said(opened: Open, folder: Path) -> None:
    shutil.rmtree(folder / "sensors")
    for name in ("velocities", "commands", "events"):
        (folder / f"{name}.csv").unlink()
    shutil.rmtree(folder / "estimates")
    recording = opened(folder)
    said = "\n".join(recording.scene["recorded"]["lacks"])
    assert "No readings were recorded" in said
    for name in ("velocities.csv", "commands.csv", "events.csv", "estimates/"):
        assert name in said
    shown = frame(recording, 20, robot=1)
    assert np.isfinite(shown.true_pose).all()
    for name in ("true", "measured", "true_twist", "command", "true_rates"):
        assert np.isnan(getattr(shown.selected, name)).all()
    assert np.isnan(shown.covariance).all()
    assert len(recording.track(1, 100).ticks) == 41


def test_a_run_that_was_broken_off_is_shown_up_to_its_last_whole_lines(opened: Open, folder: Path) -> None:
    about = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(about | {"status": "running"}))
    whole = (folder / "poses.csv").read_bytes()
    end = whole.index(b"\n3.000000") + 30
    (folder / "poses.csv").write_bytes(whole[:end])
    recording = opened(folder)
    assert recording.newest == 29
    assert np.isfinite(frame(recording, 29).true_pose).all()
    assert ["how it ended", "it is still going on, or was killed"] in recording.scene["recorded"]["facts"]
    assert ["recorded", "2.9 s of 5 s"] in recording.scene["recorded"]["facts"]


def test_a_run_that_ctrl_c_ended_is_shown(opened: Open, tmp_path: Path) -> None:
    simulation = am.Simulation(building.scenario(building.robot(), recording=What(picture=False)))
    session = am.record(simulation, tmp_path / "run")
    for _ in range(12):
        simulation.step()
        session.keep()
    session.close("interrupted")  # as `am.run` does after Ctrl-C
    recording = opened(tmp_path / "run")
    assert recording.newest == 12
    assert ["how it ended", "it was interrupted"] in recording.scene["recorded"]["facts"]
    assert np.isfinite(frame(recording, 12).true_pose).all()


def test_a_damaged_line_is_said_once_and_the_rest_is_shown(opened: Open, folder: Path) -> None:
    text = (folder / "poses.csv").read_text().splitlines()
    text[21] = text[21].replace(",other,", ",other,abc")
    (folder / "poses.csv").write_text("\n".join(text) + "\n")
    recording = opened(folder)
    does = Replaying(recording)
    for _ in range(2):
        shown = frame(recording, 10)
        assert np.isnan(shown.true_pose[0, 0])
        assert np.isfinite(shown.true_pose[1]).all()
    damage = does.carry_out({"do": "state"})["damage"]
    assert "poses.csv, at 1.000000 s, true_x: expected a number, got 'abc" in damage
    assert sum(event["kind"] == "fault" for event in recording.events()) == 1
    assert np.isfinite(frame(recording, 11).true_pose).all()
    history = does.carry_out({"do": "history", "robot": 0})
    assert 10 not in history["ticks"]
    json.dumps(history, allow_nan=False)


def test_a_damaged_event_is_left_out_and_said(opened: Open, folder: Path) -> None:
    path = folder / "events.csv"
    before = len(opened(folder).events())
    text = path.read_text().splitlines()
    text[1:1] = ["0.5,rover,collision,wall,x,1.0,0.3,,,5"]
    path.write_text("\n".join(text) + "\n")
    recording = opened(folder)
    assert len(recording.events()) == before + 1
    assert "events.csv, line 2, x: expected a finite number, got 'x'" in recording.damage


def _empty(folder: Path) -> None:
    shutil.rmtree(folder)
    folder.mkdir()


def _remove(name: str) -> Callable[[Path], None]:
    return lambda folder: (folder / name).unlink()


def _put(name: str, text: str) -> Callable[[Path], Any]:
    return lambda folder: (folder / name).write_text(text)


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (_empty, "expected the folder of a run, with a run.json in it"),
        (shutil.rmtree, "expected the folder of a run, with a run.json in it"),
        (_remove("poses.csv"), "poses.csv: cannot be read"),
        (_put("poses.csv", ""), "poses.csv, line 1: is damaged"),
        (_put("poses.csv", "time,robot,true_x\n"), "poses.csv, line 1: is damaged: no column"),
        (_remove("scenario.toml"), "scenario.toml: cannot be read"),
        (_put("scenario.toml", "robots = 3"), "scenario.toml: the map cannot be read"),
        (_put("scenario.toml", "[world"), "scenario.toml: the map cannot be read: .*not valid TOML"),
        (_put("run.json", "{"), "run.json: cannot be read"),
        (_put("run.json", '{"format": 7}'), "is in format 7, of another version of amorsim"),
    ],
)
def test_a_folder_that_cannot_be_shown_says_why(
    opened: Open, folder: Path, damage: Callable[[Path], Any], problem: str
) -> None:
    damage(folder)
    with pytest.raises(am.RunError, match=problem):
        opened(folder)


def test_a_run_without_a_step_says_so(opened: Open, folder: Path) -> None:
    header = (folder / "poses.csv").read_text().splitlines()[0]
    (folder / "poses.csv").write_text(header + "\n")
    with pytest.raises(am.RunError, match=r"poses.csv: holds no poses"):
        opened(folder)


def test_no_code_of_the_run_is_executed(opened: Open, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "import pathlib\npathlib.Path(__file__).with_name('ran').touch()\n"
        "def go(readings, estimate, clock):\n    return 0.1, 0.0\n"
    )
    (tmp_path / "own.toml").write_text(
        'format = 1\n[world]\nmap = "demo.wld"\n[[robots]]\nname = "rover"\nmodel = "pioneer2dx"\n'
        'pose = { x = 1.0, y = 1.0 }\ncontroller = { use = "mine.py:go" }\n'
    )
    (tmp_path / "demo.wld").write_text("0 0 4000 0\n4000 0 4000 4000\n4000 4000 0 4000\n0 4000 0 0\n")
    am.run(am.load(tmp_path / "own.toml"), tmp_path / "run", duration=0.5)
    for ran in tmp_path.rglob("ran"):
        ran.unlink()
    recording = opened(tmp_path / "run")
    assert frame(recording, 5).tick == 5
    assert list(tmp_path.rglob("ran")) == []


@pytest.mark.long
@pytest.mark.parametrize("name", SCENARIOS)
def test_runs_of_bundled_scenarios_are_shown_as_recorded(opened: Open, tmp_path: Path, name: str) -> None:
    am.run(am.load(name), tmp_path / "run", duration=1.0)
    recording = opened(tmp_path / "run")
    files = RunFiles(tmp_path / "run")
    poses = files.arrays("poses")
    assert recording.names == files.robots
    assert recording.newest == len(poses["time"]) - 1
    for tick in {0, 1, recording.newest // 2, recording.newest}:
        shown = frame(recording, tick)
        np.testing.assert_array_equal(shown.true_pose, poses["true_pose"][tick])
        np.testing.assert_array_equal(shown.estimated_pose, poses["estimated_pose"][tick])
        assert np.isfinite(shown.obstacle_pose).all()
    assert recording.damage == ""
