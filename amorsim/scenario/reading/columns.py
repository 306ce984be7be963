"""The columns of a sensor: which noise can be in its chain, and for which of them."""

from __future__ import annotations

from collections.abc import Mapping

from amorsim.contracts import Noise, Sensor
from amorsim.core.error_text import RAISED, error_in_words, in_words
from amorsim.core.errors import did_you_mean
from amorsim.core.parameters import describe

__all__ = ["column_problem", "columns_problem", "not_for_sensors"]


def not_for_sensors(noise: type[Noise]) -> str:
    """Why a noise that is `for_ground` is refused in a sensor's chain."""
    return (
        f"{noise.__name__} acts between wheels and ground, on travels [m]; expected it in the robot's `ground` or in a "
        "zone's, got it in a sensor's noise"
    )


def columns_problem(sensor: Sensor, size: int | None = None) -> str:
    """The fault of a sensor's `columns`, for a reading of `size` values if that is known; empty if there is none."""
    try:
        columns: object = sensor.columns()
        items = list(columns.items()) if isinstance(columns, Mapping) else None
    except RAISED as error:
        return f"columns() raised {error_in_words(error)}"
    if items is None:
        return f"columns(): expected a dict of names and units, as in {{'range': 'm'}}, got {in_words(columns)}"
    for name, unit in items:
        # Names stand in the header lines of tables and next to curves.
        if not _is_word(name) or not name:
            return f"columns(): expected names in one line, without commas, got {in_words(name)}"
        if not _is_word(unit):
            return f"columns(): expected the unit of {name!r} in one line, without commas, got {in_words(unit)}"
    if items and size is not None and size % len(items):
        names = f"{len(items)}: {', '.join(repr(name) for name, _ in items)}"
        return f"columns(): expected columns whose number divides the {size} values of a reading, got {names}"
    return ""


def _is_word(text: object) -> bool:
    return isinstance(text, str) and text.isprintable() and "," not in text and text == text.strip()


def column_problem(sensor: Sensor, noise: type[Noise], column: str) -> str:
    """The fault of a noise element of this class for this column of a sensor; empty if there is none."""
    if columns_problem(sensor):  # reported for the sensor itself, where its name is known
        return ""
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
