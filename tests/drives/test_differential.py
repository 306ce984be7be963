import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.contracts import Draws
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import compose
from amorsim.core.rows import stack
from amorsim.drives import Differential

NO_DRAWS = Draws(np.zeros(1, dtype=np.uint64), np.zeros((1, 3), dtype=np.uint32))


def make(**changes):
    given = {
        "wheel_radius_left": 0.08,
        "wheel_radius_right": 0.085,
        "track": 0.32,
        "rate_max": 20.0,
        "acceleration_max": None,
    }
    return Differential(**(given | changes))


def over_rows(*drives):
    return stack(drives)


def advance(drive, joints, rates, command, dt=0.1):
    return drive.advance(*(np.array(a, dtype=float) for a in (joints, rates, command)), dt, {}, NO_DRAWS)


def drive_along(drive, left, right, steps):
    """Poses after each of `steps` equal steps in which the wheels turn by left / steps and right / steps [rad]."""
    pose = np.zeros((1, 3))
    joints = np.linspace([0.0, 0.0], [left, right], steps + 1)
    for before, after in itertools.pairwise(joints):
        pose = compose(pose, drive.displacement(before[None], after[None], np.ones((1, 1))))
    return pose[0]


def test_an_arc_is_the_closed_form():
    drive = over_rows(make())
    left, right = 7.0, 9.0
    travel_left, travel_right = 0.08 * left, 0.085 * right
    turn = (travel_right - travel_left) / 0.32
    radius = 0.5 * (travel_left + travel_right) / turn
    x, y, heading = drive.displacement(np.zeros((1, 2)), np.array([[left, right]]), np.ones((1, 1)))[0]
    assert (x, y, heading) == pytest.approx((radius * np.sin(turn), radius * (1.0 - np.cos(turn)), turn), abs=1e-14)


@given(left=st.floats(-30.0, 30.0), right=st.floats(-30.0, 30.0), steps=st.integers(2, 40))
def test_a_path_does_not_depend_on_the_number_of_steps(left, right, steps):
    drive = over_rows(make())
    once, often = drive_along(drive, left, right, 1), drive_along(drive, left, right, steps)
    np.testing.assert_allclose(often[:2], once[:2], atol=1e-12)
    assert np.sin(0.5 * (often[2] - once[2])) == pytest.approx(0.0, abs=1e-12)


def test_a_full_circle_returns():
    drive = over_rows(make(wheel_radius_right=0.08))
    travel = 2.0 * np.pi * 0.5  # of the base point, on a circle of radius 0.5 m
    across = 0.5 * 0.32 * 2.0 * np.pi
    end = drive_along(drive, (travel - across) / 0.08, (travel + across) / 0.08, 37)
    np.testing.assert_allclose(end, 0.0, atol=1e-13)


def test_turning_in_place_stays_in_place():
    drive = over_rows(make(wheel_radius_right=0.08))
    twist = drive.twist(np.zeros((1, 2)), np.array([[-2.0, 2.0]]))
    assert twist.tolist() == [[0.0, 0.0, pytest.approx(2.0 * 0.16 / 0.32)]]


def test_a_stop_under_way_moves_as_far_as_the_joints_say():
    drive = over_rows(make())
    before, after, fraction = np.array([[1.0, 2.0]]), np.array([[4.0, 1.0]]), np.array([[0.3]])
    stopped = drive.displacement(before, drive.between(before, after, fraction), np.ones((1, 1)))
    np.testing.assert_allclose(stopped, drive.displacement(before, after, fraction), atol=1e-15)


def test_travel_is_the_length_of_the_path_and_its_turning():
    drive = over_rows(make())
    before, after = np.zeros((1, 2)), np.array([[-3.0, 1.0]])
    forward, _, turn = drive.twist(before, after)[0]
    assert drive.travel(before, after).tolist() == [[abs(forward), abs(turn)]]


def test_a_command_for_a_twist_makes_that_twist():
    drive = over_rows(make())
    wanted = np.array([[0.4, 0.0, -0.7]])
    rates = drive.command_for(wanted, np.zeros((1, 2)))
    np.testing.assert_allclose(drive.twist(np.zeros((1, 2)), rates), wanted, atol=1e-15)


def test_speeds_are_converted_with_the_drives_own_radii():
    drive = over_rows(make())
    np.testing.assert_allclose(drive.speeds_to_rates(np.array([[0.4, 0.34]])), [[5.0, 4.0]], rtol=1e-15)


def test_joints_follow_a_command_within_the_limits():
    drive = over_rows(make())
    joints, rates = advance(drive, [[1.0, 2.0]], [[0.0, 0.0]], [[5.0, -4.0]])
    assert rates.tolist() == [[5.0, -4.0]]
    np.testing.assert_allclose(joints, [[1.5, 1.6]], rtol=1e-15)


@given(left=st.floats(-1e6, 1e6), right=st.floats(-1e6, 1e6))
def test_a_command_that_is_too_fast_keeps_its_curvature(left, right):
    drive = over_rows(make())
    _, rates = advance(drive, [[0.0, 0.0]], [[0.0, 0.0]], [[left, right]])
    assert np.abs(rates).max() <= 20.0
    assert rates[0, 0] * right == pytest.approx(rates[0, 1] * left, rel=1e-12, abs=1e-9)
    if max(abs(left), abs(right)) > 20.0:
        assert np.abs(rates).max() == pytest.approx(20.0, rel=1e-15)


def test_each_wheel_speeds_up_by_itself():
    drive = over_rows(make(acceleration_max=10.0))
    _, rates = advance(drive, [[0.0, 0.0]], [[2.0, 2.5]], [[8.0, 3.0]])
    assert rates.tolist() == [[3.0, 3.0]]
    _, rates = advance(drive, [[0.0, 0.0]], [[2.0, 2.5]], [[-8.0, 2.5]])
    assert rates.tolist() == [[1.0, 2.5]]


def test_rows_do_not_touch_one_another():
    rng = np.random.default_rng(5)
    drives = [
        make(wheel_radius_left=0.08 + 0.001 * i, track=0.3 + 0.01 * i, acceleration_max=5.0 + i) for i in range(64)
    ]
    joints, rates, command, twists = (rng.normal(size=(64, k)) * 9.0 for k in (2, 2, 2, 3))
    together = over_rows(*drives)
    after, new_rates = advance(together, joints, rates, command)
    fraction = rng.uniform(size=(64, 1))
    for i, drive in enumerate(drives):
        alone, row = over_rows(drive), slice(i, i + 1)
        for whole, single in (
            ((after, new_rates), advance(alone, joints[row], rates[row], command[row])),
            (
                (together.displacement(joints, after, fraction),),
                (alone.displacement(joints[row], after[row], fraction[row]),),
            ),
            ((together.command_for(twists, joints),), (alone.command_for(twists[row], joints[row]),)),
            ((together.jacobian(joints, after),), (alone.jacobian(joints[row], after[row]),)),
        ):
            for a, b in zip(whole, single, strict=True):
                assert a[row].tobytes() == b.tobytes()


@pytest.mark.parametrize("name", ["wheel_radius_left", "wheel_radius_right", "track", "rate_max", "acceleration_max"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), "1", True])
def test_a_value_that_makes_no_sense_is_refused_by_name(name, value):
    with pytest.raises(ParameterError, match=name):
        make(**{name: value})
