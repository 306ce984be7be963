"""Forms of component classes: a proper widget for each type of field, in the spelling of Python and of files."""

from __future__ import annotations

import json
import math
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Planner
from amorsim.core.parameters import describe
from amorsim.planners import AStar
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import KINDS
from amorsim.scenario.random_start import RandomStart
from amorsim.scenario.spec import Landmark, MountedSensor
from amorsim.ui.forms.description import choices_of, deviation_form, form_of


@attrs.frozen(kw_only=True)
class Everything(am.Noise):
    """One field of each type."""

    needed: float = am.parameter(unit="m", gt=0, le=9, help="which must be given")
    angle: float = am.parameter(math.pi / 2, unit="rad", ge=0, lt=math.pi)
    std: float = am.parameter(0.1, unit="sensor", ge=0)
    optional: float | None = am.parameter(None, unit="s", gt=0)
    count: int = am.parameter(3, ge=1, static=True)
    flag: bool = am.parameter(True)
    choice: str = am.parameter("near", choices=("near", "far"))
    text: str = am.parameter("hello")
    fixed: float = am.parameter(1.0, live=False)
    file: str = am.parameter("", file=True)
    sensor: str = am.parameter("laser", refers="sensors")
    pair: tuple[float, float] = am.parameter((1.0, 2.0), unit="rad")
    numbers: tuple[float, ...] = am.parameter((1.0, 2.0), ge=0)
    whole: tuple[int, ...] = am.parameter(())
    words: tuple[str, ...] = am.parameter(("red",))
    place: tuple[float, float] = am.parameter((0.0, 1.0), unit="m", frame="body")
    points: tuple[tuple[float, float], ...] = am.parameter(((1.0, 2.0),), unit="m", frame="world")
    table: tuple[tuple[float, float, float], ...] = am.parameter(())
    mount: am.Mount = am.parameter(am.Mount(x=0.5))
    mounts: tuple[am.Mount, ...] = am.parameter((am.Mount(heading=math.pi),))
    either: str | tuple[int, ...] = am.parameter("all", choices=("all", "none"))
    planner: Planner = am.parameter(AStar(), static=True, component="planner")

    def corrupt(self, values: Any, side: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        return np.asarray(values)


KIND = {
    **dict.fromkeys(("needed", "angle", "std", "optional", "count", "fixed"), "number"),
    **{name: name for name in ("flag", "choice", "text", "file", "table", "either")},
    **dict.fromkeys(("pair", "numbers", "whole", "words", "place"), "list"),
    "sensor": "name",
    "points": "table",
    "mount": "form",
    "mounts": "forms",
    "planner": "component",
}


def everything(values: Any = None, **options: Any) -> dict[str, Any]:
    form = form_of(Everything, values, **options)
    assert json.loads(json.dumps(form)) == form  # it can be sent to a window
    return {field["path"]: field for field in form}


def test_each_type_of_field_has_its_widget() -> None:
    form = everything(sensor_unit="m", names={"sensors": ["laser", "sonar"]})
    assert {path: field["widget"]["kind"] for path, field in form.items()} == KIND
    widget = {path: field["widget"] for path, field in form.items()}
    assert (widget["needed"]["unit"], widget["needed"]["low"], widget["needed"]["high"]) == ("m", 0, 9)
    assert widget["needed"]["is_open"] == [True, False]
    assert form["needed"]["is_required"]
    assert form["needed"]["help"] == "which must be given"
    assert widget["std"]["unit"] == "m"
    assert widget["count"]["is_whole"]
    assert widget["choice"]["choices"] == ["near", "far"]
    assert widget["sensor"]["choices"] == ["laser", "sonar"]
    assert widget["sensor"]["refers"] == "sensors"
    assert [path for path, one in widget.items() if one["is_optional"]] == ["optional"]
    assert (widget["pair"]["length"], widget["numbers"]["length"]) == (2, None)
    assert widget["whole"]["item"]["is_whole"]
    assert widget["words"]["item"]["kind"] == "text"
    assert (widget["place"]["frame"], widget["place"]["columns"]) == ("body", ["x", "y"])
    assert (widget["points"]["frame"], widget["points"]["columns"]) == ("world", ["x", "y"])
    assert widget["points"]["item"]["unit"] == "m"
    assert widget["table"]["columns"] == ["1", "2", "3"]
    assert [field["path"] for field in widget["mounts"]["fields"]] == ["x", "y", "heading"]
    assert [option["kind"] for option in widget["either"]["options"]] == ["choice", "list"]


def test_values_are_those_of_the_component_or_the_defaults() -> None:
    form = everything(Everything(needed=2.0, points=((3.0, 4.0),), mount=am.Mount(y=0.2)))
    assert (form["needed"]["value"], form["points"]["value"]) == (2.0, [[3.0, 4.0]])
    inner = {field["path"]: field["value"] for field in form["mount"]["widget"]["fields"]}
    assert inner == {"mount.x": 0.0, "mount.y": 0.2, "mount.heading": 0.0}
    blank = everything()
    assert blank["needed"]["value"] is None
    assert not blank["angle"]["is_given"]
    assert blank["angle"]["value"] == blank["angle"]["default"] == math.pi / 2
    assert blank["mounts"]["value"] == [{"x": 0.0, "y": 0.0, "heading": math.pi}]


def test_a_form_of_a_file_has_degrees_and_what_the_file_says_right_or_wrong() -> None:
    said = {"needed": "much", "angle_deg": 30.0, "optional": "none", "mounts": [{"heading_deg": 90.0}]}
    form = everything(said, spelling="file", path="robots.rover.sensors.laser.noise.0")
    at = {path.removeprefix("robots.rover.sensors.laser.noise.0."): field for path, field in form.items()}
    assert at["angle_deg"]["value"] == 30.0
    assert at["angle_deg"]["default"] == pytest.approx(90.0)
    assert at["angle_deg"]["widget"]["unit"] == "deg"
    assert at["angle_deg"]["widget"]["high"] == pytest.approx(180.0)
    assert at["needed"]["value"] == "much"
    assert at["optional"]["value"] is None
    assert (at["optional"]["is_given"], at["flag"]["is_given"]) == (True, False)
    assert [field["path"] for field in at["mounts"]["widget"]["fields"]] == ["x", "y", "heading_deg"]
    assert at["pair_deg"]["default"] == pytest.approx([math.degrees(1.0), math.degrees(2.0)])


def test_what_cannot_change_while_it_runs_says_why() -> None:
    form = everything(is_running=True)
    fixed = {path: field["fixed"] for path, field in form.items() if field["fixed"]}
    assert set(fixed) == {"count", "text", "fixed", "file", "sensor", "planner"}
    assert "file" in fixed["file"]
    assert "size" in fixed["count"]
    assert "name" in fixed["sensor"]
    assert not any(field["fixed"] for field in everything().values())


def test_an_error_is_a_form_of_fixed_or_drawn_numbers() -> None:
    drawn = am.Distribution(kind="normal", values=(1.0, 0.02))
    track = describe(am.drives.Differential)["track"]
    form = deviation_form(track, am.Deviation(scale=drawn, per="study"), path="errors.drive.track")
    at = {field["path"].rpartition(".")[2]: field for field in form}
    assert [at[name]["widget"]["kind"] for name in at] == ["distribution"] * 3 + ["choice"]
    assert at["scale"]["value"] == {"normal": [1.0, 0.02]}
    assert [at[name]["widget"].get("unit") for name in ("scale", "add", "value")] == ["×", "m", "m"]
    assert at["per"]["value"] == "study"
    assert [at[name]["is_given"] for name in at] == [True, False, False, True]
    assert json.dumps(form)


def test_things_of_a_scenario_have_forms_too() -> None:
    start = {field["path"]: field for field in form_of(RandomStart, spelling="file")}
    assert [option["kind"] for option in start["random"]["widget"]["options"]] == ["choice", "list"]
    assert start["per"]["widget"]["choices"] == ["replica", "study"]
    assert [field["widget"].get("frame") for field in form_of(Landmark)[1:3]] == ["world", "world"]
    assert form_of(MountedSensor)[2]["widget"]["unit"] == "Hz"


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("robot", "device", "scenario")])
@pytest.mark.parametrize("spelling", ["python", "file"])
def test_every_component_that_is_installed_has_a_form(kind: str, spelling: Any) -> None:
    found = choices_of(kind, default_registry(), spelling=spelling)
    assert json.dumps(found)
    assert [one["name"] for one in found] == list(default_registry().names(kind))
    assert all(one["help"] for one in found)
    for one in found:
        for field in one["fields"]:
            assert field["help"], (one["name"], field["path"])
            assert field["widget"]["kind"] in set(KIND.values()), (one["name"], field["path"])
