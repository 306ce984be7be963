"""Robots and obstacles in documents."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from amorsim.contracts import Drive
from amorsim.core.arguments import checked, whole
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import AmorsimError, PluginError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.unknown_names import no_such
from amorsim.plugins.checks import check_name
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.files.models import LOOKS, drop_removed, merge_models
from amorsim.scenario.initial_belief import InitialBelief
from amorsim.scenario.kidnapping import Kidnapping
from amorsim.scenario.kinds import check_colour
from amorsim.scenario.reading.bodies import read_pose, read_shape
from amorsim.scenario.reading.columns import columns_problem
from amorsim.scenario.reading.components import (
    read_chain,
    read_controller,
    read_drive,
    read_estimator,
    read_motion,
    read_sensor,
)
from amorsim.scenario.reading.deviations import read_deviations
from amorsim.scenario.reading.faults import FaultCollector, Node, Source, shown
from amorsim.scenario.reading.fields import file_fields, read_component, read_fields
from amorsim.scenario.reading.references import check_references
from amorsim.scenario.reading.worlds import Maps
from amorsim.scenario.spec import Landmark, MountedSensor, Obstacle, Pose, Robot, Zone

__all__ = ["load_robot", "read_obstacle", "read_robot", "read_zone"]

_ROBOT_KEYS = (
    "name",
    "model",
    "resolved_from",
    "count",
    "pose",
    "start",
    "shape",
    "drive",
    "sensors",
    "ground",
    "estimators",
    "controller",
    "on_collision",
    "errors",
    "initial_belief",
    "kidnappings",
    "knowledge",
    *LOOKS,
)
_OBSTACLE_KEYS = ("name", "count", "shape", "pose", "start", "motion", *LOOKS)
_ZONE_KEYS = ("name", "shape", "pose", "ground")


@checked
def load_robot(model: str | Path, *, registry: Registry | None = None, **changes: Any) -> Robot:
    """The robot of a model: its registered name such as ``"pioneer2dx"``, or the path of its ``.toml`` file.

    Parameters
    ----------
    changes
        Fields of `Robot` in place of the model's: ``name``, ``pose``, ``controller``, ``errors`` ...; without a name it
        is called "robot". A table such as ``sensors`` replaces the whole one:
        ``sensors=robot.sensors | {"marks": am.sensors.Fiducial()}`` adds to it.

    Raises
    ------
    ScenarioError
        With all the faults of the model that were found.
    ParameterError
        If a field does not take its value.
    AmorsimError
        If a robot has no such field.
    """
    known = attrs.fields_dict(Robot)
    for name in changes:
        if name not in known:
            raise AmorsimError(no_such("field", name, known, whose="a robot"))
    registry = registry or default_registry()
    book = FaultCollector(Source(file="", folder=Path()))
    document: dict[str, Any] = {"robots": [{"model": str(model)}]}
    merge_models(document, book, registry)
    drop_removed(document["robots"][0])
    robot = read_robot(Node(document["robots"][0], ("robots", "0"), book), Maps(registry), None, registry)
    book.raise_if_any()
    assert robot is not None
    return attrs.evolve(robot, **changes)


def read_robot(
    node: Node, maps: Maps, world: Map | None, registry: Registry, marks: Sequence[Landmark] = ()
) -> Robot | None:
    """The robot in a table that its model was merged into, None after faults; its pose may be None."""
    if not node.expect_table("a table: name, model, pose, controller ..."):
        return None
    before = node.book.count
    node.refuse_unknown(_ROBOT_KEYS, dict.fromkeys(("x", "y", "heading_deg"), "pose = { ... }"))
    values: dict[str, Any] = {"name": _name(node.child("name"), "robot")}
    if "resolved_from" in node:
        values["model"] = node.child("resolved_from").text("a text")
    # What is missing where a model could not be read is not the robot's fault.
    is_incomplete = node.path in node.book.incomplete
    if "shape" in node or not is_incomplete:
        values["shape"] = read_shape(node.child("shape"))
    drive = None

    def is_change(part: Node) -> bool:
        """Whether this table changes a component of a model that could not be read: it names none itself."""
        return is_incomplete and part.is_table and not {"use", "model"} & set(part.value)

    if "drive" in node and not is_change(node.child("drive")):
        drive = read_drive(node.child("drive"), registry)
    elif not is_incomplete:
        node.child("drive").fault(
            f"missing; expected a model, or drive = {{ use = ... }} with one of: {', '.join(registry.names('drive'))}"
        )
    parts = {
        key: {name: child for name, child in _named(node, key) if not is_change(child)}
        for key in ("sensors", "estimators")
    }
    sensors = {name: read_sensor(child, registry) for name, child in parts["sensors"].items()}
    estimators = {name: read_estimator(child, registry) for name, child in parts["estimators"].items()}
    values.update(drive=drive, sensors=sensors, estimators=estimators)
    if "ground" in node:
        values["ground"] = read_chain(node.child("ground"), registry, "m")
    if "controller" in node and not is_change(node.child("controller")):
        values["controller"] = read_controller(node.child("controller"), registry)
    if "pose" in node:
        values["pose"] = read_pose(node.child("pose"))
    if "initial_belief" in node:
        values["initial_belief"] = read_component(InitialBelief, node.child("initial_belief"))
    if "kidnappings" in node:
        values["kidnappings"] = _kidnappings(node.child("kidnappings"))
    if "knowledge" in node:
        values["knowledge"] = maps.read_knowledge(node.child("knowledge"), world, marks)
    values.update(_looks(node, Robot, ("on_collision",)))
    if "errors" in node:
        pose = values.get("pose", Pose())
        of = {"drive": drive, "sensors": sensors, "pose": pose}
        values["errors"] = read_deviations(node.child("errors"), of, _unread(node, registry))
    if drive is not None:
        _check_sizes(node, drive, sensors)
    if not is_incomplete:
        _check_references(node, values)
    if node.book.count > before or is_incomplete:
        return None
    try:
        return Robot(**values)
    except ParameterError as error:
        node.child(error.name).fault(error.problem)
        return None


def _unread(node: Node, registry: Registry) -> dict[tuple[str, ...], type]:
    """The classes of a robot's drive and sensors, by where they are, whatever is wrong with their values."""
    places: list[tuple[str, tuple[str, ...], Node]] = []
    if "drive" in node:
        places.append(("drive", ("drive",), node.child("drive")))
    sensors = node.child("sensors")
    if sensors.is_table:
        places += [("sensor", ("sensors", name), child) for name, child in sensors.children()]
    found: dict[tuple[str, ...], type] = {}
    for kind, path, child in places:
        use = child.value.get("use") if child.is_table else None
        if isinstance(use, str) and use in registry.names(kind):
            with contextlib.suppress(PluginError):
                found[path] = registry.get(kind, use)
    return found


def _check_references(node: Node, values: Mapping[str, Any]) -> None:
    """A fault for each name of a sensor, estimator or joint that a component uses and the robot does not have."""
    known: dict[str, Sequence[str]] = {key: list(values[key]) for key in ("sensors", "estimators")}
    if values["drive"] is not None:
        known["joints"] = [joint.name for joint in values["drive"].joints]
    check_references(node.child("controller"), values.get("controller"), known)
    for name, estimator in values["estimators"].items():
        check_references(node.child("estimators").child(name), estimator, known)
    ground = values.get("ground", ())
    items = list(node.child("ground").items()) if ground else []
    if len(items) == len(ground):  # else some were not read
        for item, element in zip(items, ground, strict=True):
            check_references(item, element.noise, known)


def _check_sizes(node: Node, drive: Drive, sensors: Mapping[str, MountedSensor | None]) -> None:
    """A fault for each sensor whose parameters do not suit the drive, or whose columns do not suit its size."""
    for name, unit in sensors.items():
        try:
            if unit is not None:
                size = whole(unit.sensor.size(drive), "size()", "a whole number >= 1", least=1)
                if problem := columns_problem(unit.sensor, size):
                    node.child("sensors").child(name).fault(problem)
        except ParameterError as error:
            at = node.child("sensors").child(name)
            if error.name == "size()":
                at.fault(str(error))
            else:
                at.child(error.name).fault(error.problem)
        except RAISED as error:
            sensor = type(unit.sensor).__name__ if unit else ""
            node.child("sensors").child(name).fault(f"size() of {sensor} raised {error_in_words(error)}")


def read_obstacle(node: Node, number: int, registry: Registry) -> Obstacle | None:
    """The obstacle in a table, called ``obstacle<number>`` if it has no name; None after faults."""
    if not node.expect_table("a table: name, shape, pose, motion"):
        return None
    before = node.book.count
    node.refuse_unknown(_OBSTACLE_KEYS, dict.fromkeys(("x", "y", "heading_deg"), "pose = { ... }"))
    default = f"obstacle{number}_" if "count" in node else f"obstacle{number}"
    values: dict[str, Any] = {"name": _name(node.child("name"), default)}
    values["shape"] = read_shape(node.child("shape"))
    if "pose" in node:
        values["pose"] = read_pose(node.child("pose"))
    if "motion" in node:
        values["motion"] = read_motion(node.child("motion"), registry)
    values.update(_looks(node, Obstacle))
    if node.book.count > before:
        return None
    try:
        return Obstacle(**values)
    except ParameterError as error:
        node.child(error.name).fault(error.problem)
        return None


def read_zone(node: Node, number: int, registry: Registry) -> Zone | None:
    """The zone in a table, called ``zone<number>`` if it has no name; None after faults."""
    if not node.expect_table("a table: name, shape, pose, ground"):
        return None
    before = node.book.count
    node.refuse_unknown(_ZONE_KEYS)
    values: dict[str, Any] = {"name": _name(node.child("name"), f"zone{number}")}
    values["shape"] = read_shape(node.child("shape"))
    if "pose" in node:
        values["pose"] = read_pose(node.child("pose"))
    if "ground" in node:
        values["ground"] = read_chain(node.child("ground"), registry, "m")
    if node.book.count > before:
        return None
    try:
        return Zone(**values)
    except ParameterError as error:
        node.child(error.name).fault(error.problem)
        return None


def _looks(node: Node, cls: type[Robot | Obstacle], more: tuple[str, ...] = ()) -> dict[str, Any]:
    """The appearance of a body, and more fields of its class."""
    values = read_fields(node, file_fields(cls, names=(*more, *LOOKS)))
    try:  # here already, for a body with other faults is never made
        check_colour(values.get("colour"))
    except ParameterError as error:
        node.child(error.name).fault(error.problem)
    return values


def _kidnappings(node: Node) -> list[Kidnapping]:
    if not isinstance(node.value, list):
        node.fault(f"expected a list of tables {{ time, x, y, heading_deg }}, got {shown(node.value)}")
        return []
    return [found for child in node.items() if (found := read_component(Kidnapping, child)) is not None]


def _name(node: Node, default: str) -> str:
    if node.value is None:
        return default
    problem = check_name(node.value)
    if problem:
        node.fault(problem)
        return default
    return str(node.value)


def _named(node: Node, key: str) -> list[tuple[str, Node]]:
    """The named tables under a key of a robot, with faults for invalid names."""
    if key not in node:
        return []
    child = node.child(key)
    if not child.expect_table(f"tables by name, as in [robots.{key}.NAME]"):
        return []
    for name, item in child.children():
        problem = check_name(name)
        if problem:
            item.fault(problem)
    return list(child.children())
