"""Scenes: what of a simulation stays as it is while it runs, as a window draws it."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image as Pictures
from PIL import ImageColor

from amorsim.contracts import Drive
from amorsim.controllers.user import UserController
from amorsim.core.map import Map
from amorsim.core.poses import Mount, compose
from amorsim.core.rows import stack
from amorsim.core.shapes import Shape
from amorsim.plugins.manager import default_registry
from amorsim.runs.session import run_name
from amorsim.scenario.colours import robot_colours
from amorsim.scenario.spec import MountedSensor, Robot
from amorsim.simulation.simulation import Simulation
from amorsim.ui.drawings import drawing_of
from amorsim.ui.protocol import (
    Channel,
    Kind,
    Knowledge,
    MapShape,
    ObstacleShape,
    Outline,
    RobotEntry,
    Scene,
    SensorShape,
)

__all__ = ["SceneBuilder", "sensor_shapes"]

Array = npt.NDArray[np.float64]

MOST_SEGMENTS = 20_000  # beyond, a picture is drawn faster than lines
MOST_PIXELS = 4_000_000
FASTEST = (1.0, 0.0, 1.0)  # m/s, m/s, rad/s, where nothing is known of a drive's limits


class SceneBuilder:
    """The scene of a simulation, and the pictures of maps that it names."""

    def __init__(self, simulation: Simulation, version: int = 1) -> None:
        self._maps: list[Map] = []
        self._shapes: list[MapShape] = []
        self._kinds: list[Kind] = []
        self._known: dict[Any, int] = {}
        scenario = simulation.scenario
        self._colours = robot_colours(scenario.robots)
        self.scene: Scene = {
            "version": version,
            "scenario": run_name(scenario),
            "dt": simulation.dt,
            "duration": scenario.duration,
            "seed": simulation.seed,
            "map": self._map(scenario.map),
            "robots": [self._robot(simulation.robot(name).nominal) for name in simulation.names],
            "maps": self._shapes,
            "kinds": self._kinds,
            "obstacles": [
                _body(obstacle.name, obstacle.shape, obstacle.colour, moves=obstacle.motion is not None)
                for obstacle in sorted(scenario.obstacles, key=lambda obstacle: obstacle.name)
            ]
            + [
                {**_body(f"{robot.name}.{part.name}", part.shape, self._colours[robot.name]), "part_of": robot.name}
                for robot in (simulation.robot(name).true for name in simulation.names)
                for part in robot.drive.parts
            ],
            "floor": {
                "landmarks": [[mark.x, mark.y, mark.radius] for mark in scenario.landmarks],
                "lights": [[light.x, light.y] for light in scenario.lights],
                "zones": [zone.outline.tolist() for zone in scenario.zones],
                "patches": [
                    {"points": patch.points.tolist(), "width": patch.width, "colour": _rgb(patch.colour)}
                    for patch in scenario.floor.patches
                ],
            },
        }

    # ----------------------------------------------------------------------------------------------------------- maps

    def _map(self, found: Map) -> int:
        for place, known in enumerate(self._maps):
            if known is found:
                return place
        self._maps.append(found)
        width, height = found.size
        corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
        c, s = math.cos(found.origin[2]), math.sin(found.origin[2])
        world = corners @ np.array([[c, s], [-s, c]]) + found.origin[:2]
        low, high = world.min(axis=0).tolist(), world.max(axis=0).tolist()
        shape: MapShape = {
            "name": found.name,
            "origin": list(found.origin),
            "size": [width, height],
            "extent": [*low, *high],
            "segments": None,
            "image": None,
        }
        if found.segments is not None and len(found.segments) <= MOST_SEGMENTS:
            shape["segments"] = found.segments.tolist()
        else:
            shape["image"] = {"name": f"map-{len(self._shapes)}", "extent": [0.0, 0.0, width, height]}
        self._shapes.append(shape)
        return len(self._shapes) - 1

    def picture(self, name: str) -> bytes:
        """The PNG that a map's shape names: occupied cells black, free ones clear.

        Raises
        ------
        LookupError
            If no map names it.
        """
        for found, shape in zip(self._maps, self._shapes, strict=True):
            if shape["image"] is not None and shape["image"]["name"] == name:
                width, height = found.size
                side = max(found.resolution, math.sqrt(width * height / MOST_PIXELS))
                cells = found.to_array(resolution=side)[::-1]
                pixels = np.zeros((*cells.shape, 2), dtype=np.uint8)
                pixels[..., 1] = np.where(cells, 255, 0)
                out = io.BytesIO()
                Pictures.fromarray(pixels, "LA").save(out, "PNG")
                return out.getvalue()
        raise LookupError(f"there is no picture {name!r}")

    # --------------------------------------------------------------------------------------------------------- robots

    def _robot(self, robot: Robot) -> RobotEntry:
        knowledge: Knowledge = {
            "map": None if robot.knowledge.map is None else self._map(robot.knowledge.map),
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
            entry["colour"] = _rgb(colour)
        return entry

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
            "footprint": _outline(robot.shape),
            "wheels": _wheels(robot.drive, drive),
            "channels": [*_drive_channels(robot.drive), *_device_channels(robot.sensors)],
            "joints": [joint.name for joint in robot.drive.joints],
            "twist": _fastest(drive, robot.drive),
            "sensors": sensor_shapes(robot),
            "estimators": list(robot.estimators),
        }
        # Equal in all that is drawn is as good as the same.
        place = self._kinds.index(kind) if kind in self._kinds else len(self._kinds)
        if place == len(self._kinds):
            self._kinds.append(kind)
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


def _rgb(name: str) -> str:
    """A colour as "#rrggbb"."""
    return "#{:02x}{:02x}{:02x}".format(*ImageColor.getrgb(name)[:3])


def _body(name: str, shape: Shape, colour: str | None, *, moves: bool = True) -> ObstacleShape:
    body: ObstacleShape = {"name": name, "footprint": _outline(shape), "moves": moves}
    if colour is not None:
        body["colour"] = _rgb(colour)
    return body


def _outline(shape: Shape) -> Outline:
    if shape.vertices == (((0.0, 0.0),),):
        return {"circle": shape.radius}
    return {"polygon": shape.outline.tolist()}


def _wheels(drive: Drive, stacked: Drive) -> list[list[float]]:
    """The wheels that roll, where they touch the ground, and those of a car that steer."""
    places = stacked.contacts(np.zeros((1, len(drive.joints))))[0]
    if not places.any():  # a drive that does not say
        return []
    radii = np.broadcast_to(stacked.rolling_radius(), (1, len(places)))[0]
    wheels = [[x, y, 0.0, radius] for (x, y), radius in zip(places.tolist(), radii.tolist(), strict=True)]
    wheelbase, track = _number(drive, "wheelbase"), _number(drive, "track")
    if "steering" in drive.channels and wheelbase and track:
        steered = [[wheelbase, side * track / 2.0, 0.0, wheels[0][3]] for side in (1.0, -1.0)]
        wheels += [wheel for wheel in steered if wheel not in wheels]
    return wheels


def _drive_channels(drive: Drive) -> list[Channel]:
    """The drive's channels with their limits, as far as its fields have names that tell them."""
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
    """The fastest of each part of a velocity alone: as the drive tells, or by what its command asks of the joints."""
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
        told = speeds[0].tolist()
        found = [
            told[0],
            found[1] if drive.heading_offset(np.zeros((1, len(nominal.joints)))) is None else 0.0,
            told[1],
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
