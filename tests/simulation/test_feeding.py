"""Estimators that take the estimates of others come after them, in whatever order a robot lists them."""

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.simulation.estimation.feeding import feeders, feeding_order


@attrs.frozen(kw_only=True)
class Follower(am.Estimator):
    """One metre left of the mean of the estimators that it names, with the covariance of the first."""

    first: str = am.parameter(refers="estimators")
    second: str = am.parameter("", refers="estimators")

    def update(self, robot, readings, command, elapsed, state, draws):
        given = [readings[f"estimators.{name}"] for name in feeders(self)]
        for one in given:
            assert one.fresh.all()
            assert not one.age.any()
        poses = [one.measured[:, :3] for one in given]
        pose = (poses[0] + poses[-1]) / 2.0 + [0.0, 1.0, 0.0]
        return am.Estimate(pose, given[0].measured[:, 3:].reshape(-1, 3, 3))


def test_each_comes_after_those_that_feed_it_and_else_in_the_order_given():
    wheels = am.estimators.DeadReckoning()
    given = {"a": Follower(first="c"), "b": wheels, "c": Follower(first="d", second="b"), "d": wheels}
    assert feeding_order(given) == {"d": (), "b": (), "c": ("d", "b"), "a": ("c",)}


def rover(**estimators):
    return attrs.evolve(am.load("landmarks").robots[0], estimators=estimators)


def simulate(robot, steps=5):
    sim = am.Simulation(attrs.evolve(am.load("landmarks"), robots=[robot]), replicas=2)
    for _ in range(steps):
        sim.step()
    return sim


def test_estimates_of_the_same_step_are_given_along_a_chain():
    wheels = am.estimators.DeadReckoning(wheel_variance=1e-5)
    sim = simulate(rover(last=Follower(first="middle"), middle=Follower(first="wheels"), wheels=wheels))
    found = sim.frames()[0].estimates
    assert list(found) == ["last", "middle", "wheels"]
    for name, left in (("middle", 1.0), ("last", 2.0)):
        np.testing.assert_array_equal(found[name].pose, found["wheels"].pose + np.array([0.0, left, 0.0]))
        np.testing.assert_array_equal(found[name].covariance, found["wheels"].covariance)
    assert found["wheels"].covariance.any()


@pytest.mark.parametrize(
    ("estimators", "message"),
    [
        ({"a": Follower(first="weels"), "wheels": am.estimators.DeadReckoning()}, "Did you mean 'wheels'"),
        ({"a": Follower(first="b"), "b": Follower(first="a")}, "estimator 'a': .* 'a' waits for 'b' waits for 'a'"),
    ],
)
def test_a_source_that_is_not_there_and_a_circle_are_refused(estimators, message):
    with pytest.raises(am.ComponentError, match=message):
        simulate(rover(**estimators))
    with pytest.raises(am.ComponentError, match=message):
        am.EstimatorRunner(rover(**estimators), "a")
