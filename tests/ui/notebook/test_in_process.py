"""A simulation of this process, played for a window: what the window does, and what a cell does in between."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

import amorsim as am
from amorsim.ui.notebook.widget import REFUSED
from amorsim.ui.simulator.frames.packing import FrameFlag, unpack_frame
from amorsim.ui.simulator.in_process import MOST_IN_FLIGHT, Live
from tests import building


def simulation(controller: Any = None, **changes: Any) -> am.Simulation:
    robot = building.robot(controller=controller, sensors={"encoder": am.MountedSensor(sensor=building.encoder())})
    return am.Simulation(building.scenario(robot), **changes)


class Window:
    """One window that gets all frames at once."""

    def __init__(self, sim: am.Simulation) -> None:
        self.frames: list[bytes] = []
        self.live = Live(sim, self.frames.append, REFUSED)
        self.live.open_window("w")

    def ask(self, do: str, **more: Any) -> dict[str, Any]:
        answer = self.live.ask("w", {"do": do, **more})
        self.live.received("w")
        return answer

    @property
    def newest(self) -> Any:
        return unpack_frame(self.frames[-1])


def test_a_window_steps_the_very_simulation() -> None:
    sim = simulation()
    window = Window(sim)
    assert window.newest.tick == 0
    assert window.ask("scene")["scene"]["robots"][0]["name"] == sim.names[0]
    assert window.ask("step", steps=3) == {"ok": True, "tick": 3, "steps": 3}
    assert sim.tick == 3
    assert window.newest.tick == 3
    assert window.ask("state")["holder"] == "w"


def test_beginning_again_keeps_the_object() -> None:
    sim = simulation()
    before = sim.digest()
    window = Window(sim)
    window.ask("step", steps=5)
    window.ask("reset")
    assert sim.tick == 0
    assert sim.digest() == before
    window.ask("step")
    assert sim.tick == 1


def test_what_a_cell_does_the_window_shows_and_begins_there() -> None:
    sim = simulation()
    sim.run(1.0)
    window = Window(sim)
    first = sim.tick
    assert window.newest.tick == first
    window.ask("step", steps=2)
    assert window.ask("scrub", tick=0)["tick"] == first  # its past begins where the widget was made
    window.ask("scrub")
    epoch = window.newest.epoch
    sim.run(1.0)
    now = sim.tick
    assert window.ask("state")["tick"] == now
    assert window.newest.epoch > epoch
    assert window.newest.tick == now
    assert window.ask("history", robot=0)["ticks"] == [now]
    assert window.ask("scrub", tick=first)["tick"] == now
    window.ask("step", steps=3)
    window.ask("reset")
    assert sim.tick == now


def test_the_past_is_gone_on_from() -> None:
    sim = simulation()
    straight = simulation()
    straight.run(1.0)
    window = Window(sim)
    window.ask("step", steps=20)
    assert window.ask("scrub", tick=6)["tick"] == 6
    assert sim.tick == 6  # the cell sees the moment that is shown
    window.ask("continue")
    window.ask("step", steps=straight.tick - 6)
    assert sim.digest() == straight.digest()


def test_an_error_that_is_set_is_the_simulation_s() -> None:
    sim = simulation()
    window = Window(sim)
    name = sim.names[0]
    parameters = window.ask("parameters", robot=0)["parameters"]
    assert parameters
    before = sim.robot(name).true.drive.track
    assert window.ask("set", robot=name, path="drive.track", value=before * 1.1)["ok"]
    assert sim.robot(name).true.drive.track != before


def test_it_plays_while_the_kernel_sees_to_other_things(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("amorsim.ui.simulator.in_process.LONGEST_TURN", 0.0)  # a step in each turn

    async def play() -> tuple[int, int, Window, am.Simulation]:
        sim = simulation()
        window = Window(sim)
        assert window.ask("speed", factor=1000.0)["ok"]
        window.ask("run")
        turns = 0
        while sim.tick < 50:
            await asyncio.sleep(0)
            turns += 1
            window.live.received("w")
        window.ask("pause")
        await asyncio.sleep(0.1)
        stopped = sim.tick
        await asyncio.sleep(0.1)
        assert sim.tick == stopped
        return turns, stopped, window, sim

    turns, stopped, window, _ = asyncio.run(play())
    assert turns >= 50
    window.live.received("w")
    window.live.show()
    assert window.newest.tick == stopped
    assert not window.newest.flags & FrameFlag.RUNNING


def test_no_more_frames_are_on_their_way_than_a_window_takes() -> None:
    sim = simulation()
    frames: list[bytes] = []
    live = Live(sim, frames.append)
    live.open_window("w")
    for _ in range(10):
        live.ask("w", {"do": "step"})
    assert len(frames) == MOST_IN_FLIGHT
    live.received("w")
    assert len(frames) == MOST_IN_FLIGHT + 1
    assert unpack_frame(frames[-1]).tick == 10
    live.close_window("w")
    live.ask("w", {"do": "step"})
    assert len(frames) == MOST_IN_FLIGHT + 1


class Failing:
    def command(self, readings: Any, estimate: Any, clock: Any) -> Any:
        if clock.time > 0.3:
            raise ValueError("no idea")
        return am.Twist(forward=0.1)


def test_a_controller_that_fails_is_told() -> None:
    window = Window(simulation(Failing))
    window.ask("step", steps=10)
    state = window.ask("state")
    assert state["status"] == "fault"
    assert "no idea" in state["fault"]["text"]


def test_what_is_not_for_a_notebook_is_refused_in_words(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    window = Window(simulation())
    assert "am.run" in window.ask("save_run")["error"]
    assert "run the cell again" in window.ask("restart")["error"]
    assert "there is no command" in window.ask("dance")["error"]
    assert not window.ask("drive", forward="fast")["ok"]
    with pytest.raises(am.AmorsimError, match="one replica"):
        Window(simulation(replicas=3))
