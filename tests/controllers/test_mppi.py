"""Model predictive path integral control: noisy runs of a plan, weighed by what they cost."""

import numpy as np

import amorsim as am
from tests.controllers.test_dwa import make, said, simulate

POSTS = [(x, y, x, y + 0.3) for x, y in ((2.0, -0.2), (3.5, 0.6), (3.5, -1.2))]
FEW = {"goals": ((6.0, 0.3),), "speed": 0.5, "samples": 200, "time_steps": 40}


def test_it_passes_posts():
    simulation = simulate([make(am.controllers.Mppi(**FEW))], POSTS, duration=60.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]


def test_without_noise_its_plan_stays_the_nominal_one():
    """All runs are the plan itself then, so it stays what it is at the start: to stand, however far the goal is."""
    still = am.controllers.Mppi(**FEW, speed_noise=0.0, turn_rate_noise=0.0)
    simulation = simulate([make(still)], POSTS, duration=0.0)
    before = simulation.true_pose.copy()
    for _ in range(20):
        simulation.step()
        plan = simulation.frames()[0].beliefs["controller"]["plan"]
        np.testing.assert_array_equal(plan, np.zeros_like(plan))
    np.testing.assert_array_equal(simulation.true_pose, before)
