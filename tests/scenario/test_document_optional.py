"""Fields that are a component or nothing, in files and documents: read, said, left out, and overridden."""

from __future__ import annotations

import pytest

import amorsim as am
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.files.write import write_table
from tests import optional_components
from tests.building import rover_text, write_rover
from tests.installed import registered
from tests.optional_components import Careful

LINE = 'controller = { use = "careful", speed = 0.2 }  # for now'
TEXT = rover_text(LINE)
CONTROLLER = "robots.rover.controller"


@pytest.fixture(autouse=True)
def registry(monkeypatch):
    with registered(monkeypatch, optional_components) as found:
        yield found


@pytest.fixture
def document(tmp_path):
    return am.open_document(write_rover(tmp_path, LINE))


def said(*more):
    return TEXT.replace("speed = 0.2 }", ", ".join(("speed = 0.2", *more)) + " }")


def controller(document):
    assert document.faults() == ()
    return document.scenario().robots[0].controller


def test_a_component_that_is_none_by_default_comes_and_goes(document):
    assert document.get(f"{CONTROLLER}.avoider") == "none"
    assert document.inherited(f"{CONTROLLER}.avoider").source == "default"
    document.set(f"{CONTROLLER}.avoider.use", "vfh_plus")
    assert document.text == said('avoider = { use = "vfh_plus" }')
    document.set(f"{CONTROLLER}.avoider.speed", 0.25)
    assert document.text == said('avoider = { use = "vfh_plus", speed = 0.25 }')
    assert controller(document).avoider == am.controllers.VfhPlus(speed=0.25)
    document.set(f"{CONTROLLER}.avoider", "none")
    assert document.text == TEXT
    document.undo()
    document.remove(f"{CONTROLLER}.avoider")
    assert document.text == TEXT
    assert controller(document).avoider is None


def test_a_component_that_is_there_by_default_is_left_out_with_the_word_none(document):
    document.set(f"{CONTROLLER}.planner", "none")
    assert document.text == said('planner = "none"')
    assert controller(document).planner is None
    document.set(f"{CONTROLLER}.planner.use", "theta_star")
    assert document.text == said('planner = { use = "theta_star" }')
    document.set(f"{CONTROLLER}.planner", "none")
    document.set(f"{CONTROLLER}.planner", {"use": "a_star", "cell": 0.3})
    assert document.text == TEXT
    assert controller(document).planner == am.planners.AStar(cell=0.3)


def test_a_component_in_a_component_is_chosen_however_deep(document):
    place = f"{CONTROLLER}.spare"
    for _ in range(3):
        document.set(f"{place}.use", "careful")
        place = f"{place}.spare"
    document.set(f"{place}.use", "manual")
    found = controller(document)
    assert found.spare.spare.spare.spare == am.controllers.Manual()
    document.set(f"{CONTROLLER}.spare.spare", "none")
    assert document.text == said('spare = { use = "careful" }')


def test_a_model_s_component_is_taken_away_by_the_file(document, tmp_path):
    (tmp_path / "mine.toml").write_text(
        'format = 1\nmodel = "pioneer2dx"\ncontroller = { use = "careful", avoider = { use = "dwa", speed = 0.3 } }\n'
    )
    document.remove(CONTROLLER)
    document.set("robots.rover.model", "mine.toml")
    text = document.text
    document.set(f"{CONTROLLER}.avoider", "none")
    assert controller(document).avoider is None
    document.set(f"{CONTROLLER}.avoider.use", "orca")
    assert type(controller(document).avoider).__name__ == "Orca"
    document.set(f"{CONTROLLER}.avoider", {"use": "dwa", "speed": 0.3})
    assert document.text == text
    assert controller(document).avoider == am.controllers.Dwa(speed=0.3)


def test_what_is_read_is_written_again(document, tmp_path):
    document.set(f"{CONTROLLER}.planner", "none")
    document.set(f"{CONTROLLER}.avoider.use", "dwa")
    written = resolved_table(document.scenario())["robots"][0]["controller"]
    assert written["planner"] == "none"
    assert written["avoider"]["use"] == "dwa"
    assert "spare" not in written
    write_table(resolved_table(document.scenario()), tmp_path / "again.toml")
    again = am.load(tmp_path / "again.toml").robots[0].controller
    assert again == Careful(speed=0.2, planner=None, avoider=am.controllers.Dwa())


@pytest.mark.parametrize(
    ("given", "wrong"),
    [
        ('"non"', "a table with use = one of: .*, or \"none\", got 'non'"),
        ("{ speed = 0.1 }", "the name of a controller"),
        ('{ use = "manual" }', "cannot be used here; expected one of: .*dwa"),
        ("false", 'or "none", got False'),
    ],
)
def test_what_is_neither_a_component_nor_none_is_a_fault(document, given, wrong):
    document.set(f"{CONTROLLER}.avoider", "none")
    faulty = am.Document(said(f"avoider = {given}"), document.path)
    with pytest.raises(am.ScenarioError, match=wrong):
        faulty.scenario()


def test_it_is_simulated_with_and_without(document):
    document.set(f"{CONTROLLER}.avoider.use", "vfh_plus")
    simulation = am.Simulation(document.scenario())
    simulation.step()
    simulation.set("rover", "controller.avoider.speed", 0.1)
    assert simulation.robot("rover").nominal.controller.avoider.speed == 0.1
    with pytest.raises(am.AmorsimError, match=r"controller\.spare: only a number"):
        simulation.set("rover", "controller.spare", 1.0)
