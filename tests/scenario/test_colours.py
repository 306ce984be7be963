"""The colours of robots."""

from __future__ import annotations

import amorsim as am
from amorsim.runs.traces import Traces
from amorsim.scenario.colours import robot_colours
from amorsim.ui.simulator.frames.scenes import SceneBuilder
from tests import building


def robots(*colours: str | None) -> list[am.Robot]:
    return [building.robot(name=f"r{i}", colour=colour) for i, colour in enumerate(colours)]


def test_one_robot_alone_has_no_colour_but_its_own() -> None:
    assert robot_colours(robots(None)) == {"r0": None}
    assert robot_colours(robots("pink")) == {"r0": "pink"}


def test_of_several_each_has_its_own() -> None:
    given = robot_colours(robots(None, "pink", None, None))
    assert given["r1"] == "pink"
    assert None not in given.values()
    assert len(set(given.values())) == 4
    # One that has a colour of its own takes none from the others.
    assert given["r2"] == robot_colours(robots(None, None, None))["r1"]


def test_there_are_colours_for_any_number() -> None:
    given = robot_colours(robots(*[None] * 30))
    assert len(given) == 30
    assert None not in given.values()


def test_pictures_and_windows_show_the_same_colours() -> None:
    pair = [building.robot(name=name, pose=am.Pose(x=5.0 + 2.0 * i, y=5.0)) for i, name in enumerate(("b", "a"))]
    simulation = am.Simulation(building.scenario(*pair, map=building.empty(100.0)))
    given = robot_colours(pair)
    assert {path.name: path.colour for path in Traces(simulation).paths()} == given
    assert {robot["name"]: robot["colour"] for robot in SceneBuilder(simulation).scene["robots"]} == given
