"""Scenarios as tables: all that a file needs for the same scenario to be read from it again."""

from __future__ import annotations

import pickle
import types
from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from amorsim.core.errors import Fault, PluginError, ScenarioError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.files.models import FORMAT, LOOKS
from amorsim.scenario.floor import Floor
from amorsim.scenario.initial_belief import InitialBelief
from amorsim.scenario.knowledge import Knowledge
from amorsim.scenario.reading.bodies import write_shape
from amorsim.scenario.reading.deviations import write_deviations
from amorsim.scenario.reading.fields import write_component, write_fields
from amorsim.scenario.reading.floor_file import write_floor
from amorsim.scenario.reading.generated import write_generated
from amorsim.scenario.reading.starts import series_of
from amorsim.scenario.reading.worlds import start_of
from amorsim.scenario.spec import MountedSensor, NoiseElement, Obstacle, Pose, Recording, Robot, Scenario, Zone
from amorsim.worlds.drawn import DrawnWorld, origin_of
from amorsim.worlds.made import MadeWorld

__all__ = ["chain_table", "resolved", "resolved_table"]


def resolved(scenario: Scenario) -> dict[str, Any]:
    """The complete table of a scenario: the one it was read with, or else `resolved_table`."""
    return dict(scenario.resolved) if scenario.resolved is not None else resolved_table(scenario)


def resolved_table(
    scenario: Scenario, *, registry: Registry | None = None, maps_in_files: bool = True
) -> dict[str, Any]:
    """The complete table of a scenario: no models, every default filled in, files by their absolute paths.

    Unless `maps_in_files`, a map that was made in Python may be among them, and is left out.

    Raises
    ------
    ScenarioError
        With a fault for everything that has no name in a file: a component that is not registered, a map or a
        controller that is in no file, a shape that no table describes.
    """
    writer = _Writer(registry or default_registry(), maps_in_files)
    table = writer.scenario(scenario)
    if writer.faults:
        raise ScenarioError(writer.faults)
    return table


def chain_table(robot: Robot, path: str, registry: Registry) -> list[dict[str, Any]]:
    """A chain of noise of a robot, ``"ground"`` or ``"sensors.NAME.noise"``, as a list of tables.

    What is raised is as for `resolved_table`.
    """
    writer = _Writer(registry, maps_in_files=True)
    if path == "ground":
        table = writer.chain(robot.ground, path, "m")
    else:
        mounted = robot.sensors[path.split(".")[1]]
        table = writer.chain(mounted.noise, path, mounted.sensor.unit, mounted.sensor.columns())
    if writer.faults:
        raise ScenarioError(writer.faults)
    return table


def robot_table(robot: Robot, registry: Registry) -> dict[str, Any]:
    """The complete table of a robot's model: no name, no start, no knowledge; programs by their absolute
    paths.

    What is raised is as for `resolved_table`.
    """
    writer = _Writer(registry, maps_in_files=True)
    plain = attrs.evolve(
        robot, model="", pose=None, start=None, initial_belief=InitialBelief(), kidnappings=(), knowledge=Knowledge()
    )
    table = writer.model(plain)
    if writer.faults:
        raise ScenarioError(writer.faults)
    return table


def sensor_table(sensor: MountedSensor, registry: Registry) -> dict[str, Any]:
    """The complete table of a sensor; what is raised is as for `resolved_table`."""
    writer = _Writer(registry, maps_in_files=True)
    table = writer.sensor(sensor, "")
    if writer.faults:
        raise ScenarioError(writer.faults)
    return table


_ONE_QUANTITY: Mapping[str, str] = types.MappingProxyType({})


class _Writer:
    """Writes one thing in each method; collects what cannot be written."""

    def __init__(self, registry: Registry, maps_in_files: bool) -> None:
        self._registry = registry
        self._maps_in_files = maps_in_files
        self._models: dict[tuple[Any, ...], tuple[Robot, bytes]] = {}
        self.faults: list[Fault] = []

    def scenario(self, scenario: Scenario) -> dict[str, Any]:
        """The whole table."""
        table = {
            "format": FORMAT,
            "world": self._map(scenario.map, "world"),
            "simulation": write_fields(scenario, names=("dt", "duration", "seed")),
            "recording": self._recording(scenario.recording),
            "robots": [
                self._series(series, self._robot(series[0], scenario.map, f"robots.{i}"))
                for i, series in enumerate(series_of(scenario.robots))
            ],
        }
        if scenario.task is not None:
            table["task"] = self._component("task", scenario.task, "task")
        if scenario.obstacles:
            table["obstacles"] = [
                self._series(series, self._obstacle(series[0], f"obstacles.{i}"))
                for i, series in enumerate(series_of(scenario.obstacles))
            ]
        for key, things in (("landmarks", scenario.landmarks), ("lights", scenario.lights)):
            if things:
                table[key] = [write_fields(thing) for thing in things]
        if scenario.zones:
            table["zones"] = [self._zone(zone, f"zones.{i}") for i, zone in enumerate(scenario.zones)]
        if scenario.floor != Floor():
            table["floor"] = write_floor(scenario.floor, self._shape)
        return table

    def _fault(self, path: str, message: str) -> None:
        self.faults.append(Fault(file="", path=path, message=message))

    def _component(self, kind: str, component: Any, path: str, unit: str = "") -> dict[str, Any]:
        try:
            return write_component(kind, component, self._registry, unit)
        except PluginError as error:
            self._fault(path, str(error))
        except ParameterError as error:  # of a component within it
            self._fault(f"{path}.{error.name}", error.problem)
        return {}

    def _map(self, found: Map, path: str) -> dict[str, Any]:
        file = found.source
        if file is None:
            if self._maps_in_files:
                self._fault(
                    f"{path}.map",
                    "the map was not read from a file, so a file cannot name it; give it one with save_map",
                )
            return {}
        if isinstance(file, (MadeWorld, DrawnWorld)):
            name = self._component("world_generator", file.generator, f"{path}.map").get("use", "")
            return {"map": write_generated(file, name)}
        return {"map": str(file.path.absolute()), **self._component("map_loader", file.loader, path)}

    def _recording(self, recording: Recording) -> dict[str, Any]:
        written = write_fields(recording, names=("sensors", "picture"))
        if recording.also:
            written["also"] = [
                self._component("recorder", recorder, f"recording.also.{i}")
                for i, recorder in enumerate(recording.also)
            ]
        return written

    def _series(self, series: Sequence[Robot | Obstacle], written: dict[str, Any]) -> dict[str, Any]:
        """The table of many alike, from that of the first of them."""
        if len(series) == 1:
            return written
        name, *_ = series
        stem = name.name.rstrip("0123456789")
        whole: dict[str, Any] = {"name": stem, "count": len(series)}
        if "pose" in written:
            whole["start"] = {"poses": [write_fields(body.pose) for body in series]}
        return whole | {key: value for key, value in written.items() if key not in ("name", "pose")}

    def _robot(self, robot: Robot, world: Map, path: str) -> dict[str, Any]:
        written: dict[str, Any] = {"name": robot.name}
        if robot.model:
            written["resolved_from"] = robot.model
        pose = robot.pose
        if robot.start is not None:
            written["start"] = write_fields(robot.start)
        elif pose is not None or origin_of(world) is None:
            pose = pose or start_of(world, robot)
            written["pose"] = write_fields(pose)
        written.update(self._model_of(robot, path, pose))
        if robot.initial_belief != InitialBelief():
            written["initial_belief"] = write_fields(robot.initial_belief)
        if robot.kidnappings:
            written["kidnappings"] = [write_fields(one) for one in robot.kidnappings]
        knowledge: dict[str, Any] = {}
        if robot.knowledge.map is not None:
            knowledge = self._map(robot.knowledge.map, f"{path}.knowledge")
        if robot.knowledge.landmarks:
            points = robot.knowledge.landmarks
            ids = robot.knowledge.landmark_ids or (0,) * len(points)
            knowledge["landmarks"] = [
                {"id": number, "x": x, "y": y} if number else [x, y] for number, (x, y) in zip(ids, points, strict=True)
            ]
        if knowledge:
            written["knowledge"] = knowledge
        return written

    def _model_of(self, robot: Robot, path: str, pose: Pose | None) -> dict[str, Any]:
        """`model`, written once for robots that are made of the same objects."""
        if any(error.partition(".")[0] == "pose" for error in robot.errors):
            return self.model(robot, path, pose)
        parts = (robot.drive, robot.shape, robot.controller, *robot.ground)
        named = (*robot.sensors.items(), *robot.estimators.items(), *robot.errors.items())
        looks = tuple(getattr(robot, name) for name in ("on_collision", *LOOKS))
        key = (*map(id, parts), *((name, id(part)) for name, part in named), *looks)
        if key not in self._models:
            # With the robot, so that no other object gets an id of its parts.
            self._models[key] = robot, pickle.dumps(self.model(robot, path, pose))
        again: dict[str, Any] = pickle.loads(self._models[key][1])
        return again

    def model(self, robot: Robot, path: str = "", pose: Pose | None = None) -> dict[str, Any]:
        """The part of a robot that a model may set."""
        written: dict[str, Any] = {"shape": self._shape(robot.shape, path)}
        if robot.controller is not None:
            written["controller"] = self._component("controller", robot.controller, f"{path}.controller")
        written["on_collision"] = robot.on_collision
        written.update(write_fields(robot, names=LOOKS))
        if robot.ground:
            written["ground"] = self.chain(robot.ground, f"{path}.ground", "m")
        written["drive"] = self._component("drive", robot.drive, f"{path}.drive")
        written["sensors"] = {
            name: self.sensor(sensor, f"{path}.sensors.{name}") for name, sensor in robot.sensors.items()
        }
        written["estimators"] = {
            name: self._component("estimator", estimator, f"{path}.estimators.{name}")
            for name, estimator in robot.estimators.items()
        }
        if robot.errors:
            written["errors"] = self._errors(robot, pose or Pose(), path)
        return written

    def _errors(self, robot: Robot, pose: Pose, path: str) -> dict[str, Any]:
        parts = {"drive": robot.drive, "sensors": robot.sensors, "pose": pose}
        try:
            return write_deviations(robot.errors, parts)
        except (LookupError, AttributeError, ValueError) as error:
            self._fault(f"{path}.errors", f"one of its paths leads to no number: {error}")
            return {}

    def sensor(self, mounted: MountedSensor, path: str) -> dict[str, Any]:
        """A sensor's table."""
        unit = mounted.sensor.unit
        written = self._component("sensor", mounted.sensor, path)
        written["mount"] = write_fields(mounted.mount)
        written.update(write_fields(mounted, names=("rate", "latency")))
        if mounted.noise:
            written["noise"] = self.chain(mounted.noise, f"{path}.noise", unit, mounted.sensor.columns())
        return written

    def chain(
        self, chain: tuple[NoiseElement, ...], path: str, unit: str, columns: Mapping[str, str] = _ONE_QUANTITY
    ) -> list[dict[str, Any]]:
        """A chain's tables."""
        written = []
        for i, element in enumerate(chain):
            fields = self._component("noise", element.noise, f"{path}.{i}", columns.get(element.column, unit))
            column = {"column": element.column} if element.column else {}
            written.append({"use": fields.pop("use", ""), "name": element.name, **column, **fields})
        return written

    def _obstacle(self, obstacle: Obstacle, path: str) -> dict[str, Any]:
        written: dict[str, Any] = {"name": obstacle.name, "shape": self._shape(obstacle.shape, path)}
        if obstacle.start is not None:
            written["start"] = write_fields(obstacle.start)
        else:
            written["pose"] = write_fields(obstacle.pose)
        written.update(write_fields(obstacle, names=LOOKS))
        if obstacle.motion is not None:
            written["motion"] = self._component("motion", obstacle.motion, f"{path}.motion")
        return written

    def _zone(self, zone: Zone, path: str) -> dict[str, Any]:
        written: dict[str, Any] = {"name": zone.name, "shape": self._shape(zone.shape, path)}
        written["pose"] = write_fields(zone.pose)
        if zone.ground:
            written["ground"] = self.chain(zone.ground, f"{path}.ground", "m")
        return written

    def _shape(self, shape: Any, path: str) -> dict[str, Any]:
        written = write_shape(shape)
        if written is None:
            self._fault(
                f"{path}.shape",
                "a shape that is not a circle, polygon or rounded convex polygon cannot be written into a file",
            )
        return written or {}
