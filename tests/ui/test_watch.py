"""A window for a simulation that a program steps: what it shows, what it may change, and what it refuses."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.ui.simulator.frames.packing import unpack_frame
from amorsim.ui.watch import Watch
from tests import building


def simulation(**changes: Any) -> am.Simulation:
    robot = building.robot(sensors={"encoder": am.MountedSensor(sensor=building.encoder())})
    return am.Simulation(building.scenario(robot), **changes)


@pytest.fixture
def watch() -> Iterator[Watch]:
    made = Watch(simulation(), name="mine", goal_of=lambda _: np.array([4.0, 3.0]), browser=False)
    yield made
    made.close()


def ask(watch: Watch, window: str, do: str, **more: Any) -> dict[str, Any]:
    return asyncio.run(watch.ask(window, {"do": do, **more}))


def newest_tick(watch: Watch, after: int = 0) -> int:
    async def newest() -> bytes:
        return await watch.newest_frame(after)

    future = asyncio.run_coroutine_threadsafe(newest(), watch._loop)
    return int(unpack_frame(future.result(10.0)).tick)


def test_a_program_s_steps_are_shown_and_are_those_of_the_simulation(watch: Watch) -> None:
    alone = simulation()
    watch.open_window()
    for _ in range(4):
        watch.step()
        alone.step()
    watch.show(0.0)
    assert newest_tick(watch, after=1) == 4
    assert watch.simulation.digest() == alone.digest()


def test_errors_can_be_set_in_between_and_the_time_is_the_program_s(watch: Watch) -> None:
    window = watch.open_window()
    (name,) = watch.simulation.names
    path = "errors.drive.wheel_radius_left.scale"
    assert ask(watch, window, "set", path=path, value=1.01, robot=name)["ok"]
    watch.step()
    drive: Any = watch.simulation.robot(name).true.drive
    nominal: Any = watch.simulation.robot(name).nominal.drive
    assert drive.wheel_radius_left == 1.01 * nominal.wheel_radius_left
    for do in ("run", "step", "reset", "scrub", "restart"):
        assert "a program steps and drives this" in ask(watch, window, do)["error"]
    assert watch.simulation.tick == 1


def test_the_way_to_the_goal_is_drawn(watch: Watch) -> None:
    window = watch.open_window()
    (name,) = watch.simulation.names
    x, y = watch.simulation.estimated_pose[0, :2]
    for robot in (0, name):
        assert ask(watch, window, "intended", robot=robot)["intended"]["path"] == [[x, y], [4.0, 3.0]]


def test_another_simulation_is_shown_in_the_same_windows(watch: Watch) -> None:
    window = watch.open_window()
    before = ask(watch, window, "scene")["scene"]["version"]
    other = simulation(seed=7)
    watch.take(other)
    watch.step()
    assert (watch.simulation, other.tick) == (other, 1)
    assert ask(watch, window, "scene")["scene"]["version"] == before + 1


def test_an_error_of_a_step_is_the_program_s() -> None:
    def broken(*_: Any) -> Any:
        raise ValueError("oh")

    robot = building.robot(controller=broken)
    watch = Watch(am.Simulation(building.scenario(robot)), name="broken", browser=False)
    try:
        with pytest.raises(am.ControllerError, match="oh"):
            watch.step()
    finally:
        watch.close()


def test_nothing_is_left_once_it_is_closed() -> None:
    before = threading.active_count()
    watch = Watch(simulation(), name="mine", browser=False)
    assert threading.active_count() > before
    watch.close()
    watch.close()
    assert not watch._thread.is_alive()


def test_of_several_replicas_none_can_be_shown() -> None:
    with pytest.raises(am.AmorsimError, match="expected a simulation of one replica, got one of 2"):
        Watch(simulation(replicas=2), name="two", browser=False)
