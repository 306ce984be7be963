"""Monte Carlo localization in a small room."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.core.parameters import ParameterError
from amorsim.sensors import Laser
from amorsim.testing import check_component

WALLS = [[0, 0, 6, 0], [6, 0, 6, 4], [6, 4, 0, 4], [0, 4, 0, 0], [2, 0, 2, 1.5], [4.5, 4, 4.5, 3]]
START = am.Pose(x=1.0, y=2.0)
KNOWN = am.InitialBelief(kind="gaussian", std=0.1, heading_std=0.05)
NOTHING = am.InitialBelief(kind="nothing")


def estimator(**changes):
    given = {
        "wheel_variance": 1e-4,
        "beams": 24,
        "particles_min": 200,
        "particles_max": 1000,
        "tempering": 0.3,
        "update_distance": 0.1,
    }
    return am.estimators.MonteCarlo(**(given | changes))


def scenario(using, belief=KNOWN, walls=WALLS, start=START, turn=3.0, **changes):
    """A robot that goes round in the room; its laser looks all about."""
    room = am.Map.from_segments(walls, resolution=0.05)
    robot = am.load_robot("pioneer2dx")
    laser = am.MountedSensor(sensor=Laser(beams=72, fov=2.0 * math.pi), noise=[am.noise.Gaussian(std=0.03)])
    robot = attrs.evolve(
        robot,
        pose=start,
        initial_belief=belief,
        knowledge=am.Knowledge(map=room),
        ground=[am.noise.Diffusion(variance_per_length=1e-4)],
        sensors={"encoder": robot.sensors["encoder"], "laser": laser},
        controller=lambda readings, estimate, clock: am.WheelSpeeds(turn, 2.0 * turn),
        estimators={"where": using},
        **changes,
    )
    return am.Scenario(map=room, robots=[robot])


def errors(sim):
    """Distances [m] and turns [rad] between truth and estimate."""
    off = sim.true_pose - sim.estimated_pose
    return np.hypot(off[:, 0], off[:, 1]), np.abs(am.wrap_angle(off[:, 2]))


def beliefs(sim):
    return sim.frames()[0].beliefs["where"]


@pytest.mark.parametrize("model", ["likelihood_field", "beam"])
def test_it_tracks(model):
    sim = am.Simulation(scenario(estimator(model=model)), replicas=4)
    sim.run(6.0)
    away, turned = errors(sim)
    assert away.max() < 0.15
    assert turned.max() < math.radians(6.0)
    assert not sim.events


def test_it_finds_itself_from_nothing():
    using = estimator(particles_max=4000)
    sim = am.Simulation(scenario(using, NOTHING), replicas=3)
    first = beliefs(sim)["count"]
    sim.run(8.0)
    away, turned = errors(sim)
    assert away.max() < 0.3
    assert turned.max() < math.radians(10.0)
    assert (beliefs(sim)["count"] < first).all()


def test_beliefs_are_particles_with_weights_and_the_modes():
    sim = am.Simulation(scenario(estimator(particles_max=800), NOTHING), replicas=2)
    sim.run(1.0)
    found = beliefs(sim)
    assert found["particles"].shape == (2, 800, 3)
    for row in range(2):
        count = found["count"][row]
        assert np.isfinite(found["particles"][row, :count]).all()
        assert np.isnan(found["particles"][row, count:]).all()
        assert np.nansum(found["weights"][row]) == pytest.approx(1.0, abs=1e-12)
        weights = found["hypotheses_weight"][row]
        weights = weights[np.isfinite(weights)]
        assert (np.diff(weights) <= 0.0).all()
        assert weights.sum() <= 1.0 + 1e-12
        np.testing.assert_allclose(found["hypotheses"][row, 0], sim.estimated_pose[row], atol=1e-12)


def test_a_replica_alone_and_among_others_has_the_same_bits():
    for model in ("likelihood_field", "beam"):
        given = scenario(estimator(model=model, recovery_slow=0.01, recovery_fast=0.2), NOTHING)
        many, one = am.Simulation(given, replicas=7, threads=2), am.Simulation(given, replicas=[4])
        many.run(2.0)
        one.run(2.0)
        assert many.digest(4) == one.digest(4)
        every, alone = beliefs(many), beliefs(one)
        for name, array in alone.items():
            assert array[0].tobytes() == every[name][4].tobytes(), name


def test_restored_from_a_snapshot_it_goes_on_as_before():
    sim = am.Simulation(scenario(estimator(), NOTHING), replicas=2)
    sim.run(1.0)
    kept = sim.snapshot().to_bytes()
    sim.run(2.0)
    digest, before = sim.digest(), {name: array.tobytes() for name, array in beliefs(sim).items()}
    sim.restore(kept)
    sim.run(2.0)
    assert sim.digest() == digest
    assert {name: array.tobytes() for name, array in beliefs(sim).items()} == before


@attrs.frozen(kw_only=True)
class Lost(am.Noise):
    """No beam returns, in one replica and for half a second."""

    def start(self, context):
        return {"time": np.zeros((context.rows, 1))}

    def corrupt(self, values, side, elapsed, state, draws):
        state["time"] = state["time"] + elapsed
        return np.where((draws.counter[:, :1] == 1) & (np.abs(state["time"] - 1.0) < 0.25), np.inf, values)


@pytest.mark.parametrize("on_failure", ["continue", "end"])
def test_a_scan_that_no_particle_explains_is_an_event_and_leaves_other_rows_alone(on_failure):
    # That a beam does not return from a wall near by has the probability 0, not a small one.
    using = estimator(model="beam", z_max=0.0, hit_std=0.05, tempering=0.1, on_failure=on_failure)
    given = scenario(using)
    robot = given.robots[0]
    laser = attrs.evolve(
        robot.sensors["laser"],
        noise=(*robot.sensors["laser"].noise, am.NoiseElement(name="lost", noise=Lost())),
    )
    lossy = attrs.evolve(given, robots=[attrs.evolve(robot, sensors={**robot.sensors, "laser": laser})])
    sim, clean = (am.Simulation(one, replicas=3) for one in (lossy, given))
    sim.run(2.0)
    clean.run(2.0)
    kinds = [event.kind for event in sim.events]
    assert {event.replica for event in sim.events} == {1}
    assert kinds.count("estimator_failed") >= 1
    assert kinds.count("controller_ended") == (on_failure == "end")
    assert sim.events[0].path == "estimators.where"
    assert not clean.events
    for row in (0, 2):
        assert sim.estimated_pose[row].tobytes() == clean.estimated_pose[row].tobytes()
        assert sim.covariance[row].tobytes() == clean.covariance[row].tobytes()
    away, turned = errors(sim)
    assert away.max() < 0.3
    assert turned.max() < math.radians(10.0)


def test_between_scans_wheels_carry_the_estimate_and_the_cloud():
    sim = am.Simulation(scenario(estimator(update_distance=50.0, update_angle=50.0)))
    first = beliefs(sim)
    start, estimated = first["particles"][0, 0], sim.estimated_pose[0].copy()
    sim.run(1.0)
    moved = am.relative(estimated[None], sim.estimated_pose)
    found = beliefs(sim)["particles"][0, 0]
    np.testing.assert_allclose(am.relative(start[None], found[None]), moved, atol=1e-9)
    assert np.hypot(*moved[0, :2]) > 0.1
    assert (np.diagonal(sim.covariance[0]) > 0.0).all()


def test_it_gives_the_same_in_the_runner():
    given = scenario(estimator(), NOTHING)
    sim = am.Simulation(given, replicas=[2])
    runner = am.EstimatorRunner(given.robots[0], "where", seed=sim.seed, replica=2)
    for _ in range(12):
        frame = sim.frames()[0]
        readings = {name: reading.measured[0] for name, (_, reading) in frame.readings.items()}
        estimate = runner.update(frame.time[0], readings, frame.command[0])
        assert estimate.pose.tobytes() == sim.estimated_pose[0].tobytes()
        sim.step()


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"particles_min": 2000}, "particles_min: expected at most particles_max 1000"),
        ({"particles_min": 0}, "particles_min: expected a whole number >= 1"),
        ({"particles_max": 0, "particles_min": 1}, "particles_max: expected a whole number >= 1"),
        ({"recovery_slow": 0.1}, "recovery_slow: expected a gain above 0 and below recovery_fast"),
        ({"recovery_slow": 0.2, "recovery_fast": 0.1}, "recovery_slow"),
        ({"tempering": 0.0}, "tempering"),
        ({"z_random": 0.0}, "z_random"),
    ],
)
def test_numbers_that_make_no_filter_are_refused(changes, problem):
    with pytest.raises(ParameterError, match=problem):
        estimator(**changes)


def knowing(world, using):
    given = scenario(using)
    robot = attrs.evolve(given.robots[0], knowledge=am.Knowledge(map=world))
    return attrs.evolve(given, robots=[robot])


def test_what_it_cannot_do_without_is_named():
    large = am.Map.from_segments([[0, 0, 1000, 1000]], resolution=0.01)
    for given, problem in (
        (knowing(None, estimator()), r"it knows none; name one in knowledge\.map"),
        (scenario(estimator(laser="encoder")), "measures no ranges along beams"),
        (scenario(estimator(laser="lidar")), "'lidar', which the robot does not have"),
        (knowing(large, estimator(field_resolution=0.01)), r"likelihood field of .* cells .* is too large"),
    ):
        with pytest.raises(am.ComponentError, match=problem):
            am.Simulation(given)


def test_it_tells_what_it_uses():
    listed = estimator().sources()
    assert listed[0] == ("sensor 'encoder'", "moves the particles", "0.0001 m² of travel per m")
    assert listed[1] == ("sensor 'laser'", "weighs x, y, heading", "24 beams, its likelihood field, 0.2 m")


@pytest.mark.parametrize("changes", [{}, {"model": "beam"}, {"weighting": "cubed"}])
def test_it_keeps_the_contract(changes):
    check_component(
        estimator(particles_min=20, particles_max=60, age_max=1.0, recovery_slow=0.01, recovery_fast=0.2, **changes)
    )
