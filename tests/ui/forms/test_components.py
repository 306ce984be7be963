"""Fields that are components themselves: forms of them, as deep as they go, of built-in and of foreign classes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Planner
from amorsim.controllers.avoider import Avoider
from amorsim.controllers.dwa import Dwa
from amorsim.controllers.navigate import Navigate
from amorsim.planners import AStar, ThetaStar
from amorsim.plugins.manager import make_registry
from amorsim.ui.forms.description import form_of
from amorsim.ui.forms.origins import Origins
from amorsim.ui.forms.running_robot import forms_of
from tests import building
from tests.building import write_rover
from tests.installed import registered


@attrs.frozen(kw_only=True)
class Fallback(am.Controller):
    """Stands still, and has two controllers to fall back on."""

    first: am.Controller = am.parameter(Navigate(goals=((1.0, 2.0),), planner=AStar()), component="controller")
    way: Planner = am.parameter(AStar(cell=0.3), component="planner", static=True)

    def command(self, robot: Any, readings: Any, estimate: Any, clock: Any, state: Any, draws: Any) -> Any:
        return np.zeros((robot.rows, 2))


@attrs.frozen(kw_only=True)
class Shifted(am.Estimator):
    """What another estimator estimates, shifted along x."""

    inner: am.Estimator = am.parameter(am.estimators.DeadReckoning(), component="estimator")
    shift: float = am.parameter(0.5, unit="m")

    def start(self, context: Any) -> Any:
        return self.inner.start(context)

    def update(self, robot: Any, readings: Any, command: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        found = self.inner.update(robot, readings, command, elapsed, state, draws)
        pose = found.pose + np.concatenate([self.shift, 0 * self.shift, 0 * self.shift], axis=1)
        return am.Estimate(pose=pose, covariance=found.covariance)


class Foreign:
    """A plugin that brings components whose fields are components, and no code for forms."""

    @staticmethod
    @am.hookimpl
    def amorsim_register(registry: Any) -> None:
        registry.controller("fallback", Fallback)
        registry.estimator("shifted", Shifted)


@pytest.fixture(scope="module")
def registry() -> Any:
    return make_registry({"foreign": Foreign}, entry_points=(), disabled="")


def by_path(fields: Any) -> dict[str, Any]:
    """Fields by their paths, with those within them."""
    found = {}
    for field in fields:
        found[field["path"]] = field
        found |= by_path(field["widget"].get("fields", ()) if field["widget"]["kind"] == "component" else ())
    return found


def test_a_field_that_is_a_component_is_a_choice_with_the_fields_of_what_is_chosen() -> None:
    said = {"goals": [[1.0, 2.0]], "planner": {"use": "theta_star", "cell": 0.2}}
    fields = by_path(form_of(Navigate, said, spelling="file", path="robots.0.controller"))
    planner, avoider = fields["robots.0.controller.planner"], fields["robots.0.controller.avoider"]
    assert json.loads(json.dumps(planner)) == planner
    assert planner["widget"]["kind"] == avoider["widget"]["kind"] == "component"
    assert (planner["widget"]["component"], avoider["widget"]["component"]) == ("planner", "controller")
    assert {"a_star", "theta_star"} <= set(planner["widget"]["choices"])
    # Of the controllers, those that can drive along a path.
    assert "dwa" in avoider["widget"]["choices"]
    assert not {"manual", "navigate"} & set(avoider["widget"]["choices"])
    assert planner["value"] == {"use": "theta_star", "cell": 0.2}
    assert (planner["is_required"], avoider["is_given"], avoider["value"]["use"]) == (True, False, "dwa")
    cell = fields["robots.0.controller.planner.cell"]
    assert (cell["value"], cell["is_given"], cell["widget"]["unit"]) == (0.2, True, "m")
    turn = fields["robots.0.controller.avoider.turn_rate_deg"]
    assert (turn["widget"]["unit"], turn["is_given"]) == ("deg/s", False)
    assert turn["value"] == pytest.approx(np.degrees(Dwa().turn_rate))


def test_a_component_that_is_not_chosen_or_not_known_has_no_fields_yet() -> None:
    for said in ({}, {"planner": {"use": "warp"}}, {"planner": 3}, {"planner": {"cell": 0.1}}):
        planner = by_path(form_of(Navigate, said, spelling="file"))["planner"]
        assert planner["widget"]["fields"] == []
        assert json.dumps(planner)


def test_a_foreign_component_has_a_form_however_deep_it_goes(registry: Any) -> None:
    given = Fallback(first=Navigate(goals=((1.0, 2.0),), planner=ThetaStar(), avoider=Dwa(speed=0.25)))
    for spelling in ("python", "file"):
        fields = by_path(form_of(Fallback, spelling=spelling, registry=registry))  # type: ignore[arg-type]
        assert "fallback" in fields["first"]["widget"]["choices"]
        assert fields["way.cell"]["value"] == 0.3
        assert fields["first.avoider.speed"]["value"] == Dwa().speed
        assert not any(field["is_given"] for field in fields.values())
    fields = by_path(form_of(Fallback, given, registry=registry, is_running=True))
    assert fields["first.planner"]["value"]["use"] == "theta_star"
    assert fields["first.avoider.speed"]["value"] == 0.25
    fixed = {path: field["fixed"] for path, field in fields.items()}
    assert not fixed["first.avoider.speed"]
    assert "controller" in fixed["first"]
    assert fixed["first.planner.cell"] == fixed["way.cell"] == "The planner is set when the simulation is made."


def simulated() -> am.Simulation:
    laser = am.sensors.Laser(beams=9, range_max=4.0)
    controller = Navigate(goals=((4.0, 4.0),), planner=AStar(cell=0.1), avoider=Dwa(speed=0.4))
    sensors = {"encoder": building.encoder(), "laser": laser}
    return am.Simulation(building.scenario(building.robot(sensors=sensors, controller=controller)))


def test_the_simulator_shows_the_components_of_a_controller_and_tunes_what_may_change() -> None:
    simulation = simulated()
    forms = {form["path"]: form for form in forms_of(simulation, "rover")}
    planner, cell = forms["controller.planner"], forms["controller.planner.cell"]
    assert (planner["widget"]["kind"], planner["value"]["use"]) == ("component", "a_star")
    assert (planner["group"], cell["group"], cell["kind"]) == ("controller", "controller.planner", "controller")
    assert planner["fixed"] == "Which planner it is, is set when the simulation is made."
    assert cell["fixed"] == "The planner is set when the simulation is made."
    assert (cell["value"], cell["slider"]) == (0.1, [])
    assert forms["controller.avoider"]["fixed"]
    speed = forms["controller.avoider.speed"]
    assert (speed["value"], speed["fixed"]) == (0.4, "")
    assert speed["slider"]
    assert json.dumps(list(forms.values()))
    simulation.set("rover", "controller.avoider.speed", 0.3)
    forms = {form["path"]: form for form in forms_of(simulation, "rover")}
    speed = forms["controller.avoider.speed"]
    assert (speed["value"], speed["scenario"], speed["is_changed"]) == (0.3, 0.4, True)
    for path in ("controller.planner.cell", "controller.planner"):
        with pytest.raises(am.AmorsimError, match=r"fixed once a simulation is made|only a number"):
            simulation.set("rover", path, 0.2)


def test_where_a_value_of_a_component_in_a_field_comes_from_is_said() -> None:
    scenario = am.load("find-the-way")
    forms = {form["path"]: form for form in forms_of(am.Simulation(scenario), "rover", Origins(scenario))}
    assert forms["controller.avoider.speed"]["source"].startswith("from find-the-way.toml, line ")
    assert forms["controller.avoider.speed"]["origin"] == forms["controller.planner.cell"]["origin"] == "file"
    assert forms["controller.avoider.patience"]["origin"] == "default"
    assert issubclass(Dwa, Avoider)


def test_a_foreign_estimator_in_another_is_read_shown_and_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with registered(monkeypatch, Foreign):
        file = write_rover(
            tmp_path,
            "estimators.dead_reckoning = false",
            "estimators.both = { use = 'shifted', inner = { use = 'shifted', inner = { use = 'dead_reckoning' } } }",
        )
        simulation = am.Simulation(am.load(file))
        forms = {form["path"]: form for form in forms_of(simulation, "rover")}
        inner = forms["estimators.both.inner.inner"]
        assert (inner["value"]["use"], inner["group"]) == ("dead_reckoning", "estimators.both.inner")
        assert forms["estimators.both.inner.shift"]["slider"]
        simulation.step()
        true, estimated = simulation.robot("rover").true_pose, simulation.robot("rover").estimated_pose
        assert estimated[0] - true[0] == pytest.approx(1.0, abs=0.01)
        simulation.set("rover", "estimators.both.inner.shift", 0.25)
        simulation.step()
        assert simulation.robot("rover").estimated_pose[0] - true[0] == pytest.approx(0.75, abs=0.01)
