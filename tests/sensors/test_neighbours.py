"""What robots tell one another: places, velocities and sizes, the nearest first."""

from __future__ import annotations

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.sensors.neighbours import Neighbours
from tests import building


def table(*others: am.Robot, obstacles: tuple[am.Obstacle, ...] = (), **changes: float) -> np.ndarray:
    """What a robot at (2, 2) that looks along y hears of others; its mount is 0.1 m ahead."""
    sensor = am.MountedSensor(sensor=Neighbours(slots=3, **changes), mount=am.Mount(x=0.1))
    rover = building.robot(pose=am.Pose(x=2.0, y=2.0, heading=math.pi / 2), sensors={"radio": sensor}, estimators={})
    simulation = am.Simulation(building.scenario(rover, *others, obstacles=obstacles))
    return simulation.robot("rover").readings["radio"].measured.reshape(3, 6)


def disc(name: str, x: float, y: float, radius: float = 0.2) -> am.Robot:
    return building.robot(name=name, pose=am.Pose(x=x, y=y), shape=am.Shape.circle(radius))


def test_places_are_in_the_frame_of_the_mount_and_the_nearest_is_first() -> None:
    heard = table(disc("far", 2.0, 4.1, radius=0.3), disc("near", 3.0, 2.1))
    np.testing.assert_allclose(heard[0], [1.0, 0.0, -1.0, 0.0, 0.0, 0.2], atol=1e-12)
    np.testing.assert_allclose(heard[1], [2.0, 2.0, 0.0, 0.0, 0.0, 0.3], atol=1e-12)
    assert heard[2].tolist() == [math.inf, math.inf, math.inf, 0.0, 0.0, 0.0]


def test_of_more_than_there_are_slots_for_the_farthest_are_left_out() -> None:
    heard = table(*(disc(f"r{n}", 2.0 + 0.6 * n, 1.2) for n in range(4)))
    ranges = sorted(math.hypot(0.6 * n, 0.9) for n in range(4))
    np.testing.assert_allclose(heard[:, 0], ranges[:3], atol=1e-12)


def test_who_is_out_of_reach_and_what_is_no_robot_is_not_heard() -> None:
    post = am.Obstacle(name="post", shape=am.Shape.circle(0.1), pose=am.Pose(x=3.0, y=2.0))
    assert np.isinf(table(disc("far", 4.0, 3.0), obstacles=(post,), range_max=1.5)[:, 0]).all()


def test_velocities_are_over_ground() -> None:
    sensor = am.MountedSensor(sensor=Neighbours(slots=1))
    rover = building.robot(pose=am.Pose(x=2.0, y=2.0, heading=math.pi / 2), sensors={"radio": sensor}, estimators={})
    simulation = am.Simulation(building.scenario(rover, disc("other", 3.0, 3.0)))
    other = simulation.robot("other")
    other.drive(forward=0.3)
    simulation.run(1.0)
    speed = other.true_twist[0]
    assert speed == pytest.approx(0.3, rel=0.05)
    # It drives along x, which is to the right of a robot that looks along y.
    assert simulation.robot("rover").readings["radio"].measured[3:5] == pytest.approx([0.0, -speed], abs=1e-9)
