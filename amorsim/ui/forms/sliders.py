"""Sliders for numbers: their ends, chosen so that the present value is on them and none is refused."""

from __future__ import annotations

import math
from typing import Any

from amorsim.scenario.spec import Distribution
from amorsim.ui.simulator.frames.protocol import ParameterForm

__all__ = ["slider_of"]

# How far a slider goes from 0, by unit, where the scenario's value does not ask for more.
_REACH = {"": 0.1, "m": 0.1, "rad": math.radians(10.0), "rad/s": math.radians(10.0), "count": 10.0, "s": 1.0}
_FACTOR = 0.1  # a slider of a factor goes so far to both sides of 1
_NOISE = 10.0  # times the scenario's value: how far a slider of a noise goes
_DEVIATIONS = 3.0  # standard deviations that a slider of a normally drawn value covers
_CLEAR = 0.9  # of the way to a bound that is itself not allowed


def slider_of(form: ParameterForm, origin: Any) -> list[float]:
    """The ends of a slider: near the scenario's value `origin`, within the bounds, around the present value.

    For what is drawn the middle is the middle of the distribution; what was drawn is on it.
    """
    if isinstance(origin, Distribution):
        low, high = _about(form, origin)
    elif form["unit"] == "×":
        low, high = 1.0 - _FACTOR, 1.0 + _FACTOR
    else:
        low, high = _near(form, float(origin or 0.0))
    here = form["drawn_value"] if form["value"] is None else form["value"]
    value = low if here is None else here
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
    """The allowed range; a bound that is excluded is moved a little inwards."""
    low = -math.inf if form["low"] is None else form["low"]
    high = math.inf if form["high"] is None else form["high"]
    if form["is_open"][0] and math.isfinite(low):
        low = inside - _CLEAR * (inside - low)
    if form["is_open"][1] and math.isfinite(high):
        high = inside + _CLEAR * (high - inside)
    return low, high
