"""`goto`, `square` and `manual`, in the engine."""

import math

import numpy as np
import pytest

from amorsim.controllers import GoTo, Manual, Square
from amorsim.core.parameters import ParameterError
from amorsim.scenario.spec import Pose
from amorsim.simulation.simulation import Simulation
from tests.building import TRACK, drive, empty, robot, scenario


def simulate(controller, pose=(2.0, 2.0, 0.3), **changes):
    start = Pose(x=pose[0], y=pose[1], heading=pose[2])
    return Simulation(scenario(robot(controller=controller, pose=start, **changes), map=empty(), dt=0.1))


@pytest.mark.parametrize("place", [(5.0, 3.0), (-1.0, 2.5), (2.0, -3.0), (2.001, 2.0)])
@pytest.mark.parametrize("acceleration", [None, 4.0])
def test_goto_comes_to_its_place_and_stays(place, acceleration):
    sim = simulate(GoTo(x=place[0], y=place[1], tolerance=0.02), drive=drive(acceleration_max=acceleration))
    sim.run(60.0)
    assert math.dist(sim.true_pose[0, :2], place) < 0.02 + 1e-9
    before = sim.true_pose.copy()
    sim.run(1.0)
    np.testing.assert_array_equal(sim.true_pose, before)


def test_goto_is_no_faster_than_set():
    sim = simulate(GoTo(x=6.0, y=2.0, speed=0.25, turn_rate=0.5), pose=(2.0, 2.0, 2.0))
    most = np.zeros(3)
    for _ in range(200):
        before = sim.true_pose[0].copy()
        sim.step()
        most = np.maximum(most, np.abs(sim.true_pose[0] - before))
    assert math.hypot(most[0], most[1]) == pytest.approx(0.025, rel=0.05)
    assert most[2] == pytest.approx(0.05, rel=1e-9)


@pytest.mark.parametrize("direction", ["anticlockwise", "clockwise"])
@pytest.mark.parametrize("acceleration", [None, 4.0])
def test_a_square_comes_back_through_its_corners(direction, acceleration):
    sim = simulate(
        Square(side=2.0, speed=0.4, direction=direction, laps=2),
        pose=(1.0, 1.0, 0.0),
        drive=drive(acceleration_max=acceleration),
    )
    sign = 1.0 if direction == "anticlockwise" else -1.0
    corners = np.array([[3.0, 1.0], [3.0, 1.0 + 2.0 * sign], [1.0, 1.0 + 2.0 * sign]])
    path = []
    for _ in range(1200):
        sim.step()
        path.append(sim.true_pose[0].copy())
    path = np.array(path)
    for corner in corners:
        assert np.hypot(*(path[:, :2] - corner).T).min() < 0.003
    offside = np.maximum(np.abs(path[:, 0] - 2.0), np.abs(path[:, 1] - (1.0 + sign))) - 1.0
    assert np.abs(offside).max() < 0.005  # all of the path lies on the sides
    np.testing.assert_allclose(path[-1], [1.0, 1.0, 0.0], atol=0.005)
    length = np.hypot(*np.diff(path[:, :2], axis=0).T).sum()
    assert length == pytest.approx(16.0, abs=0.1)  # two laps, and no more


def test_a_square_shows_the_errors_of_the_drive():
    """A wrong track turns each corner by too much: UMBmark's Eb comes out of where the robot ends."""
    from amorsim.scenario.spec import Deviation

    scale = 0.99
    sim = simulate(Square(side=4.0), pose=(0.0, 0.0, 0.0), errors={"drive.track": Deviation(scale=scale)})
    sim.run(120.0)
    turned = math.pi / 2.0 * (1.0 / scale - 1.0)  # too far, at each corner
    x = y = heading = 0.0
    for _ in range(4):
        x, y = x + 4.0 * math.cos(heading), y + 4.0 * math.sin(heading)
        heading += math.pi / 2.0 + turned
    np.testing.assert_allclose(sim.true_pose[0, :2], [x, y], atol=0.02)
    np.testing.assert_allclose(sim.estimated_pose[0, :2], [0.0, 0.0], atol=0.003)


def test_manual_follows_its_command_until_it_gets_another():
    sim = simulate(Manual())
    sim.run(1.0)
    np.testing.assert_array_equal(sim.true_pose, [[2.0, 2.0, 0.3]])
    sim.robot("rover").command(-1.0, 1.0)
    sim.run(1.0)
    assert sim.true_pose[0, 2] == pytest.approx(0.3 + 2.0 * 0.0825 / TRACK, abs=1e-12)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: GoTo(y=1.0, x=math.nan), "x"),
        (lambda: GoTo(x=1.0, y=1.0, tolerance=0.0), "tolerance"),
        (lambda: Square(direction="left"), "direction"),
        (lambda: Square(laps=1.5), "laps"),
        (lambda: Square(side=-1.0), "side"),
    ],
)
def test_a_value_that_makes_no_sense_is_refused_by_name(make, name):
    with pytest.raises(ParameterError, match=name):
        make()


@pytest.mark.parametrize("lag", [0.15, 0.5, 1.0])
@pytest.mark.parametrize("acceleration", [None, 4.0])
@pytest.mark.parametrize("place", [(4.0, 3.0), (1.0, 2.5)])
def test_goto_comes_to_its_place_with_motors_that_lag_longer_than_a_step(place, acceleration, lag):
    sim = simulate(GoTo(x=place[0], y=place[1], tolerance=0.02), drive=drive(acceleration_max=acceleration, lag=lag))
    sim.run(40.0)
    assert math.dist(sim.true_pose[0, :2], place) < 0.02 + 1e-9
    before = sim.true_pose.copy()
    sim.run(5.0)
    assert sim.true_pose == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("lag", [0.15, 0.5, 1.0])
@pytest.mark.parametrize("acceleration", [None, 4.0])
def test_a_square_comes_back_with_motors_that_lag_longer_than_a_step(acceleration, lag):
    controller = Square(side=2.0, speed=0.4)
    sim = simulate(controller, pose=(1.0, 1.0, 0.0), drive=drive(acceleration_max=acceleration, lag=lag))
    (group,) = sim._fleet.groups
    while group.driver.state["reached"][0, 0] < 4:
        sim.step()
        assert sim.time < 25.0 + 4.0 * (4.0 + 25.0 * lag)
    sim.run(10.0 * lag)
    assert math.dist(sim.true_pose[0, :2], (1.0, 1.0)) < 0.003
    assert abs(math.remainder(sim.true_pose[0, 2], 2.0 * math.pi)) < 0.0045
