"""Forms of a robot's parameters that may change while it runs, made from its components' own fields."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from amorsim.core.parameters import Parameter, describe
from amorsim.scenario.paths import changed
from amorsim.scenario.spec import Deviation, Distribution, MountedSensor, NoiseElement, Robot
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.protocol import ParameterForm

__all__ = ["forms_of", "value_at"]

# How far a slider goes from 0, by unit, where the scenario's value does not ask for more.
_REACH = {"": 0.1, "m": 0.1, "rad": math.radians(10.0), "rad/s": math.radians(10.0), "count": 10.0, "s": 1.0}
_FACTOR = 0.1  # a slider of a factor goes so far to both sides of 1
_NOISE = 10.0  # a slider of a noise goes up to so many times the scenario's value
_DEVIATIONS = 3.0  # a slider of a value drawn from a normal distribution covers so many standard deviations
_CLEAR = 0.9  # of the way to a bound that is itself not allowed


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
            by_factor = nominal != 0.0 and parameter.unit != "rad"
            parts = ["scale"] if by_factor else ["add"]
            if by_factor and deviation.add != 0.0:
                parts.append("add")
            if not by_factor and deviation.scale != 1.0:
                parts.append("scale")
        for part in parts:
            form = self._form(f"errors.{target}.{part}", name, parameter, "systematic")
            if part == "scale":
                form |= {"unit": "×", "low": None, "high": None, "is_open": [True, True]}
            elif part == "add":  # "lag 0" would read as though there were none
                form["label"] += " error"
                form["low"] = None if form["low"] is None else form["low"] - nominal
                form["high"] = None if form["high"] is None else form["high"] - nominal
            form["nominal"] = nominal
            true = value_at(self._true, target)
            form["true"] = float(true)
            form["slider"] = _slider(form, self._origin(form["path"]))
            if part == "add":
                form |= {"low": None, "high": None, "is_open": [True, True]}
            yield form

    def _origin(self, path: str) -> Any:
        """What the scenario says at a path, or where it has no such place what there is."""
        try:
            return value_at(self._scenario, path)
        except LookupError:
            return value_at(self._nominal, path)

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
        form["slider"] = _slider(form, self._origin(path))
        return form


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def _drawn(value: Any) -> str:
    return str(value) if isinstance(value, Distribution) else ""


def _slider(form: ParameterForm, origin: Any) -> list[float]:
    """Ends of a slider: what is near the scenario's value `origin`, as far as it is allowed; always the present value.

    For what is drawn the middle is the middle of the distribution.
    """
    if isinstance(origin, Distribution):
        low, high = _about(form, origin)
    elif form["unit"] == "×":
        low, high = 1.0 - _FACTOR, 1.0 + _FACTOR
    else:
        low, high = _near(form, float(origin or 0.0))
    value = low if form["value"] is None else form["value"]
    return [min(low, value), max(high, value)]


def _about(form: ParameterForm, drawn: Distribution) -> tuple[float, float]:
    """Equally far to both sides of the middle of a distribution, within bounds."""
    first, second = drawn.values
    if drawn.kind == "uniform":
        middle, reach = (first + second) / 2.0, (second - first) / 2.0
    else:
        middle, reach = first, _DEVIATIONS * second
    if form["unit"] == "×":
        reach = min(max(reach, _FACTOR), _CLEAR * abs(middle)) or _FACTOR
    else:
        reach = max(reach, _REACH.get(form["unit"], 1.0))
        low, high = _bounds(form, middle)
        reach = min([reach, *(room for room in (middle - low, high - middle) if room > 0.0)])
    return middle - reach, middle + reach


def _near(form: ParameterForm, origin: float) -> tuple[float, float]:
    low, high = _bounds(form, origin)
    is_noise = form["kind"] == "noise"
    if math.isfinite(low) and math.isfinite(high) and form["unit"] == "":  # a share, a probability
        return low, high
    if form["low"] == 0.0 and form["is_open"][0] and origin > 0.0:  # what must not vanish is changed by a factor
        factor = _NOISE if is_noise else 2.0
        return max(low, origin / factor), min(high, factor * origin)
    reach = _REACH.get(form["unit"], 1.0)
    reach = _NOISE * abs(origin) if is_noise and origin else max(reach, 2.0 * abs(origin))
    return max(low, -reach), min(high, reach)


def _bounds(form: ParameterForm, inside: float) -> tuple[float, float]:
    """What is allowed; a bound that is itself left out is kept away from, as seen from a value inside."""
    low = -math.inf if form["low"] is None else form["low"]
    high = math.inf if form["high"] is None else form["high"]
    if form["is_open"][0] and math.isfinite(low):
        low = inside - _CLEAR * (inside - low)
    if form["is_open"][1] and math.isfinite(high):
        high = inside + _CLEAR * (high - inside)
    return low, high
