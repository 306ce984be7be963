"""The colours of robots."""

from __future__ import annotations

import amorsim as am
from amorsim.scenario.colours import robot_colours
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
