"""Forms of a robot's parameters: sliders that start from something sensible, and names that say what a number is."""

from __future__ import annotations

import json
from typing import Any

import pytest

import amorsim as am
from amorsim.noise.quantize import Quantize
from amorsim.ui.forms.origins import Origins
from amorsim.ui.forms.running_robot import forms_of
from amorsim.ui.simulator.frames.protocol import ParameterForm
from amorsim.ui.simulator.sources.inputs import Input
from tests import building


def form_of(error: Any, path: str = "errors.drive.track.scale", **robot: Any) -> ParameterForm:
    errors = {} if error is None else {".".join(path.split(".")[1:-1]): error}
    simulation = am.Simulation(building.scenario(building.robot(errors=errors, **robot)))
    return next(form for form in forms_of(simulation, "rover") if form["path"] == path)


def normal(mean: float, std: float) -> am.Distribution:
    return am.Distribution(kind="normal", values=(mean, std))


def test_the_slider_of_a_drawn_factor_is_centred_on_its_mean() -> None:
    form = form_of(am.Deviation(scale=normal(1.0, 0.01)))
    assert form["value"] is None
    assert form["slider"] == pytest.approx([0.9, 1.1])


def test_the_slider_of_a_drawn_factor_covers_what_may_be_drawn() -> None:
    # Three standard deviations; none of it is 0 or less, for no track is.
    assert form_of(am.Deviation(scale=normal(1.02, 0.1)))["slider"] == pytest.approx([0.72, 1.32])
    low, high = form_of(am.Deviation(scale=normal(1.0, 0.8)))["slider"]
    assert low > 0.0
    assert (low + high) / 2.0 == pytest.approx(1.0)
    uniform = am.Distribution(kind="uniform", values=(0.8, 1.4))
    assert form_of(am.Deviation(scale=uniform))["slider"] == pytest.approx([0.8, 1.4])


def test_a_drawn_value_keeps_its_slider_when_it_is_set() -> None:
    simulation = am.Simulation(
        building.scenario(building.robot(errors={"drive.track": am.Deviation(scale=normal(1.02, 0.1))}))
    )
    simulation.set("rover", "errors.drive.track.scale", 1.05)
    form = next(form for form in forms_of(simulation, "rover") if form["path"] == "errors.drive.track.scale")
    assert form["value"] == 1.05
    assert form["slider"] == pytest.approx([0.72, 1.32])


def test_a_drawn_offset_stays_within_what_its_parameter_allows() -> None:
    path = "errors.drive.track.add"
    track = building.robot().drive.track  # type: ignore[attr-defined]
    form = form_of(am.Deviation(add=normal(0.01, 2.0)), path)
    low, high = form["slider"]
    assert low < 0.01 < high
    assert low <= form["drawn_value"] <= high  # type: ignore[operator]
    assert low + track > 0.0


def test_the_limit_of_a_rate_deviates_by_a_factor_and_what_is_nominally_0_by_a_sum() -> None:
    errors = [form for form in forms_of(am.Simulation(am.load("demo")), "rover") if form["kind"] == "systematic"]
    shown = {form["label"]: (form["value"], form["unit"]) for form in errors if form["group"] == "drive"}
    # "rate max 0" would be a limit of 0.
    assert shown["rate max"] == (1.0, "×")
    assert shown["acceleration max"] == (1.0, "×")
    assert shown["lag error"] == (0.0, "s")
    for form in errors:
        assert form["label"].endswith(" error") == form["path"].endswith(".add")


@pytest.mark.long
def test_no_end_of_a_slider_is_absurd_or_refused() -> None:
    simulation = am.Simulation(am.load("demo"))
    with_sliders = [form for form in forms_of(simulation, "rover") if form["slider"]]
    assert len(with_sliders) > 50
    for form in with_sliders:
        low, high = form["slider"]
        for end in (low, high):
            simulation.set("rover", form["path"], int(end) if form["type"] == "int" else end)
        simulation.set("rover", form["path"], form["value"])
        if form["kind"] == "nominal" and form["low"] == 0.0 and form["is_open"][0]:
            assert low == pytest.approx(form["value"] / 2.0), form["path"]


def test_the_slider_of_a_noise_is_of_the_size_of_the_noise() -> None:
    path = "sensors.encoder.noise.quantize.step"
    sensors = {
        "encoder": am.MountedSensor(sensor=building.encoder(), noise=building.chain(Quantize(step=0.000268))),
    }
    low, high = form_of(None, path, sensors=sensors)["slider"]
    assert 0.0 <= low < 0.000268 < high < 0.003


def test_a_drawn_value_is_reported_in_words() -> None:
    drawn = normal(1.0, 0.01)
    assert form_of(am.Deviation(scale=drawn))["drawn"] == "normal(1, 0.01)"
    simulation = am.Simulation(building.scenario(building.robot(errors={"drive.track": am.Deviation(scale=drawn)})))
    simulation.set("rover", "errors.drive.track.scale", 1.05)
    simulation.set("rover", "errors.drive.track.scale", drawn)
    assert str(simulation.events[-1]).endswith("rover: errors.drive.track.scale = normal(1, 0.01)")


def test_a_drawn_value_that_was_given_back_can_be_given_again() -> None:
    drawn = normal(1.0, 0.01)
    errors = {"drive.track": am.Deviation(scale=drawn)}
    given = Input(tick=0, do="set", robot="rover", path="errors.drive.track.scale", value=drawn)
    simulation = am.Simulation(building.scenario(building.robot(errors=errors)))
    again = Input.from_json(json.loads(json.dumps(given.to_json())))
    assert again == given
    again.give(simulation)


def test_what_was_drawn_is_shown_and_lies_on_its_slider() -> None:
    errors = {
        "drive.track": am.Deviation(scale=normal(1.02, 0.1)),
        "drive.wheel_radius_left": am.Deviation(value=normal(0.08, 0.001), per="study"),
        "sensors.encoder.mount.x": am.Deviation(add=normal(0.0, 0.1)),
    }
    simulation = am.Simulation(building.scenario(building.robot(errors=errors)))
    forms = {form["path"]: form for form in forms_of(simulation, "rover")}
    true = simulation.robot("rover").true
    drawn = {path: forms[path]["drawn_value"] for path in forms if forms[path]["drawn"]}
    assert drawn == {
        "errors.drive.track.scale": pytest.approx(true.drive.track / building.TRACK),  # type: ignore[attr-defined]
        "errors.drive.wheel_radius_left.value": true.drive.wheel_radius_left,  # type: ignore[attr-defined]
        "errors.sensors.encoder.mount.x.add": true.sensors["encoder"].mount.x,
    }
    for path, value in drawn.items():
        low, high = forms[path]["slider"]
        assert low <= value <= high  # type: ignore[operator]
    parts = {field["path"]: field["value"] for field in forms["errors.drive.track.scale"]["deviation"]}
    assert parts["errors.drive.track.scale"] == {"normal": [1.02, 0.1]}


def test_every_field_is_there_and_what_cannot_change_says_why() -> None:
    forms = {form["path"]: form for form in forms_of(am.Simulation(am.load("demo")), "rover")}
    assert "size" in forms["sensors.laser.beams"]["fixed"]
    assert forms["sensors.laser.beams"]["value"] == 181
    assert "name" in forms["controller.sensor"]["fixed"]
    assert forms["controller.sensor"]["widget"]["choices"] == ["encoder", "laser", "sonar", "compass", "gyro"]
    assert forms["sensors.sonar.elements"]["widget"]["kind"] == "forms"
    assert len(forms["sensors.sonar.elements"]["value"]) == 16
    assert forms["sensors.laser.latency"]["fixed"]
    assert not forms["sensors.laser.range_max"]["fixed"]


def test_a_value_says_where_it_comes_from() -> None:
    scenario = am.load("demo", ["robots.rover.drive.rate_max_deg=900.0"])
    simulation = am.Simulation(scenario)
    simulation.set("rover", "drive.track", 0.4)
    forms = {form["path"]: form for form in forms_of(simulation, "rover", Origins(scenario))}
    shown = {path: (forms[path]["origin"], forms[path]["is_changed"]) for path in forms}
    assert shown["errors.drive.track.scale"] == ("file", False)
    assert shown["drive.track"] == ("model", True)
    assert shown["drive.wheel_radius_left"] == ("model", False)
    assert shown["drive.lag"] == ("default", False)
    assert shown["drive.rate_max"] == ("command line", False)
    assert shown["errors.drive.lag.add"] == ("default", False)
    assert forms["sensors.compass.noise.quantize.step"]["source"].startswith("from the model pioneer2dx.toml, line ")
    assert {origin for origin, _ in shown.values()} == {"file", "model", "default", "command line"}


def test_the_error_of_one_element_of_a_ring_is_shown_too() -> None:
    errors = {"sensors.ring.elements.2.heading": am.Deviation(add=0.02)}
    simulation = am.Simulation(
        building.scenario(
            building.robot(errors=errors, sensors={"encoder": building.encoder(), "ring": building.ring()})
        )
    )
    form = next(form for form in forms_of(simulation, "rover") if form["path"].startswith("errors.sensors.ring.ele"))
    assert form["widget"]["kind"] == "number"
    assert (form["label"], form["value"], form["unit"]) == ("elements 2 heading error", 0.02, "rad")


def test_what_the_robot_knows_of_its_start_is_shown_and_fixed() -> None:
    belief = am.InitialBelief(kind="gaussian", std=0.3)
    simulation = am.Simulation(building.scenario(building.robot(initial_belief=belief)))
    forms = {form["path"]: form for form in forms_of(simulation, "rover")}
    std = forms["initial_belief.std"]
    assert (std["value"], std["unit"], std["group"], std["kind"]) == (0.3, "m", "initial_belief", "nominal")
    assert std["fixed"] == "It is used when an episode starts, and set when the simulation is made."
    assert std["slider"] == []
    assert forms["initial_belief.kind"]["widget"]["choices"] == ["exact", "gaussian", "nothing"]
    bare = am.Simulation(building.scenario(building.robot(estimators={})))
    assert not any(form["path"].startswith("initial_belief") for form in forms_of(bare, "rover"))
