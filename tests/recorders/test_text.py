"""The text files of a run: their columns, their rows, and that they say what was simulated."""

from __future__ import annotations

import csv
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import attrs
import numpy as np
import numpy.typing as npt
import pytest

import amorsim as am
from amorsim.contracts import RunInfo
from amorsim.core.errors import RunError
from amorsim.recorders.line_files import LONGEST_WAIT
from amorsim.recorders.text import Text
from tests import building
from tests.recorders.plain_text import PlainText


class State(NamedTuple):
    """What there was of the first robot after a step."""

    pose: npt.NDArray[np.float64]
    joints: npt.NDArray[np.float64]
    command: npt.NDArray[np.float64]
    covariance: npt.NDArray[np.float64]


class Written:
    """A simulation that is written down by the recorder alone."""

    def __init__(self, scenario: am.Scenario, folder: Path, replicas: int = 1) -> None:
        folder.mkdir()
        self.folder = folder
        self.simulation = am.Simulation(scenario, replicas=replicas)
        self._text = Text()
        info = RunInfo(folder, self.simulation.dt, self.simulation.replicas, with_sensors=True)
        self._text.open(info, self.simulation.frames())
        self.kept = [self._state()]

    def _state(self) -> State:
        robot = self.simulation.robot(self.simulation.names[0], self.simulation.replicas[0])
        command = self.simulation.frames()[0].command[0]
        return State(robot.true_pose.copy(), robot.joints.copy(), command.copy(), robot.covariance.copy())

    def step(self, count: int) -> None:
        for _ in range(count):
            known = len(self.simulation.events)
            self.simulation.step()
            self._text.write(self.simulation.frames(), self.simulation.events[known:])
            self.kept.append(self._state())

    def rows(self, name: str) -> list[dict[str, str]]:
        self._text.close()
        with (self.folder / f"{name}.csv").open(newline="") as file:
            return list(csv.DictReader(file))


@pytest.fixture
def written(tmp_path: Path) -> Iterator[Written]:
    robot = building.robot(
        sensors=building.all_sensors(),
        controller=building.Roam(),
        estimators={"dead_reckoning": am.estimators.DeadReckoning(wheel_variance=1e-4)},
    )
    held = Written(building.scenario(robot), tmp_path / "run")
    held.step(20)
    yield held
    held._text.close()


def column(rows: list[dict[str, str]], name: str) -> list[float]:
    return [float(row[name]) for row in rows]


def test_poses_are_written_to_a_micrometre(written: Written) -> None:
    rows = written.rows("poses")
    assert list(rows[0]) == [
        *("time", "robot", "true_x", "true_y", "true_heading"),
        *("estimated_x", "estimated_y", "estimated_heading"),
    ]
    assert len(rows) == 21
    true = np.array([kept.pose for kept in written.kept])
    for i, name in enumerate(("true_x", "true_y", "true_heading")):
        np.testing.assert_allclose(column(rows, name), true[:, i], atol=5.1e-7)
    assert {len(row["true_x"].split(".")[1]) for row in rows} == {6}
    np.testing.assert_allclose(column(rows, "time"), np.arange(21) * 0.1, atol=1e-9)


def test_commands_read_back_as_the_same_bits(written: Written) -> None:
    rows = written.rows("commands")
    assert list(rows[0]) == ["time", "robot", "left", "right"]
    for row, kept in zip(rows, written.kept, strict=True):
        assert [float(row["left"]), float(row["right"])] == kept.command.tolist()
    assert max(column(rows, "left")) > 1.0


def test_sensors_have_a_row_for_each_sample(written: Written) -> None:
    assert len(written.rows("sensors/laser")) == 21
    sonar = written.rows("sensors/sonar")  # at 4 Hz
    np.testing.assert_allclose(column(sonar, "time"), [0.0, 0.3, 0.5, 0.8, 1.0, 1.3, 1.5, 1.8, 2.0], atol=1e-9)
    compass = written.rows("sensors/compass")  # with 0.25 s of latency
    later = [row for row in compass if float(row["time"]) > 0.0]
    assert later
    np.testing.assert_allclose(np.array(column(later, "time")) - column(later, "stamp"), 0.3, atol=1e-9)
    truth = [kept.pose[2] for kept in written.kept]
    for row in later:
        turned = float(row["true_0"]) - truth[round(float(row["stamp"]) / 0.1)]
        assert abs((turned + np.pi) % (2 * np.pi) - np.pi) < 2e-6
    assert list(written.rows("sensors/encoder")[0]) == [
        *("time", "stamp", "robot", "true_0", "true_1", "measured_0", "measured_1")
    ]


def test_velocities_are_those_of_body_and_wheels(written: Written) -> None:
    rows = written.rows("velocities")
    joints = np.array([kept.joints for kept in written.kept])
    measured = np.column_stack([column(rows, f"measured_{name}") for name in ("left_wheel", "right_wheel")])
    travelled = np.diff(joints, axis=0) / 0.1
    count = 2.0 * np.pi / 39400.0 / 0.1  # [rad/s], one count in a step
    assert np.abs(measured[1:] - travelled).max() <= 1.001 * count
    forward = np.array(column(rows, "true_forward"))[1:]
    np.testing.assert_allclose(forward, travelled.mean(axis=1) * building.RADIUS, atol=1e-5)


def test_estimates_carry_their_covariance(written: Written) -> None:
    rows = written.rows("estimates/dead_reckoning")
    assert list(rows[0])[-6:] == ["xx", "xy", "xh", "yy", "yh", "hh"]
    last = written.kept[-1].covariance[np.triu_indices(3)]
    assert [float(rows[-1][name]) for name in ("xx", "xy", "xh", "yy", "yh", "hh")] == last.tolist()
    assert last[0] > 0.0


def test_robots_of_several_kinds_share_the_files(tmp_path: Path) -> None:
    held = Written(several_kinds(), tmp_path / "run", replicas=2)
    held.step(3)
    poses = held.rows("poses")
    assert next(iter(poses[0])) == "replica"
    assert {(row["replica"], row["robot"]) for row in poses} == {
        (replica, name) for replica in "01" for name in ("blind", "rover", "scout")
    }
    assert len(poses) == 4 * 6
    laser = held.rows("sensors/laser")
    assert {row["robot"] for row in laser} == {"rover", "scout"}
    for row in laser:
        beams = 19 if row["robot"] == "rover" else 2
        assert [row[f"true_{i}"] == "nan" for i in range(19)] == [i >= beams for i in range(19)]


def test_times_of_tiny_steps_can_be_distinguished(tmp_path: Path) -> None:
    held = Written(building.scenario(dt=1e-6), tmp_path / "run")
    held.step(3)
    assert len({row["time"] for row in held.rows("poses")}) == 4


def test_events_are_written_with_their_values_as_json(tmp_path: Path) -> None:
    held = Written(building.scenario(), tmp_path / "run")
    held.simulation.set("rover", "drive.track", np.float64(0.25))
    events = list(held.simulation.events)
    held.simulation.set_pose("rover", np.array([3.0, 1 / 3 + 1.0, 0.0]))
    held.simulation.step()
    held._text.write(held.simulation.frames(), held.simulation.events)
    rows = held.rows("events")
    assert events[0].kind == rows[0]["kind"] == "parameter_set"
    assert (rows[0]["path"], rows[0]["value"], rows[0]["tick"]) == ("drive.track", "0.25", "0")
    assert (rows[1]["kind"], rows[1]["value"]) == ("pose_set", "[3.0, 1.3333333333333333, 0.0]")


def several_kinds() -> am.Scenario:
    blind = building.robot(name="blind", pose=am.Pose(x=4.5, y=3.5), controller=building.Roam())
    seeing = building.robot(sensors=building.all_sensors(), controller=building.Roam())
    short = am.MountedSensor(sensor=am.sensors.Laser(beams=2, range_max=8.0))
    scout = attrs.evolve(seeing, name="scout", pose=am.Pose(x=1.0, y=4.0), sensors={**seeing.sensors, "laser": short})
    return building.scenario(blind, seeing, scout)


@pytest.mark.parametrize("replicas", [1, 3])
@pytest.mark.parametrize("kinds", ["one", "several", "and obstacles"])
def test_every_byte_is_that_of_plain_formatting(tmp_path: Path, kinds: str, replicas: int) -> None:
    robot = building.robot(sensors=building.all_sensors(), controller=building.Roam())
    scenario = building.scenario(robot) if kinds == "one" else several_kinds()
    if kinds == "and obstacles":
        still = am.Obstacle(name="box", shape=am.Shape.circle(0.1), pose=am.Pose(x=5.5, y=0.5))
        guard = attrs.evolve(still, name="guard", pose=am.Pose(x=5.5, y=4.5), motion=am.motions.Wander(speed=0.3))
        scenario = attrs.evolve(scenario, obstacles=[still, guard])
    simulation = am.Simulation(scenario, replicas=replicas)
    text = Text()
    text.open(RunInfo(tmp_path, simulation.dt, simulation.replicas, with_sensors=True), simulation.frames())
    text.write_obstacles(simulation.obstacle_frames())
    plain = PlainText(simulation.frames(), simulation.obstacle_frames(), simulation.dt, replicas > 1)
    for step in range(250):
        simulation.step()
        text.write(simulation.frames(), [])
        text.write_obstacles(simulation.obstacle_frames())
        plain.write(simulation.frames(), simulation.obstacle_frames())
        if step == 100:
            text._hand_over()  # as the thread does, at any time
    text.close()
    assert len(plain.lines) >= 9
    for name, lines in plain.lines.items():
        assert lines_in(tmp_path, name) == lines, name


def lines_in(folder: Path, name: str) -> list[str]:
    """The lines of a file, without the head."""
    return (folder / f"{name}.csv").read_text(encoding="utf-8").splitlines()[1:]


@pytest.mark.parametrize("kinds", ["one", "several"])
@pytest.mark.parametrize("error", [KeyboardInterrupt, RunError])
def test_who_is_broken_off_loses_and_doubles_no_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kinds: str, error: type[BaseException]
) -> None:
    robot = building.robot(sensors=building.all_sensors(), controller=building.Roam())
    simulation = am.Simulation(building.scenario(robot) if kinds == "one" else several_kinds())
    monkeypatch.setattr("amorsim.recorders.line_files.LONGEST_WAIT", 3600.0)  # nobody but this test asks for lines
    text = Text()
    text.open(RunInfo(tmp_path, simulation.dt, simulation.replicas, with_sensors=True), simulation.frames())
    plain = PlainText(simulation.frames(), [], simulation.dt, False)
    for _ in range(30):
        simulation.step()
        text.write(simulation.frames(), [])
        plain.write(simulation.frames(), [])
    write, asked = text._files.write, []

    def break_off(name: str, lines: bytes) -> None:
        asked.append(name)
        if len(asked) == 4:
            raise error
        write(name, lines)

    monkeypatch.setattr(text._files, "write", break_off)
    with pytest.raises(error):
        text._hand_over()
    if error is KeyboardInterrupt:  # and the caller that catches it goes on
        simulation.step()
        text.write(simulation.frames(), [])
        plain.write(simulation.frames(), [])
    text.close()
    for name, lines in plain.lines.items():
        is_lost = error is RunError and name == asked[3]
        assert lines_in(tmp_path, name) == ([] if is_lost else lines), name


def test_steps_that_wait_reach_the_files_in_time(tmp_path: Path) -> None:
    held = Written(building.scenario(), tmp_path / "run")
    held.step(3)
    deadline = time.monotonic() + LONGEST_WAIT + 1.0
    while (tmp_path / "run" / "poses.csv").read_text().count("\n") < 5:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    held._text.close()


def test_what_a_recorder_is_given_may_change_afterwards(tmp_path: Path) -> None:
    simulation = am.Simulation(building.scenario())
    text = Text()
    text.open(RunInfo(tmp_path, simulation.dt, simulation.replicas, with_sensors=True), simulation.frames())
    (frame,) = simulation.frames()
    pose = frame.true_pose.copy()
    text.write([frame._replace(true_pose=pose)], [])
    pose[:] = 99.0
    text.close()
    assert "99.0" not in (tmp_path / "poses.csv").read_text()
