"""All robots and obstacles of a simulation in all its replicas: groups of rows, their bodies, their time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.core.draws import check_collisions
from amorsim.core.errors import Fault, ScenarioError
from amorsim.core.maps.footprint_room import overlap_with_others, overlap_with_walls
from amorsim.core.rows import signature
from amorsim.scenario.spec import Obstacle, Robot, Scenario
from amorsim.simulation.contact.resolve import WALL, Movement
from amorsim.simulation.estimation.first_beliefs import BELIEF
from amorsim.simulation.events import Event
from amorsim.simulation.fleet.group import Group
from amorsim.simulation.fleet.grouping import group_key
from amorsim.simulation.fleet.obstacles import ObstacleGroup
from amorsim.simulation.fleet.placing import Areas, draw_starts_again, with_start
from amorsim.simulation.fleet.starting import bodies_of, starts_in, world_of
from amorsim.simulation.fleet.zones import zone_streams
from amorsim.simulation.schedule import Call
from amorsim.simulation.world.terrain import Terrains
from amorsim.worlds.drawn import origin_of

__all__ = ["Fleet"]


class Fleet:
    """All rows of a simulation with one seed.

    A body is a robot or an obstacle in one replica; bodies are in order of replica, robots by name before obstacles by
    name. The robots are rows of groups, whatever the order of their bodies.

    Attributes
    ----------
    replicas
        The replicas' numbers.
    terrains
        The maps that replicas have, and those that their robots know; made if not given.
    ticks, episodes
        `(R,)` tick and episode of each replica.
    events
        The events so far, in order.
    movement
        Moves all bodies through a step.
    only
        The group of robots, if there is no other group, no obstacle and no part.
    touching
        The pairs of bodies (`WALL` for a wall) that touched in the last step while still moving towards each other.
    kidnappings
        By the tick before which they happen: names of robots, and poses.
    contacts
        The pairs whose contact continues: they touched in the last step, or earlier and have not parted since.
    """

    def __init__(
        self,
        scenario: Scenario,
        seed: int,
        replicas: tuple[int, ...],
        threads: int = 1,
        terrains: Terrains | None = None,
    ) -> None:
        self.scenario = scenario
        self.seed = seed
        self.dt = scenario.dt
        self.replicas = replicas
        self.events: list[Event] = []
        self.terrains = Terrains(replicas) if terrains is None else terrains
        terrain = self.terrains.of(scenario.map)
        robots, obstacles = bodies_of(scenario, terrain)
        self.names = tuple(robot.name for robot in robots)
        self.kidnappings = _kidnappings(robots, scenario.dt)
        zones = zone_streams(scenario.zones)
        streams = [(robot.name, *stream) for robot in robots for stream in (*_stream_names(robot), *zones)]
        bodies: list[Robot | Obstacle] = [*robots, *obstacles]
        streams += [(obstacle.name, "motion") for obstacle in obstacles]
        check_collisions(seed, [*streams, *((body.name, "start") for body in bodies if body.start is not None)])
        self.world = world_of(scenario, robots, obstacles, terrain, threads)
        source = str(scenario.source) if scenario.source else ""
        self._placed = bodies
        self._areas: Areas | None = None
        self._starts = starts_in(self.world, bodies, seed, replicas, source)
        try:
            self.groups = [
                Group(*self._rows(members), world=self.world, seed=seed, dt=self.dt, zones=scenario.zones)
                for members in _partition(robots, group_key)
            ]
        except ScenarioError as error:  # of true values; the code that raises it does not know the file
            raise ScenarioError(attrs.evolve(fault, file=fault.file or source) for fault in error.faults) from None
        self.obstacles = [
            ObstacleGroup(*self._rows(members, len(robots)), world=self.world, seed=seed, dt=self.dt)
            for members in _partition(obstacles, lambda obstacle: obstacle.motion and signature(obstacle.motion))
        ]
        self.everything: list[Group | ObstacleGroup] = [*self.groups, *self.obstacles]
        self.parts = [group.parts for group in self.groups if group.parts is not None]
        moved = [group for group in self.obstacles if group.motion is not None]
        self.movement = Movement(self.world, [*(group.locomotion for group in self.groups), *self.parts, *moved])
        self.has_emitters = any(unit.sensor.medium for group in self.groups for unit in group.sensors.values())
        self.upcoming: Any = None  # a snapshot of the next episodes' starts; see `amorsim.simulation.state.restart`
        self.calls: Sequence[Call] = ()  # of a step; see `amorsim.simulation.phases.calls_of`
        self.touching: frozenset[tuple[int, int]] = frozenset()
        self.contacts: frozenset[tuple[int, int]] = frozenset()
        self.ticks: Ints = np.zeros(len(replicas), dtype=np.int64)
        self.episodes: Ints = np.zeros(len(replicas), dtype=np.int64)
        self.place()
        self._check_starts()

    def __getstate__(self) -> dict[str, Any]:
        """All but the calls, which a copy prepares again."""
        return {**vars(self), "calls": ()}

    def release(self) -> None:
        """Drop the calls, so that unused memory is freed at once; they are prepared again when they are needed."""
        self.calls = ()
        for group in self.groups:
            group.unbind()

    def _rows(self, members: Sequence[tuple[int, Any]], offset: int = 0) -> tuple[list[Any], Ints, Ints]:
        """The specification of each row, its body in the world, and its replica's number."""
        specified, bodies, replica = [], [], []
        for index, number in enumerate(self.replicas):
            for position, thing in members:
                body = index * self.world.count + offset + position
                if isinstance(thing, Robot):
                    thing = self._knowing(thing, index)
                is_given = thing.start is None and thing.pose is not None
                specified.append(thing if is_given else with_start(thing, self._starts[body]))
                bodies.append(body)
                replica.append(number)
        return specified, np.array(bodies, dtype=np.int64), np.array(replica, dtype=np.int64)

    def _knowing(self, robot: Robot, index: int) -> Robot:
        """A copy of a robot with the map that it knows in the replica with that index."""
        known = robot.knowledge.map
        if known is None or origin_of(known) is None:
            return robot
        here = self.terrains.of(known).at(index)
        return robot if here is known else attrs.evolve(robot, knowledge=attrs.evolve(robot.knowledge, map=here))

    def draw_starts(self, which: Bools) -> None:
        """Draw the starts of the present episode in the replicas marked in `which` `(R,)`, if any are random."""
        if not any(body.start is not None and body.start.per == "replica" for body in self._placed):
            return
        source = str(self.scenario.source) if self.scenario.source else ""
        if self._areas is None:
            self._areas = Areas(self.world, [body.start for body in self._placed])
        given = self._placed, self._starts, self.seed, self.replicas, self.episodes, which, self._areas, source
        self._starts = draw_starts_again(self.world, *given)
        random = np.array([body.start is not None for body in self._placed])
        for group in self.everything:
            drawn = random[group.bodies % self.world.count]
            group.drawn_start[drawn] = self._starts[group.bodies[drawn]]

    def place(self) -> None:
        """Copy the groups' poses to the bodies of the world."""
        poses, twists = self.world.poses.copy(), self.world.twists
        for group in self.everything:
            poses[group.bodies] = group.true_pose
            twists[group.bodies] = group.true_twist
        for part in self.parts:
            poses[part.bodies] = part.poses
            twists[part.bodies] = part.twists
        self.world.poses = poses

    def _check_starts(self) -> None:
        world = self.world
        none = np.zeros(len(world.everyone))
        gaps, where = world.wall_gaps(world.everyone, world.poses, none)
        faults = []
        for body in np.flatnonzero(gaps < 0.0).tolist():
            x, y, _ = world.poses[body]
            what = "the footprint" if world.owner[body] == body else repr(world.name(body))
            index = int(world.replica_index[body])
            message = overlap_with_walls(world.terrain.at(index), x, y, where[body], what)
            of_replica = f"in replica {self.replicas[index]}, " if len(world.terrain.maps) > 1 else ""
            faults.append(self._start_fault(body, of_replica + message))
        a, b = world.pairs_within(world.poses, none)
        overlaps = world.body_gaps(a, world.poses[a], b, world.poses[b], np.zeros(len(a))) < 0.0
        overlapped: dict[int, list[str]] = {}
        for first, second in zip(a[overlaps].tolist(), b[overlaps].tolist(), strict=True):
            # The message is about the robot of a part, or else the later of the two bodies.
            who, other = (first, second) if int(world.owner[second]) < int(world.owner[first]) else (second, first)
            overlapped.setdefault(who, []).append(world.name(other))
        faults += [self._start_fault(who, overlap_with_others(names)) for who, names in overlapped.items()]
        if faults:
            raise ScenarioError(dict.fromkeys(faults))

    def _start_fault(self, body: int, message: str) -> Fault:
        body = int(self.world.owner[body])
        kind = "robots" if body % self.world.count < len(self.names) else "obstacles"
        source = self.scenario.source
        return Fault(file=str(source) if source else "", path=f"{kind}.{self.world.name(body)}.pose", message=message)

    def robot_bodies(self, group: Group, row: int) -> Ints:
        """The bodies of a robot `(1 + p,)`: its own, and its parts'."""
        own = group.bodies[row : row + 1]
        return np.concatenate((own, self.world.parts_of(own)[0]))

    def overlap(self, group: Group, row: int, poses: Array) -> str:
        """What a robot or one of its parts would overlap if all bodies stood at `poses` `(T, 3)`; empty if nothing."""
        world = self.world
        own = self.robot_bodies(group, row)
        if (world.wall_gaps(own, poses[own], np.zeros(len(own)))[0] < 0.0).any():
            return "a wall"
        mine = int(own[0])
        first = int(world.first[world.replica_index[mine]])
        others = np.arange(first, first + world.count)
        others = others[world.owner[others] != mine]
        a, b = np.repeat(own, len(others)), np.tile(others, len(own))
        gaps = world.body_gaps(a, poses[a], b, poses[b], np.zeros(len(b)))
        return repr(world.name(int(b[int(np.argmax(gaps < 0.0))]))) if (gaps < 0.0).any() else ""

    def tell_time(self) -> None:
        """Set the clocks of all groups to the present ticks and episodes, and start the tick's draws."""
        for group in self.everything:
            index = self.world.replica_index[group.bodies]
            group.row_clock.set_tick(self.ticks[index][:, None])
            group.row_clock.set_episode(self.episodes[index])
            group.streams.rewind()

    def advance(self) -> None:
        """Go to the next tick in all replicas, and start the tick's draws."""
        self.ticks = self.ticks + 1
        for group in self.everything:
            group.row_clock.advance()
            group.streams.rewind()

    def log(self, group: Group | ObstacleGroup, row: int, kind: str, fraction: float = 0.0, **fields: Any) -> None:
        """Append an event of a robot or an obstacle: now, or at a fraction of the step that is being made."""
        index = int(self.world.replica_index[group.bodies[row]])
        tick = int(self.ticks[index])
        time, replica, name = (tick + fraction) * self.dt, self.replicas[index], group.names[row]
        self.events.append(Event(tick=tick, time=time, replica=replica, kind=kind, name=name, **fields))

    def end_controller(self, group: Group, row: int, fraction: float = 0.0) -> None:
        """Let a robot stand still from now on; if it has a controller, that is an event."""
        group.driver.end(row)
        if group.driver.controller is not None:
            self.log(group, row, "controller_ended", fraction)

    def part_from_all(self, body: int) -> None:
        """End all contacts of a robot and its parts: touching the same body again is a new collision."""
        owner = self.world.owner
        self.contacts = frozenset(
            pair for pair in self.contacts if all(owner[one] != body for one in pair if one != WALL)
        )

    def row_of(self, body: int) -> tuple[Group | ObstacleGroup, int]:
        """The group of a body, and its row there."""
        for group in self.everything:
            row = int(np.searchsorted(group.bodies, body))
            if row < len(group.bodies) and group.bodies[row] == body:
                return group, row
        raise LookupError(body)

    def body_of(self, name: str, index: int) -> int:
        """The body of a robot or an obstacle in the replica of that index."""
        return int(self.world.first[index]) + self.world.names.index(name)

    def robot_row(self, name: str, index: int) -> tuple[Group, int]:
        """The group and row of a robot in the replica of that index."""
        group, row = self.row_of(self.body_of(name, index))
        assert isinstance(group, Group)
        return group, row


def _kidnappings(robots: Sequence[Robot], dt: float) -> dict[int, list[tuple[str, tuple[float, ...]]]]:
    found: dict[int, list[tuple[str, tuple[float, ...]]]] = {}
    for robot in robots:
        for one in robot.kidnappings:
            tick = math.ceil(one.time / dt - 1e-9)
            found.setdefault(tick, []).append((robot.name, (one.x, one.y, one.heading)))
    return found


def _partition(things: Sequence[Any], key: Callable[[Any], Any]) -> list[list[tuple[int, Any]]]:
    """Things with their positions, grouped by key, in order of each group's first."""
    parts: dict[Any, list[tuple[int, Any]]] = {}
    for position, thing in enumerate(things):
        parts.setdefault(key(thing), []).append((position, thing))
    return list(parts.values())


def _stream_names(robot: Robot) -> list[tuple[str, ...]]:
    names: list[tuple[str, ...]] = [("drive",), ("controller",), BELIEF]
    names += [("estimator", name) for name in robot.estimators]
    names += [("ground", "noise", element.name) for element in robot.ground]
    for name, unit in robot.sensors.items():
        names += [("sensor", name), *(("sensor", name, "noise", element.name) for element in unit.noise)]
    names += [("errors", path, role) for path in robot.errors for role in ("scale", "add", "value")]
    return names
