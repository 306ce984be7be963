"""The sensors that correct a Kalman filter: what each must measure, and the variances that must be given for it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from amorsim.contracts import RobotModel, SensorModel
from amorsim.core.errors import ComponentError
from amorsim.estimators.wheels import sensor_of

__all__ = ["SOURCES", "Source", "check_sources", "noise_in_words"]


class Source(NamedTuple):
    """A kind of sensor that corrects."""

    field: str  # the estimator's field that names the sensor
    corrects: str
    noise: tuple[tuple[str, str, str], ...]  # the fields that must be stated with it, their words and units
    numbers: int  # in an update
    wanted: str  # what the sensor must be, in words
    fits: Callable[[SensorModel], bool]


def _has_columns(*names: str) -> Callable[[SensorModel], bool]:
    return lambda model: tuple(model.sensor.columns())[: len(names)] == names


SOURCES = (
    Source(
        "gyro",
        "heading, bias",
        (("gyro_std", "rate", "rad/s"), ("gyro_bias_std", "bias at first", "rad/s")),
        1,
        "one rate of turn [rad/s], as a gyro does",
        lambda model: model.size == 1 and model.sensor.unit == "rad/s",
    ),
    Source(
        "compass",
        "heading",
        (("compass_std", "heading", "rad"),),
        1,
        "one heading [rad], as a compass does",
        lambda model: model.size == 1 and model.sensor.unit == "rad",
    ),
    Source("gps", "x, y", (("gps_std", "x and y", "m"),), 2, "x and y [m], as a gps does", _has_columns("x", "y")),
    Source(
        "landmarks",
        "x, y, heading",
        (("range_std", "range", "m"), ("bearing_std", "bearing", "rad")),
        2,
        "range, bearing and id, as a fiducial does",
        _has_columns("range", "bearing", "id"),
    ),
)


def noise_in_words(estimator: Any, source: Source) -> str:
    """The standard deviations that an estimator assumes of a source."""
    found = []
    for field, words, unit in source.noise:
        std = getattr(estimator, field)
        found.append(f"{words} {'not stated' if std is None else _in_words(std, unit)}")
    return ", ".join(found)


def _in_words(std: float, unit: str) -> str:
    if unit.startswith("rad"):
        return f"{math.degrees(std):g}°{unit.removeprefix('rad')}"
    return f"{std:g} {unit}"


def check_sources(estimator: Any, robot: RobotModel) -> dict[str, int]:
    """How many updates a reading of each sensor that is named brings at most, by the estimator's field.

    Raises
    ------
    ComponentError
        If the robot has no such sensor, or one of another kind; if its noise is not stated; if landmarks are to be
        seen and the robot knows none, or none with an identity, or two that cannot be distinguished.
    """
    who, found = estimator.who, {}
    for source in SOURCES:
        name = getattr(estimator, source.field)
        if not name:
            continue
        sensor = sensor_of(who, robot, name, source.field, source.field)
        model = robot.sensors[name]
        if not source.fits(model):
            raise ComponentError(
                f"{who} corrects by the sensor {name!r} ({source.field}), but a {type(sensor).__name__} does not "
                f"measure {source.wanted}"
            )
        for field, words, unit in source.noise:
            if getattr(estimator, field) is None:
                raise ComponentError(
                    f"{who} corrects by the sensor {name!r} ({source.field}), but does not know its noise; state the "
                    f"standard deviation of the {words} [{unit}] in the field {field!r}"
                )
        found[source.field] = model.size // 3 if source.field == "landmarks" else 1
    if estimator.landmarks:
        _check_landmarks(estimator, robot)
    return found


def _check_landmarks(estimator: Any, robot: RobotModel) -> None:
    """Raise unless the robot knows landmarks that can be distinguished."""
    who, places, ids = estimator.who, robot.landmarks, robot.landmark_ids
    if places is None or ids is None or not len(places):
        raise ComponentError(
            f"{who} corrects by landmarks ({estimator.landmarks!r}), but the robot knows none; list them in "
            "knowledge.landmarks, or write landmarks = 'world' there"
        )
    if estimator.association == "identity":
        numbers, counts = np.unique(ids[ids > 0], return_counts=True)
        if not len(numbers):
            raise ComponentError(
                f"{who} tells landmarks apart by their identity, but none that the robot knows has an id; write them "
                "as { id, x, y }, or set association = 'nearest' or 'joint'"
            )
        if counts.max() > 1:
            raise ComponentError(
                f"{who} tells landmarks apart by their identity, but {counts.max()} that the robot knows have the id "
                f"{numbers[np.argmax(counts)]}; list each once"
            )
        return
    rows, counts = np.unique(places, axis=0, return_counts=True)
    if counts.max() > 1:
        x, y = rows[np.argmax(counts)].tolist()
        raise ComponentError(f"{who}: the robot knows {counts.max()} landmarks at ({x:g}, {y:g}) m; list each once")
