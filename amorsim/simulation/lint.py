"""Remarks on scenarios: what is valid but probably not intended."""

from __future__ import annotations

import collections

import attrs
import numpy as np
import shapely

from amorsim.array_types import Bools
from amorsim.contracts import Controller, Motion
from amorsim.core.errors import ComponentError, MapError
from amorsim.core.maps.connectivity import shut_off
from amorsim.core.maps.footprint_room import out_of_reach
from amorsim.core.maps.map import Map
from amorsim.scenario.named_places import goals_of
from amorsim.scenario.parameter_paths import changed
from amorsim.scenario.reading.worlds import start_of
from amorsim.scenario.spec import Obstacle, Robot, Scenario
from amorsim.worlds.drawn import map_of, origin_of

__all__ = ["REPLICAS", "advice"]

REPLICAS = 4
"""The replicas whose maps are looked at where they have different ones."""


_MOST = 3  # places of one body that are reported
_TURN = np.arange(32) * (np.pi / 16.0)


def advice(scenario: Scenario) -> list[str]:
    """Remarks on a valid scenario, each with the path that it is about.

    Where replicas have different maps, those of the first few are looked at, and a remark that is not on replica 0's
    names its replica.
    """
    remarks = _of_parts(scenario) + _of_places(scenario) + _alike(scenario)
    if origin_of(scenario.map) is not None:
        for replica in range(1, REPLICAS):
            try:
                other = attrs.evolve(scenario, map=map_of(scenario.map, replica))
            except MapError as error:
                remarks.append(f"world.map: replica {replica} has no world: {error}")
                continue
            remarks += [f"{remark} (replica {replica})" for remark in _of_places(other) if remark not in remarks]
    return remarks


def _of_parts(scenario: Scenario) -> list[str]:
    """Remarks on robots by themselves."""
    remarks = []
    for robot in scenario.robots:
        for name, unit in robot.sensors.items():
            path = f"robots.{robot.name}.sensors.{name}"
            if unit.rate is not None and unit.rate * scenario.dt > 1.0 + 1e-9:
                remarks.append(
                    f"{path}.rate: {unit.rate:g} Hz is faster than the steps ({1.0 / scenario.dt:g} Hz); "
                    "it reads once every step"
                )
            ticks = unit.latency / scenario.dt
            if abs(ticks - round(ticks)) > 1e-6:
                remarks.append(
                    f"{path}.latency: {unit.latency:g} s is not a multiple of dt ({scenario.dt:g} s); "
                    "readings arrive at the first step after it"
                )
        if robot.controller is None:
            remarks.append(f"robots.{robot.name}.controller: there is none, so the robot stands still")
        remarks += _factors(robot)
    return remarks


def _of_places(scenario: Scenario) -> list[str]:
    """Remarks on what lies where on the map."""
    remarks = _unreachable(scenario)
    for i, mark in enumerate(scenario.landmarks):
        x, y = mark.x + mark.radius * np.cos(_TURN), mark.y + mark.radius * np.sin(_TURN)
        if scenario.map.occupied(np.stack((np.append(x, mark.x), np.append(y, mark.y)), axis=1)).all():
            remarks.append(
                f"landmarks.{i}: ({mark.x:g}, {mark.y:g}) m and all within its radius of {mark.radius:g} m is wall, or "
                "outside the map; no sensor can see it"
            )
    for i, light in enumerate(scenario.lights):
        if scenario.map.occupied([[light.x, light.y]])[0]:
            remarks.append(
                f"lights.{i}: ({light.x:g}, {light.y:g}) m is in a wall or outside the map; the lamp lights nothing"
            )
    return remarks


def _factors(robot: Robot) -> list[str]:
    """Errors whose true value is near 1 and far from the nominal one: probably a factor, given as a value."""
    remarks = []
    for path, error in robot.errors.items():
        if not isinstance(error.value, float) or not 0.5 <= error.value <= 2.0:
            continue
        found: list[float] = []
        changed(robot, path.split("."), lambda value, found=found: found.append(value) or value)  # type: ignore[misc]
        nominal = float(found[0])
        if nominal > 0.0 and not 0.5 <= error.value / nominal <= 2.0:
            remarks.append(
                f"robots.{robot.name}.errors.{path}: the true value is {error.value:g}, where the robot believes in "
                f"{nominal:g}; a factor is written {{ scale = {error.value:g} }}"
            )
    return remarks


def _unreachable(scenario: Scenario) -> list[str]:
    """Goals of robots and obstacles that are out of reach; one remark for a series."""
    remarks = []
    asked: set[int] = set()
    bodies: list[tuple[str, Controller | Motion | None, Robot | Obstacle]] = [
        *((f"robots.{robot.name}.controller", robot.controller, robot) for robot in scenario.robots),
        *((f"obstacles.{obstacle.name}.motion", obstacle.motion, obstacle) for obstacle in scenario.obstacles),
    ]
    for path, component, body in bodies:
        try:
            places = [] if component is None or id(component) in asked else goals_of(component)
        except ComponentError as error:
            raise ComponentError(f"{path} ({type(component).__name__}): {error}") from error.__cause__
        asked.add(id(component))
        if not places:
            continue
        points = [(x, y) for _, x, y in places]
        blocked = scenario.map.occupied(points)
        lost = blocked | _shut_off(scenario.map, body, points, ~blocked)
        unreached = [
            (*places[i], out_of_reach(scenario.map, *points[i]) or "is walled off from where it starts")
            for i in np.flatnonzero(lost).tolist()
        ]
        for field, x, y, problem in unreached[:_MOST]:
            remarks.append(f"{path}.{field}: ({x:g}, {y:g}) m {problem}; it cannot get there")
        if len(unreached) > _MOST:
            remarks.append(f"{path}: so are {len(unreached) - _MOST} more of the {len(places)} places on its route")
    return remarks


def _shut_off(world: Map, body: Robot | Obstacle, points: list[tuple[float, float]], which: Bools) -> Bools:
    """Which of the places marked in `which` walls cut off from a body's start; none if the start is not known."""
    found = np.zeros_like(which)
    pose = body.pose or (start_of(world, body) if isinstance(body, Robot) else None)
    if body.start is not None or pose is None:
        return found
    outline, base = shapely.Polygon(body.shape.outline), shapely.Point(0.0, 0.0)
    room = outline.exterior.distance(base) if outline.contains(base) else 0.0
    asked = np.flatnonzero(which)
    found[asked] = shut_off(world, room, (pose.x, pose.y), [points[i] for i in asked.tolist()])
    return found


def _alike(scenario: Scenario) -> list[str]:
    """Landmarks that share their id with another landmark or a body."""
    remarks = []
    bodies: list[tuple[str, Robot | Obstacle]] = [
        *(("robots", robot) for robot in scenario.robots),
        *(("obstacles", obstacle) for obstacle in scenario.obstacles),
    ]
    seen = {body.fiducial: f"{kind}.{body.name}" for kind, body in reversed(bodies) if body.fiducial}
    for i, mark in enumerate(scenario.landmarks):
        if mark.id in seen:
            remarks.append(
                f"landmarks.{i}.id: {seen[mark.id]} carries {mark.id} too; a sensor cannot know which of them it sees"
            )
        seen.setdefault(mark.id, f"landmarks.{i}")
    for robot in scenario.robots:
        counts = collections.Counter(number for number in robot.knowledge.landmark_ids if number)
        twice = [number for number, count in counts.items() if count > 1]
        if twice:
            remarks.append(
                f"robots.{robot.name}.knowledge.landmarks: more than one has the id {twice[0]}; expected each id once"
            )
    return remarks
