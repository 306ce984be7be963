"""The lines of a simulation's story: a contact of two bodies is one of them."""

from __future__ import annotations

import amorsim as am
from amorsim.simulation.events import Event
from amorsim.ui.simulator.sources.story import Story


def met(name: str, other: str, speed: float, *, tick: int = 3) -> Event:
    return Event(
        tick=tick, time=0.1 * tick, replica=0, kind="collision", name=name, other=other, point=(1.0, 2.0), speed=speed
    )


def test_a_contact_of_two_bodies_is_shown_once_with_both_speeds() -> None:
    lines = Story().lines([met("a", "b", 0.5), met("b", "a", 0.25)])
    assert [line.get("is_told", False) for line in lines] == [False, True]
    assert lines[0]["text"] == "a met b at (1.000, 2.000) m, going 0.500 m/s, b 0.250 m/s"
    assert [line["number"] for line in lines] == [1, 2]


def test_contacts_with_walls_and_with_others_are_shown_each() -> None:
    happened = [
        met("a", "wall", 0.5),
        met("b", "wall", 0.5),
        met("a", "b", 0.5),
        met("b", "c", 0.5),
        met("b", "a", 0.1, tick=4),
    ]
    assert not any("is_told" in line for line in Story().lines(happened))


def test_an_error_that_was_added_is_told_in_words() -> None:
    simulation = am.Simulation(am.load("demo"))
    simulation.set("rover", "errors.drive.track", {"scale": 1.0, "add": 0.0})
    assert Story().lines(simulation.events)[-1]["text"] == "rover: errors.drive.track: scale = 1.0, add = 0.0"
