"""Forms of a robot's parameters that may change while it runs, made from its components' own fields."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from amorsim.core.parameters import Parameter, describe
from amorsim.scenario.paths import changed
from amorsim.scenario.spec import Deviation, Distribution, MountedSensor, NoiseElement, Robot
from amorsim.simulation.simulation import Simulation
from amorsim.ui.protocol import ParameterForm

__all__ = ["forms_of", "value_at"]

# How far a slider goes from 0, by unit, where neither bounds nor the present value ask for more.
_REACH = {"m": 0.1, "rad": math.radians(10.0), "rad/s": math.radians(10.0), "count": 10.0, "s": 1.0}
_FACTOR = 0.1  # a slider of a factor goes so far to both sides of 1


def forms_of(simulation: Simulation, name: str) -> list[ParameterForm]:
    """All parameters of a robot that `Simulation.set` changes, by part of the robot."""
    handle = simulation.robot(name)
    specified = next(robot for robot in simulation.scenario.robots if robot.name == name)
    return [form for place in _places(handle.nominal) for form in _Forms(handle.nominal, handle.true, specified, place)]


def value_at(robot: Robot, path: str) -> Any:
    """What a robot has at a path of `Simulation.set`; a part of an error that is not named has its default."""
    parts = path.split(".")
    if parts[0] == "errors":
        deviation = robot.errors.get(".".join(parts[1:-1]), Deviation())
        return getattr(deviation, parts[-1])
    found: list[Any] = []

    def keep(value: Any) -> Any:
        found.append(value)
        return value

    changed(robot, parts, keep)
    return found[0]


class _Place:
    """A thing with parameters: its path in the robot, how forms call it, and of which kind its parameters are."""

    def __init__(self, path: str, thing: Any, kinds: tuple[str, ...], unit: str = "", label: str = "") -> None:
        self.path = path
        self.thing = thing
        self.kinds = kinds
        self.unit = unit  # of what the thing works on
        self.label = label


def _places(robot: Robot) -> Iterator[_Place]:
    yield _Place("drive", robot.drive, ("systematic", "nominal"))
    for element in robot.ground:
        yield _Place(f"ground.{element.name}", element.noise, ("noise",), "m", element.name)
    for name, unit in robot.sensors.items():
        at = f"sensors.{name}"
        yield _Place(at, unit.sensor, ("systematic", "nominal"), unit.sensor.unit)
        yield _Place(f"{at}.mount", unit.mount, ("systematic",), label="mount")
        yield from _noise(at, unit)
    for name, estimator in robot.estimators.items():
        yield _Place(f"estimators.{name}", estimator, ("estimator",))
    if robot.controller is not None:
        yield _Place("controller", robot.controller, ("controller",))


def _noise(at: str, unit: MountedSensor) -> Iterator[_Place]:
    for element in unit.noise:
        assert isinstance(element, NoiseElement)
        yield _Place(f"{at}.noise.{element.name}", element.noise, ("noise",), unit.sensor.unit, element.name)


class _Forms:
    """The forms of one place."""

    def __init__(self, nominal: Robot, true: Robot, scenario: Robot, place: _Place) -> None:
        self._nominal = nominal
        self._true = true
        self._scenario = scenario
        self._place = place

    def __iter__(self) -> Iterator[ParameterForm]:
        place = self._place
        for name, parameter in describe(type(place.thing)).items():
            value = getattr(place.thing, name)
            if not parameter.live or isinstance(value, bool) or not isinstance(value, (int, float)):
                continue
            for kind in place.kinds:
                path = f"{place.path}.{name}"
                if kind == "systematic":
                    yield from self._error(path, name, parameter, float(value))
                else:
                    yield self._form(path, name, parameter, kind)

    def _error(self, target: str, name: str, parameter: Parameter, nominal: float) -> Iterator[ParameterForm]:
        deviation = self._nominal.errors.get(target, Deviation())
        if deviation.value is not None:
            parts = ["value"]
        else:
            # A factor says nothing of what is nominally 0, nor of an angle.
            by_factor = nominal != 0.0 and not parameter.is_angle
            parts = ["scale"] if by_factor else ["add"]
            if by_factor and deviation.add != 0.0:
                parts.append("add")
            if not by_factor and deviation.scale != 1.0:
                parts.append("scale")
        for part in parts:
            form = self._form(f"errors.{target}.{part}", name, parameter, "systematic")
            if part == "scale":
                form |= {"unit": "×", "low": None, "high": None, "is_open": [True, True]}
            elif part == "add":
                form |= {"low": None, "high": None, "is_open": [True, True]}
            form["nominal"] = nominal
            true = value_at(self._true, target)
            form["true"] = float(true)
            form["slider"] = _slider(form)
            yield form

    def _form(self, path: str, name: str, parameter: Parameter, kind: str) -> ParameterForm:
        place = self._place
        value = value_at(self._nominal, path)
        parts = place.path.split(".")
        try:
            scenario = value_at(self._scenario, path)
        except LookupError:
            scenario = None
        form: ParameterForm = {
            "path": path,
            "group": ".".join(parts[:2]) if parts[0] in ("sensors", "estimators") else parts[0],
            "label": " ".join(word for word in (place.label, name.replace("_", " ")) if word),
            "unit": place.unit if parameter.unit == "sensor" else parameter.unit,
            "help": parameter.help,
            "type": "int" if parameter.type is int else "float",
            "low": parameter.gt if parameter.ge is None else parameter.ge,
            "high": parameter.lt if parameter.le is None else parameter.le,
            "is_open": [parameter.ge is None, parameter.le is None],
            "slider": [],
            "value": _number(value),
            "scenario": _number(scenario),
            "drawn": _drawn(value),
            "nominal": None,
            "true": None,
            "kind": kind,
        }
        form["slider"] = _slider(form)
        return form


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def _drawn(value: Any) -> str:
    return f"{value.kind} {value.values[0]:g}, {value.values[1]:g}" if isinstance(value, Distribution) else ""


def _slider(form: ParameterForm) -> list[float]:
    """Ends that hold what is allowed where that is bounded, else what is near; always the value."""
    value = form["value"] if form["value"] is not None else 0.0
    if form["unit"] == "×":
        low, high = 1.0 - _FACTOR, 1.0 + _FACTOR
    else:
        reach = max(_REACH.get(form["unit"], 1.0), 2.0 * abs(form["scenario"] or 0.0))
        low = -reach if form["low"] is None else max(form["low"], -reach)
        high = reach if form["high"] is None else min(form["high"], reach)
    return [min(low, value), max(high, value)]
