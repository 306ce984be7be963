"""Forms of a running robot: all parameters of its parts, which can change now, and where they come from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import attrs

from amorsim.core.parameters import Parameter, describe
from amorsim.scenario.parameter_paths import value_in
from amorsim.scenario.spec import Deviation, Distribution, MountedSensor, NoiseElement, Robot
from amorsim.simulation.simulation import Simulation
from amorsim.ui.forms.description import (
    FieldForm,
    Widget,
    deviation_form,
    form_of,
    number_widget,
    why_part_fixed,
)
from amorsim.ui.forms.json_values import field_plain
from amorsim.ui.forms.origins import Origins
from amorsim.ui.forms.sliders import slider_of
from amorsim.ui.simulator.frames.protocol import ParameterForm

__all__ = ["forms_of", "places_of", "value_at"]

_NUMBERS = ("scale", "add", "value")  # of a deviation
_AT_START = "It is used when an episode starts, and set when the simulation is made."


def forms_of(simulation: Simulation, name: str, origins: Origins | None = None) -> list[ParameterForm]:
    """All parameters of a robot's parts, by part; `origins` maps them to where the scenario's values come from."""
    handle = simulation.robot(name)
    specified = next(robot for robot in simulation.scenario.robots if robot.name == name)
    robots = _Robots(handle.nominal, handle.true, specified)
    made = [form for place in _all_places(handle.nominal) for form in _Forms(robots, place)]
    for form in made:
        if origins is not None:
            form["origin"], form["source"] = origins.of(specified, form["path"], form["scenario"])
    return made


def places_of(robot: Robot) -> list[tuple[str, Any]]:
    """The parts of a robot, each with its path in the robot; a sensor has that of its unit."""
    return [(place.path, place.thing) for place in _all_places(robot)]


def value_at(robot: Robot, path: str) -> Any:
    """A robot's value at a path of `Simulation.set`; a part of an error that is not named has its default."""
    parts = path.split(".")
    if parts[0] == "errors":
        if parts[-1] not in _NUMBERS:
            return robot.errors.get(".".join(parts[1:]))
        deviation = robot.errors.get(".".join(parts[1:-1]), Deviation())
        return getattr(deviation, parts[-1])
    return value_in(robot, parts)


@attrs.frozen
class _Robots:
    """A robot as its software has it now, its true self, and the scenario's version."""

    nominal: Robot
    true: Robot
    scenario: Robot


@attrs.frozen
class _Place:
    """A thing with parameters: its path in the robot, and the kind of its parameters.

    `label` is how forms call it, `unit` that of what it works on, `names` those of its fields that count. `group` is
    that of its fields, where its path does not show it; `fixed` the reason why none of them can change.
    """

    path: str
    thing: Any
    kinds: tuple[str, ...]
    unit: str = ""
    label: str = ""
    names: tuple[str, ...] | None = None
    group: str = ""
    fixed: str = ""


def _all_places(robot: Robot) -> Iterator[_Place]:
    """The places of a robot, each with the components that are fields of its thing."""
    for place in _places(robot):
        yield place
        yield from _components_in(place)


def _components_in(place: _Place) -> Iterator[_Place]:
    for name, parameter in describe(type(place.thing)).items():
        thing = getattr(place.thing, name)
        if parameter.component and thing is not None and (place.names is None or name in place.names):
            path = f"{place.path}.{name}"
            fixed = place.fixed or why_part_fixed(parameter)
            inner = _Place(path, thing, place.kinds, place.unit, place.label, group=path, fixed=fixed)
            yield inner
            yield from _components_in(inner)


def _places(robot: Robot) -> Iterator[_Place]:
    yield _Place("drive", robot.drive, ("systematic", "nominal"))
    for element in robot.ground:
        yield _Place(f"ground.{element.name}", element.noise, ("noise",), "m", element.name)
    for name, unit in robot.sensors.items():
        at = f"sensors.{name}"
        yield _Place(at, unit.sensor, ("systematic", "nominal"), unit.sensor.unit)
        yield _Place(f"{at}.mount", unit.mount, ("systematic",), label="mount")
        yield _Place(at, unit, ("nominal",), names=("rate", "latency"))
        yield from _noise(at, unit)
    for name, estimator in robot.estimators.items():
        yield _Place(f"estimators.{name}", estimator, ("estimator",))
    if robot.controller is not None:
        yield _Place("controller", robot.controller, ("controller",))
    if robot.estimators:
        yield _Place("initial_belief", robot.initial_belief, ("nominal",), fixed=_AT_START)


def _noise(at: str, unit: MountedSensor) -> Iterator[_Place]:
    columns = unit.sensor.columns()
    for element in unit.noise:
        assert isinstance(element, NoiseElement)
        its_unit = columns.get(element.column, unit.sensor.unit)
        yield _Place(f"{at}.noise.{element.name}", element.noise, ("noise",), its_unit, element.name)


def _names(robot: Robot) -> Mapping[str, Sequence[str]]:
    joints = [joint.name for joint in robot.drive.joints]
    return {"sensors": list(robot.sensors), "estimators": list(robot.estimators), "joints": joints}


class _Forms:
    """Makes the forms of one part."""

    def __init__(self, robots: _Robots, place: _Place) -> None:
        self._robots = robots
        self._place = place

    def __iter__(self) -> Iterator[ParameterForm]:
        place = self._place
        fields = form_of(
            type(place.thing),
            place.thing,
            sensor_unit=place.unit,
            names=_names(self._robots.nominal),
            path=place.path,
            is_running=True,
        )
        described = describe(type(place.thing))
        for field, (name, parameter) in zip(fields, described.items(), strict=True):
            if place.names is not None and name not in place.names:
                continue
            value = getattr(place.thing, name)
            field["fixed"] = place.fixed or field["fixed"]
            is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
            for kind in place.kinds:
                if kind != "systematic":
                    yield self._form(field, parameter, kind)
                elif place.fixed:
                    continue
                elif is_number and parameter.live:
                    yield from self._error(field, parameter, float(value))
                elif isinstance(value, tuple) and not parameter.static:
                    yield from self._errors_within(field, parameter, value)

    def _errors_within(self, field: FieldForm, parameter: Parameter, items: tuple[Any, ...]) -> Iterator[ParameterForm]:
        """The errors that there are of the numbers in a list: of elements, and of their mounts."""
        for path in self._robots.nominal.errors:
            if not path.startswith(f"{field['path']}."):
                continue
            number, _, name = path.removeprefix(f"{field['path']}.").partition(".")
            item = items[int(number)]
            inner = describe(type(item))[name] if name and attrs.has(type(item)) else parameter
            nominal = value_at(self._robots.nominal, path)
            label = f"{field['label']} {number} {name.replace('_', ' ')}".strip()
            yield from self._error({**field, "path": path, "label": label, "help": inner.help}, inner, float(nominal))

    def _error(self, field: FieldForm, parameter: Parameter, nominal: float) -> Iterator[ParameterForm]:
        target = field["path"]
        deviation = self._robots.nominal.errors.get(target, Deviation())
        if deviation.value is not None:
            parts = ["value"]
        else:
            # A factor has no effect on what is nominally 0, nor a meaning for an angle.
            by_factor = nominal != 0.0 and parameter.unit != "rad"
            parts = ["scale"] if by_factor else ["add"]
            if by_factor and deviation.add != 0.0:
                parts.append("add")
            if not by_factor and deviation.scale != 1.0:
                parts.append("scale")
        for part in parts:
            path = f"errors.{target}.{part}"
            form = self._form({**field, "path": path, "fixed": ""}, parameter, "systematic")
            true = float(value_at(self._robots.true, target))
            form["true"], form["drawn_value"] = true, _drawn_value(deviation, part, nominal, true)
            if part == "scale":
                form |= {"unit": "×", "low": None, "high": None, "is_open": [True, True]}
            elif part == "add":  # "lag 0" would read as though there were none
                form["label"] += " error"
                form["low"] = None if form["low"] is None else form["low"] - nominal
                form["high"] = None if form["high"] is None else form["high"] - nominal
            form["nominal"] = nominal
            form["deviation"] = deviation_form(
                parameter,
                self._robots.nominal.errors.get(target),
                path=f"errors.{target}",
                sensor_unit=self._place.unit,
            )
            form["slider"] = slider_of(form, self._origin(path))
            if part == "add":
                form |= {"low": None, "high": None, "is_open": [True, True]}
            yield form

    def _origin(self, path: str) -> Any:
        """The scenario's value at a path, or the present one where it has no such place."""
        try:
            return value_at(self._robots.scenario, path)
        except LookupError:
            return value_at(self._robots.nominal, path)

    def _form(self, field: FieldForm, parameter: Parameter, kind: str) -> ParameterForm:
        place, path = self._place, field["path"]
        is_error = path.startswith("errors.")
        nominal, scenario = (_found(robot, path) for robot in (self._robots.nominal, self._robots.scenario))
        parts = place.path.split(".")
        widget = number_widget(parameter) if is_error else _fitting(field["widget"], nominal)
        if widget["kind"] == "component":  # whose fields are a group of their own
            widget["fields"] = []
        is_number = widget["kind"] == "number"
        form: ParameterForm = {
            "path": path,
            "group": place.group or ".".join(parts[: 2 if parts[0] in ("sensors", "estimators") else 1]),
            "part": place.path,
            "label": " ".join(word for word in (place.label, field["label"]) if word),
            "unit": place.unit if parameter.unit == "sensor" else parameter.unit,
            "help": field["help"],
            "type": "int" if parameter.type is int else "float",
            "widget": widget,
            "low": parameter.gt if parameter.ge is None else parameter.ge,
            "high": parameter.lt if parameter.le is None else parameter.le,
            "is_open": [parameter.ge is None, parameter.le is None],
            "slider": [],
            "value": _number(nominal) if is_number else field_plain(parameter, nominal),
            "scenario": _number(scenario) if is_number else field_plain(parameter, scenario),
            "is_changed": scenario != nominal,
            "is_added": kind == "noise" and _found(self._robots.scenario, place.path) is None,
            "fixed": field["fixed"] or _fixed_by_value(nominal),
            "drawn": str(nominal) if isinstance(nominal, Distribution) else "",
            "drawn_value": None,
            "nominal": None,
            "true": None,
            "deviation": [],
            "kind": kind,
            "origin": "",
            "source": "",
        }
        if is_number and not form["fixed"] and nominal is not None and not is_error:
            form["slider"] = slider_of(form, nominal if scenario is None else scenario)
        return form


def _fitting(widget: Widget, value: Any) -> Widget:
    """For a widget for several kinds of value: the widget of the kind that the value has."""
    if widget["kind"] != "either":
        return widget
    wanted = {"list", "table", "forms"} if isinstance(value, tuple) else {"choice", "text"}
    wanted = {"number"} if isinstance(value, (int, float)) else wanted
    return next((option for option in widget["options"] if option["kind"] in wanted), widget["options"][0])


def _fixed_by_value(value: Any) -> str:
    is_form = isinstance(value, (bool, str)) or value is None
    return "It fixes the form of what is simulated, and is set when the simulation is made." if is_form else ""


def _found(robot: Robot, path: str) -> Any:
    """A robot's value at a path, of any type; None if it has no such part."""
    if path.startswith("errors."):
        return value_at(robot, path)
    thing: Any = robot
    for part in path.split("."):
        if isinstance(thing, tuple):
            thing = next((one for one in thing if getattr(one, "name", "") == part), None)
            thing = thing.noise if isinstance(thing, NoiseElement) else thing
        elif isinstance(thing, Mapping):
            thing = thing.get(part)
        elif isinstance(thing, MountedSensor) and part not in attrs.fields_dict(MountedSensor):
            thing = getattr(thing.sensor, part, None)
        else:
            thing = getattr(thing, part, None)
    return thing


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def _drawn_value(deviation: Deviation, part: str, nominal: float, true: float) -> float | None:
    """The number that was drawn for a part of an error; None if it is not drawn, or other parts are drawn as well."""
    if not isinstance(getattr(deviation, part), Distribution):
        return None
    if part == "value":
        return true
    if part == "scale":
        return None if isinstance(deviation.add, Distribution) else (true - deviation.add) / nominal
    return None if isinstance(deviation.scale, Distribution) else true - nominal * deviation.scale
