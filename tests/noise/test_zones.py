"""Zones of the floor and bumps: what they do to wheels, against closed forms, whatever the step."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.core.parameters import ParameterError
from amorsim.core.shapes import Shape
from amorsim.noise import Bump, Diffusion, Gaussian, Scale, Slip
from tests import building
from tests.noise.sampling import Samples
from tests.some_cases import one_in

TRACK, RADIUS = building.TRACK, building.RADIUS
SPEED = 0.4


def zone(*ground, name="zone", shape=None, **pose):
    return am.Zone(name=name, shape=shape or Shape.rectangle(1.0, 4.0), pose=am.Pose(**pose), ground=ground)


def drive(duration, *zones, dt=0.1, replicas=1, ground=(), forward=SPEED, turn=0.0, **changes):
    robot = building.robot(pose=am.Pose(), ground=building.chain(*ground), **changes)
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=dt, zones=zones), replicas=replicas)
    for replica in range(replicas):
        sim.robot("rover", replica).drive(forward=forward, turn=turn)
    sim.run(duration)
    return sim


@pytest.mark.parametrize("dt", [0.02, 0.1, 0.25, 0.5])
@pytest.mark.parametrize("factor", [0.4, 0.8, 1.3])
def test_a_slippery_metre_takes_its_part_of_the_way(dt, factor):
    """Wheels roll 4 m, and over the metre of the zone 1 / factor of it: steps are cut at its borders."""
    sim = drive(10.0, zone(Scale(factor=factor), x=1.63), dt=dt)
    expected = 4.0 - (1.0 / factor - 1.0)
    assert sim.true_pose[0, 0] == pytest.approx(expected, abs=1e-9)
    assert sim.true_pose[0, 1:] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert sim.estimated_pose[0] == pytest.approx([4.0, 0.0, 0.0], abs=1e-9)  # encoders see nothing of it


@pytest.mark.parametrize("dt", [0.02, 0.5])
def test_zones_one_behind_the_other_in_one_step(dt):
    zones = [
        zone(Scale(factor=0.5), name="a", shape=Shape.rectangle(0.03, 4.0), x=1.015),
        zone(Scale(factor=0.2), name="b", shape=Shape.rectangle(0.04, 4.0), x=1.06),
    ]
    sim = drive(5.0, *zones, dt=dt)
    assert sim.true_pose[0, 0] == pytest.approx(2.0 - 0.03 - 0.16, abs=1e-9)


def test_who_stops_in_a_zone_stays_there():
    sim = drive(5.0, zone(Slip(at=0.0, duration=9.0, factor=0.0), x=1.5), dt=0.25)
    assert sim.true_pose[0, 0] == pytest.approx(1.0, abs=1e-9)


def test_only_the_wheels_that_are_in_it_feel_a_zone():
    left = zone(Scale(factor=0.9), shape=Shape.rectangle(40.0, 4.0), y=2.05)
    sim = drive(0.5, left)
    # The left wheel alone is in the zone: it goes nine tenths of 0.2 m.
    assert sim.true_pose[0, 2] == pytest.approx(0.1 * 0.2 / TRACK, abs=1e-12)


@pytest.mark.long
def test_a_circle_and_a_turned_polygon_lie_where_they_are_put():
    disc = zone(Scale(factor=0.5), shape=Shape.circle(0.5), x=2.0, y=TRACK / 2.0)
    way = drive(10.0, disc, dt=0.01).true_pose[0]
    # The left wheel crosses the whole of the disc, the right one a chord of it.
    assert way[2] > 0.1
    turned = zone(Scale(factor=0.5), shape=Shape.rectangle(4.0, 1.0), x=1.7, heading=math.pi / 2.0)
    straight = zone(Scale(factor=0.5), shape=Shape.rectangle(1.0, 4.0), x=1.7)
    assert drive(10.0, turned).true_pose[0] == pytest.approx(drive(10.0, straight).true_pose[0], abs=1e-9)


@pytest.mark.parametrize("dt", [0.05, 0.5])
def test_noise_of_a_zone_is_that_of_the_way_within_it(dt):
    """Variance by length on one metre of four: var(heading) = 2 k / b^2 times a metre, whatever the step."""
    k, replicas = 2e-5, 3000
    sim = drive(10.0, zone(Diffusion(variance_per_length=k), x=1.7), dt=dt, replicas=replicas)
    heading = sim.true_pose[:, 2]
    assert heading.var(ddof=1) == pytest.approx(2.0 * k / TRACK**2, rel=5.0 * math.sqrt(2.0 / (replicas - 1)))
    assert abs(heading.mean()) < 5.0 * math.sqrt(2.0 * k / TRACK**2 / replicas)


def test_zones_act_one_after_the_other_and_on_top_of_the_robots_own_ground():
    twice = drive(
        1.0,
        zone(Scale(factor=0.8), name="a", shape=Shape.circle(9.0)),
        zone(Scale(factor=0.5), name="b", shape=Shape.circle(9.0)),
        ground=[Scale(factor=0.9)],
    )
    assert twice.true_pose[0, 0] == pytest.approx(0.4 * 0.9 * 0.8 * 0.5, abs=1e-12)


def test_who_meets_no_zone_keeps_every_bit():
    noise = [Diffusion(variance_per_length=1e-5)]
    plain = drive(2.0, ground=noise, turn=0.3)
    far = drive(2.0, zone(Scale(factor=0.5), Gaussian(std=0.1), x=50.0), ground=noise, turn=0.3)
    assert plain.digest() == far.digest()
    nothing = drive(2.0, zone(Scale(factor=1.0), shape=Shape.circle(9.0)), ground=noise, turn=0.3)
    assert plain.digest() == nothing.digest()


@pytest.mark.long
def test_replicas_snapshots_and_threads_keep_their_bits():
    zones = [
        zone(Diffusion(variance_per_length=1e-4), Gaussian(proportional=0.05), shape=Shape.circle(0.8), x=2.5, y=2.5),
        zone(Bump(height=0.01), name="sill", shape=Shape.rectangle(0.05, 5.0), x=3.5, y=2.5),
        zone(Bump(height=0.005, rate=2.0), name="rough", shape=Shape.rectangle(2.0, 5.0), x=5.0, y=2.5),
    ]
    robot = building.robot(controller=building.Roam(), on_collision="continue")
    scenario = building.scenario(robot, zones=zones)
    sim = am.Simulation(scenario, replicas=4)
    sim.run(3.0)
    middle = sim.snapshot()
    sim.run(3.0)
    end = [sim.digest(replica) for replica in range(4)]
    sim.restore(middle)
    sim.run(3.0)
    assert [sim.digest(replica) for replica in range(4)] == end
    alone = am.Simulation(scenario, replicas=[2], threads=2)
    alone.run(6.0)
    assert alone.digest(2) == end[2]
    sim.reset(seed=3)
    sim.run(6.0)
    assert [sim.digest(replica) for replica in range(4)] == end


# ------------------------------------------------------------------------------------------------------------ bumps


def lacks(height, radius=RADIUS):
    """What a wheel that climbs over an edge comes less ahead than it rolls [m]."""
    phi = math.acos(1.0 - height / radius)
    return 2.0 * radius * (phi - math.sin(phi))


def test_the_way_lost_on_a_bump():
    # By hand, from the sine's series: 165 mm (0.4976^3 / 6 - 0.4976^5 / 120 + 0.4976^7 / 5040).
    assert lacks(0.01) == pytest.approx(3.344e-3, abs=5e-6)
    out = Samples(Bump(height=0.01, at=0.0), rows=3, k=2).ground([0.05, -0.05], 0.1)
    assert out == pytest.approx(np.tile([0.05 - lacks(0.01), -0.05 + lacks(0.01)], (3, 1)), rel=1e-12)


@pytest.mark.parametrize("dt", [0.02, 0.1, 0.25, 0.5])
def test_a_sill_that_one_wheel_crosses_turns_the_robot_whatever_the_step(dt):
    sill = zone(Bump(height=0.01), shape=Shape.rectangle(0.004, 0.3), x=1.003, y=TRACK / 2.0)
    sim = drive(5.0, sill, dt=dt)
    assert sim.true_pose[0, 2] == pytest.approx(lacks(0.01) / TRACK, abs=1e-12)
    assert sim.estimated_pose[0] == pytest.approx([2.0, 0.0, 0.0], abs=1e-9)


def test_each_crossing_costs_again_and_staying_costs_nothing():
    sill = zone(Bump(height=0.01), x=1.5)  # a metre long: the wheels are on it for a while
    sim = drive(5.0, sill)
    assert sim.true_pose[0, 0] == pytest.approx(2.0 - lacks(0.01), abs=1e-9)
    sim.robot("rover").drive(forward=-SPEED)
    sim.run(2.5)
    assert sim.true_pose[0, 0] == pytest.approx(1.0 - lacks(0.01), abs=1e-9)
    sim.run(1.0)  # out at its near end, and in again
    sim.robot("rover").drive(forward=SPEED)
    sim.run(2.0)
    assert sim.true_pose[0, 0] == pytest.approx(1.4 - 2.0 * lacks(0.01), abs=1e-9)


@pytest.mark.parametrize("dt", one_in(2, [0.5, 0.005, 0.05, 0.01, 0.25]))
@pytest.mark.parametrize("width", [0.002, 0.02])
@pytest.mark.parametrize("x", one_in(4, [0.0, 0.0123, 0.0246, 0.0369]))
def test_a_sill_costs_one_bump_wherever_steps_end(dt, width, x):
    """Also where a step is shorter than the way that a bump costs, and where that is wider than the sill."""
    sill = zone(Bump(height=0.01), shape=Shape.rectangle(width, 4.0), x=1.0 + x)
    assert drive(5.0, sill, dt=dt).true_pose[0, 0] == pytest.approx(2.0 - lacks(0.01), abs=1e-9)


@pytest.mark.parametrize("dt", [0.25, 0.5, 1.0])
def test_a_sill_whose_border_is_at_the_end_of_a_step_costs_one_bump(dt):
    sim = drive(6.0, zone(Bump(height=0.01), x=2.0), dt=dt, forward=0.5)
    assert sim.true_pose[0, 0] == pytest.approx(3.0 - lacks(0.01), abs=1e-9)


@pytest.mark.parametrize("dt", [0.01, 0.5])
def test_who_starts_or_is_put_on_a_sill_has_not_entered_it(dt):
    sill = zone(Bump(height=0.01), x=0.0)
    sim = drive(2.0, sill, dt=dt)
    assert sim.true_pose[0, 0] == pytest.approx(0.8, abs=1e-9)
    sim.set_pose("rover", (-1.0, 0.0, 0.0))
    # In the smaller steps, the wheels are now in the midst of the bump.
    sim.run(1.25 + dt)
    sim.set_pose("rover", (0.0, 0.0, 0.0))
    sim.run(0.5)
    assert sim.true_pose[0, 0] == pytest.approx(0.2, abs=1e-9)
    sim.set_pose("rover", (-0.5, 0.0, 0.0))
    sim.run(2.0)
    assert sim.true_pose[0, 0] == pytest.approx(0.3 - lacks(0.01), abs=1e-9)


@pytest.mark.parametrize("dt", [0.01, 0.02, 0.1])
@pytest.mark.parametrize("heading", one_in(3, [0.3, 0.5, 0.7]))
def test_both_wheels_of_a_robot_that_comes_aslant_meet_one_bump(dt, heading):
    sill = zone(Bump(height=0.004), shape=Shape.rectangle(0.02, 40.0), x=1.0)
    robot = building.robot(pose=am.Pose(heading=heading))
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=dt, zones=[sill]))
    sim.robot("rover").drive(forward=0.2)
    sim.run(10.0)
    assert sim.true_pose[0, 2] == pytest.approx(heading, abs=1e-9)


def test_one_replica_that_begins_again_meets_the_bumps_that_it_meets_alone():
    robot = building.robot(pose=am.Pose(), controller=building.Roam(), on_collision="continue")
    zones = [zone(Bump(height=0.01), shape=Shape.circle(0.3))]
    sim = am.Simulation(building.scenario(robot, map=building.empty(), dt=0.01, zones=zones), replicas=3)
    sim.run(1.0)
    sim.reset(replicas=[1])
    sim.run(3.0)
    alone = am.Simulation(sim.scenario, replicas=[1])
    alone.run(1.0)
    alone.reset()
    alone.run(3.0)
    assert sim.digest(1) == alone.digest(1)


@pytest.mark.parametrize("dt", [0.05, 0.1, 0.25])
def test_a_bump_at_a_time(dt):
    sim = drive(2.0, ground=[Bump(height=0.008, at=0.6, joint="right_wheel")], dt=dt)
    assert sim.true_pose[0, 2] == pytest.approx(-lacks(0.008) / TRACK, abs=1e-12)


@pytest.mark.parametrize("steps", [1, 20])
def test_a_rough_floor_has_its_bumps_by_the_metre(steps):
    """The number of bumps on 2 m, three on each: a Poisson distribution of mean 6, in one step or in twenty."""
    rows = 50_000
    samples = Samples(Bump(height=0.01, rate=3.0), rows=rows, k=2)
    total = np.zeros((rows, 2))
    for _ in range(steps):
        total += samples.ground(2.0 / steps, 0.1)
    count = np.rint((2.0 - total) / lacks(0.01))
    assert total == pytest.approx(2.0 - count * lacks(0.01), abs=1e-12)
    # Pearson's statistic of 13 classes: on average 12 with variance 24, here below five standard deviations.
    chances = [math.exp(-6.0) * 6.0**i / math.factorial(i) for i in range(12)]
    expected = 2 * rows * np.array([*chances, 1.0 - sum(chances)])
    found = np.array([*((count == i).sum() for i in range(12)), (count >= 12).sum()])
    assert ((found - expected) ** 2 / expected).sum() < 12.0 + 5.0 * math.sqrt(24.0)
    assert abs(np.corrcoef(count.T)[0, 1]) < 5.0 / math.sqrt(rows)


def test_a_bump_of_nothing_leaves_every_bit():
    for bump in (Bump(height=0.0, rate=5.0), Bump(height=0.01, rate=0.0), Bump(height=0.0, at=0.0)):
        values = np.array([[0.0, -0.0], [1.0 / 3.0, -1e-300], [-2.5, 7.0]])
        assert Samples(bump, rows=3, k=2).ground(values, 0.1).tobytes() == values.tobytes()


def test_bumps_that_are_nowhere_or_too_high_are_refused():
    with pytest.raises(ParameterError, match="either at or rate"):
        Bump(height=0.01, at=1.0, rate=1.0)
    with pytest.raises(am.ComponentError, match="expected at or rate, or to be in the ground of a zone"):
        drive(0.1, ground=[Bump(height=0.01)])
    with pytest.raises(am.ComponentError, match=r"expected less than the wheel's radius, 0\.0825 m, got 0\.1 m"):
        drive(0.1, ground=[Bump(height=0.1, at=0.0)])
    with pytest.raises(am.ComponentError, match="expected the ground of a robot or a zone, with 2 joints"):
        Samples(Bump(height=0.01, at=0.0), k=5)


# ------------------------------------------------------------------------------------------------------------ specs


def test_a_zone_has_a_plain_shape_and_a_name_of_its_own():
    with pytest.raises(ParameterError, match="a circle, a rectangle or a polygon without rounding"):
        zone(shape=Shape.polygon([(0, 0), (1, 0), (0, 1)], rounding=0.1))
    with pytest.raises(ParameterError, match="two zones are called 'zone'"):
        building.scenario(zones=[zone(), zone()])


def test_outlines_are_in_the_world():
    corners = zone(shape=Shape.rectangle(2.0, 1.0), x=3.0, y=1.0, heading=math.pi / 2.0).outline
    assert corners == pytest.approx(np.array([(3.5, 0.0), (3.5, 2.0), (2.5, 2.0), (2.5, 0.0)]), abs=1e-12)
