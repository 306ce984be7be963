"""Groups of robots: which robots share a group, and the model that the software of a whole group holds."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import RobotModel, SensorModel
from amorsim.core.arguments import whole
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import ComponentError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.rows import signature, stack
from amorsim.scenario.reading.columns import columns_problem
from amorsim.scenario.spec import MountedSensor, Robot
from amorsim.worlds.drawn import origin_of

__all__ = ["channels_of", "group_key", "poses_of", "reading_size", "robot_model"]


def group_key(robot: Robot) -> Hashable:
    """The properties that robots of one group share."""
    return (
        signature(robot.drive),
        robot.shape,
        tuple(
            (name, signature(unit.sensor), tuple((e.name, e.column, signature(e.noise)) for e in unit.noise))
            for name, unit in robot.sensors.items()
        ),
        tuple((element.name, signature(element.noise)) for element in robot.ground),
        tuple((name, signature(estimator)) for name, estimator in robot.estimators.items()),
        None if robot.controller is None else signature(robot.controller),
        robot.on_collision,
        robot.initial_belief,
        _key_of(robot.knowledge.map),
        robot.knowledge.landmarks,
        robot.knowledge.landmark_ids,
    )


def _key_of(known: Map | None) -> Hashable:
    """A key of the maps that groups know: their content, or the one origin of maps that replicas draw."""
    origin = None if known is None else origin_of(known)
    return known if origin is None else origin


def robot_model(robots: Sequence[Robot], sizes: Mapping[str, int], channels: tuple[str, ...], dt: float) -> RobotModel:
    """The model of the robots of one group, a row each, with nominal parameters.

    Parameters
    ----------
    sizes
        The number of values in a reading of each sensor.
    channels
        The columns of a command.
    """
    first = robots[0]
    knowledge = first.knowledge
    count = len(knowledge.landmarks)
    maps = tuple(robot.knowledge.map for robot in robots)
    is_one = all(known == maps[0] for known in maps)
    return RobotModel(
        rows=len(robots),
        dt=dt,
        names=tuple(robot.name for robot in robots),
        drive=stack([robot.drive for robot in robots]),
        shape=first.shape,
        sensors={
            name: _sensor_model([robot.sensors[name] for robot in robots], name, size) for name, size in sizes.items()
        },
        channels=channels,
        map=maps[0] if is_one else None,
        maps=() if is_one else maps,
        landmarks=np.array(knowledge.landmarks, dtype=float) if count else None,
        landmark_ids=np.array(knowledge.landmark_ids or (0,) * count, dtype=np.int64) if count else None,
    )


def _sensor_model(units: Sequence[MountedSensor], name: str, size: int) -> SensorModel:
    rates = tuple(unit.rate for unit in units)
    return SensorModel(
        name=name,
        sensor=stack([unit.sensor for unit in units]),
        mount=stack([unit.mount for unit in units]),
        size=size,
        rate=min((rate for rate in rates if rate is not None), default=None),
        rates=rates if len(set(rates)) > 1 else (),
    )


def channels_of(robot: Robot) -> tuple[str, ...]:
    """The columns of a robot's command: its drive's channels, then ``<sensor>.<channel>`` of each commanded device."""
    devices = (f"{name}.{channel}" for name, unit in robot.sensors.items() for channel in unit.sensor.channels)
    return (*robot.drive.channels, *devices)


def poses_of(robots: Sequence[Robot]) -> Array:
    """Start poses of robots `(N, 3)`."""
    found = []
    for robot in robots:
        assert robot.pose is not None
        found.append([robot.pose.x, robot.pose.y, robot.pose.heading])
    return np.array(found, dtype=np.float64)


def reading_size(robot: Robot, name: str) -> int:
    """The number of values in a reading of a robot's sensor, with which its columns must agree."""
    sensor = robot.sensors[name].sensor
    what = f"sensor {name!r} ({type(sensor).__name__}) of robot {robot.name!r}"
    try:
        size: object = sensor.size(robot.drive)
    except ParameterError as error:
        raise ComponentError(f"robot {robot.name!r}: sensors.{name}.{error}") from None
    except RAISED as error:
        raise ComponentError(f"{what}: size() raised {error_in_words(error)}") from error
    try:
        number = whole(size, f"{what}: size()", "a whole number >= 1", least=1)
    except ParameterError as error:
        raise ComponentError(str(error)) from None
    if problem := columns_problem(sensor, number):
        raise ComponentError(f"{what}: {problem}")
    return number
