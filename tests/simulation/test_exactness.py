"""With no errors and no noise the estimate is the truth; with one error the drift is the closed form's."""

from __future__ import annotations

import math

import numpy as np
import pytest

import amorsim as am
from tests import building


def roam(steps: int, seed: int, size: float = 6.0) -> tuple[am.Simulation, float]:
    """Drive at random in a room of this size [m]; the simulation, and how far the left wheel rolled in all [m]."""
    robot = building.robot(controller=building.Roam(rate=12.0), on_collision="continue")
    sim = am.Simulation(building.scenario(robot, map=building.room(size, size), dt=0.1), seed=seed)
    rolled, before = 0.0, 0.0
    for _ in range(steps):
        sim.step()
        now = float(sim.robot("rover").joints[0])
        rolled, before = rolled + abs(now - before) * building.RADIUS, now
    return sim, rolled


def check_estimate_is_truth(sim: am.Simulation) -> None:
    offset = sim.true_pose - sim.estimated_pose
    assert np.abs(offset[:, :2]).max() < 1e-7
    assert np.abs(np.sin(offset[:, 2])).max() < 1e-9


def test_without_errors_the_estimate_is_the_truth() -> None:
    sim, _ = roam(1500, seed=1)
    assert any(event.kind == "collision" for event in sim.events)  # else the test would not try that
    check_estimate_is_truth(sim)


@pytest.mark.long
def test_over_a_kilometre_with_collisions() -> None:
    sim, rolled = roam(30_000, seed=2, size=25.0)
    assert rolled > 1000.0
    assert sum(event.kind == "collision" for event in sim.events) > 100
    check_estimate_is_truth(sim)


@pytest.mark.parametrize("dt", [0.01, 0.1, 0.5])
def test_a_larger_left_wheel_bends_the_path_as_it_must(dt: float) -> None:
    errors = {"drive.wheel_radius_left": am.Deviation(scale=1.01)}
    robot = building.robot(errors=errors, pose=am.Pose())
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=dt))
    rate = 4.0  # rad/s of both wheels
    sim.robot("rover").command(rate, rate)
    duration = 10.0
    sim.run(duration)
    left, right = rate * 1.01 * building.RADIUS * duration, rate * building.RADIUS * duration
    forward, turn = (left + right) / 2.0, (right - left) / building.TRACK
    # The robot believes that both wheels are equal, and that it drove straight.
    assert sim.estimated_pose[0] == pytest.approx([rate * building.RADIUS * duration, 0.0, 0.0], abs=1e-9)
    expected = [forward * math.sin(turn) / turn, forward * (1.0 - math.cos(turn)) / turn, turn]
    assert sim.true_pose[0] == pytest.approx(expected, abs=1e-9)


def test_a_wider_true_track_turns_less_than_believed() -> None:
    errors = {"drive.track": am.Deviation(add=0.01)}
    robot = building.robot(errors=errors, pose=am.Pose())
    sim = am.Simulation(building.scenario(robot, map=building.empty()))
    sim.robot("rover").command(-2.0, 2.0)
    sim.run(2.0)
    arc = 2.0 * building.RADIUS * 2.0 * 2.0
    assert sim.estimated_pose[0, 2] == pytest.approx(arc / building.TRACK, abs=1e-9)
    assert sim.true_pose[0, 2] == pytest.approx(arc / (building.TRACK + 0.01), abs=1e-9)


def test_a_turned_laser_reads_other_walls_than_the_robot_believes() -> None:
    laser = am.sensors.Laser(beams=1, fov=0.1, range_max=20.0)
    sensors = {"encoder": building.encoder(), "laser": am.MountedSensor(sensor=laser)}
    errors = {"sensors.laser.mount.heading": am.Deviation(add=math.radians(30.0))}
    robot = building.robot(sensors=sensors, errors=errors, pose=am.Pose(x=2.0, y=2.0))
    sim = am.Simulation(building.scenario(robot))
    distance = 6.0 - 2.0
    assert sim.robot("rover").readings["laser"].true[0] == pytest.approx(distance / math.cos(math.pi / 6), abs=0.002)
    assert sim._fleet.groups[0].robot.sensors["laser"].mount.heading[0, 0] == 0.0


@pytest.mark.parametrize("dt", [0.02, 0.1])
def test_commands_in_rates_make_the_exact_circle(dt: float) -> None:
    sim = am.Simulation(building.scenario(building.robot(pose=am.Pose()), map=building.empty(), dt=dt))
    speed, turn = 0.5, 0.5
    sim.robot("rover").drive(forward=speed, turn=turn)
    for _ in range(round(2 * math.pi / turn / dt)):
        sim.step()
    angle = turn * sim.time
    expected = [speed / turn * math.sin(angle), speed / turn * (1 - math.cos(angle))]
    assert sim.true_pose[0, :2] == pytest.approx(expected, abs=1e-9)
