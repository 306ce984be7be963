"""Bodies that slide while they roll: what the ground does to drives whose wheels cannot do it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.core.shapes import Shape
from amorsim.noise import OdometryModel, VelocityModel
from tests import building
from tests.drives.fleet import MAKERS, make

STEERED = [name for name in MAKERS if name not in ("differential", "tractor", "mecanum")]
REPLICAS = 2000
WITHIN = 5.0 * math.sqrt(2.0 / REPLICAS)  # of a sample variance, relatively


def drive(name, *ground, dt=1.0, forward=0.5, turn=0.0, time=1.0, replicas=REPLICAS, zones=(), **changes):
    robot = building.robot(
        drive=make(name, rate_max=1e3),
        ground=building.chain(*ground),
        pose=am.Pose(),
        shape=Shape.circle(0.2),
        **changes,
    )
    world = changes.pop("map", building.empty())
    sim = am.Simulation(building.scenario(robot, map=world, dt=dt, zones=zones), replicas=replicas, threads=1)
    for replica in range(replicas):
        sim.robot("rover", replica).drive(forward=forward, turn=turn)
    sim.run(time)
    return sim


def thrun(t, r1, r2, a, rng, count=200_000):
    """Samples of the odometry model as it is published (table 5.6): turn, way, turn."""
    s1, s2 = math.sqrt(a["a1"] * r1**2 + a["a2"] * t**2), math.sqrt(a["a1"] * r2**2 + a["a2"] * t**2)
    st = math.sqrt(a["a3"] * t**2 + a["a4"] * (r1**2 + r2**2))
    first, way, second = rng.normal(r1, s1, count), rng.normal(t, st, count), rng.normal(r2, s2, count)
    return np.stack((way * np.cos(first), way * np.sin(first), first + second), axis=1)


@pytest.mark.parametrize("name", ["differential", "mecanum", "ackermann centre", "tricycle"])
def test_a_step_spreads_as_the_published_odometry_model(name):
    """Straight ahead for 1 s: the variance of y is t^2 a2 t^2, of which the turn alone, spread evenly, makes half."""
    a = {"a1": 0.0, "a2": 0.01, "a3": 0.002, "a4": 0.0}
    sim = drive(name, OdometryModel(**a), forward=1.0)
    way = float(sim.estimated_pose[0, 0])
    found = np.cov(sim.true_pose.T)
    expected = np.cov(thrun(way, 0.0, 0.0, a, np.random.default_rng(1)).T)
    assert np.diag(found)[1:] == pytest.approx(np.diag(expected)[1:], rel=1.2 * WITHIN)
    # Of two normal quantities with correlation c, the sample covariance has the variance (1 + c^2) v1 v2 / n.
    spread = math.sqrt(2.0 * expected[1, 1] * expected[2, 2] / REPLICAS)
    assert found[1, 2] == pytest.approx(expected[1, 2], abs=5.0 * spread)


@pytest.mark.parametrize("name", STEERED)
def test_a_drive_that_steers_is_turned_by_the_velocity_model(name):
    sim = drive(name, VelocityModel(a1=0.02, a3=0.05), dt=0.1, time=0.1)
    way = float(sim.estimated_pose[0, 0])
    assert way > 0.0
    assert sim.true_pose[:, 0].var(ddof=1) == pytest.approx(0.02 * way**2, rel=WITHIN + 0.01)
    assert sim.true_pose[:, 2].var(ddof=1) == pytest.approx(0.05 * way**2, rel=WITHIN)
    # The turn is spread over the step, and bends the way by half of it.
    assert np.corrcoef(sim.true_pose[:, 1], sim.true_pose[:, 2])[0, 1] > 0.99
    assert sim.true_pose[:, 1].var(ddof=1) == pytest.approx(0.05 * way**4 / 4.0, rel=WITHIN + 0.05)
    assert np.ptp(sim.estimated_pose, axis=0).max() == 0.0  # encoders see nothing of it


@pytest.mark.parametrize("name", STEERED)
def test_a_model_of_nothing_leaves_a_steered_drive_as_it_is(name):
    plain = drive(name, dt=0.1, turn=0.4, replicas=1)
    for model in (VelocityModel(), OdometryModel(interval=0.1)):
        assert drive(name, model, dt=0.1, turn=0.4, replicas=1).digest() == plain.digest()


@pytest.mark.parametrize("name", ["ackermann rear", "synchro driven"])
def test_in_a_zone_alone_it_slides_in_the_zone_alone(name):
    ice = am.Zone(
        name="ice", shape=Shape.circle(20.0), pose=am.Pose(x=20.4), ground=building.chain(VelocityModel(a3=0.05))
    )
    before = drive(name, dt=0.1, time=0.5, zones=[ice], replicas=50)
    assert np.ptp(before.true_pose[:, 2]) == 0.0
    before.run(1.5)
    assert np.ptp(before.true_pose[:, 2]) > 1e-3


@pytest.mark.parametrize("name", ["differential", "tricycle", "tractor"])
def test_one_that_slides_into_a_wall_stops_there(name):
    robot = building.robot(
        drive=make(name),
        ground=building.chain(OdometryModel(a2=0.3)),
        pose=am.Pose(x=2.0, y=1.2),
        on_collision="continue",
    )
    sim = am.Simulation(building.scenario(robot, dt=0.2), replicas=40, threads=1)
    for replica in range(40):
        sim.robot("rover", replica).drive(forward=0.8)
    sim.run(12.0)
    walls = [event for event in sim.events if event.kind == "collision" and event.other == "wall"]
    assert len({event.replica for event in walls}) > 30
    fleet = sim._fleet
    gaps, _ = fleet.world.wall_gaps(fleet.world.everyone, fleet.world.poses, np.zeros(len(fleet.world.everyone)))
    assert (gaps >= 0.0).all()
