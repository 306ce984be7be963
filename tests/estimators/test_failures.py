"""Filters whose numbers explode: an event, and nothing for the rows beside them."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import amorsim as am
from tests.estimators.test_ekf_consistency import FUSIONS


@attrs.frozen(kw_only=True)
class Exploding(am.Noise):
    """Ranges so large, in one replica and at one time, that no filter's numbers hold them."""

    def start(self, context):
        return {"time": np.zeros((context.rows, 1))}

    def corrupt(self, values, side, elapsed, state, draws):
        state["time"] = state["time"] + elapsed
        first = draws.counter[:, :1] == 1
        return np.where(first & (np.abs(state["time"] - 1.0) < 0.01) & np.isfinite(values), 1e308, values)


def scenario(on_failure, explodes=True):
    given = am.load("landmarks")
    rover = given.robots[0]
    unit = rover.sensors["fiducial"]
    noise = (*unit.noise, am.NoiseElement(name="bang", noise=Exploding(), column="range"))
    fiducial = attrs.evolve(unit, noise=noise) if explodes else unit
    estimator = attrs.evolve(FUSIONS["landmarks"], gate=1.0, on_failure=on_failure)
    rover = attrs.evolve(rover, sensors=rover.sensors | {"fiducial": fiducial}, estimators={"ekf": estimator})
    return attrs.evolve(given, robots=[rover], resolved=None)


@pytest.mark.parametrize("on_failure", ["continue", "end"])
def test_it_is_an_event_and_leaves_other_rows_alone(on_failure):
    sim = am.Simulation(scenario(on_failure), replicas=3)
    clean = am.Simulation(scenario(on_failure, explodes=False), replicas=3)
    with np.errstate(all="ignore"):
        sim.run(1.0)
        at_failure = sim.estimated_pose[1].copy()
        sim.run(1.0)
    clean.run(2.0)
    kinds = [(event.kind, event.replica, event.tick) for event in sim.events]
    wanted = [("estimator_failed", 1, 10)] + [("controller_ended", 1, 10)] * (on_failure == "end")
    assert kinds == wanted
    assert sim.events[0].path == "estimators.ekf"
    assert "estimators.ekf exploded" in str(sim.events[0])
    assert np.isfinite(sim.estimated_pose).all()
    assert np.isfinite(sim.covariance).all()
    for row in (0, 2):
        assert sim.estimated_pose[row].tobytes() == clean.estimated_pose[row].tobytes()
        assert sim.covariance[row].tobytes() == clean.covariance[row].tobytes()
    has_moved = bool((sim.estimated_pose[1] != at_failure).all())
    assert has_moved == (on_failure == "continue")
    away = np.hypot(*(sim.true_pose - sim.estimated_pose)[1, :2])
    assert away < 0.2
