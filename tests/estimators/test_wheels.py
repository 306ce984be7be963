"""Encoders whose readings come late, or are lost for a while."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import amorsim as am
from tests.estimators.test_bits import MAKERS, scenario


def followed(name, lost=(), begins=0, value=np.nan, jumps=()):
    """The last pose of an estimator that got no reading of the encoder in some steps, and what it is with all."""
    sim = am.Simulation(scenario(name), seed=5)
    runner = am.EstimatorRunner(sim.scenario.robots[0], "it", dt=sim.dt, seed=5)
    for step in range(12):
        if step:
            sim.step()
        frame = sim.frames()[0]
        readings = {sensor: reading.measured[0].copy() for sensor, (_, reading) in frame.readings.items()}
        if step < begins:
            del readings["encoder"]
        elif step in lost:
            readings["encoder"][-1] = value
        elif step in jumps:
            readings["encoder"][0] += 1e9
        estimate = runner.update(frame.time[0], readings, frame.command[0])
        assert np.isfinite(estimate.covariance).all()
        if "failed" in frame.beliefs.get("it", {}):
            assert not runner.beliefs["failed"]
    return estimate.pose, frame.estimates["it"].pose[0]


@pytest.mark.parametrize("name", MAKERS)
def test_a_lost_reading_is_made_up_for_by_the_next(name):
    found, wanted = followed(name, lost=(4, 5))
    # A robot that turns while its encoder is silent: 0.1 m in one piece, and not in three.
    assert np.hypot(*(found - wanted)[:2]) < 0.03
    assert abs(found[2] - wanted[2]) < 0.03


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e308])
@pytest.mark.parametrize("name", MAKERS)
def test_what_no_wheel_can_have_turned_is_a_lost_reading(name, value):
    found, wanted = followed(name, lost=(4,), value=value)
    assert np.hypot(*(found - wanted)[:2]) < 0.03
    assert abs(found[2] - wanted[2]) < 0.03


@pytest.mark.parametrize("name", MAKERS)
def test_a_log_need_not_begin_with_the_encoder(name):
    found, wanted = followed(name, begins=2)
    # What the wheels did before their first reading nobody knows: 0.08 m at most. Particles are drawn at other times.
    assert np.hypot(*(found - wanted)[:2]) < (0.3 if name == "monte_carlo" else 0.1)


@pytest.mark.parametrize("jumps", [(5,), range(5, 12)], ids=["once", "for good"])
@pytest.mark.parametrize("name", MAKERS)
def test_counts_that_jump_further_than_a_wheel_turns_begin_again(name, jumps):
    found, wanted = followed(name, jumps=jumps)
    # What the wheels did in the step of a jump nobody knows: 0.08 m in two steps at most.
    assert np.hypot(*(found - wanted)[:2]) < (0.3 if name == "monte_carlo" else 0.1)
    assert abs(found[2] - wanted[2]) < 0.1


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (2,)])
def test_angles_of_other_joints_than_the_drives_are_refused(shape):
    """Of an encoder of somebody's own, before a kernel reads beyond them."""

    class Odd(am.sensors.Encoder):
        def angles(self, values):
            return np.zeros(shape)

    robot = scenario("dead_reckoning").robots[0]
    odd = Odd(counts_per_revolution=100.0)
    changed = attrs.evolve(robot, sensors=dict(robot.sensors) | {"encoder": odd})
    with pytest.raises(am.ComponentError, match=r"sensor 'encoder' \(Odd\): expected .* \(1, 2\) \[rad\], got one of"):
        am.Simulation(attrs.evolve(scenario("dead_reckoning"), robots=[changed]))
