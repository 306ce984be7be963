"""What a window shows of a controller's intentions."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.recorders.arrays import Arrays
from amorsim.scenario.spec import Recording as What
from amorsim.ui.simulator.frames.intended import intended_of
from amorsim.ui.simulator.sources.recording import Recording
from tests.building import drive, encoder

WALLS = am.Map.from_segments([[3.0, -0.4, 3.0, 0.4]], resolution=0.02, extent=(-2.0, -4.0, 8.0, 4.0))


def one(controller: am.Controller, world: am.Map = WALLS) -> am.Simulation:
    """A robot with a scanner, looking along x, 1.5 m before a short wall; after two steps."""
    simulation = at_start(controller, world)
    simulation.step()
    simulation.step()
    return simulation


def at_start(controller: am.Controller, world: am.Map = WALLS, **changes: Any) -> am.Simulation:
    laser = am.MountedSensor(sensor=am.sensors.Laser(beams=91, fov=math.pi, range_max=4.0))
    robot = am.Robot(
        name="rover",
        drive=drive(rate_max=20.0),
        shape=am.Shape.circle(0.2),
        pose=am.Pose(x=1.5, y=0.0, heading=0.0),
        sensors={"encoder": am.MountedSensor(sensor=encoder()), "laser": laser},
        estimators={"wheels": am.estimators.DeadReckoning()},
        controller=controller,
    )
    return am.Simulation(am.Scenario(map=world, robots=[robot], dt=0.1, **changes))


def test_arcs_start_at_the_robot_and_the_one_taken_is_the_last() -> None:
    simulation = one(am.controllers.Dwa(goals=((5.0, 2.0),), horizon=1.0))
    said = intended_of(simulation, "rover")
    assert said["arcs"]
    assert all(arc["points"][0] == pytest.approx(said["pose"][:2], abs=1e-3) for arc in said["arcs"])
    assert [arc["taken"] for arc in said["arcs"]].count(True) == 1
    assert said["arcs"][-1]["taken"]
    assert max(arc["worth"] for arc in said["arcs"]) == said["arcs"][-1]["worth"] == 1.0
    v, w = simulation.frames()[0].beliefs["controller"]["twist"][0]
    x, y, heading = said["pose"]
    assert w != 0.0
    end = [
        x + v / w * (math.sin(heading + w) - math.sin(heading)),
        y - v / w * (math.cos(heading + w) - math.cos(heading)),
    ]
    assert said["arcs"][-1]["points"][-1] == pytest.approx(end, abs=1e-3)
    assert said["path"] is said["blocked"] is said["velocities"] is None


def test_the_plan_of_mppi_is_drawn_over_some_of_its_runs() -> None:
    simulation = one(am.controllers.Mppi(goals=((5.0, 0.0),), samples=30, time_steps=10))
    said = intended_of(simulation, "rover")
    assert said["arcs"] is not None
    assert len(said["arcs"]) == 25
    assert [arc["taken"] for arc in said["arcs"]] == [False] * 24 + [True]
    assert {len(arc["points"]) for arc in said["arcs"]} == {11}
    beliefs = simulation.frames()[0].beliefs["controller"]
    # The plan is a mean of all runs: within what they span, step by step.
    few = one(am.controllers.Mppi(goals=((5.0, 0.0),), samples=20, time_steps=10)).frames()[0].beliefs["controller"]
    assert (few["plan"] <= few["runs"].max(axis=1) + 1e-12).all()
    assert (few["plan"] >= few["runs"].min(axis=1) - 1e-12).all()
    assert beliefs["runs"].shape == (1, 24, 10, 2)


@pytest.mark.parametrize("name", ["VfhPlus", "NearnessDiagram"])
def test_a_histogram_is_blocked_where_the_wall_is(name: str) -> None:
    said = intended_of(one(getattr(am.controllers, name)(goals=((5.0, 0.0),), range_max=2.0)), "rover")
    assert said["blocked"] is not None
    count = len(said["blocked"])
    assert said["blocked"][count // 2]  # ahead
    assert not said["blocked"][count // 4]  # to the right
    assert said["bearing"]
    # The way that was taken is open.
    assert not said["blocked"][math.floor((said["bearing"][0] + math.pi) / (2.0 * math.pi) * count) % count]


@pytest.mark.parametrize(("name", "part"), [("Orca", "borders"), ("Hrvo", "cones"), ("HumanLike", "")])
def test_others_are_in_the_robots_frame_with_the_velocities_that_lead_into_them(name: str, part: str) -> None:
    neighbours = am.MountedSensor(sensor=am.sensors.Neighbours(slots=3))
    robots = [
        am.Robot(
            name=who,
            drive=drive(rate_max=20.0),
            shape=am.Shape.circle(0.2),
            pose=am.Pose(x=x, y=1.0, heading=heading),
            sensors={"encoder": am.MountedSensor(sensor=encoder()), "neighbours": neighbours},
            estimators={"wheels": am.estimators.DeadReckoning()},
            controller=getattr(am.controllers, name)(goals=((goal, 1.0),), sensor="neighbours", speed=0.4),
        )
        for who, x, heading, goal in (("left", 0.0, 0.0, 4.0), ("right", 3.0, math.pi, -1.0))
    ]
    simulation = am.Simulation(am.Scenario(map=WALLS, robots=robots, dt=0.1))
    simulation.step()
    said = intended_of(simulation, "right")["velocities"]
    assert said is not None
    assert said["speed"] == 0.4
    assert said["others"] == [pytest.approx([3.0, 0.0, 0.0, 0.0, 0.2], abs=1e-3)]
    assert len(said["borders"]) == (part == "borders")
    assert len(said["cones"]) == (part == "cones")
    ways = intended_of(simulation, "right")["ways"]
    assert (ways is None) == (name != "HumanLike")
    if ways:
        # Straight to the goal, the way ends before the other; aside it is free.
        ahead = min(ways, key=lambda way: abs(way[0]))
        assert ahead[1] == pytest.approx(3.0 - 0.4 - 0.05, abs=1e-3)
        assert max(way for _, way in ways) == 5.0


def test_the_path_and_what_was_searched_lie_in_the_world() -> None:
    navigate = am.controllers.Navigate(goals=((5.0, 0.0),), planner=am.planners.AStar(cell=0.1))
    simulation = one(navigate)
    said = intended_of(simulation, "rover")
    assert said["path"]
    assert said["path"][0] == pytest.approx([1.5, 0.0], abs=0.1)
    assert said["path"][-1] == pytest.approx([5.0, 0.0], abs=1e-3)
    assert said["searched"]
    low, high = np.min(said["searched"], axis=0), np.max(said["searched"], axis=0)
    assert low[0] <= 1.6
    assert high[0] >= 4.9
    assert len(said["searched"]) <= 1024
    assert said["arcs"]


def test_a_robot_by_hand_intends_nothing_and_a_controller_without_beliefs_has_none() -> None:
    simulation = one(am.controllers.Navigate(goals=((5.0, 0.0),), planner=am.planners.AStar(cell=0.1)))
    simulation.hand_over("rover")
    said = intended_of(simulation, "rover")
    assert said["path"] == said["searched"] == said["arcs"] == []
    assert intended_of(one(am.controllers.GoTo(x=3.0, y=1.0)), "rover")["path"] is None
    past = intended_of(one(am.controllers.VfhPlus(goals=((5.0, 0.0),))), "rover", is_known=False)
    assert past["blocked"] == past["bearing"] == []


def close(one: Any, other: Any) -> bool:
    """Whether two answers differ by the millimetre to which they are rounded, and the micrometre of files, at most."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(close(one[key], other[key]) for key in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(close, one, other))
    return one == pytest.approx(other, abs=2e-3) if isinstance(one, float) else one == other


@pytest.mark.parametrize(
    "controller",
    [
        am.controllers.Dwa(goals=((5.0, 2.0),), horizon=0.7),
        am.controllers.Mppi(goals=((5.0, 0.0),), samples=30, time_steps=10),
        am.controllers.VfhPlus(goals=((5.0, 0.0),), range_max=2.0),
        am.controllers.Navigate(goals=((5.0, 0.0),), planner=am.planners.AStar(cell=0.1)),
    ],
    ids=lambda one: type(one).__name__,
)
def test_a_recorded_run_shows_what_was_intended(tmp_path: Path, controller: am.Controller) -> None:
    """At each moment what was written last, where the robot was then."""
    also = [Arrays(every=0.2, of=("controller",))]
    simulation = at_start(controller, duration=0.6, recording=What(picture=False, also=also))
    live = []
    with am.record(simulation, tmp_path / "run") as session:
        for tick in range(6):
            live += [intended_of(simulation, "rover")] * 2 if tick % 2 == 0 else []
            simulation.step()
            session.keep()
    recording = Recording(tmp_path / "run")
    try:
        for tick, was in enumerate(live):
            assert recording.scrub(tick) == tick
            assert close(recording.intended("rover"), was), tick
        assert recording.scene["recorded"]["lacks"] == []
    finally:
        recording.close()
    assert any(was["arcs"] or was["blocked"] or was["path"] for was in live)


def test_without_arrays_a_recorded_run_shows_what_is_small_and_says_what_it_lacks(tmp_path: Path) -> None:
    simulation = at_start(am.controllers.VfhPlus(goals=((5.0, 0.0),), range_max=2.0), recording=What(picture=False))
    with am.record(simulation, tmp_path / "run") as session:
        simulation.step()
        session.keep()
    recording = Recording(tmp_path / "run")
    try:
        recording.scrub(1)
        assert close(recording.intended("rover")["bearing"], intended_of(simulation, "rover")["bearing"])
        (lack,) = recording.scene["recorded"]["lacks"]
        assert "Paths, searched cells and arcs, if controllers had any, were not recorded" in lack
    finally:
        recording.close()
