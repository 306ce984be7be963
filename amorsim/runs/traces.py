"""The paths of robots as pictures want them; those of a run's first replica are kept in memory for its summary."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Frame
from amorsim.core.poses import compose
from amorsim.core.shapes import Shape
from amorsim.render.obstacles import Thing
from amorsim.render.robot_paths import RobotPath
from amorsim.scenario.colours import robot_colours
from amorsim.scenario.spec import Scenario
from amorsim.simulation.simulation import Simulation

__all__ = ["Traces", "collisions_of", "paths_at_start", "paths_of", "things_at_start", "things_of"]


LARGEST = 2_000_000  # points kept, over all robots
FEWEST = 1000  # of each robot, however many there are
_NUMBERS = 1 << 14  # that wait at most, but for a step's


MOST_LABELS = 40  # landmarks that are labelled with their numbers


class Traces:
    """The paths of the first replica's robots; very long ones keep every second, fourth ... point."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._count = len(simulation.names)
        self._most = max(FEWEST, LARGEST // (2 * self._count))
        self._every = 1
        self._seen = 0
        self._distance = np.zeros(self._count)
        frames = simulation.frames()
        # The first replica's rows come first in every group.
        rows = [int(np.count_nonzero(frame.replica == simulation.replicas[0])) for frame in frames]
        names = [name for frame, count in zip(frames, rows, strict=True) for name in frame.names[:count]]
        self._order = np.array([names.index(name) for name in simulation.names])
        # Steps as they come, and how many: of each group poses, estimated poses and twists.
        most = max(1, _NUMBERS // (9 * self._count))
        self._tables = [np.empty((most, 3, count, 3)) for count in rows]
        self._waiting = 0
        self._take(frames)
        points, _ = self._sorted()
        self._kept = [points[0]]  # (M, 4) each: true x and y, estimated x and y [m]
        self._last = points[0]
        self._waiting = 0

    def keep(self, frames: Sequence[Frame]) -> None:
        """Take the present step."""
        self._take(frames)
        if self._waiting == len(self._tables[0]):
            self._settle()

    def _take(self, frames: Sequence[Frame]) -> None:
        for frame, table in zip(frames, self._tables, strict=True):
            poses, twists = frame.true_pose, frame.true_twist
            estimated = next(iter(frame.estimates.values())).pose
            rows = table.shape[2]
            if len(poses) > rows:  # of several replicas
                poses, estimated, twists = poses[:rows], estimated[:rows], twists[:rows]
            table[self._waiting, 0] = poses
            table[self._waiting, 1] = estimated
            table[self._waiting, 2] = twists
        self._waiting += 1

    def _sorted(self) -> tuple[Array, Array]:
        """Of the steps that wait, points `(S, M, 4)` and speeds `(S, M)` [m/s], in the order of the robots' names."""
        points, speeds = [], []
        for table in self._tables:
            part = table[: self._waiting]
            points.append(np.concatenate((part[:, 0, :, :2], part[:, 1, :, :2]), axis=2))
            # From the velocity, not from positions: `set_pose` may have moved the robot.
            speeds.append(np.hypot(part[:, 2, :, 0], part[:, 2, :, 1]))
        return np.concatenate(points, axis=1)[:, self._order], np.concatenate(speeds, axis=1)[:, self._order]

    def _settle(self) -> None:
        """Turn the waiting steps into kept points."""
        if not self._waiting:
            return
        points, speeds = self._sorted()
        self._waiting = 0
        driven = np.concatenate((self._distance[None], speeds * self._simulation.dt))
        self._distance = np.add.accumulate(driven, axis=0)[-1]  # one step after the other, however many wait
        self._last = points[-1]
        for now in points:
            self._seen += 1
            if self._seen % self._every == 0:
                self._kept.append(now)
            if len(self._kept) > self._most:
                self._kept = self._kept[::2]
                self._every *= 2

    @property
    def distance(self) -> Array:
        """Distance that each robot has driven [m] `(M,)`, over all steps."""
        self._settle()
        return self._distance

    def errors(self) -> Array:
        """Distance between true and estimated positions at the end [m] `(M,)`."""
        self._settle()
        apart: Array = np.hypot(self._last[:, 0] - self._last[:, 2], self._last[:, 1] - self._last[:, 3])
        return apart

    def paths(self) -> list[RobotPath]:
        """The paths as pictures want them, in order of the robots' names."""
        self._settle()
        points = np.array([*self._kept, self._last])
        return paths_of(self._simulation, self._simulation.replicas[0], points[..., :2], points[..., 2:])

    def things(self) -> list[Thing]:
        """The obstacles in the first replica now, as pictures want them."""
        return things_of(self._simulation, self._simulation.replicas[0])


def paths_of(simulation: Simulation, replica: int, true: Array, estimated: Array) -> list[RobotPath]:
    """Paths `(T, M, 2)` [m] of a replica's M robots as pictures want them, in order of the robots' names.

    The robots' outlines are where they are now, and so are the collisions.
    """
    robots = {robot.name: robot for robot in simulation.scenario.robots}
    colours = robot_colours(simulation.scenario.robots)
    found = []
    for i, name in enumerate(simulation.names):
        handle = simulation.robot(name, replica)
        found.append(
            RobotPath(
                name=name,
                true=true[:, i],
                estimated=estimated[:, i],
                outline=_placed(robots[name].shape, handle.true_pose[None]),
                collisions=collisions_of(simulation, name, replica),
                parts=[_placed(part.shape, handle.parts[part.name][None]) for part in handle.true.drive.parts],
                colour=colours[name],
            )
        )
    return found


def collisions_of(simulation: Simulation, name: str, replica: int) -> Array:
    """Where a robot of a replica met something [m] `(K, 2)`."""
    points = [
        event.point
        for event in simulation.events
        if event.kind == "collision" and event.name == name and event.replica == replica and event.point
    ]
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def things_of(simulation: Simulation, replica: int) -> list[Thing]:
    """The obstacles of a replica where they are now, the landmarks and the lamps, as pictures want them."""
    scenario = simulation.scenario
    poses = [simulation.obstacle(obstacle.name, replica).true_pose for obstacle in scenario.obstacles]
    return _things(scenario, poses)


def paths_at_start(scenario: Scenario) -> list[RobotPath]:
    """The robots at their starts, in the form for pictures; without those whose start is still unknown."""
    colours = robot_colours(scenario.robots)
    found = []
    for robot in scenario.robots:
        if robot.pose is None:
            continue
        pose = np.array([[robot.pose.x, robot.pose.y, robot.pose.heading]])
        outline = _placed(robot.shape, pose)
        found.append(RobotPath(name=robot.name, true=(), outline=outline, colour=colours[robot.name]))
    return found


def things_at_start(scenario: Scenario) -> list[Thing]:
    """The obstacles of a scenario at their starts, the landmarks and the lamps, as pictures want them."""
    poses = [np.array([each.pose.x, each.pose.y, each.pose.heading]) for each in scenario.obstacles]
    return _things(scenario, poses)


def _things(scenario: Scenario, poses: Sequence[Array]) -> list[Thing]:
    """Obstacles at given poses, landmarks and lamps."""
    found = []
    for obstacle, pose in zip(scenario.obstacles, poses, strict=True):
        outline = _placed(obstacle.shape, pose[np.newaxis])
        found.append(Thing(kind="obstacle", place=pose[:2], outline=outline, colour=obstacle.colour))
    labelled = len(scenario.landmarks) <= MOST_LABELS
    found += [
        Thing(
            kind="landmark",
            place=(mark.x, mark.y),
            radius=mark.radius,
            colour=mark.colour,
            label=str(mark.id) if labelled else "",
        )
        for mark in scenario.landmarks
    ]
    return found + [Thing(kind="lamp", place=(light.x, light.y)) for light in scenario.lights]


def _placed(shape: Shape, pose: Array) -> Array:
    """The outline `(V, 2)` of a body at a pose `(1, 3)`, in the world."""
    outline = shape.outline
    corners = np.column_stack((outline, np.zeros(len(outline))))
    return compose(np.repeat(pose, len(corners), axis=0), corners)[:, :2]
