"""MPPI: without noise its plan stays, at no temperature the best run is taken."""

import math

import numpy as np

from amorsim.kernels.avoidance.dynamic_window import Abilities
from amorsim.kernels.avoidance.guide import Guide
from amorsim.kernels.avoidance.sampling import Costs, Field, distances, roll_out
from amorsim.kernels.behaviours.free_space import Sight

FIELD = Field(60, 0.1)
DISC = np.array([[0.0, 0.0, 0.2]])


def column(value):
    return np.full((1, 1), value)


def improved(plan, noise, *, temperature=0.05, ranges=math.inf, goal=(5.0, 0.0), moving=(0.5, 0.0)):
    """A plan after a step of MPPI of a robot at the origin that sees something at `ranges` ahead."""
    bearings = np.linspace(-0.5, 0.5, 21)
    beams = np.zeros((1, 5, 21))
    beams[0, 2:5] = bearings, np.cos(bearings), np.sin(bearings)
    plan = np.array([plan], dtype=float)
    roll_out(
        Sight(np.full((1, 21), ranges), beams, column(0.0), 1),
        column(0.0),
        np.zeros((1, 3)),
        DISC,
        FIELD,
        Guide(np.array([[goal]]), np.zeros((1, 1)), np.ones(1, np.int64), np.zeros(1, np.int64)),
        Abilities(
            column(1.0), column(0.0), column(2.0), np.array([[1.5, 3.0, 99.0, 99.0]]), column(math.inf), column(0.0)
        ),
        Costs(*map(column, (temperature, 2.0, 1.0, 0.2, 5.0, 0.05))),
        np.array([noise], dtype=float),
        0.1,
        np.array([moving]),
        0,
        1,
        plan,
    )  # fmt: skip
    return plan[0]


def test_without_noise_the_plan_stays():
    plan = np.tile((0.5, 0.1), (10, 1))
    assert improved(plan, np.zeros((5, 10, 2))).tolist() == plan.tolist()


def test_at_no_temperature_the_best_run_is_taken():
    random = np.random.default_rng(1)
    noise = random.normal(size=(40, 10, 2)) * (0.1, 0.3)
    plan = np.tile((0.5, 0.0), (10, 1))
    best = improved(plan, noise, temperature=1e-9)
    ends = []
    for run in np.clip(plan + noise, (0.0, -2.0), (1.0, 2.0)):
        heading = np.concatenate(([0.0], np.cumsum(run[:, 1] * 0.1)))
        middle = 0.5 * (heading[1:] + heading[:-1])
        end = (run[:, 0] * 0.1 * np.cos(middle)).sum(), (run[:, 0] * 0.1 * np.sin(middle)).sum()
        ends.append(math.dist(end, (5.0, 0.0)))
    expected = np.clip(plan + noise[int(np.argmin(ends))], (0.0, -2.0), (1.0, 2.0))
    np.testing.assert_allclose(best, expected, atol=1e-9)


def test_it_turns_from_what_is_ahead():
    random = np.random.default_rng(2)
    noise = random.normal(size=(200, 15, 2)) * (0.2, 1.0)
    plan = np.tile((0.8, 0.0), (15, 1))
    free = improved(plan, noise.copy())
    blocked = improved(plan, noise.copy(), ranges=0.9)
    assert free[:, 0].sum() > blocked[:, 0].sum() + 1.0
    assert np.abs(blocked[:, 1]).sum() > np.abs(free[:, 1]).sum() + 1.0


def test_distances_are_those_to_the_nearest_point():
    random = np.random.default_rng(3)
    points = np.full((3, 6), math.inf)
    points[:2, :5] = random.uniform(-2.5, 2.5, (2, 5))
    out = np.empty((60, 60))
    distances(points, FIELD, out)
    middles = (np.arange(60) - 30 + 0.5) * 0.1
    cells = np.floor(points[:2, :5] / 0.1) * 0.1 + 0.05
    exact = np.hypot(middles[None, :, None] - cells[0], middles[:, None, None] - cells[1]).min(axis=2)
    exact = np.minimum(exact, 1.0)
    assert (np.abs(out - exact) <= 0.042 * exact + 1e-9).all()
