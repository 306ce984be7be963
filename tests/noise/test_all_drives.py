"""What the ground does to wheels, it does to those of every drive."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Part
from amorsim.core.shapes import Shape
from amorsim.drives import Tricycle
from amorsim.noise import Bump, Diffusion, Gaussian, OdometryModel, Scale, Slip, VelocityModel
from amorsim.studies.umbmark import umbmark
from tests import building
from tests.drives.fleet import MAKERS, make
from tests.noise.sampling import Samples, assert_moments, assert_uncorrelated
from tests.some_cases import one_in


def simulate(name, *ground, zones=(), replicas=1, dt=0.1, **changes):
    robot = building.robot(
        drive=make(name), ground=building.chain(*ground), pose=am.Pose(), shape=Shape.circle(0.3), **changes
    )
    sim = am.Simulation(
        building.scenario(robot, map=building.empty(), dt=dt, zones=zones), replicas=replicas, threads=1
    )
    for replica in range(replicas):
        sim.robot("rover", replica).drive(forward=0.4)
    return sim


def rolled(sim):
    """What each rolling joint went by its angle [m] `(N, r)`."""
    (group,) = sim._fleet.groups
    return group.joints[:, group.locomotion.rolling] * group.drive.rolling_radius()


@pytest.mark.parametrize("name", MAKERS)
def test_slip_scale_and_zones_shorten_the_way_and_encoders_do_not_see_it(name):
    plain = simulate(name)
    plain.run(2.0)
    way = plain.true_pose[0, 0]
    everywhere = am.Zone(name="ice", shape=Shape.circle(50.0), ground=(Scale(factor=0.8),))
    for sim in (
        simulate(name, Slip(at=0.0, duration=9.0, factor=0.8)),
        simulate(name, Scale(factor=0.8)),
        simulate(name, zones=[everywhere]),
    ):
        sim.run(2.0)
        assert sim.true_pose[0] == pytest.approx([0.8 * way, 0.0, 0.0], abs=1e-9)
        assert sim.estimated_pose[0] == pytest.approx([way, 0.0, 0.0], abs=1e-9)
        assert rolled(sim).tobytes() == rolled(plain).tobytes()


@pytest.mark.parametrize("name", MAKERS)
def test_noise_by_length_has_its_variance_in_the_way(name):
    """Each of r wheels with an independent variance k per metre: their mean has k S / r."""
    k, replicas = 1e-4, 1500
    sim = simulate(name, Diffusion(variance_per_length=k), replicas=replicas)
    sim.run(2.0)
    (group,) = sim._fleet.groups
    way = float(rolled(sim)[0].mean())
    # The heading bends the way by the second order in k: here a part in a thousand of the variance.
    allowed = 5.0 * math.sqrt(2.0 / (replicas - 1)) + 1e-2
    along = sim.true_pose[:, 0] if len(group.locomotion.rolling) == 1 else np.hypot(*sim.true_pose[:, :2].T)
    assert along.var(ddof=1) == pytest.approx(k * way / len(group.locomotion.rolling), rel=allowed)


@pytest.mark.parametrize("name", MAKERS)
def test_a_bump_costs_the_way_of_an_edge(name):
    plain, bumped = simulate(name), simulate(name, Bump(height=0.01, at=1.0))
    for sim in (plain, bumped):
        sim.run(2.0)
    radius = float(plain._fleet.groups[0].drive.rolling_radius()[0, 0])
    phi = math.acos(1.0 - 0.01 / radius)
    lost = 2.0 * radius * (phi - math.sin(phi))
    assert plain.true_pose[0, 0] - bumped.true_pose[0, 0] == pytest.approx(lost, rel=1e-9)


@pytest.mark.parametrize("name", one_in(3, MAKERS))
def test_wheels_meet_a_sill_where_they_are(name):
    """A sill ahead is met by the foremost wheel first: by how far it stands before the base point."""
    sill = am.Zone(name="sill", shape=Shape.rectangle(0.01, 9.0), pose=am.Pose(x=1.0), ground=(Bump(height=0.01),))
    sim = simulate(name, zones=[sill], dt=0.01)
    (group,) = sim._fleet.groups
    ahead = float(group.drive.contacts(group.joints)[0, :, 0].max())
    assert ahead == {"tricycle": 0.6, "ackermann front": 0.5, "mecanum": 0.15}.get(name, 0.0)
    ways = [0.0]
    while ways[-1] < 1.1:
        sim.step()
        ways.append(float(sim.true_pose[0, 0]))
    steps = np.diff(ways)
    hindered = np.flatnonzero((steps < 0.8 * steps.max()) & (np.array(ways[:-1]) > 0.2))
    # The first step in which the way falls short: the wheel comes to the near edge of the sill in it.
    assert ways[hindered[0]] + ahead <= 0.995 + 1e-9
    assert ways[hindered[0]] + ahead + steps.max() >= 0.995


@pytest.mark.parametrize("name", MAKERS)
def test_snapshots_and_replicas_keep_their_bits(name):
    zones = [
        am.Zone(
            name="patch",
            shape=Shape.circle(0.5),
            pose=am.Pose(x=0.8),
            ground=(Diffusion(variance_per_length=1e-4), Bump(height=0.004, rate=3.0)),
        )
    ]
    ground = (Gaussian(proportional=0.02, per="increment"), Diffusion(variance_per_length=1e-5))
    sim = simulate(name, *ground, zones=zones, replicas=3)
    sim.run(1.0)
    middle = sim.snapshot()
    sim.run(1.0)
    end = sim.digest(2)
    sim.restore(middle)
    sim.run(1.0)
    assert sim.digest(2) == end
    robot = sim.scenario
    alone = am.Simulation(robot, replicas=[2])
    alone.robot("rover").drive(forward=0.4)
    alone.run(2.0)
    assert alone.digest(2) == end


@pytest.mark.parametrize("model", [VelocityModel, OdometryModel])
def test_models_of_the_bodys_motion_refuse_drives_that_steer_and_have_parts(model):
    class Lorry(Tricycle):
        parts = (Part("trailer", Shape.circle(0.1)),)

    lorry = Lorry(**MAKERS["tricycle"][1])
    with pytest.raises(am.ComponentError, match=r"expected a drive without parts, .* got Lorry"):
        Samples(model(), rows=1, k=1, drive=lorry)


@pytest.mark.parametrize(("ahead", "aside", "turn"), [(0.04, 0.0, 0.0), (0.03, -0.04, 0.06), (0.0, 0.0, 0.1)])
def test_a_mecanum_drives_motion_has_the_velocity_models_variances(ahead, aside, turn):
    drive = make("mecanum")
    lever = 0.5 * (drive.wheelbase + drive.track)
    travel = [ahead - aside - lever * turn, ahead + aside + lever * turn]
    travel += [ahead + aside - lever * turn, ahead - aside + lever * turn]
    a = {"a1": 0.02, "a2": 1e-3, "a3": 0.3, "a4": 0.05}
    samples = Samples(VelocityModel(**a), rows=100_000, k=4, drive=drive)
    out = samples.ground(travel, 0.1)
    fl, fr, rl, rr = out.T
    found = np.array([fl + fr + rl + rr, -fl + fr + rl - rr, (-fl + fr - rl + rr) / lever]) / 4.0
    way = math.hypot(ahead, aside)
    direction = (ahead / way, aside / way) if way else (1.0, 0.0)
    along = direction[0] * found[0] + direction[1] * found[1] - way
    across = direction[0] * found[1] - direction[1] * found[0]
    spread = math.sqrt(a["a1"] * way**2 + a["a2"] * turn**2)
    assert_moments(along, spread)
    assert np.abs(across).max() < 1e-15
    assert_moments(found[2] - turn, math.sqrt(a["a3"] * way**2 + a["a4"] * turn**2))
    assert_uncorrelated(along, found[2])
    assert np.abs((fl + fr) - (rl + rr)).max() < 1e-15  # wheels are not set against one another


def test_a_mecanum_model_of_nothing_leaves_every_bit():
    values = np.array([[0.0, -0.0, 1.0 / 3.0, -1e-300], [2.0, 7.0, -2.5, 1e-9]])
    for noise in (VelocityModel(), OdometryModel(interval=0.1)):
        out = Samples(noise, rows=2, k=4, drive=make("mecanum")).ground(values, 0.1)
        assert out.tobytes() == values.tobytes()


@pytest.mark.parametrize("name", [name for name in MAKERS if name not in ("differential", "tractor")])
def test_umbmark_refuses_drives_that_are_not_differential(name):
    robot = building.robot(drive=make(name), pose=am.Pose(), shape=Shape.circle(0.3))
    kind = type(make(name)).__name__
    with pytest.raises(am.AmorsimError, match=f"UMBmark is for differential drives, and this one's is {kind}"):
        umbmark(building.scenario(robot, map=building.empty()))
