"""The bodies of a scenario before its first step: their order, their world, and where they start."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.core.maps.map import Map
from amorsim.scenario.floor import Floor
from amorsim.scenario.reading.worlds import start_of
from amorsim.scenario.spec import Landmark, Light, Obstacle, Robot
from amorsim.simulation.fleet.placing import draw_starts
from amorsim.simulation.world.marks_and_lamps import Surroundings
from amorsim.simulation.world.terrain import Terrain
from amorsim.simulation.world.world import World

__all__ = ["bodies_of", "drawn_starts", "starts_in", "world_of"]


class Things(Protocol):
    """The parts of a scenario that have a place in its world."""

    @property
    def robots(self) -> Sequence[Robot]: ...
    @property
    def obstacles(self) -> Sequence[Obstacle]: ...
    @property
    def landmarks(self) -> Sequence[Landmark]: ...
    @property
    def lights(self) -> Sequence[Light]: ...
    @property
    def floor(self) -> Floor: ...


def bodies_of(things: Things, terrain: Terrain) -> tuple[list[Robot], list[Obstacle]]:
    """Robots and obstacles by name. A robot without a pose stands at the map's start if all replicas share the map."""
    robots = sorted(things.robots, key=lambda robot: robot.name)
    if len(terrain.maps) == 1:
        robots = [_placed(robot, terrain.maps[0]) for robot in robots]
    return robots, sorted(things.obstacles, key=lambda obstacle: obstacle.name)


def world_of(
    things: Things, robots: Sequence[Robot], obstacles: Sequence[Obstacle], terrain: Terrain, threads: int = 1
) -> World:
    """The world with these bodies, and with the parts of robots after them."""
    bodies: list[Robot | Obstacle] = [*robots, *obstacles]
    parts = [(number, part) for number, robot in enumerate(robots) for part in robot.drive.parts]
    owners = [number for number, _ in parts]
    return World(
        terrain,
        [body.name for body in bodies] + [f"{robots[owner].name}.{part.name}" for owner, part in parts],
        [body.shape for body in bodies] + [part.shape for _, part in parts],
        len(terrain.of_replica),
        threads,
        robots=len(robots),
        surroundings=Surroundings.of(bodies, things.landmarks, things.lights, owners, things.floor),
        owners=owners,
    )


def starts_in(
    world: World, bodies: Sequence[Robot | Obstacle], seed: int, replicas: Sequence[int], source: str
) -> Array:
    """Start poses `(T, 3)` of all bodies in all replicas, as `draw_starts` returns them."""
    given = _given(world.terrain, bodies, len(replicas))
    return draw_starts(world, bodies, given, seed, replicas, source)


def drawn_starts(things: Things, map_: Map, seed: int, replica: int = 0) -> dict[str, list[float]]:
    """Where a run with a seed lets the bodies start that start at random, by name: x, y [m] and heading [rad].

    Raises
    ------
    AmorsimError
        If some find no place, or the replica's map cannot be made.
    """
    terrain = Terrain.of(map_, [replica])
    robots, obstacles = bodies_of(things, terrain)
    bodies: list[Robot | Obstacle] = [*robots, *obstacles]
    poses = starts_in(world_of(things, robots, obstacles, terrain), bodies, seed, [replica], "")
    return {body.name: poses[number].tolist() for number, body in enumerate(bodies) if body.start is not None}


def _placed(robot: Robot, map_: Map) -> Robot:
    if robot.pose is not None or robot.start is not None:
        return robot
    return attrs.evolve(robot, pose=start_of(map_, robot))


def _given(terrain: Terrain, bodies: Sequence[Robot | Obstacle], replicas: int) -> Array:
    """Start poses `(R, B, 3)` of robots and obstacles in all replicas; 0 where they are drawn."""
    given: Array = np.zeros((replicas, len(bodies), 3))
    for number, body in enumerate(bodies):
        if body.pose is not None:
            given[:, number] = body.pose.x, body.pose.y, body.pose.heading
        elif body.start is None and isinstance(body, Robot):
            poses = [start_of(map_, body) for map_ in terrain.maps]
            given[:, number] = np.array([(pose.x, pose.y, pose.heading) for pose in poses])[terrain.of_replica]
    return given
