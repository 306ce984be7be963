"""The tricycle against the geometry of its wheels."""

import itertools
import math

import numpy as np
import pytest
from example_world import Hold, open_ground, robot, simulation, tricycle

import amorsim as am
from amorsim.core.rows import stack


@pytest.mark.parametrize(("steering", "rate"), [(0.5, 4.0), (-0.9, 4.0), (0.5, -3.0)])
def test_it_drives_circles_about_the_point_abeam_of_the_rear_axle(steering: float, rate: float) -> None:
    sim = simulation(robot(controller=Hold(channels=(steering, rate))))
    radius = 0.5 / math.tan(steering)
    for _ in range(10):  # until the steering is there
        sim.step()
    centres, headings = [], []
    for _ in range(100):
        sim.step()
        x, y, heading = sim.true_pose[0]
        centres.append((x - radius * math.sin(heading), y + radius * math.cos(heading)))
        headings.append(heading)
    np.testing.assert_allclose(centres, np.broadcast_to(centres[0], (100, 2)), rtol=0, atol=1e-10)
    # The front wheel rolls along a circle of its own about that point.
    turned = np.diff(np.unwrap(headings))
    front = math.copysign(0.5 / math.sin(abs(steering)), steering)
    np.testing.assert_allclose(turned, rate * 0.1 * 0.1 / front, rtol=1e-9)


def test_steps_in_which_the_steering_moves_are_of_second_order() -> None:
    drive = _rows(tricycle())
    start, end = np.array([0.1, 0.0]), np.array([0.3, 5.0])
    # The plain integral of the way and the turn of the base, by the midpoint rule.
    n = 200_000
    s = 0.1 + 0.2 * (np.arange(n) + 0.5) / n
    way = 5.0 * 0.1 / n
    turn = way * np.sin(s) / 0.5
    heading = np.cumsum(turn) - 0.5 * turn
    expected = [(way * np.cos(s) * np.cos(heading)).sum(), (way * np.cos(s) * np.sin(heading)).sum(), turn.sum()]

    def error(steps: int) -> float:
        joints = start + (end - start) * np.linspace(0.0, 1.0, steps + 1)[:, None]
        pose = np.zeros((1, 3))
        for before, after in itertools.pairwise(joints):
            pose = am.compose(pose, drive.displacement(before[None], after[None], np.ones((1, 1))))
        return float(np.abs(pose[0] - expected).max())

    assert error(64) < 1e-5
    assert error(32) / error(64) == pytest.approx(4.0, rel=0.02)


def test_at_a_right_angle_it_turns_in_place() -> None:
    sim = simulation(robot(controller=Hold(channels=(math.pi / 2, 5.0))))
    sim.run(1.0)  # until the steering is there
    before = sim.true_pose.copy()
    sim.run(2.0)
    # The front wheel rolls 5 rad/s * 0.1 m for 2 s on a circle of 0.5 m about the base.
    np.testing.assert_allclose(am.relative(before, sim.true_pose), [[0.0, 0.0, 2.0]], rtol=0, atol=1e-12)


def test_the_steering_moves_at_its_rate_and_the_wheel_waits_for_it() -> None:
    sim = simulation(robot(controller=Hold(channels=(0.7, 4.0))))
    joints = []
    for _ in range(5):
        sim.step()
        joints.append(sim.robot("lift").joints.copy())
    np.testing.assert_allclose([joint[0] for joint in joints], [0.2, 0.4, 0.6, 0.7, 0.7], rtol=0, atol=1e-15)
    np.testing.assert_allclose([joint[1] for joint in joints], [0.0, 0.0, 0.0, 0.4, 0.8], rtol=0, atol=1e-15)


def test_exact_encoders_tell_the_truth_also_at_a_wall() -> None:
    turning = Hold(channels=(0.4, 9.0))
    sim = simulation(robot(controller=turning), map=open_ground((1.4, -5.0, 1.4, 5.0)))
    sim.run(10.0)
    assert [event.kind for event in sim.events][:1] == ["collision"]
    assert sim.true_pose[0, 0] > 0.5
    np.testing.assert_allclose(sim.estimated_pose, sim.true_pose, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    "twist", [(0.3, 0.0, 0.0), (0.3, 0.0, 0.4), (-0.3, 0.0, 0.4), (-0.2, 0.0, -0.1), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
)
def test_the_command_for_a_motion_makes_it(twist: tuple[float, float, float]) -> None:
    drive = _rows(tricycle())
    wanted = np.array([twist])
    command = drive.command_for(wanted, np.zeros((1, 2)))
    assert abs(command[0, 0]) <= math.pi / 2
    steered = np.array([[command[0, 0], 0.0]])
    rolled = np.array([[command[0, 0], command[0, 1]]])
    np.testing.assert_allclose(drive.twist(steered, rolled), wanted, rtol=0, atol=1e-12)


def test_beyond_its_limits_the_command_is_the_nearest() -> None:
    drive = _rows(tricycle(steering_max=0.6))
    wanted = np.array([[0.1, 0.0, 0.8]])  # the front wheel at (0.1, 0.4) m/s: 76 degrees
    command = drive.command_for(wanted, np.zeros((1, 2)))
    assert command[0, 0] == 0.6
    velocity = command[0, 1] * 0.1 * np.array([math.cos(0.6), math.sin(0.6)])
    off = np.hypot(*(velocity - (0.1, 0.4)))
    for rate in np.linspace(-10.0, 10.0, 2001):
        other = rate * 0.1 * np.array([math.cos(0.6), math.sin(0.6)])
        assert np.hypot(*(other - (0.1, 0.4))) >= off - 1e-12


def test_at_rest_the_steering_stays() -> None:
    drive = _rows(tricycle())
    np.testing.assert_array_equal(drive.command_for(np.zeros((1, 3)), np.array([[0.3, 7.0]])), [[0.3, 0.0]])


def _rows(drive: am.Drive) -> am.Drive:
    """The drive as a run holds it: its numbers are arrays over rows, here of one."""
    return stack([drive])
