"""Steps that are broken off in the middle, and runs that are stopped between two steps; handles that outlive both."""

from __future__ import annotations

import signal
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from tests import building


class Stopped:
    """Drives, and asks the run to stop at a tick, as Ctrl-C does."""

    def command(self, readings: Any, estimate: Any, clock: Any) -> am.Twist:
        if clock.tick == 5:
            signal.raise_signal(signal.SIGINT)
        return am.Twist(forward=0.2, turn=0.1)


def failing_at(tick: int) -> Any:
    def command(readings: Any, estimate: Any, clock: Any) -> am.Twist:
        if clock.tick == tick:
            raise ValueError("a fault of the user's")
        return am.Twist(forward=0.2)

    return command


def simulation(controller: Any, **given: Any) -> am.Simulation:
    robot = building.robot(name="rover", controller=controller, pose=am.Pose(x=3.0, y=4.0))
    return am.Simulation(building.scenario(robot), **given)


def test_ctrl_c_stops_a_run_between_two_steps_and_it_can_go_on() -> None:
    stopped, whole = simulation(Stopped), simulation(Stopped)
    with pytest.raises(KeyboardInterrupt):
        stopped.run(2.0)
    assert stopped.tick == 6
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        stopped.run(1.4)
        whole.run(2.0)
    finally:
        signal.signal(signal.SIGINT, before)
    assert stopped.digest() == whole.digest()


def test_after_a_step_that_was_broken_off_there_is_no_next() -> None:
    sim = simulation(failing_at(3))
    snapshot = sim.snapshot()
    with pytest.raises(am.ControllerError):
        sim.run(1.0)
    for _ in range(2):
        with pytest.raises(am.AmorsimError, match=r"the step after 0\.3 s was broken off.*restore"):
            sim.step()
    sim.restore(snapshot)
    sim.run(0.3)
    assert sim.tick == 3


def test_the_time_is_that_at_which_the_step_began_whatever_phase_failed() -> None:
    @attrs.frozen(kw_only=True)
    class Failing(am.estimators.DeadReckoning):
        def update(self, *given: Any) -> Any:
            if state["at"] == 4:  # the first update is before any step
                raise ValueError("a fault of the user's")
            state["at"] += 1
            return super().update(*given)

    state = {"at": 0}
    sim = am.Simulation(building.scenario(building.robot(name="rover", estimators={"dr": Failing()})))
    with pytest.raises(am.AmorsimError, match="a fault of the user's"):
        sim.run(1.0)
    with pytest.raises(am.AmorsimError, match=r"the step after 0\.3 s was broken off"):
        sim.step()


@pytest.mark.parametrize("seed", [None, 7])
def test_a_reset_makes_whole_what_was_broken_off(seed: int | None) -> None:
    sim = simulation(failing_at(3))
    with pytest.raises(am.ControllerError):
        sim.run(1.0)
    sim.reset(seed)
    sim.run(0.3)
    assert sim.tick == 3


def test_a_reset_of_some_replicas_leaves_the_others_half_way() -> None:
    sim = simulation(failing_at(3), replicas=2)
    with pytest.raises(am.ControllerError):
        sim.run(1.0)
    sim.reset(replicas=[0])
    with pytest.raises(am.AmorsimError, match="broken off"):
        sim.step()


def test_a_handle_drives_its_robot_after_every_reset() -> None:
    sim = simulation(am.controllers.Manual())
    rover, ways = sim.robot("rover"), []
    for again in (lambda: sim.reset(seed=2), lambda: sim.reset(), lambda: sim.set("rover", "ground", [])):
        start = rover.true_pose.copy()
        rover.drive(forward=0.5)
        sim.run(1.0)
        assert rover.true_pose.tolist() == sim.true_pose[0].tolist()
        ways.append(float(np.hypot(*(rover.true_pose - start)[:2])))
        again()
    assert min(ways) > 0.3
