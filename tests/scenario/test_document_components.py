"""Fields that are components themselves, in documents: what is said of them, what holds by default, and what is set."""

from __future__ import annotations

import pytest

import amorsim as am
from tests.building import rover_text, write_rover

LINES = (
    "[robots.controller]",
    'use = "navigate"',
    "goals = [[3.0, 2.0]]",
    'planner = { use = "theta_star", cell = 0.1 }  # fine',
)
TEXT = rover_text(*LINES)
CONTROLLER = "robots.rover.controller"


@pytest.fixture
def document(tmp_path):
    return am.open_document(write_rover(tmp_path, *LINES))


def test_a_component_in_a_field_has_the_defaults_of_its_class(document):
    for path, source, value in (
        ("planner.use", "file", "theta_star"),
        ("planner.cell", "file", 0.1),
        ("avoider.use", "default", "dwa"),
        ("avoider.speed", "default", 0.5),
    ):
        origin = document.inherited(f"{CONTROLLER}.{path}")
        assert (origin.source, origin.value) == (source, value), path
    assert document.get(f"{CONTROLLER}.avoider")["use"] == "dwa"
    with pytest.raises(am.DocumentError, match="nothing says it"):
        document.get(f"{CONTROLLER}.avoider.sped")


def test_setting_a_field_of_a_default_component_says_which_component_it_is(document):
    document.set(f"{CONTROLLER}.avoider.speed", 0.3)
    assert document.text == TEXT + 'avoider = { use = "dwa", speed = 0.3 }\n'
    assert document.faults() == ()
    assert document.scenario().robots[0].controller.avoider.speed == 0.3
    document.set(f"{CONTROLLER}.avoider.speed", 0.5)
    assert document.text == TEXT
    document.undo()
    document.undo()
    assert document.text == TEXT


def test_another_component_in_a_field_takes_nothing_of_the_one_before(document):
    document.set(f"{CONTROLLER}.planner.use", "a_star")
    assert document.text == TEXT.replace('{ use = "theta_star", cell = 0.1 }', '{ use = "a_star" }')
    document.undo()
    assert document.text == TEXT
    document.set(f"{CONTROLLER}.avoider.use", "vfh_plus")
    assert document.text == TEXT + 'avoider = { use = "vfh_plus" }\n'
    document.set(f"{CONTROLLER}.avoider.use", "dwa")
    assert document.text == TEXT
    document.set(f"{CONTROLLER}.planner.cell", 0.2)
    assert document.text == TEXT.replace("cell = 0.1", "cell = 0.2")


def test_a_component_that_must_be_given_is_chosen_like_any_other(document):
    document.remove(f"{CONTROLLER}.planner")
    assert [fault.path for fault in document.faults()] == ["robots.0.controller.planner"]
    document.set(f"{CONTROLLER}.planner.use", "a_star")
    assert document.text.endswith('goals = [[3.0, 2.0]]\nplanner = { use = "a_star" }\n')
    assert document.faults() == ()


def test_a_component_of_the_model_is_overridden_in_parts_or_as_a_whole(document, tmp_path):
    (tmp_path / "mine.toml").write_text(
        'format = 1\nmodel = "pioneer2dx"\n'
        'controller = { use = "navigate", goals = [[1, 1]], planner = { use = "a_star", cell = 0.3 } }\n'
    )
    document.remove(CONTROLLER)
    document.set("robots.rover.model", "mine.toml")
    text = document.text
    origin = document.inherited(f"{CONTROLLER}.planner.cell")
    assert (origin.source, origin.value) == ("model", 0.3)
    document.set(f"{CONTROLLER}.planner.cell", 0.2)
    planner = document.scenario().robots[0].controller.planner
    assert (type(planner).__name__, planner.cell) == ("AStar", 0.2)
    document.set(f"{CONTROLLER}.planner.cell", 0.3)
    assert document.text == text
    document.set(f"{CONTROLLER}.planner.use", "theta_star")
    planner = document.scenario().robots[0].controller.planner
    assert (type(planner).__name__, planner.cell) == ("ThetaStar", None)
    document.set(f"{CONTROLLER}.avoider.speed", 0.3)
    assert document.scenario().robots[0].controller.avoider.speed == 0.3
