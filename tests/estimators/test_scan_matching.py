"""Odometry from scans."""

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.estimators import DeadReckoning, ScanMatching
from amorsim.testing import check_component
from tests.estimators.slam_rig import errors_of, scenario
from tests.kernels.matching.scenes import corridor, room


def matching(**changes):
    return ScanMatching(**({"wheel_variance": 1e-3, "range_std": 0.01, "key_distance": 0.5} | changes))


@pytest.mark.long
def test_it_keeps_the_contract():
    check_component(matching(match_distance=0.0, match_angle=0.0, window=0.05, window_angle=0.04))


def test_it_drifts_far_less_than_the_wheels():
    sim = am.Simulation(scenario(matched=matching(), wheels=DeadReckoning()))
    off = errors_of(sim, 30.0)
    assert not sim.events
    assert off["wheels"][-1, 0] > 0.25
    assert off["matched"].max() < 0.04
    assert off["matched"][-1, 0] < off["wheels"][-1, 0] / 10.0


@pytest.mark.long
def test_without_noise_it_hardly_drifts_through_the_office():
    """Corners that are taken for slanting walls push the robot on: that made 290 mm in a minute."""
    given = am.load("map-the-office")
    robot = given.robots[0]
    laser = attrs.evolve(robot.sensors["laser"], noise=())
    matched = {"matched": ScanMatching(wheel_variance=1e-4, range_std=0.005)}
    robot = attrs.evolve(robot, sensors={**robot.sensors, "laser": laser}, estimators=matched)
    sim = am.Simulation(attrs.evolve(given, robots=[robot]))
    assert errors_of(sim, 60.0)["matched"].max() < 0.025


@pytest.mark.long
def test_with_a_third_of_its_beams_lost_it_hardly_drifts():
    """When a lost beam ended a line, it was off by 9, 20 and 4 cm in three runs; at most 1.7 to 4.8 cm in eight now."""
    given = am.load("map-the-office")
    robot = given.robots[0]
    laser = robot.sensors["laser"]
    laser = attrs.evolve(laser, noise=(*laser.noise, am.noise.Dropout(probability=0.3)))
    matched = {"matched": ScanMatching(wheel_variance=1e-4, range_std=0.005)}
    robot = attrs.evolve(robot, sensors={**robot.sensors, "laser": laser}, estimators=matched)
    sim = am.Simulation(attrs.evolve(given, robots=[robot]), replicas=8)
    # Single runs differ by a factor of three, so the mean of eight counts: 2.9 cm, with a standard error of 0.4.
    assert errors_of(sim, 40.0)["matched"].max(axis=0).mean() < 0.04


@pytest.mark.long
def test_its_error_is_about_as_large_as_it_says():
    sim = am.Simulation(scenario(matched=matching()), replicas=20)
    errors_of(sim, 12.0)
    frame = sim.frames()[0]
    off = frame.estimates["matched"].pose - frame.true_pose
    off[:, 2] = am.wrap_angle(off[:, 2])
    squared = [
        error @ np.linalg.solve(p, error) for error, p in zip(off, frame.estimates["matched"].covariance, strict=True)
    ]
    assert np.median(squared) < 30.0  # 2.4 if scans had no errors in common
    assert (np.linalg.eigvalsh(frame.estimates["matched"].covariance) > 0.0).all()


@pytest.mark.long
def test_in_a_corridor_it_says_that_nothing_tells_how_far_along_it_is():
    way = ((30.0, 1.0), (40.0, 1.0))
    sim = am.Simulation(scenario(corridor(), (26.0, 1.0, 0.0), way, matched=matching()), replicas=40)
    sim.run(8.0)
    seen, directions = [], []
    for _ in range(20):
        sim.step()
        beliefs = sim.frames()[0].beliefs["matched"]
        matched = np.isfinite(beliefs["match_degenerate"])
        seen += beliefs["match_degenerate"][matched].tolist()
        directions += np.abs(beliefs["match_direction"][matched, 0]).tolist()
    assert len(seen) > 120
    assert np.mean(seen) == 1.0
    assert min(directions) > 0.99
    # Along the corridor the wheels count alone; across it, and in heading, the scans do.
    frame = sim.frames()[0]
    error = frame.estimates["matched"].pose - frame.true_pose
    assert np.abs(error[:, 1]).max() < 0.02
    assert np.abs(error[:, 2]).max() < 0.01
    # One wheel is 1 % larger than the robot believes. Lines have errors, each robot's of its own, so that scans tell a
    # little; by how much robots are off, their covariance knows.
    covariance = frame.estimates["matched"].covariance
    aside = error[:, 0] + 0.005 * (frame.true_pose[:, 0] - 26.0)
    assert abs(aside.mean()) < 0.02
    assert (aside**2).mean() < covariance[:, 0, 0].mean()
    assert (covariance[:, 0, 0] > 10.0 * covariance[:, 1, 1]).all()


def test_in_a_room_it_is_determined():
    sim = am.Simulation(scenario(matched=matching()))
    seen = []
    for _ in range(60):
        sim.step()
        seen.append(sim.frames()[0].beliefs["matched"]["match_degenerate"][0])
    assert np.nanmax(seen) == 0.0


def test_the_matched_scan_lies_on_the_walls():
    sim = am.Simulation(scenario(matched=matching()))
    errors_of(sim, 6.0)
    points = sim.frames()[0].beliefs["matched"]["scan"][0]
    points = points[np.isfinite(points[:, 0])]
    inside = (points > 0.05).all(axis=1) & (points < (5.95, 3.95)).all(axis=1)
    assert len(points) > 60
    assert inside.mean() < 0.4  # the niche and the column


def test_a_match_with_few_points_on_the_key_is_refused():
    sim = am.Simulation(scenario(matched=matching(least_fit=1.0)))
    used = []
    for _ in range(40):
        sim.step()
        used.append(sim.frames()[0].beliefs["matched"]["match_used"][0])
    assert np.nanmin(used) == 0.0


def test_a_replica_alone_and_among_others_has_the_same_bits():
    given = scenario(matched=matching())
    many, one = am.Simulation(given, replicas=4), am.Simulation(given, replicas=[2])
    for sim in (many, one):
        sim.run(3.0)
    every, alone = many.frames()[0], one.frames()[0]
    assert every.estimates["matched"].pose[2:3].tobytes() == alone.estimates["matched"].pose.tobytes()
    assert every.estimates["matched"].covariance[2:3].tobytes() == alone.estimates["matched"].covariance.tobytes()
    for name, array in alone.beliefs["matched"].items():
        assert array.tobytes() == every.beliefs["matched"][name][2:3].tobytes(), name


def followed(*headings, people=0.0, **changes):
    """Poses and beliefs of a robot whose wheels stand, at each of these headings; a share of the beams sees people."""
    robot = scenario(matched=matching(window_angle=math.radians(10.0), **changes)).robots[0]
    runner = am.EstimatorRunner(robot, "matched")
    bearings = robot.sensors["laser"].sensor.bearings()[0]
    found = []
    for time, heading in enumerate(headings):
        laser = am.compose(np.array([[1.0, 1.0, heading]]), np.array([[0.1, 0.02, 0.1]]))
        ranges = room().cast_rays(laser, bearings, 8.0)[0]
        ranges[: round(people * len(ranges))] *= 0.5 + 0.3 * (time % 2)
        estimate = runner.update(float(time), {"laser": ranges, "encoder": np.zeros(2)})
        found.append((estimate.pose, dict(runner.beliefs)))
    return found


@pytest.mark.parametrize("turned", [0.1, 0.2, 0.3, 0.5])
def test_a_robot_that_is_turned_while_its_wheels_stand_is_followed(turned):
    """Also beyond the window, where it fits badly."""
    _, (pose, beliefs) = followed(0.0, turned)
    assert beliefs["match_used"] == 1.0
    np.testing.assert_allclose(pose, [1.0, 1.0, turned], atol=0.02)


@pytest.mark.parametrize("turned", [-0.35, 0.35])
def test_a_scan_whose_best_pose_is_at_the_windows_border_is_looked_for_beyond(turned):
    """However well it fits there."""
    _, (pose, beliefs) = followed(0.0, turned, sure_fit=0.0)
    assert beliefs["match_used"] == 1.0
    np.testing.assert_allclose(pose, [1.0, 1.0, turned], atol=0.02)


def test_people_who_pass_do_not_move_a_robot_that_stands():
    for pose, beliefs in followed(0.0, 0.0, 0.0, people=0.4):
        assert np.isnan(beliefs["match_used"])
        np.testing.assert_array_equal(pose, [1.0, 1.0, 0.0])


def test_without_its_sensors_it_is_refused():
    with pytest.raises(am.ComponentError, match="scan_matching reads scans of the sensor 'encoder'"):
        am.Simulation(scenario(matched=matching(laser="encoder")))
