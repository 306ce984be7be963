"""Maps drawn at given poses, in rooms whose walls are known exactly."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.estimators import DeadReckoning, Ekf, GridMapping
from amorsim.estimators.map_area import log_odds_evidence
from amorsim.kernels.mapping import occupancy
from amorsim.kernels.mapping.scan_cells import Area, window_for
from amorsim.sensors import Gps, Laser
from amorsim.testing import check_component
from tests import building

SIDE = 0.05
AREA = Area(120, 160, SIDE)  # 8 m x 6 m
ORIGIN = np.array([[-1.0, -1.0]])
LEFT, LOW, RIGHT, HIGH = 0.012, 0.017, 5.987, 3.971  # inside of cells, not on their borders
WALLS = np.array(
    [
        *((LEFT, LOW, RIGHT, LOW), (RIGHT, LOW, RIGHT, HIGH), (RIGHT, HIGH, LEFT, HIGH), (LEFT, HIGH, LEFT, LOW)),
        *((2.03, HIGH, 2.51, 2.77), (4.2, 0.9, 4.83, 1.31)),
    ]
)
BEARINGS = np.arange(360)[None] / 360.0 * 2.0 * math.pi - math.pi


def mapped(std=0.0, count=120, seed=1, model="log_odds"):
    """Probabilities of all cells, and how often each was hit and missed, from scans at true poses about a room."""
    world = am.Map.from_segments(WALLS, resolution=0.001)
    rng = np.random.default_rng(seed)
    poses = []
    while len(poses) < count:
        pose = rng.uniform((0.2, 0.2, -math.pi), (5.8, 3.8, math.pi))
        if world.cast_rays(pose[None], BEARINGS[0], 8.0).min() > 0.15:
            poses.append(pose)
    poses = np.array(poses)
    ranges = world.cast_rays(poses, BEARINGS[0], 8.0) + std * rng.normal(size=(count, 360))
    room = window_for(AREA, 8.0)
    cells = AREA.rows * AREA.cols
    log_odds = np.full((1, cells), np.nan, dtype=np.float32)
    hits, misses = np.zeros((2, 1, cells), dtype=np.int32)
    evidence = log_odds_evidence()  # the defaults
    for pose, values in zip(poses, ranges, strict=True):
        fresh = np.ones((1, 1), dtype=bool)
        scan = occupancy.Scans(
            pose[None], values[None].copy(), fresh, np.cos(BEARINGS), np.sin(BEARINGS), np.array([[8.0]])
        )
        occupancy.add_log_odds(AREA, ORIGIN, scan, evidence, room, log_odds)
        occupancy.add_counts(AREA, ORIGIN, scan, room, hits, misses)
    found = np.empty((1, cells))
    if model == "log_odds":
        occupancy.probabilities_of_log_odds(log_odds, found)
    else:
        occupancy.probabilities_of_counts(hits, misses, found)
    shape = AREA.rows, AREA.cols
    return found.reshape(shape), hits.reshape(shape), misses.reshape(shape)


def crossed():
    """Cells whose inside a wall crosses, by walking along the walls."""
    cells = np.zeros((AREA.rows, AREA.cols), dtype=bool)
    for x0, y0, x1, y1 in WALLS:
        along = np.linspace(0.0, 1.0, 100_001)
        x, y = (x0 + (x1 - x0) * along + 1.0) / SIDE, (y0 + (y1 - y0) * along + 1.0) / SIDE
        inside = (np.abs(x - np.rint(x)) > 1e-6) & (np.abs(y - np.rint(y)) > 1e-6)
        cells[np.floor(y[inside]).astype(int), np.floor(x[inside]).astype(int)] = True
    return cells


def near(cells):
    """Those cells and the ones around them."""
    grown = np.pad(cells, 1)
    rows, cols = cells.shape
    return np.any([grown[r : r + rows, c : c + cols] for r in range(3) for c in range(3)], axis=0)


def area_under_curve(score, truth):
    """The probability that an occupied cell has a larger score than a free one; ties count half."""
    from scipy.stats import rankdata

    ranks = rankdata(score)
    positive = truth.sum()
    return (ranks[truth].sum() - positive * (positive + 1) / 2.0) / (positive * (~truth).sum())


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_with_true_poses_and_an_ideal_laser_every_wall_is_occupied_and_what_is_crossed_is_free(seed):
    found, hits, misses = mapped(seed=seed)
    walls = crossed()
    assert (walls & (hits > 0)).sum() > 250
    assert (found[walls & (hits > 0)] > 0.5).all()
    assert (found[(hits == 0) & (misses >= 3)] < 0.35).all()
    # A wall is drawn in cells of 1 mm, so a beam may end that much before it, in the next cell.
    free = ~near(walls) & (misses >= 3)
    assert free.sum() > 5000
    assert (found[free] < 0.35).all()


@pytest.mark.parametrize("model", ["log_odds", "counting"])
def test_with_noise_occupied_cells_are_distinguished_from_free_ones(model):
    found, hits, _ = mapped(std=0.03, model=model)
    known = np.isfinite(found)
    walls = crossed()
    # Cells next to a wall are neither: noise of 0.03 m puts ends there rightly.
    counted = known & (walls & (hits > 0) | ~near(near(walls)))
    assert area_under_curve(found[counted], walls[counted]) >= 0.99


def test_counting_gives_the_share_of_hits():
    found, hits, misses = mapped(count=20, model="counting")
    seen = hits + misses
    np.testing.assert_array_equal(np.isnan(found), seen == 0)
    np.testing.assert_array_equal(found[seen > 0], hits[seen > 0] / seen[seen > 0])


def mapper(**changes):
    return GridMapping(**({"resolution": 0.1, "width": 9.0, "height": 7.0} | changes))


@pytest.mark.parametrize("model", ["log_odds", "counting"])
def test_it_keeps_the_contract(model):
    check_component(mapper(model=model))


def test_it_keeps_the_contract_at_the_poses_of_another_estimator():
    check_component(mapper(estimator="slam"))


def driven(*estimators, duration=6.0, replicas=1, lost=0.0, **tracked):
    """A simulation of a robot that roams about the room, whose wheels are off and whose tracking system is exact.

    `tracked` are fields of that system; readings of the wheels are `lost` with that probability.
    """
    counted = building.encoder()
    if lost:
        counted = am.MountedSensor(sensor=counted, noise=(am.noise.Dropout(probability=lost),))
    world = am.Map.from_segments(WALLS, resolution=0.01)
    off = {"drive.wheel_radius_left": am.Deviation(scale=1.05), "drive.track": am.Deviation(scale=1.2)}
    robot = building.robot(
        pose=am.Pose(x=1.0, y=1.0),
        controller=building.Roam(),
        sensors={
            "laser": am.MountedSensor(sensor=Laser(beams=91), mount=am.Mount(x=0.1, y=0.02, heading=0.3)),
            "gps": am.MountedSensor(sensor=Gps(heading=True), mount=am.Mount(x=-0.1, heading=-0.2), **tracked),
            "encoder": counted,
        },
        estimators={f"map{i}": one for i, one in enumerate(estimators)},
        errors=off,
    )
    sim = am.Simulation(am.Scenario(map=world, robots=[robot], seed=2), replicas=replicas)
    sim.run(duration)
    return sim


def strays(belief):
    """The share of the occupied cells of a map that no wall touches."""
    found = am.estimated_map(belief, occupied=0.6)
    true = am.Map.from_segments(WALLS, resolution=0.001)
    rows, cols = np.nonzero(found.to_array())
    centres = np.stack((cols + 0.5, rows + 0.5), axis=1) * 0.1 + found.origin[:2]
    return np.mean([not _touches(true, centre) for centre in centres])


def test_the_map_of_a_tracking_system_is_the_room_and_that_of_bad_wheels_is_not():
    frame = driven(mapper(place="gps"), mapper()).frames()[0]
    np.testing.assert_allclose(frame.estimates["map0"].pose, frame.true_pose, atol=1e-12)
    assert strays(frame.beliefs["map0"]) < 0.02
    assert strays(frame.beliefs["map1"]) > 0.15


def test_scans_between_the_places_of_a_tracking_system_are_refused_unless_an_age_is_allowed():
    with pytest.raises(am.ComponentError, match=r"the place that 'gps' gave is 0\.\d+ s old; let it read whenever"):
        driven(mapper(place="gps"), rate=2.0)
    driven(mapper(place="gps", age_max=0.5), rate=2.0)


def test_where_the_place_is_lost_no_scan_is_drawn():
    lost = am.NoiseElement(name="lost", noise=am.noise.Dropout(probability=0.5), column="heading")
    assert strays(driven(mapper(place="gps"), noise=(lost,)).frames()[0].beliefs["map0"]) < 0.02


@pytest.mark.parametrize("of", ["wheels", "gps"])
def test_a_map_at_the_poses_of_another_estimator_is_the_one_that_this_would_draw(of):
    source = mapper(place="gps") if of == "gps" else mapper(wheel_variance=1e-5)
    frame = driven(mapper(estimator="map1"), source, mapper(place="gps")).frames()[0]
    fed, drawn, exact = (frame.beliefs[f"map{i}"]["occupancy"] for i in range(3))
    assert fed.tobytes() == drawn.tobytes()
    assert (fed.tobytes() == exact.tobytes()) == (of == "gps")
    for mine, its in zip(frame.estimates["map0"], frame.estimates["map1"], strict=True):
        np.testing.assert_array_equal(mine, its)
    assert (frame.estimates["map0"].covariance.any()) == (of == "wheels")


@pytest.mark.parametrize("of", ["mapper", "dead_reckoning", "ekf"])
def test_no_scan_is_laid_at_a_place_that_the_wheels_have_not_told_yet(of):
    source = {
        "mapper": mapper(wheel_variance=1e-5),
        "dead_reckoning": DeadReckoning(wheel_variance=1e-5),
        "ekf": Ekf(wheel_variance=1e-5),
    }[of]
    frame = driven(mapper(estimator="map1"), source, mapper(wheel_variance=1e-5), lost=0.3).frames()[0]
    fed, drawn = (np.isnan(frame.beliefs[name]["occupancy"]) for name in ("map0", "map2"))
    assert (fed == drawn).mean() > 0.999  # the same scans; an EKF's poses have other last bits
    if of != "ekf":
        assert frame.beliefs["map0"]["occupancy"].tobytes() == frame.beliefs["map2"]["occupancy"].tobytes()
    every = driven(mapper(estimator="map1"), source, mapper(wheel_variance=1e-5)).frames()[0]
    assert (np.isnan(every.beliefs["map0"]["occupancy"]) == fed).mean() < 0.999  # many are left out


def test_a_runner_runs_the_estimator_that_feeds_it_too():
    sim = driven(mapper(estimator="map1"), mapper(wheel_variance=1e-5), duration=0.0)
    runner = am.EstimatorRunner(sim.scenario.robots[0], "map0", dt=sim.dt)
    for step in range(20):
        if step:
            sim.step()
        frame = sim.frames()[0]
        readings = {name: reading.measured[0] for name, (_, reading) in frame.readings.items()}
        estimate = runner.update(frame.time[0], readings, frame.command[0])
    assert estimate.pose.tobytes() == frame.estimates["map0"].pose[0].tobytes()
    assert runner.beliefs["occupancy"].tobytes() == frame.beliefs["map0"]["occupancy"][0].tobytes()
    assert np.isfinite(runner.beliefs["occupancy"]).any()


def _touches(world, centre):
    """Whether a wall is within a cell's width of a place."""
    x, y = centre
    left, low = x - 0.11 - world.origin[0], y - 0.11 - world.origin[1]
    window = left, low, left + 0.22, low + 0.22
    return bool(world.to_array(window, resolution=0.22).any())


def test_rows_of_a_run_have_their_own_maps():
    many, one = driven(mapper(), duration=2.0, replicas=3), driven(mapper(), duration=2.0, replicas=[2])
    every, alone = many.frames()[0].beliefs["map0"], one.frames()[0].beliefs["map0"]
    for name, array in alone.items():
        assert array.tobytes() == every[name][2:].tobytes(), name


def test_the_map_lies_where_it_is_asked_for():
    sim = driven(mapper(center_x=3.0, center_y=2.0), mapper(), duration=0.1)
    beliefs = sim.frames()[0].beliefs
    np.testing.assert_allclose(beliefs["map0"]["occupancy_origin"], [[3.0 - 4.5, 2.0 - 3.5]], atol=1e-9)
    np.testing.assert_allclose(beliefs["map1"]["occupancy_origin"], [[1.0 - 4.5, 1.0 - 3.5]], atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"laser": "lidar"}, "reads the sensor 'lidar', which the robot does not have"),
        ({"laser": "gps"}, "a Gps has no beams of a known longest range"),
        ({"place": "laser"}, "a Laser does not measure x, y and heading"),
        ({"encoder": "gps"}, "counts no joints"),
        ({"estimator": "map1"}, r"robot 'rover', estimator 'map0': it takes the estimate of 'map1'.*has: no other[.]$"),
        ({"estimator": "map0"}, "in a circle: 'map0' waits for 'map0'"),
        ({"resolution": 0.0005}, "cells of 0.0005 m; expected 5e[+]07 at most"),
    ],
)
def test_what_it_cannot_map_with_is_refused(changes, message):
    with pytest.raises(am.ComponentError, match=message):
        driven(mapper(**changes), duration=0.1)


def test_two_sources_of_poses_are_refused():
    with pytest.raises(am.ComponentError, match="both estimator = 'map1' and place = 'gps' are given"):
        driven(mapper(estimator="map1", place="gps"), mapper(), duration=0.1)
