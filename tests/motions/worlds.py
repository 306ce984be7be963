"""Obstacles with motions in an empty room, and where they were at each step."""

from __future__ import annotations

from typing import Any

import numpy as np

import amorsim as am
from tests import building

DT = 0.1


def obstacle(motion: Any, *, name: str = "thing", shape: am.Shape | None = None, **others: Any) -> am.Obstacle:
    return am.Obstacle(name=name, shape=shape or am.Shape.circle(0.2), motion=motion, **others)


def world(
    *obstacles: am.Obstacle, robot: am.Robot | None = None, size: float = 10.0, dt: float = DT, **changes: Any
) -> am.Simulation:
    """A room with its lower left corner at the origin; a robot stands out of the way, in its upper right one."""
    robot = robot or building.robot(pose=am.Pose(x=size - 0.5, y=size - 0.5), on_collision="continue")
    room = building.room(size, size, 0.01)
    return am.Simulation(building.scenario(robot, map=room, obstacles=obstacles, dt=dt), **changes)


def track(sim: am.Simulation, steps: int, name: str = "thing") -> np.ndarray:
    """Its poses `(steps + 1, 3)`, from the present one on."""
    poses = [sim.obstacle(name).true_pose.copy()]
    for _ in range(steps):
        sim.step()
        poses.append(sim.obstacle(name).true_pose.copy())
    return np.array(poses)
