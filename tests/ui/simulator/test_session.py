"""The session and its child process: driven, watched, broken off, ended."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import threading
import time
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.ui.simulator.frame_buffer import FrameBuffer
from amorsim.ui.simulator.frames.packing import Dynamic, FrameFlag, RobotFlag, unpack_frame
from amorsim.ui.simulator.link import Link
from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.session import Session
from tests.processes import is_running
from tests.ui.aside import aside
from tests.ui.sessions import Driven, Make, in_time, write_project

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

PATIENCE = 1.0


def done(session: Driven, do: str, **keys: Any) -> dict[str, Any]:
    answer = session.request({"do": do, **keys})
    assert answer["ok"], answer
    return answer


def until(what: Any, timeout: float = 60.0) -> Any:
    deadline = time.monotonic() + timeout
    while not (found := what()):
        assert time.monotonic() < deadline, "it never came"
        time.sleep(0.02)
    return found


def frame(session: Driven, after: int = -1, window: str = "") -> Dynamic:
    return unpack_frame(aside(asyncio.wait_for(session.newest_frame(after, window), 60.0)))


def state(session: Driven, window: str) -> dict[str, Any]:
    return aside(session.ask(window, {"do": "state"}))


def test_a_session_from_beginning_to_end(start: Make, tmp_path: Path) -> None:
    """One long story, for a start takes seconds: look, run, drive, change, look back, go on, save."""
    session = start()
    scene = session.scene
    assert [robot["name"] for robot in scene["robots"]] == ["other", "rover"]
    assert [robot["controller"] for robot in scene["robots"]] == ["manual", "own.py:Circling"]
    assert len(scene["maps"][scene["map"]]["segments"] or ()) == 4
    first = frame(session)
    assert (first.tick, first.flags, len(first.true_pose)) == (0, 0, 2)

    # It runs at the speed that was set, and frames come as it goes.
    done(session, "select", robot="rover")
    done(session, "speed", factor=20.0)
    done(session, "run")
    until(lambda: frame(session).tick >= 20)
    running = frame(session)
    assert running.flags & FrameFlag.RUNNING
    assert running.selected_robot == 1
    assert running.speed == 20.0
    done(session, "pause")
    tick = frame(session).tick
    assert done(session, "step", steps=3)["tick"] == tick + 3

    # The hand.
    done(session, "hand_over", robot="rover", to="hand")
    done(session, "drive", robot="rover", forward=0.3)
    done(session, "step", steps=10)
    by_hand = frame(session)
    assert by_hand.robot_flags[1] & RobotFlag.BY_HAND
    assert by_hand.selected.command[0] > 3.0
    done(session, "stop")
    done(session, "hand_over", robot="rover", to="controller")

    # A parameter, there and back.
    path = "errors.drive.wheel_radius_left.scale"
    assert done(session, "set", robot="rover", path=path, value=1.05)["value"] == 1.05
    forms = {form["path"]: form for form in done(session, "parameters", robot="rover")["parameters"]}
    assert (forms[path]["value"], forms[path]["scenario"]) == (1.05, 1.0)
    assert forms[path]["true"] == pytest.approx(1.05 * 0.0825)
    answer = session.request({"do": "set", "robot": "rover", "path": "drive.track", "value": -1.0})
    assert "expected a number [m] >= 0.001 and <= 100" in answer["error"]
    # The typed value is shown next to what follows from it.
    answer = session.request({"do": "set", "robot": "rover", "path": "errors.drive.track.scale", "value": -1.0})
    assert "-1.0 would be out of bounds" in answer["error"]
    assert "drive.track: expected a number [m] >= 0.001 and <= 100, got -0.33" in answer["error"]
    done(session, "step", steps=20)
    done(session, "save_scenario", name="changed")
    changed = am.load(tmp_path / "changed.toml")
    assert changed.robots[0].errors["drive.wheel_radius_left"].scale == 1.05
    assert 'map = "room.wld"' in (tmp_path / "changed.toml").read_text()
    done(session, "restore", robot="rover")

    # The past, and another future.
    newest = frame(session).newest
    assert done(session, "scrub", tick=10) == {
        "ok": True,
        "tick": 10,
        "exact": True,
        "can_continue": True,
        "reason": "",
    }
    assert frame(session).flags & FrameFlag.SCRUBBED
    assert done(session, "scrub", tick=None)["tick"] == newest
    done(session, "scrub", tick=newest - 15)
    epoch = frame(session).epoch
    assert done(session, "continue")["tick"] == newest - 15
    assert frame(session).epoch > epoch
    done(session, "step", steps=30)
    ticks = done(session, "history", robot="rover", max_points=5)["ticks"]
    assert len(ticks) <= 5
    assert ticks[-1] == newest + 15
    kinds = [line["kind"] for line in done(session, "events")["events"]]
    assert kinds == ["handed_over", "handed_over", "parameter_set", "continued", "saved"][: len(kinds)]
    assert "handed_over" in kinds

    # What was seen is what is saved.
    answer = done(session, "save_run", name="runs/first")
    assert answer["same"] is True
    outcome = am.reproduce(answer["folder"])
    assert (outcome.is_exact, outcome.steps) == (True, newest + 15), str(outcome)
    page = done(session, "page")["page"]
    assert page.startswith("<!doctype html>")
    assert len(page) > 300_000

    pid = session.link.pid
    began = time.monotonic()
    session.close()
    assert time.monotonic() - began < in_time()
    assert not is_running(pid)


def test_its_state_is_touched_in_its_loop_alone(start: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the threads find at the pipes, also at the child's end, comes to the session in its event loop."""
    seen: set[str] = set()

    def watch(kind: type, name: str) -> None:
        plain = getattr(kind, name)

        def noted(*arguments: Any) -> Any:
            assert asyncio.get_running_loop() is session._loop, name
            seen.add(name)
            return plain(*arguments)

        monkeypatch.setattr(kind, name, noted)

    session = start()
    for name in ("take", "stand_still", "newest"):
        watch(FrameBuffer, name)
    for name in ("_heard", "_finish"):
        watch(Link, name)
    window = session.open_window()
    done(session, "step", steps=3)
    frame(session)
    os.kill(session.link.pid, signal.SIGKILL)
    until(lambda: state(session, window)["status"] == "gone")
    assert seen == {"take", "stand_still", "newest", "_heard", "_finish"}


def test_windows_and_the_controls(start: Make) -> None:
    session = start()
    first, second = session.open_window(), session.open_window()

    def ask(window: str, do: str, **keys: Any) -> dict[str, Any]:
        return aside(session.ask(window, {"do": do, **keys}))

    assert ask(first, "step")["ok"]
    assert "another window has the controls" in ask(second, "step")["error"]
    assert ask(second, "state")["holder"] == first
    assert "another window has the controls" in ask(second, "controls", want="take")["error"]
    assert ask(second, "controls", want="ask")["asking"] == [second]
    assert ask(first, "state")["asking"] == [second]
    assert ask(first, "controls", want="give", to=second)["holder"] == second
    assert ask(second, "step")["ok"]
    assert "no command 'job'" in ask(second, "job")["error"]
    assert "not known" in ask("somebody", "state")["error"]

    # A window that goes while its robot drives.
    assert ask(second, "hand_over", robot="rover")["ok"]
    assert ask(second, "drive", robot="rover", forward=0.3)["ok"]
    assert ask(second, "step")["ok"]
    assert ask(second, "select", robot="rover")["ok"]
    session.close_window(second)
    assert session.holder == ""
    assert ask(first, "controls", want="take")["holder"] == first
    assert ask(first, "step")["ok"]
    done(session, "select", robot="rover")
    assert frame(session).selected.command.tolist() == [0.0, 0.0]

    # A window that goes while another one asks.
    third = session.open_window()
    assert ask(third, "controls", want="ask")["asking"] == [third]
    session.close_window(first)
    assert (session.holder, ask(third, "state")["asking"]) == (third, [])
    first = third

    # Names that lead out of the project's folder, and other nonsense.
    for name in ("../run", "/tmp/run", "a/../../b", "C:\\run", "", ".hidden", "a" * 200, "run\0"):
        assert "expected a name" in ask(first, "save_run", name=name)["error"]
    for command in (
        {"do": "speed", "factor": 0},
        {"do": "step", "steps": -1},
        {"do": "select", "robot": 9},
        {"do": "set", "robot": "rover", "path": "drive.nothing", "value": 1.0},
        {"do": "set", "robot": "rover", "path": "errors", "value": 1.0},
        {"do": "set", "robot": "rover", "path": "name", "value": 1.0},
        {"do": "set", "robot": "rover", "path": "controller", "value": 1.0},
        {"do": "set", "robot": "rover", "path": "errors.drive.track.scale", "value": "1"},
        {"do": "command", "robot": "rover", "channels": [1.0]},
        {"do": "hand_over", "robot": "rover", "to": "me"},
        {"do": "image", "name": "../../x"},
        {"do": "fly"},
        {"do": "end"},
        {"do": ["run"]},
        {},
    ):
        answer = aside(session.ask(first, command))
        assert not answer["ok"], command
        assert "Traceback" not in answer["error"]


def test_each_window_looks_at_its_own_robot(start: Make) -> None:
    session = start()
    first, second = session.open_window(), session.open_window()

    def ask(window: str, do: str, **keys: Any) -> dict[str, Any]:
        return aside(session.ask(window, {"do": do, **keys}))

    assert "expected a robot's name or its place from 0 to 1" in ask(first, "select", robot="rovr")["error"]
    assert ask(second, "select", robot="rover")["ok"]  # which needs no controls
    assert ask(first, "step", steps=5)["ok"]
    seen = [frame(session, window=window) for window in (first, second)]
    assert [one.selected_robot for one in seen] == [0, 1]
    assert [ask(window, "state")["selected"] for window in (first, second)] == [0, 1]
    # Each tells all of its robot, and both the same of what is common.
    other, rover = seen
    assert other.selected.true_twist.tolist() == [0.0, 0.0, 0.0]
    assert rover.selected.true_twist[0] > 0.1
    assert rover.selected.estimated_twist[0] == pytest.approx(rover.selected.true_twist[0], rel=0.1)
    assert len(rover.selected.measured) > 190
    assert (other.tick, rover.tick) == (5, 5)
    # What names no robot is meant for the one that is looked at.
    assert ask(second, "history")["true"] == ask(first, "history", robot="rover")["true"]
    assert ask(first, "history")["true"] == ask(second, "history", robot="other")["true"]
    # While nothing moves, a window that turns to it sees the other robot, and nobody else does.
    assert ask(first, "select", robot=1)["ok"]
    turned = frame(session, seen[0].number, first)
    assert (turned.selected_robot, turned.tick) == (1, 5)
    assert ask(second, "select", robot=0)["ok"]
    assert frame(session, seen[1].number, second).selected_robot == 0
    assert frame(session, window=first).selected_robot == 1
    # A window that goes is not looked for.
    session.close_window(second)
    assert session.session._looks.robots == [1]


def test_nobody_waits_for_a_window_and_none_leaves_anything_behind(start: Make) -> None:
    session = start()
    number = frame(session).number

    async def impatient() -> None:
        for _ in range(50):
            waiting = asyncio.ensure_future(session.newest_frame(number))
            await asyncio.sleep(0.001)
            waiting.cancel()
            with pytest.raises(asyncio.CancelledError):
                await waiting

    aside(impatient())
    until(lambda: session.session._frame_buffer.waiting == 0)
    # A loop that has gone takes no frame with it.
    with pytest.raises(asyncio.TimeoutError):
        aside(asyncio.wait_for(session.newest_frame(number), 0.01))
    done(session, "speed", factor=None)
    done(session, "run")
    # Nobody looks, and it runs all the same.
    before = done(session, "state")["tick"]
    until(lambda: done(session, "state")["tick"] > before or done(session, "state")["status"] == "ended")
    until(lambda: frame(session).flags & FrameFlag.ENDED)
    assert frame(session).tick == 600


@pytest.mark.parametrize("controller", ["Raising", "Endless", "Sleeping", "Exiting"])
def test_a_controller_that_fails_is_shown_and_left_out(start: Make, controller: str) -> None:
    session = start(f"own.py:{controller}", patience=PATIENCE, duration=8.0)
    window = session.open_window()
    frame(session)
    done(session, "select", robot="rover")
    done(session, "hand_over", robot="other", to="hand")
    done(session, "command", robot="other", channels=[1.0, 1.0])
    done(session, "speed", factor=None)
    done(session, "run")
    status = {"Raising": "fault", "Exiting": "gone"}.get(controller, "hang")
    shown = until(lambda: (s := state(session, window))["status"] == status and s)
    fault = shown["fault"]
    if status != "gone":  # nothing is left to tell where it was
        assert fault["robot"] == "rover"
        assert "own.py" in fault["stack"]
        assert {"Raising": "by design", "Endless": "while clock.tick == 40", "Sleeping": "time.sleep(3600)"}[
            controller
        ] in fault["stack"]
    if status == "hang":
        assert until(lambda: frame(session).flags & FrameFlag.HANG)
        assert "does not answer" in aside(session.ask(window, {"do": "step"}))["error"]
    if controller == "Raising":
        # Once more with it, and it fails again.
        done(session, "restart", without=[])
        assert state(session, window)["status"] == "paused"
        done(session, "run")
        until(lambda: state(session, window)["status"] == "fault")
        done(session, "restart", without=["rover"])
    else:
        began = time.monotonic()
        answer = done(session, "restart", without=["rover"])
        assert answer["again"] == (controller != "Endless")
        assert time.monotonic() - began < 30.0
    shown = state(session, window)
    assert (shown["status"], sorted(shown["by_hand"])) == ("paused", ["other", "rover"])
    # The last sign of life of a child that is gone may be some ticks old; otherwise it is as it was.
    assert shown["tick"] <= 40 if status == "gone" else shown["tick"] == 40
    done(session, "run")
    until(lambda: frame(session).flags & FrameFlag.ENDED)
    ended = frame(session)
    assert (ended.tick, ended.robot_flags[1] & RobotFlag.BY_HAND) == (80, RobotFlag.BY_HAND)
    if controller != "Exiting":
        # A run that is saved has the same past, the controller's failure left out.
        answer = done(session, "save_run", name="after")
        assert answer["same"] is True
        assert am.reproduce(answer["folder"]).is_exact


@pytest.mark.parametrize("controller", ["Exiting", "Held"])
def test_another_child_goes_on_from_the_last_snapshot_where_that_can_be_carried(start: Make, controller: str) -> None:
    session = start(f"own.py:{controller}", patience=PATIENCE)
    window = session.open_window()
    path = "errors.drive.wheel_radius_left.scale"
    done(session, "step", steps=3)
    done(session, "set", robot="rover", path=path, value=1.04)
    done(session, "speed", factor=1.6)
    done(session, "run")  # it gets to tick 40 after 2.3 s at the least, and a snapshot is taken after two
    until(lambda: state(session, window)["status"] == "gone")
    link = session.link
    assert (link.carried is not None) == (controller == "Exiting")
    done(session, "restart", without=["rover"])
    remark = next(one for one in done(session, "events")["events"] if one["kind"] == "restarted")
    since = "from the snapshot of" if controller == "Exiting" else "from the start, for controller of 'rover'"
    assert since in remark["text"]
    tick = state(session, window)["tick"]
    assert 3 < tick <= 40
    # It knows what was set, where it was, and the past, all as though nothing had happened.
    forms = {form["path"]: form for form in done(session, "parameters", robot="rover")["parameters"]}
    assert forms[path]["value"] == 1.04
    ticks = done(session, "history", robot="rover", max_points=1000)["ticks"]
    assert ticks == list(range(tick + 1))
    looked = done(session, "scrub", tick=2)
    assert (looked["exact"], looked["can_continue"]) == (True, controller == "Exiting")
    done(session, "scrub", tick=None)
    done(session, "step", steps=10)
    answer = done(session, "save_run", name="after")
    assert answer["same"] is True  # as the same led from the start
    # What is given up is not gone on from.
    if controller == "Exiting":
        assert session.link.carried is not None
        done(session, "reset")
        assert session.link.carried is None


def test_each_state_has_a_status_while_the_child_goes(start: Make) -> None:
    session = start()
    window = session.open_window()
    os.kill(session.link.pid, signal.SIGKILL)
    statuses = []
    until(lambda: statuses.append(state(session, window)["status"]) or statuses[-1] == "gone")
    assert set(statuses) <= {"paused", "gone"}


def test_what_a_controller_prints_goes_to_the_log(
    start: Make, capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Nor does a file in the present folder stand in for one of Python's.
    monkeypatch.chdir(tmp_path)
    (tmp_path / "json.py").write_text("raise SystemExit('not this one')")
    session = start("own.py:printing")
    done(session, "step", steps=3)
    until(lambda: "J" * 100 in capfd.readouterr().err)


def test_faults_of_a_scenario_are_reported_as_run_reports_them(tmp_path: Path) -> None:
    path = write_project(tmp_path)
    with pytest.raises(am.AmorsimError, match="unknown key; known keys") as caught:
        asyncio.run(Session(Recipe(name=str(path), changes=["robots.0.nme=3"])).start())
    with pytest.raises(am.ScenarioError) as directly:
        am.load(path, ["robots.0.nme=3"])
    assert str(caught.value) == str(directly.value)


def test_a_folder_is_written_as_it_goes(start: Make, tmp_path: Path) -> None:
    session = start(out=tmp_path / "out")
    done(session, "step", steps=5)
    done(session, "command", robot="other", channels=[2.0, 1.0])
    done(session, "step", steps=20)
    done(session, "reset")
    done(session, "step", steps=7)
    assert session.folder == str(tmp_path / "out-2")
    assert done(session, "futures", robot="other")["can_go_back"] is False
    session.close()
    for name, steps in (("out", 25), ("out-2", 7)):
        outcome = am.reproduce(tmp_path / name)
        assert (outcome.is_exact, outcome.steps) == (True, steps), str(outcome)


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="processes are looked for in /proc")  # noqa: PTH112
def test_a_child_ends_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    import signal
    import subprocess
    import sys

    path = write_project(tmp_path)
    script = (
        "import asyncio\n"
        "from pathlib import Path\n"
        "from amorsim.ui.simulator.recipe import Recipe\n"
        "from amorsim.ui.simulator.session import Session\n"
        "async def main():\n"
        f"    session = Session(Recipe(name={str(path)!r}), out=Path({str(tmp_path / 'out')!r}))\n"
        "    await session.start()\n"
        "    await session.request({'do': 'speed', 'factor': 5.0})\n"
        "    await session.request({'do': 'run'})\n"
        "    while session._supervisor.link.tick < 5: await asyncio.sleep(0.05)\n"
        "    print(session._supervisor.link.pid, flush=True)\n"
        "    await asyncio.sleep(60)\n"
        "asyncio.run(main())\n"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        pid = int(parent.stdout.readline())
        assert is_running(pid)
        parent.send_signal(signal.SIGKILL)
        parent.wait()
        began = time.monotonic()
        until(lambda: not is_running(pid))
        assert time.monotonic() - began < in_time()
    # It ended in order: the run it left is whole.
    assert am.reproduce(tmp_path / "out").is_exact


def test_it_ends_in_time_with_whole_files_while_a_controller_does_not_return(start: Make, tmp_path: Path) -> None:
    session = start("own.py:Endless", out=tmp_path / "out")
    done(session, "speed", factor=None)
    done(session, "run")
    until(lambda: session.link.tick == 40)
    began = time.monotonic()
    session.close()
    assert time.monotonic() - began < in_time()
    outcome = am.reproduce(tmp_path / "out")
    assert (outcome.is_exact, outcome.steps) == (True, 40)


@pytest.mark.long
def test_a_run_that_is_being_saved_is_broken_off_with_the_rest(start: Make, tmp_path: Path) -> None:
    session = start(duration=100_000.0)
    done(session, "speed", factor=None)
    done(session, "run")
    # So long that the second time takes some seconds too.
    until(lambda: frame(session).tick > 8000, 60.0)
    answers: list[dict[str, Any]] = []
    thread = threading.Thread(target=lambda: answers.append(session.request({"do": "save_run", "name": "saved"})))
    thread.start()
    poses = tmp_path / "saved" / "poses.csv"
    until(lambda: poses.exists() and poses.stat().st_size > 1000)
    began = time.monotonic()
    session.close()
    thread.join(5.0)
    assert time.monotonic() - began < in_time()
    assert not answers[0]["ok"]
    assert json.loads((tmp_path / "saved" / "run.json").read_text())["status"] in ("interrupted", "broken off")
    assert poses.read_text().endswith("\n")


def test_a_child_that_is_sent_nonsense_ends_and_is_no_orphan(start: Make) -> None:
    session = start()
    link = session.link
    link.tell({"do": "ping"})  # without a number to answer under
    until(lambda: not is_running(link.pid))
    until(lambda: session.hang is not None)
    assert done(session, "restart")["again"]
    done(session, "step")
