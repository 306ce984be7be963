"""Which noise can stand in a sensor's chain, and for which of the sensor's columns."""

from __future__ import annotations

from amorsim.contracts import Noise, Sensor
from amorsim.core.errors import did_you_mean
from amorsim.core.parameters import describe

__all__ = ["column_problem", "not_for_sensors"]


def not_for_sensors(noise: type[Noise]) -> str:
    """Why a noise that is `for_ground` is refused in a sensor's chain."""
    return (
        f"{noise.__name__} acts between wheels and ground, on travels [m]; expected it in the robot's `ground` or in a "
        "zone's, got it in a sensor's noise"
    )


def column_problem(sensor: Sensor, noise: type[Noise], column: str) -> str:
    """What is wrong with a noise element of this class being for this column of a sensor, or nothing."""
    columns = sensor.columns()
    if column in columns:
        return ""
    known = ", ".join(repr(name) for name in columns)
    if column:
        what = f"one of {known}" if columns else "none, for all its values are of one quantity"
        return f"expected {what}, got {column!r}.{did_you_mean(column, columns)}"
    if len(set(columns.values())) > 1 and any(parameter.unit == "sensor" for parameter in describe(noise).values()):
        return f"missing; the values are of several quantities, so say which: {known}"
    return ""
