"""Changes from outside while a simulation runs: robots moved, parameters set, robots handed over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from amorsim.core.arguments import check_text
from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError, ComponentError, ScenarioError
from amorsim.core.maps.footprint_room import outside
from amorsim.core.parameters import ParameterError
from amorsim.scenario.parameter_paths import with_value
from amorsim.scenario.reading.chains import read_elements, tables_of, with_chain
from amorsim.scenario.spec import Robot
from amorsim.simulation.fleet.fleet import Fleet
from amorsim.simulation.fleet.group import Group
from amorsim.simulation.fleet.grouping import group_key
from amorsim.simulation.handle import RobotHandle
from amorsim.simulation.state.regroup import chains_of, regrouped

__all__ = ["hand_over", "move", "set_parameter", "with_other_chain"]


def move(fleet: Fleet, moves: Sequence[tuple[RobotHandle, tuple[float, ...]]], kind: str) -> None:
    """Move robots and their parts at one instant, each to a pose (x [m], y [m], heading [rad]), at rest.

    Each move is an event of that kind. Places are judged with all robots where they are moved to; if one is refused,
    none moves.
    """
    poses = fleet.world.poses.copy()
    for handle, pose in moves:
        beyond = outside(fleet.world.terrain.at(fleet.replicas.index(handle.replica)), *pose[:2])
        if beyond:
            raise AmorsimError(f"robot {handle.name!r} cannot stand at {pose}: that {beyond}")
        group, row, wanted = handle._group, handle._row, np.array([pose])
        parts = np.empty((0, 3)) if group.parts is None else group.parts.of_row(row, wanted[0])
        poses[fleet.robot_bodies(group, row)] = np.concatenate((wanted, parts))
    for handle, pose in moves:
        found = fleet.overlap(handle._group, handle._row, poses)
        if found:
            raise AmorsimError(f"robot {handle.name!r} cannot stand at {pose}: it would overlap {found}")
    for handle, pose in moves:
        group, row = handle._group, handle._row
        bodies = fleet.robot_bodies(group, row)
        group.true_pose[row] = poses[bodies[0]]
        if group.parts is not None:
            group.parts.put(row, poses[bodies[1:]])
        group.true_twist[row] = 0.0
        group.joint_rates[row] = 0.0
        group.locomotion.zones.put(row)
        fleet.place()
        fleet.part_from_all(int(bodies[0]))
        fleet.log(group, row, kind, path="pose", value=pose)


def set_parameter(fleet: Fleet, handles: Sequence[RobotHandle], path: str, value: Any) -> None:
    """Set a parameter of one robot, in the replicas of its `handles`; if it is refused, nothing has changed."""
    for group in {id(handle._group): handle._group for handle in handles}.values():
        rows = [handle._row for handle in handles if handle._group is group]
        before = list(group.specified)
        key = group_key(before[rows[0]])
        known: dict[int, Robot] = {}
        try:
            for row in rows:
                robot = before[row]
                changed = known.get(id(robot)) or known.setdefault(id(robot), with_value(robot, path, value))
                if group_key(changed) != key:
                    raise LookupError("this fixes the shape of the robot's arrays")
                group.specified[row] = changed
            group.set_parameters()
            _move_parts(fleet, group, rows)
        except (LookupError, ParameterError, ScenarioError) as error:
            group.specified = before
            group.set_parameters()
            reason = error.problem if isinstance(error, ParameterError) else str(error.args[0])
            if isinstance(error, ScenarioError):  # it is about what follows from the value
                reason = f"{in_words(value)} would be out of bounds; with it, {reason}"
            raise AmorsimError(f"robot {handles[0].name!r}, {path}: {reason}") from None
    for handle in handles:
        fleet.log(handle._group, handle._row, "parameter_set", path=path, value=value)


def with_other_chain(fleet: Fleet, name: str, path: str, given: Any) -> Fleet:
    """A copy of a fleet, at the same moment, in which a robot has another noise chain at `path` in all replicas."""
    group, row = fleet.robot_row(name, 0)
    robot = group.specified[row]
    elements = read_elements(robot, path, given)
    tables = tables_of(with_chain(robot, path, elements), path)
    try:
        changed = regrouped(fleet, {name: {**chains_of(robot), path: elements}})
    except (ComponentError, ScenarioError) as error:
        raise AmorsimError(f"robot {name!r}, {path}: {error}") from None
    for index in range(len(changed.replicas)):
        changed.log(*changed.robot_row(name, index), "parameter_set", path=path, value=tables)
    return changed


def hand_over(fleet: Fleet, handle: RobotHandle, to: str) -> None:
    """Drive a robot from outside (``"hand"``), or by its ``"controller"`` again."""
    driver = handle._group.driver
    check_text(to, "to", "'hand' or 'controller'")
    if to not in ("hand", "controller"):
        raise AmorsimError(f"robot {handle.name!r}: expected to hand it over to 'hand' or 'controller', got {to!r}")
    if to == "controller" and driver.controller is None:
        raise AmorsimError(f"robot {handle.name!r} has no controller; it can only be driven by hand")
    if handle.is_by_hand == (to == "hand") and (to == "hand" or handle.is_active):
        return
    driver.hand_over(handle._row, to == "hand")
    fleet.part_from_all(int(handle._group.bodies[handle._row]))
    fleet.log(handle._group, handle._row, "handed_over", path="driver", value=to)


def _move_parts(fleet: Fleet, group: Group, rows: Sequence[int]) -> None:
    """Move the parts of some robots to where their drives place them; a `LookupError` names an obstruction."""
    if group.parts is None:
        return
    moved = [group.parts.of_row(row, group.true_pose[row]) for row in rows]
    poses = fleet.world.poses.copy()
    for row, parts in zip(rows, moved, strict=True):
        poses[fleet.robot_bodies(group, row)[1:]] = parts
    for row in rows:
        found = fleet.overlap(group, row, poses)
        if found:
            raise LookupError(f"with it the robot would overlap {found}")
    for row, parts in zip(rows, moved, strict=True):
        group.parts.put(row, parts)
    fleet.place()
