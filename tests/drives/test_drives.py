"""What holds for every drive that comes with amorsim."""

from __future__ import annotations

import numpy as np
import pytest

from amorsim.contracts import Draws
from amorsim.core.poses import compose, relative
from amorsim.core.rows import stack
from tests.drives.fleet import MAKERS, make

NO_DRAWS = Draws(np.zeros(1, dtype=np.uint64), np.zeros((1, 3), dtype=np.uint32))
ONE = np.ones((1, 1))

# Commands that go round, and the speed and turn of the body (or of its course) that they are to make.
ROUND = {
    "differential": ([4.0, 6.0], 0.08 * 5.0, 0.08 * 2.0 / 0.32),
    "ackermann rear": ([0.35, 5.0], 0.5, 0.5 * np.tan(0.35) / 0.5),
    "ackermann front": ([0.35, 5.0], 0.5, 0.5 * np.tan(0.35) / 0.5),
    "ackermann centre": ([-0.35, 5.0], 0.5, -0.5 * np.tan(0.35) / 0.5),
    "synchro fixed": ([0.5, 6.0], 0.36, 0.5),
    "synchro follows": ([0.5, 6.0], 0.36, 0.5),
    "synchro driven": ([0.5, 6.0, 0.3], 0.36, 0.5),
    "tricycle": ([0.8, 5.0], 0.5 * np.cos(0.8), 0.5 * np.sin(0.8) / 0.6),
    "tractor": ([4.0, 6.0], 0.08 * 5.0, 0.08 * 2.0 / 0.32),
}
EVERY = sorted(MAKERS)


def advance(drive, joints, rates, command, dt):
    return drive.advance(joints, rates, np.array([command], dtype=float), dt, {}, NO_DRAWS)


def settle(drive, command, seconds=20.0, dt=0.1):
    """Joints and rates after a while under a command."""
    joints = rates = np.zeros((1, len(drive.joints)))
    for _ in range(round(seconds / dt)):
        before = joints
        joints, rates = advance(drive, joints, rates, command, dt)
        joints = drive.follow(joints, drive.displacement(before, joints, ONE))
    return joints, rates


def go(drive, joints, rates, command, seconds, steps):
    """The body's displacement from some joints on, and the joints in the end."""
    pose = np.zeros((1, 3))
    for _ in range(steps):
        before = joints
        joints, rates = advance(drive, joints, rates, command, seconds / steps)
        moved = drive.displacement(before, joints, ONE)
        pose, joints = compose(pose, moved), drive.follow(joints, moved)
    return pose[0], joints


@pytest.mark.parametrize("name", sorted(ROUND))
@pytest.mark.parametrize("steps", [1, 7, 100])
def test_a_constant_command_drives_the_exact_circle_whatever_the_step(name, steps):
    drive = stack([make(name)])
    command, speed, turn = ROUND[name]
    joints, rates = settle(drive, command)
    course = drive.heading_offset(joints)
    course = 0.0 if course is None else course[0, 0]
    seconds = 4.0
    pose, _ = go(drive, joints, rates, command, seconds, steps)
    radius = speed / turn
    x = radius * (np.sin(course + turn * seconds) - np.sin(course))
    y = -radius * (np.cos(course + turn * seconds) - np.cos(course))
    assert pose[:2] == pytest.approx([x, y], abs=1e-12)
    heads = {"synchro fixed": 0.0, "synchro driven": 0.3 * seconds}.get(name, turn * seconds)
    assert np.sin(0.5 * (pose[2] - heads)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", sorted(ROUND))
@pytest.mark.parametrize("steps", [3, 11])
def test_a_full_circle_returns(name, steps):
    drive = stack([make(name)])
    command, _, turn = ROUND[name]
    joints, rates = settle(drive, command)
    pose, _ = go(drive, joints, rates, command, 2.0 * np.pi / abs(turn), steps)
    assert pose[:2] == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("name", EVERY)
def test_a_command_for_a_motion_makes_that_motion(name):
    drive = stack([make(name)])
    for forward, turn in ((0.3, 0.2), (0.25, -0.3), (-0.3, 0.1), (0.4, 0.0)):
        wanted = np.array([[forward, 0.0, turn]])
        joints = np.zeros((1, len(drive.joints)))
        command = drive.command_for(wanted, joints)
        joints, rates = settle(drive, command[0], seconds=10.0)
        course = drive.heading_offset(joints)
        pose, after = go(drive, joints, rates, command[0], 0.5, 1)
        if course is None:
            assert drive.twist(joints, after)[0] == pytest.approx(0.5 * wanted[0], abs=1e-12)
        else:
            assert (drive.heading_offset(after) + pose[2] - course)[0, 0] == pytest.approx(0.5 * turn, abs=1e-12)
            assert (after - joints)[0, 1] * drive.wheel_radius[0, 0] == pytest.approx(0.5 * forward, abs=1e-12)


def test_mecanum_wheels_go_any_way():
    drive = stack([make("mecanum")])
    wanted = np.array([[0.2, -0.3, 0.4]])
    command = drive.command_for(wanted, np.zeros((1, 4)))
    joints, rates = settle(drive, command[0])
    _, after = go(drive, joints, rates, command[0], 1.0, 1)
    assert drive.twist(joints, after)[0] == pytest.approx(wanted[0], abs=1e-12)
    # Rollers of 45 degrees: purely aside the wheels of a diagonal turn alike.
    aside = drive.command_for(np.array([[0.0, 1.0, 0.0]]), np.zeros((1, 4)))[0]
    assert aside.tolist() == [-20.0, 20.0, 20.0, -20.0]


def test_mecanum_wheels_do_not_work_against_one_another():
    drive = stack([make("mecanum")])
    after, _ = advance(drive, np.zeros((1, 4)), np.zeros((1, 4)), [5.0, 5.0, -5.0, -5.0], 1.0)
    np.testing.assert_allclose(after, 0.0, atol=1e-15)


@pytest.mark.parametrize("name", EVERY)
def test_parts_of_a_step_add_up_to_it(name):
    """Also while the steering moves: a path is one path, wherever it is cut."""
    drive = stack([make(name)] * 50)
    rng = np.random.default_rng(4)
    joints, rates = np.zeros((50, len(drive.joints))), np.zeros((50, len(drive.joints)))
    fraction, one = rng.uniform(0.05, 0.95, (50, 1)), np.ones((50, 1))
    for _ in range(4):
        command = (
            rng.uniform(-0.5, 0.5, (50, len(drive.channels))) * np.array([[2.0] + [12.0] * 3])[:, : len(drive.channels)]
        )
        after, rates = drive.advance(joints, rates, command, 0.4, {}, NO_DRAWS)
        stop = drive.between(joints, after, fraction)
        cut = compose(drive.displacement(joints, stop, one), drive.displacement(stop, after, one))
        np.testing.assert_allclose(cut, drive.displacement(joints, after, one), atol=1e-13)
        joints = after


@pytest.mark.parametrize("acceleration", [None, 7.0])
@pytest.mark.parametrize(
    ("name", "command", "most"),  # most: of the error over the square of the step [m/s^2]
    [
        ("differential", [7.0, 9.0], 0.05),
        ("ackermann rear", [0.5, 9.0], 0.8),
        ("synchro fixed", [0.5, 9.0], 0.05),
        ("tricycle", [0.5, 9.0], 1.3),
        ("mecanum", [7.0, 9.0, 6.0, 8.0], 0.05),
        ("tractor", [7.0, 9.0], 0.05),
    ],
)
def test_from_rest_the_path_depends_on_the_step_by_its_square(name, command, most, acceleration):
    """Ramps of motors end, steering arrives and a tricycle's wheel sets off within steps."""
    drive = stack([make(name, acceleration_max=acceleration)])
    still = np.zeros((1, len(drive.joints)))
    true, _ = go(drive, still, still, command, 3.0, 3000)
    for steps in (150, 60, 30, 15):
        found, _ = go(drive, still, still, command, 3.0, steps)
        assert np.hypot(*(found - true)[:2]) < most * (3.0 / steps) ** 2 + 1e-9


def test_a_cars_heading_is_off_by_no_more_than_the_page_says():
    """A steering that arrives within a step moves evenly to the end of it: v w dt^2 / (8 L cos^2 s) at most."""
    drive = stack([make("ackermann rear")])
    speed, rate, wheelbase, dt = 0.9, 1.5, 0.5, 0.1
    largest = 0.0
    for angle in np.linspace(0.4, 0.55, 16):  # arrives everywhere within a step
        turned, after = 0.0, np.zeros((1, 3))
        for _ in range(10):
            before, (after, _) = after, advance(drive, after, np.zeros((1, 3)), [angle, speed / 0.1], dt)
            turned += drive.displacement(before, after, ONE)[0, 2]
        true = speed / wheelbase * (-np.log(np.cos(angle)) / rate + np.tan(angle) * (1.0 - angle / rate))
        bound = speed * rate * dt**2 / (8.0 * wheelbase * np.cos(angle) ** 2)
        assert -1e-12 < true - turned < bound
        largest = max(largest, (true - turned) / bound)
    assert largest > 0.9


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize(("lag", "acceleration"), [(0.3, None), (0.0, 6.0), (0.2, 6.0)])
def test_motors_with_lag_and_limits_do_not_depend_on_the_step(name, lag, acceleration):
    drive = stack([make(name, lag=lag, acceleration_max=acceleration)])
    plain = stack([make(name)])
    command = [0.3] + [9.0] * (len(drive.channels) - 1) if "wheels" in drive.channels else [9.0] * len(drive.channels)
    if name == "tricycle":
        command = [0.0, 9.0]
    ends = []
    for steps in (1, 8, 64):
        joints = rates = np.zeros((1, len(drive.joints)))
        if name.startswith("ackermann"):
            joints[0, 0] = 0.3  # the steering is there already
        for _ in range(steps):
            joints, rates = advance(drive, joints, rates, command, 1.6 / steps)
        ends.append(np.concatenate((joints, rates), axis=1))
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(ends[2], ends[0], rtol=1e-12, atol=1e-12)
    whole, _ = advance(plain, np.zeros((1, len(drive.joints))), np.zeros((1, len(drive.joints))), command, 1.6)
    assert (np.abs(ends[0][0, 1 : len(drive.joints)]) <= np.abs(whole[0, 1:])).all()
    assert not np.allclose(ends[0][0, 1], whole[0, 1], rtol=0.05)  # it matters


@pytest.mark.parametrize("name", [name for name in EVERY if name.startswith("ackermann")])
def test_a_curve_that_tightens_is_that_of_fine_steps(name):
    """Euler's midpoint rule in a hundred thousand steps, and the wheels' own paths."""
    drive = stack([make(name)])
    rate, way = 1.5, 0.4  # rad/s of the steering, m/s of the base
    joints = rates = np.zeros((1, len(drive.joints)))
    joints[0, 0] = -0.2
    after, _ = advance(drive, joints, rates, [0.4, way / 0.1], 0.4)
    assert after[0, 0] == pytest.approx(-0.2 + 0.4 * rate)
    n = 100_000
    step = 0.4 / n
    steering = -0.2 + rate * step * (np.arange(n) + 0.5)
    turn = way * np.tan(steering) / 0.5
    heading = np.cumsum(turn) * step - 0.5 * turn * step
    expected = [way * step * np.cos(heading).sum(), way * step * np.sin(heading).sum(), turn.sum() * step]
    assert drive.displacement(joints, after, ONE)[0] == pytest.approx(expected, abs=1e-9)
    speeds = {
        "rear": [way - 0.15 * turn, way + 0.15 * turn],
        "front": [np.hypot(way - 0.15 * turn, 0.5 * turn), np.hypot(way + 0.15 * turn, 0.5 * turn)],
        "centre": [np.full(n, way)],
    }[name.split()[1]]
    assert (after - joints)[0, 1:] * 0.1 == pytest.approx([speed.sum() * step for speed in speeds], abs=1e-9)


def test_a_tricycle_whose_steering_moves_is_that_of_fine_steps():
    drive = stack([make("tricycle")])
    joints, after = np.array([[-0.3, 0.0]]), np.array([[1.4, 9.0]])
    n = 100_000
    steering = -0.3 + 1.7 * (np.arange(n) + 0.5) / n
    way = 0.9 / n
    turn = way * np.sin(steering) / 0.6
    heading = np.cumsum(turn) - 0.5 * turn
    expected = [(way * np.cos(steering) * np.cos(heading)).sum(), (way * np.cos(steering) * np.sin(heading)).sum()]
    found = drive.displacement(joints, after, ONE)[0]
    assert found == pytest.approx([*expected, turn.sum()], abs=1e-9)


def test_a_tricycle_turns_in_place_with_its_wheel_athwart():
    drive = stack([make("tricycle")])
    command = drive.command_for(np.array([[0.0, 0.0, 0.7]]), np.zeros((1, 2)))
    joints, rates = settle(drive, command[0])
    pose, _ = go(drive, joints, rates, command[0], 1.0, 5)
    assert pose == pytest.approx([0.0, 0.0, 0.7], abs=1e-12)
    assert np.isinf(drive.curvature_max()).all()
    narrow = stack([make("tricycle", steering_max=0.7)])
    assert narrow.curvature_max()[0, 0] == pytest.approx(np.tan(0.7) / 0.6, rel=1e-12)


def test_front_wheels_point_along_circles_about_one_centre():
    drive = stack([make("ackermann rear")])
    assert drive.curvature_max()[0, 0] == pytest.approx(np.tan(0.6) / 0.5, rel=1e-12)
    for angle in (-0.6, -0.1, 1e-9, 0.2, 0.6):
        left, right = drive.front_wheel_angles(np.array([[angle]]))[0]
        inner, outer = (left, right) if angle > 0 else (right, left)
        assert 1.0 / np.tan(abs(outer)) - 1.0 / np.tan(abs(inner)) == pytest.approx(0.3 / 0.5, rel=1e-6)
        # The rear axle's line meets each front wheel's axle at the distance of the turning circle.
        radius = 0.5 / np.tan(angle)
        assert 0.5 / np.tan(left) == pytest.approx(radius - 0.15, rel=1e-9)
        assert 0.5 / np.tan(right) == pytest.approx(radius + 0.15, rel=1e-9)


def test_steering_moves_at_its_rate_and_with_its_lag():
    drive = stack([make("ackermann rear", steering_rate=0.5)])
    joints = rates = np.zeros((1, 3))
    for k in range(1, 13):
        joints, rates = advance(drive, joints, rates, [0.4, 0.0], 0.1)
        assert joints[0, 0] == pytest.approx(min(0.05 * k, 0.4), abs=1e-12)
    lagging = stack([make("ackermann rear", steering_rate=10.0, steering_lag=0.2)])
    after, _ = advance(lagging, np.zeros((1, 3)), np.zeros((1, 3)), [0.4, 0.0], 0.3)
    assert after[0, 0] == pytest.approx(0.4 * (1.0 - np.exp(-1.5)), rel=1e-12)
    beyond, _ = advance(drive, np.zeros((1, 3)), np.zeros((1, 3)), [9.0, 0.0], 60.0)
    assert beyond[0, 0] == 0.6


def test_a_synchro_drive_keeps_the_curve_of_a_command_that_is_too_fast():
    drive = stack([make("synchro fixed")])
    _, rates = advance(drive, np.zeros((1, 2)), np.zeros((1, 2)), [5.0, 10.0], 0.1)
    assert rates.tolist() == [[2.0, 4.0]]


def test_a_synchro_drive_brings_its_wheels_round_to_a_velocity():
    """The body never turns, but it can be sent anywhere: the wheels roll backwards where that is nearer."""
    drive = stack([make("synchro fixed")])
    for way in (0.3, 2.0, -1.2, 3.0):
        velocity = np.array([[0.3 * np.cos(way), 0.3 * np.sin(way), 0.0]])
        joints = rates = np.zeros((1, 2))
        for _ in range(100):
            before = joints
            joints, rates = advance(drive, joints, rates, drive.command_for(velocity, joints)[0], 0.1)
        moved = drive.displacement(before, joints, ONE)[0] / 0.1
        assert moved == pytest.approx(velocity[0], abs=1e-6)


@pytest.mark.parametrize("offset", [0.0, 0.1, -0.05])
@pytest.mark.parametrize(
    ("way", "turn", "start"), [(0.4, 0.2, 0.3), (0.1, 2.0, -0.5), (-0.3, 0.1, 0.2), (0.0, 0.0, 0.4)]
)
def test_the_hitch_follows_its_equation(offset, way, turn, start):
    drive = stack([make("tractor", trailer_length=0.5, hitch_offset=offset)])
    left, right = (way - 0.16 * turn) / 0.08, (way + 0.16 * turn) / 0.08
    before, after = np.array([[0.0, 0.0, start]]), np.array([[left, right, start]])
    found = drive.follow(after, drive.displacement(before, after, ONE))[0, 2]
    hitch, n = start, 20_000

    def slope(b):
        return turn - way / 0.5 * np.sin(b) + offset * turn / 0.5 * np.cos(b)

    for _ in range(n):
        hitch += slope(hitch + 0.5 / n * slope(hitch)) / n
    assert found == pytest.approx(hitch, abs=1e-8)


def test_a_trailer_does_not_slip_sideways():
    """The middle of its axle moves along its own heading: to second order in a short step."""
    drive = stack([make("tractor")])
    joints, rates = np.array([[0.0, 0.0, 0.3]]), np.zeros((1, 3))
    after, _ = advance(drive, joints, rates, [5.0, 7.0], 1e-4)
    moved = drive.displacement(joints, after, ONE)
    before = drive.part_poses(joints)[:, 0]
    now = compose(moved, drive.part_poses(drive.follow(after, moved))[:, 0])
    ahead, aside, _ = relative(before, now)[0]
    assert abs(aside) < 1e-3 * abs(ahead)


def test_a_trailer_settles_on_the_inner_circle():
    drive = stack([make("tractor", trailer_length=0.6, hitch_offset=0.0)])
    joints, _ = settle(drive, [4.0, 6.0], seconds=80.0)
    radius = 0.4 / 0.5
    assert joints[0, 2] == pytest.approx(np.arcsin(0.6 / radius), abs=1e-9)


@pytest.mark.parametrize("name", EVERY)
def test_what_the_drive_can_do_is_what_it_says(name):
    drive = stack([make(name)])
    speeds = drive.top_speeds()
    if speeds is None:
        pytest.skip("found from its rate_max")
    fastest, turn = speeds[0, :2]
    joints = np.zeros((1, len(drive.joints)))
    curvature = drive.curvature_max()
    forward = 0.0 if curvature is None or np.isinf(curvature[0, 0]) else turn / curvature[0, 0]
    for wanted in ([[fastest, 0.0, 0.0]], [[forward, 0.0, turn]]):
        command = drive.command_for(np.array(wanted), joints)[0]
        before, rates = settle(drive, command)
        course = drive.heading_offset(before)
        _, after = go(drive, before, rates, command, 0.1, 1)
        moved = drive.twist(before, after)[0] / 0.1
        if course is None:
            assert moved == pytest.approx(wanted[0], rel=1e-9, abs=1e-9)
        else:
            found = (after - before)[0, :2] / 0.1 * (1.0, drive.wheel_radius[0, 0])
            assert found == pytest.approx(wanted[0][2::-2], rel=1e-9, abs=1e-9)
