"""A simulation played forward and back."""

from __future__ import annotations

import random
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.noise.gaussian import Gaussian
from amorsim.ui.simulator.frames.packing import Dynamic, FrameFlag, RobotFlag
from amorsim.ui.simulator.sources.inputs import Input
from amorsim.ui.simulator.sources.player import MOST_OTHERS, Player
from amorsim.ui.simulator.sources.timeline import MOST_MOMENTS, Paths
from tests import building


class Swerving:
    """Turns ever more, so that a call too many or too few shows."""

    def __init__(self) -> None:
        self.calls = 0

    def command(self, readings: Any, estimate: Any, clock: Any) -> am.Twist:
        self.calls += 1
        return am.Twist(forward=0.1, turn=0.01 * self.calls)


def player(controller: Any = Swerving, **changes: Any) -> Player:
    noise = building.chain(Gaussian(std=2.0))
    robot = building.robot(
        controller=controller,
        sensors={"encoder": am.MountedSensor(sensor=building.encoder(), noise=noise)},
    )
    return Player(am.Simulation(building.scenario(robot)), **changes)


def play(one: Player, steps: int) -> None:
    for _ in range(steps):
        assert one.step(), one.fault


def frame(one: Player) -> Dynamic:
    return one.frames(version=1, number=1, speed=1.0, achieved=1.0, flags=0)[0]


def same(a: Dynamic, b: Dynamic) -> None:
    np.testing.assert_array_equal(a.true_pose, b.true_pose)
    np.testing.assert_array_equal(a.estimated_pose, b.estimated_pose)
    for name, one, other in zip(a.selected._fields, a.selected, b.selected, strict=True):
        np.testing.assert_array_equal(one, other, err_msg=name)


def test_the_past_looks_as_it_did_and_the_present_is_as_it_was() -> None:
    one = player()
    play(one, 73)
    then = frame(one)
    one.give(Input(tick=73, do="hand_over", robot="rover", value="hand"))
    one.give(Input(tick=73, do="command", robot="rover", value=[1.0, 2.0]))
    play(one, 60)
    now, digest = frame(one), one.simulation.digest()
    assert one.scrub(73) == 73
    back = frame(one)
    same(back, then)
    assert back.flags & FrameFlag.SCRUBBED
    assert one.is_exact
    assert back.newest == 133
    with pytest.raises(am.AmorsimError, match="this is the past"):
        one.step()
    with pytest.raises(am.AmorsimError, match="this is the past"):
        one.give(Input(tick=73, do="set", robot="rover", path="drive.track", value=0.4))
    one.scrub(None)
    same(frame(one), now)
    play(one, 1)
    one.scrub(133)
    assert one.simulation.digest() == digest


def test_going_on_from_the_past_is_another_future_that_can_be_given_again() -> None:
    one, twin = player(), player()
    play(one, 120)
    one.scrub(60)
    epoch = one.epoch
    assert one.go_on() == 60
    assert one.epoch > epoch
    assert (one.tick, one.newest, one.is_past) == (60, 60, False)
    one.give(Input(tick=60, do="set", robot="rover", path="errors.drive.track.scale", value=1.1))
    play(one, 30)
    play(twin, 60)
    twin.simulation.set("rover", "errors.drive.track.scale", 1.1)
    play(twin, 30)
    assert one.simulation.digest() == twin.simulation.digest()
    one.scrub(75)
    one.scrub(None)
    assert one.simulation.digest() == twin.simulation.digest()


def test_a_reset_keeps_what_was_set_and_gives_robots_back() -> None:
    one = player()
    play(one, 5)
    one.give(Input(tick=5, do="set", robot="rover", path="drive.track", value=0.5))
    one.give(Input(tick=5, do="hand_over", robot="rover", value="hand"))
    play(one, 5)
    one.reset()
    assert (one.tick, one.newest) == (0, 0)
    robot = one.simulation.robot("rover")
    assert robot.nominal.drive.track == 0.5  # type: ignore[attr-defined]
    assert not robot.is_by_hand
    assert [(i.tick, i.do) for i in one.inputs] == [(0, "set")]


def test_a_frame_tells_velocities_of_the_selected_robot() -> None:
    one = player(controller=lambda readings, estimate, clock: am.Twist(0.2, 0.0))
    np.testing.assert_array_equal(frame(one).selected.measured_rates, [0.0, 0.0])
    play(one, 20)
    selected = frame(one).selected
    assert selected.true_twist == pytest.approx([0.2, 0.0, 0.0])
    rate = 0.2 / building.RADIUS
    assert selected.true_rates == pytest.approx([rate, rate])
    # Two readings with 2 counts of noise each, a step apart: within five deviations.
    spread = 5 * np.sqrt(2) * 2.0 / 39400.0 * 2 * np.pi / 0.1
    assert selected.measured_rates == pytest.approx([rate, rate], abs=spread)
    assert (selected.measured_rates != selected.true_rates).all()
    assert selected.estimated_twist[0] == pytest.approx(0.2, abs=spread * building.RADIUS)


class Holding(Swerving):
    """Holds what cannot be copied."""

    def __init__(self) -> None:
        super().__init__()
        self.lock = threading.Lock()


def test_where_a_controller_cannot_be_copied_the_past_has_poses_and_a_reason() -> None:
    one = player(Holding)
    play(one, 40)
    then = frame(one).true_pose
    play(one, 40)
    assert one.scrub(40) == 40
    back = frame(one)
    np.testing.assert_allclose(back.true_pose, then, atol=1e-6)
    assert back.flags & FrameFlag.POSES_ONLY
    assert np.isnan(back.selected.measured).all()
    assert "Holding cannot be copied" in one.reason
    with pytest.raises(am.AmorsimError, match="cannot continue from here: controller of 'rover': Holding cannot be"):
        one.go_on()
    one.scrub(None)
    play(one, 1)
    assert one.newest == 81


def test_a_controller_with_randomness_of_its_own_is_found_out() -> None:
    one = player(controller=lambda readings, estimate, clock: am.Twist(0.1, random.random()))
    play(one, 60)
    one.scrub(30)
    assert not one.is_exact
    with pytest.raises(am.AmorsimError, match="a clock or randomness of its own"):
        one.go_on()


class Failing(Swerving):
    def command(self, readings: Any, estimate: Any, clock: Any) -> am.Twist:
        if clock.tick == 57:
            raise ZeroDivisionError("by design")
        return super().command(readings, estimate, clock)


def test_an_error_in_a_controller_waits_until_a_hand_takes_the_robot() -> None:
    one = player(Failing)
    play(one, 57)
    before = frame(one)
    assert not one.step()
    assert one.fault is not None
    assert one.fault.robots == ("rover",)
    assert "ZeroDivisionError: by design" in one.fault.text
    assert 'raise ZeroDivisionError("by design")' in one.fault.stack
    assert not one.step()
    same(frame(one), before)
    assert frame(one).flags & FrameFlag.FAULT
    assert one.events()[-1]["kind"] == "fault"
    one.give(Input(tick=57, do="hand_over", robot="rover", value="hand"))
    assert one.fault is None
    play(one, 30)
    assert frame(one).robot_flags.tolist() == [RobotFlag.BY_HAND]


class FailingWithALock(Failing):
    def __init__(self) -> None:
        super().__init__()
        self.lock = threading.Lock()


def test_a_hand_takes_the_robot_also_where_a_controller_cannot_be_copied() -> None:
    one = player(FailingWithALock)
    play(one, 57)
    assert not one.step()
    one.give(Input(tick=57, do="hand_over", robot="rover", value="hand"))
    play(one, 30)
    assert frame(one).robot_flags.tolist() == [RobotFlag.BY_HAND]


def test_what_is_kept_of_a_long_run_is_bounded_and_still_leads_back() -> None:
    one = player()
    one.paths = Paths(1, most_bytes=24 * 64)
    one.paths.keep(0, one.simulation.true_pose, one.simulation.estimated_pose)
    one.snapshots._most = 4
    one.snapshots.stride = 5
    poses = {}
    for tick in range(1, 501):
        play(one, 1)
        poses[tick] = one.simulation.true_pose.copy()
    assert len(one.snapshots) <= 4
    assert one.paths._count <= 64
    ticks, track = one.paths.track(0, 20)
    assert len(ticks) <= 21
    assert ticks[-1] > 480
    for tick, pose in zip(ticks, track, strict=True):
        if tick:
            np.testing.assert_allclose(pose[:3], poses[tick][0], atol=1e-6)
    one.scrub(333)
    np.testing.assert_array_equal(one.simulation.true_pose, poses[333])


def test_a_run_that_is_written_as_it_goes_reproduces_also_from_where_it_went_on(tmp_path: Path) -> None:
    (tmp_path / "room.wld").write_text(
        "width 6000\nheight 5000\n0 0 6000 0\n6000 0 6000 5000\n6000 5000 0 5000\n0 5000 0 0\n"
    )
    robot = building.robot(controller=building.Manual())
    scenario = am.Scenario(map=am.load_map(tmp_path / "room.wld"), robots=[robot], duration=10.0)
    one = Player(am.Simulation(scenario), out=tmp_path / "run")
    play(one, 10)
    one.give(Input(tick=10, do="command", robot="rover", value=[3.0, 2.0]))
    play(one, 20)
    one.scrub(20)
    one.go_on()
    one.give(Input(tick=20, do="command", robot="rover", value=[1.0, 2.0]))
    one.give(Input(tick=20, do="set", robot="rover", path="errors.drive.track.scale", value=1.2))
    play(one, 20)
    folder = one.folder
    assert folder == tmp_path / "run-2"
    one.close()
    for name, steps in (("run", 30), ("run-2", 40)):
        outcome = am.reproduce(tmp_path / name)
        assert (outcome.is_exact, outcome.steps) == (True, steps), str(outcome)
    # Nothing but a start leaves nothing.
    nothing = Player(am.Simulation(scenario), out=tmp_path / "nothing")
    nothing.close()
    assert not (tmp_path / "nothing").exists()


def test_what_becomes_known_comes_after_what_was_known() -> None:
    one = player()
    known: list[str] = []

    def look() -> None:
        lines = one.events()
        assert [line["number"] for line in lines] == list(range(1, len(lines) + 1))
        texts = [line["text"] for line in lines]
        assert texts[: len(known)] == known
        assert len(texts) == len(known) + 1 == one.event_count
        known[:] = texts

    def change(scale: float) -> None:
        path = "errors.drive.track.scale"
        one.give(Input(tick=one.newest, do="set", robot=one.simulation.names[0], path=path, value=scale))

    one.step()
    one.remark("saved", "first")
    look()
    change(1.1)  # at the same time
    look()
    one.remark("saved", "second")
    look()
    one.remark("saved", "third")
    look()
    one.step()
    change(1.2)
    look()
    one.scrub(1)
    one.remark("saved", "while the past is shown")
    look()
    one.go_on()
    texts = [line["text"] for line in one.events() if line["kind"] != "continued"]
    assert texts == [text for text in known if "1.2" not in text]


def test_what_was_left_by_going_on_can_be_taken_up_again() -> None:
    one, twin = player(), player()
    play(one, 120)
    then, digest, inputs = frame(one), one.simulation.digest(), list(one.inputs)
    events = [line for line in one.events() if line["kind"] != "continued"]
    with pytest.raises(am.AmorsimError, match="no later history"):
        one.go_back()
    one.scrub(60)
    one.go_on()
    one.give(Input(tick=60, do="hand_over", robot="rover", value="hand"))
    one.give(Input(tick=60, do="command", robot="rover", value=[1.0, 2.0]))
    play(one, 30)
    other, others = one.simulation.digest(), list(one.inputs)
    epoch = one.epoch
    assert one.go_back() == 120
    assert one.epoch > epoch
    assert (one.tick, one.newest, one.is_past, list(one.inputs)) == (120, 120, False, inputs)
    assert one.simulation.digest() == digest
    same(frame(one), then)
    assert [line for line in one.events() if line["kind"] != "continued"] == events
    # Its past is whole too, and so is its future.
    play(one, 10)
    play(twin, 130)
    assert one.simulation.digest() == twin.simulation.digest()
    one.scrub(100)
    twin.scrub(100)
    same(frame(one), frame(twin))
    assert one.paths.track(0, 1000)[0] == list(range(131))
    # And the other way round: the one that is left now is kept, from the past as well as from the present.
    assert one.go_back() == 90
    assert one.simulation.digest() == other
    assert list(one.inputs) == others
    assert one.go_back() == 130
    # A new start leaves nothing.
    one.reset()
    with pytest.raises(am.AmorsimError, match="no later history"):
        one.go_back()


def test_other_futures_are_kept_each_from_where_it_parts() -> None:
    path = "errors.drive.wheel_radius_left.scale"
    one = player()
    play(one, 100)
    first = frame(one)
    for tick, scale in ((60, 1.03), (80, 1.05), (40, 1.07)):
        one.scrub(tick)
        one.go_on()
        one.give(Input(tick=tick, do="set", robot="rover", path=path, value=scale))
        play(one, 30)
    # 1 to 100; 2 from it at 60, to 90; 3 from 2 at 80, to 110; 4, which is played, from 3 at 40, to 70.
    assert one.number == 4
    assert [(other.number, other.since, other.newest) for other in one.others] == [
        (1, 40, 100),
        (2, 40, 90),
        (3, 40, 110),
    ]
    assert [other.changes_of("rover") for other in one.others] == [
        [],
        [{"path": path, "value": 1.03}],
        [{"path": path, "value": 1.05}],
    ]
    assert one.others[0].track(0, 1000).ticks == list(range(101))
    assert one.others[1].track(0, 1000).ticks == list(range(91))
    same_until = [other.track(0, 1000).poses[60] for other in one.others]
    assert (same_until[0] == same_until[1]).all()
    assert (one.others[0].track(0, 1000).poses[90] != one.others[1].track(0, 1000).poses[90]).any()
    # Each can be taken up again, and what is played then is kept in its place.
    assert one.go_back(1) == 100
    same(frame(one), first)
    assert [other.number for other in one.others] == [2, 3, 4]
    one.forget(3)
    assert [other.number for other in one.others] == [2, 4]
    for does in (one.forget, one.go_back):
        with pytest.raises(am.AmorsimError, match="no other future of number 3"):
            does(3)
    # The oldest go when there are too many.
    for _ in range(MOST_OTHERS):
        one.scrub(10)
        one.go_on()
        play(one, 5)
    assert [other.number for other in one.others] == [1, 5, 6, 7]


def test_the_futures_that_are_left_share_a_bounded_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    one = player()
    play(one, 100)
    monkeypatch.setattr("amorsim.ui.simulator.sources.player.MOST_BYTES_OF_SNAPSHOTS", 3 * one.snapshots.nbytes // 2)
    for _ in range(3):
        one.scrub(50)
        one.go_on()
        play(one, 50)
    assert [other.number for other in one.others] == [3]  # what was left last stays in any case


def test_going_on_says_what_is_kept(tmp_path: Path) -> None:
    one, written = player(), player(controller=None, out=tmp_path / "run")
    for each in (one, written):
        play(each, 80)
        each.scrub(40)
        each.go_on()
    assert one.events()[-1]["text"] == "continued from here; what came after, up to 8.0 s, is kept"
    assert written.events()[-1]["text"].endswith(f"is kept in {tmp_path / 'run'}")
    assert (one.can_go_back, written.can_go_back) == (True, False)
    with pytest.raises(am.AmorsimError, match="no later history"):
        written.go_back()
    written.close()


def test_the_paths_of_a_simulation_that_runs_for_hours_stop_growing() -> None:
    paths = Paths(1)
    pose = np.zeros((1, 3))
    for tick in range(3 * MOST_MOMENTS):
        paths.keep(tick, pose, pose)
    assert paths.stride == 4
    assert len(paths.kept) <= MOST_MOMENTS
    assert paths._kept.nbytes <= 24 * MOST_MOMENTS
    assert paths.at(3 * MOST_MOMENTS)[0] == 3 * MOST_MOMENTS - 4
