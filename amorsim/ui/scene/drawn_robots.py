"""Robots as they are drawn: each one's own properties, and those shared by robots of one kind."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from amorsim.contracts import Drive
from amorsim.controllers.user import UserController
from amorsim.core.poses import Mount, compose
from amorsim.core.rows import stack
from amorsim.plugins.manager import default_registry
from amorsim.scenario.colours import robot_colours
from amorsim.scenario.spec import MountedSensor, Robot
from amorsim.ui.scene.bodies import body_of, outline_of, rgb
from amorsim.ui.scene.maps import MapShapes
from amorsim.ui.scene.readings import drawing_of
from amorsim.ui.scene.wire import Channel, Kind, Knowledge, ObstacleShape, RobotEntry, SensorShape

__all__ = ["RobotShapes", "sensor_shapes"]

FASTEST = (1.0, 0.0, 1.0)  # m/s, m/s, rad/s, where nothing is known of a drive's limits


class RobotShapes:
    """The entries of robots in a scene, and their kinds; the maps that they know are added to `maps`."""

    def __init__(self, robots: Sequence[Robot], maps: MapShapes) -> None:
        self.kinds: list[Kind] = []
        self._maps = maps
        self._known: dict[Any, int] = {}
        self._colours = robot_colours(robots)

    def entry(self, robot: Robot) -> RobotEntry:
        """A robot, by its nominal parameters."""
        knowledge: Knowledge = {
            "map": None if robot.knowledge.map is None else self._maps.add(robot.knowledge.map),
            "landmarks": [list(point) for point in robot.knowledge.landmarks],
        }
        entry: RobotEntry = {
            "name": robot.name,
            "kind": self._kind(robot),
            "controller": _controller(robot.controller),
            "knowledge": knowledge,
        }
        colour = self._colours[robot.name]
        if colour is not None:
            entry["colour"] = rgb(colour)
        return entry

    def parts(self, robot: Robot) -> list[ObstacleShape]:
        """The parts of a robot's drive, such as trailers, drawn as obstacles are."""
        return [
            {**body_of(f"{robot.name}.{part.name}", part.shape, self._colours[robot.name]), "part_of": robot.name}
            for part in robot.drive.parts
        ]

    def _kind(self, robot: Robot) -> int:
        # Robots that were made from one another share what they have in common.
        key = (
            robot.model,
            id(robot.drive),
            robot.shape,
            tuple((n, id(u)) for n, u in robot.sensors.items()),
        )
        if key in self._known:
            return self._known[key]
        drive = stack([robot.drive])
        kind: Kind = {
            "model": robot.model,
            "drive": _registered("drive", robot.drive),
            "footprint": outline_of(robot.shape),
            "wheels": _wheels(robot.drive, drive),
            "channels": [*_drive_channels(robot.drive), *_device_channels(robot.sensors)],
            "joints": [joint.name for joint in robot.drive.joints],
            "twist": _fastest(drive, robot.drive),
            "sensors": sensor_shapes(robot),
            "estimators": list(robot.estimators),
        }
        # Equal in all that is drawn is as good as the same.
        place = self.kinds.index(kind) if kind in self.kinds else len(self.kinds)
        if place == len(self.kinds):
            self.kinds.append(kind)
        self._known[key] = place
        return place


def _registered(kind: str, component: Any) -> str:
    return default_registry().name_of(kind, type(component)) or type(component).__name__


def _controller(controller: Any) -> str:
    if controller is None:
        return ""
    if isinstance(controller, UserController):
        file, _, name = controller.source.rpartition(":")
        name = name or getattr(controller.function, "__qualname__", "a function")
        return f"{file.replace(chr(92), '/').rpartition('/')[2]}:{name}" if file else name
    return _registered("controller", controller)


def _wheels(drive: Drive, stacked: Drive) -> list[list[float]]:
    """The wheels that roll, where they touch the ground, and those of a car that steer."""
    places = stacked.contacts(np.zeros((1, len(drive.joints))))[0]
    if not places.any():  # a drive that does not define them
        return []
    radii = np.broadcast_to(stacked.rolling_radius(), (1, len(places)))[0]
    wheels = [[x, y, 0.0, radius] for (x, y), radius in zip(places.tolist(), radii.tolist(), strict=True)]
    wheelbase, track = _number(drive, "wheelbase"), _number(drive, "track")
    if "steering" in drive.channels and wheelbase and track:
        steered = [[wheelbase, side * track / 2.0, 0.0, wheels[0][3]] for side in (1.0, -1.0)]
        wheels += [wheel for wheel in steered if wheel not in wheels]
    return wheels


def _drive_channels(drive: Drive) -> list[Channel]:
    """The drive's channels with their limits, as far as the names of its fields show them."""
    fixed = [joint.name for joint in drive.joints if not joint.rolls]
    channels: list[Channel] = []
    for name in drive.channels:
        position = _number(drive, f"{name}_max") if name in fixed else None
        limit = position or _number(drive, f"{name}_rate_max") or _number(drive, "rate_max")
        if limit is not None and not math.isfinite(limit):
            limit = None
        channels.append(
            {
                "name": name,
                "unit": "rad" if position else "rad/s",
                "low": None if limit is None else -limit,
                "high": limit,
            }
        )
    return channels


def _device_channels(sensors: Mapping[str, MountedSensor]) -> list[Channel]:
    return [
        {"name": f"{name}.{channel}", "unit": "", "low": None, "high": None}
        for name, unit in sensors.items()
        for channel in unit.sensor.channels
    ]


def _fastest(drive: Drive, nominal: Drive) -> list[float]:
    """The top speed of each part of a velocity by itself: the drive's own, or where a joint reaches its limit."""
    limit = _number(nominal, "rate_max")
    found = list(FASTEST)
    if limit is not None and math.isfinite(limit):
        joints = np.zeros((1, len(nominal.joints)))
        for part, wanted in enumerate(np.eye(3)):
            command = np.asarray(drive.command_for(wanted[None, :].copy(), joints), dtype=float)
            largest = float(np.abs(command).max(initial=0.0))
            found[part] = limit / largest if largest > 1e-9 else 0.0
    speeds = drive.top_speeds()
    if speeds is not None:
        top = speeds[0].tolist()
        found = [
            top[0],
            found[1] if drive.heading_offset(np.zeros((1, len(nominal.joints)))) is None else 0.0,
            top[1],
        ]
        if drive.curvature_max() is not None:  # what rolls along a curve does not go aside
            found[1] = 0.0
    return [speed if math.isfinite(speed) else default for speed, default in zip(found, (1.0, 1.0, 1.0), strict=True)]


def sensor_shapes(robot: Robot) -> list[SensorShape]:
    """A robot's sensors as they are drawn, by the parameters that it has."""
    return [_sensor(name, unit, robot) for name, unit in robot.sensors.items()]


def _sensor(name: str, unit: MountedSensor, robot: Robot) -> SensorShape:
    sensor: Any = unit.sensor
    size = sensor.size(robot.drive)
    bearings = stack([sensor]).bearings()
    elements: Sequence[Any] = getattr(sensor, "elements", ())
    if size == len(elements) and all(isinstance(element, Mount) for element in elements):
        mounts = compose(np.repeat([_pose(unit.mount)], size, axis=0), np.array([_pose(e) for e in elements]))
        looks = None if bearings is None else [0.0] * size
    else:
        mounts = np.array([_pose(unit.mount)])
        looks = None if bearings is None else np.broadcast_to(bearings, (1, size))[0].tolist()
    return {
        "name": name,
        "kind": _registered("sensor", sensor),
        "unit": sensor.unit,
        "columns": [[column, unit_] for column, unit_ in sensor.columns().items()],
        "size": size,
        "mounts": mounts.tolist(),
        "bearings": looks,
        "range_max": _number(sensor, "range_max"),
        "half_angle": _number(sensor, "half_angle"),
        "drawing": drawing_of(sensor, unit.mount, robot.shape, has_bearings=bearings is not None),
    }


def _pose(mount: Mount) -> list[float]:
    return [mount.x, mount.y, mount.heading]


def _number(thing: Any, name: str) -> float | None:
    value = getattr(thing, name, None)
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None
