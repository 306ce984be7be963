"""A scan that takes its time: each beam from where the robot was when it looked."""

import math
import types

import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Aim
from amorsim.core.poses import compose, exponential, relative
from amorsim.noise import AimGaussian, MotionDistortion
from amorsim.sensors.beam_poses import poses_at
from amorsim.sensors.laser import Laser
from amorsim.sensors.sonar import Sonar
from tests import building
from tests.noise.sampling import Samples

WIDTH, HEIGHT = 6.0, 5.0
SWEEP = 0.08


def distance(x, y, heading):
    """To the walls of the room, which are lines here and cells of 1 mm there."""
    c, s = np.cos(heading), np.sin(heading)
    with np.errstate(divide="ignore"):
        to_x = np.where(c > 0.0, (WIDTH - x) / c, -x / c)
        to_y = np.where(s > 0.0, (HEIGHT - y) / s, -y / s)
    return np.minimum(to_x, to_y), np.where(to_x < to_y, np.abs(c), np.abs(s))


def drive(sensor, *, forward=0.0, turn=0.0, sweep=SWEEP, mount=None):
    unit = am.MountedSensor(
        sensor=sensor, mount=mount or am.Mount(), noise=building.chain(MotionDistortion(sweep=sweep))
    )
    robot = building.robot(sensors={"encoder": building.encoder(), "range": unit})
    sim = am.Simulation(building.scenario(robot))
    sim.robot("rover").drive(forward=forward, turn=turn)
    sim.run(0.5)
    return sim


def test_the_beams_times_run_from_the_sweep_before_to_now():
    samples = Samples(MotionDistortion(sweep=0.3), rows=2)
    aim = samples.noise.aim(Aim(), np.zeros((2, 1)), samples.state, samples.draws)
    np.testing.assert_allclose(aim.time, [[-0.3, -0.2, -0.1, 0.0]] * 2, atol=1e-15)
    again = samples.noise.aim(aim, np.zeros((2, 1)), samples.state, samples.draws)
    np.testing.assert_allclose(again.time, 2.0 * aim.time)
    bent = Samples(AimGaussian(std=0.1), rows=2)
    both = bent.noise.aim(aim, np.zeros((2, 1)), bent.state, bent.draws)
    assert both.time is aim.time  # one who bends beams leaves their times alone
    assert both.bearing.shape == (2, 4)


@pytest.mark.parametrize(("forward", "turn"), [(0.6, 0.0), (0.0, 1.5), (0.5, -1.0)])
def test_each_beam_is_cast_from_where_the_laser_was(forward, turn):
    """Against the room's own geometry, and the arc that the robot drives, integrated backwards."""
    laser = Laser(beams=91, fov=math.radians(270.0), range_max=20.0)
    sim = drive(laser, forward=forward, turn=turn, mount=am.Mount(x=0.2, y=-0.05, heading=0.1))
    x, y, heading = sim.true_pose[0]
    time = np.linspace(-SWEEP, 0.0, 91)
    then = heading + turn * time
    if turn:
        x_then = x + forward / turn * (np.sin(then) - math.sin(heading))
        y_then = y - forward / turn * (np.cos(then) - math.cos(heading))
    else:
        x_then, y_then = x + forward * time * math.cos(heading), y + forward * time * math.sin(heading)
    x_then, y_then = (
        x_then + 0.2 * np.cos(then) + 0.05 * np.sin(then),
        y_then + 0.2 * np.sin(then) - 0.05 * np.cos(then),
    )
    expected, slope = distance(x_then, y_then, then + 0.1 + laser.bearings()[0])
    reading = sim.robot("rover").readings["range"]
    # A wall fills the cells that its line touches, one on each side: the faces are within a cell of the line.
    assert (np.abs(reading.measured - expected) <= 0.0011 / slope).all()
    assert np.abs(reading.measured - reading.true).max() > 0.02
    assert reading.measured[-1] == reading.true[-1]


def test_the_elements_of_a_ring_fire_one_after_another():
    sim = drive(building.ring(8), forward=0.6)
    reading = sim.robot("rover").readings["range"]
    x, y, heading = sim.true_pose[0]
    time = np.linspace(-SWEEP, 0.0, 8)
    mounts = np.arange(8) * (2.0 * math.pi / 8)
    ahead = 0.1 + 0.6 * time
    expected, slope = distance(x + ahead * math.cos(heading), y + ahead * math.sin(heading), heading + mounts)
    # The cone's edges, a degree to each side, may be nearer by this much.
    slack = 0.0011 / slope + expected * math.radians(1.0) * np.sqrt(1.0 / slope**2 - 1.0) * 1.05 + expected * 2e-4
    measured = np.where(np.isinf(reading.measured), expected, reading.measured)
    assert np.isfinite(reading.measured).sum() >= 6
    assert (np.abs(measured - expected) <= slack).all()


@pytest.mark.parametrize("sensor", [Laser(beams=31), Sonar(half_angle=0.1)])
def test_a_sweep_of_no_time_leaves_every_bit_and_so_does_standing_still(sensor):
    askew = am.Mount(x=0.13, y=-0.07, heading=0.3)
    moving = drive(sensor, forward=0.5, turn=0.7, sweep=0.0, mount=askew).robot("rover").readings["range"]
    assert moving.measured.tobytes() == moving.true.tobytes()
    still = drive(sensor).robot("rover").readings["range"]
    np.testing.assert_allclose(still.measured, still.true, rtol=1e-9)


def test_what_looks_now_stands_where_it_stands_to_the_last_bit():
    random = np.random.default_rng(5)
    body, poses, twist = (random.uniform(-3.0, 3.0, (500, 3)) for _ in range(3))
    view = types.SimpleNamespace(body_pose=body, twist=twist)
    assert poses_at(view.body_pose, view.twist, poses, np.zeros((500, 1))).tobytes() == poses.tobytes()
    # The way there and back again: the body moves by its twist, and the pose with it.
    before = poses_at(view.body_pose, view.twist, poses, np.full((500, 1), -0.2))
    moved = compose(body, exponential(twist, np.full((500, 1), -0.2)))
    np.testing.assert_allclose(relative(moved, before), relative(body, poses), atol=1e-12)
