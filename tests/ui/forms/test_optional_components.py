"""Forms of fields that are a component or nothing: of all registered components, in files and while they run."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import pytest

import amorsim as am
from amorsim.core.parameters import describe
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import KINDS
from amorsim.ui.editor.changes import apply
from amorsim.ui.editor.inspectors.inspector import inspect
from amorsim.ui.editor.work import Work
from amorsim.ui.forms.chains import noises_for, with_element
from amorsim.ui.forms.description import form_of
from amorsim.ui.forms.running_robot import forms_of
from tests import building, optional_components
from tests.building import rover_text, write_rover
from tests.installed import registered
from tests.optional_components import Careful

LINE = 'controller = { use = "careful" }  # for now'
TEXT = rover_text(LINE)
CONTROLLER = "robots.0.controller"


@pytest.fixture(autouse=True)
def registry(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    with registered(monkeypatch, optional_components) as found:
        yield found


def by_path(fields: Any) -> dict[str, Any]:
    """Fields by their paths, with those within them."""
    found = {}
    for field in fields:
        found[field["path"]] = field
        found |= by_path(field["widget"].get("fields", ()) if field["widget"]["kind"] == "component" else ())
    return found


def optional_fields() -> Iterator[tuple[str, type, str]]:
    """Each registered component with a field that may be none, and the field's name."""
    for kind in KINDS:
        for name in default_registry().names(kind) if kind not in ("robot", "device", "scenario") else ():
            cls = default_registry().get(kind, name)
            for parameter in describe(cls).values():
                if parameter.component and parameter.is_optional:
                    yield kind, cls, parameter.name


def test_every_optional_component_of_every_registered_component_is_a_choice_with_none() -> None:
    found = list(optional_fields())
    assert {("controller", Careful, name) for name in ("avoider", "spare", "planner")} <= set(found)
    for _, cls, name in found:
        parameter = describe(cls)[name]
        for spelling in ("python", "file"):
            field = by_path(form_of(cls, {name: None}, spelling=spelling))[name]  # type: ignore[arg-type]
            assert (field["widget"]["kind"], field["widget"]["is_optional"]) == ("component", True)
            assert (field["value"], field["widget"]["fields"], field["is_given"]) == (None, [], True)
            assert field["widget"]["choices"], (cls, name)
            for use in field["widget"]["choices"]:
                fields = by_path(form_of(cls, {name: {"use": use}}, spelling=spelling))  # type: ignore[arg-type]
                inner = default_registry().get(parameter.component, use)
                assert fields[name]["value"] == {"use": use}
                assert len(fields[name]["widget"]["fields"]) == len(attrs.fields(inner))
        said = by_path(form_of(cls, {name: "none"}, spelling="file"))[name]
        assert said["value"] is None


@pytest.fixture
def work(tmp_path: Path) -> Work:
    return Work(str(write_rover(tmp_path, LINE)), tmp_path)


def shown(work: Work) -> dict[str, Any]:
    sections = inspect(work.document, "robots.0", work.registry)
    return by_path(field for section in sections for field in section["fields"])


def test_the_editor_writes_and_removes_it_at_any_depth(work: Work) -> None:
    fields = shown(work)
    avoider, planner = fields[f"{CONTROLLER}.avoider"], fields[f"{CONTROLLER}.planner"]
    assert (avoider["value"], avoider["widget"]["is_optional"], avoider["is_given"]) == (None, True, False)
    assert (planner["value"]["use"], planner["widget"]["is_optional"]) == ("a_star", True)
    apply(work, [{"op": "set", "path": f"{CONTROLLER}.spare.use", "value": "careful"}])
    apply(work, [{"op": "set", "path": f"{CONTROLLER}.spare.avoider.use", "value": "dwa"}])
    apply(work, [{"op": "set", "path": f"{CONTROLLER}.spare.avoider.speed", "value": 0.3}])
    inner = 'spare = { use = "careful", avoider = { use = "dwa", speed = 0.3 } }'
    assert work.text == TEXT.replace('"careful" }', f'"careful", {inner} }}')
    fields = shown(work)
    speed = fields[f"{CONTROLLER}.spare.avoider.speed"]
    assert (speed["value"], speed["is_given"], speed["widget"]["unit"]) == (0.3, True, "m/s")
    apply(work, [{"op": "set", "path": f"{CONTROLLER}.spare.avoider", "value": None}])
    assert work.text == TEXT.replace('"careful" }', '"careful", spare = { use = "careful" } }')
    apply(work, [{"op": "remove", "path": f"{CONTROLLER}.spare"}])
    assert work.text == TEXT
    apply(work, [{"op": "set", "path": f"{CONTROLLER}.planner", "value": None}])
    assert work.text == TEXT.replace('"careful" }', '"careful", planner = "none" }')
    assert shown(work)[f"{CONTROLLER}.planner"]["value"] is None
    apply(work, [{"op": "set", "path": f"{CONTROLLER}.planner.use", "value": "theta_star"}])
    assert work.text == TEXT.replace('"careful" }', '"careful", planner = { use = "theta_star" } }')
    assert work.document.faults() == ()


def test_the_simulator_shows_it_tunes_what_is_in_it_and_says_why_it_stays() -> None:
    controller = Careful(avoider=am.controllers.Dwa(speed=0.3), spare=Careful(avoider=am.controllers.VfhPlus()))
    robot = building.robot(
        sensors={"encoder": building.encoder(), "laser": am.sensors.Laser(beams=9)}, controller=controller
    )
    simulation = am.Simulation(building.scenario(robot))
    forms = {form["path"]: form for form in forms_of(simulation, "rover")}
    assert json.dumps(list(forms.values()))
    assert forms["controller.avoider"]["value"]["use"] == "dwa"
    none = forms["controller.spare.spare"]
    assert (none["widget"]["kind"], none["value"]) == ("component", None)
    why = "Whether there is a controller, and which, is set when the simulation is made."
    assert none["fixed"] == forms["controller.avoider"]["fixed"] == why
    simulation.set("rover", "controller.spare.avoider.speed", 0.1)
    forms = {form["path"]: form for form in forms_of(simulation, "rover")}
    assert forms["controller.spare.avoider.speed"]["value"] == 0.1
    assert forms["controller.spare.avoider.speed"]["is_changed"]


def test_a_draft_of_noise_has_the_fields_of_what_is_chosen_in_it() -> None:
    robot = building.robot(sensors={"encoder": building.encoder(), "laser": am.sensors.Laser(beams=9)})

    def fields(said: dict[str, Any] | None = None) -> dict[str, Any]:
        choices = {one["name"]: one for one in noises_for(robot, "sensors.laser.noise", said)}
        return by_path(choices["swayed"]["fields"])

    assert (fields()["guide"]["value"], fields()["way.cell"]["is_given"]) == (None, False)
    assert not any(path.startswith("guide.") for path in fields())
    table = {"use": "swayed", "add": 0.1, "guide": {"use": "dead_reckoning"}, "way": {"use": "theta_star", "cell": 0.2}}
    made = fields(table)
    assert (made["add"]["value"], made["add"]["is_given"]) == (0.1, True)
    assert made["guide.encoder"]["value"] == "encoder"
    assert (made["way.cell"]["value"], made["way.lazy"]["is_given"]) == (0.2, False)
    (element,) = with_element(robot, "sensors.laser.noise", {**table, "guide": None})
    assert element == {**table, "guide": "none"}
    simulation = am.Simulation(building.scenario(robot))
    simulation.set("rover", "sensors.laser.noise", [{**table, "guide": "none"}])
    (added,) = simulation.robot("rover").nominal.sensors["laser"].noise
    assert (added.noise.guide, added.noise.way.cell) == (None, 0.2)
    forms = {form["path"]: form for form in forms_of(simulation, "rover")}
    assert forms["sensors.laser.noise.swayed.guide"]["value"] is None
    assert forms["sensors.laser.noise.swayed.way.cell"]["value"] == 0.2
