"""ORCA: its linear program against brute force, and two agents against the steps of RVO2."""

import math

import numpy as np
import pytest

from amorsim.kernels.avoidance.reciprocal import nearest_velocity, reciprocal_velocities


def step(places, velocities, goals, *, radius=0.5, horizon=5.0, dt=0.1, fastest=2.0, wanted_speed=1.0):
    """A step of agents that know all of one another, as RVO2's examples have them."""
    count = len(places)
    others = np.empty((count, count - 1, 5))
    for i in range(count):
        rest = [j for j in range(count) if j != i]
        rest.sort(key=lambda j: math.dist(places[i], places[j]))
        others[i, :, :2] = places[rest] - places[i]
        others[i, :, 2:4] = velocities[rest]
        others[i, :, 4] = radius
    wanted = goals - places
    length = np.hypot(*wanted.T)[:, None]
    wanted = np.where(length > wanted_speed, wanted / np.maximum(length, 1e-300) * wanted_speed, wanted)
    lines, out = np.empty((count, count - 1, 4)), np.empty((count, 2))
    column = np.ones((count, 1))
    reciprocal_velocities(
        others, velocities, wanted, radius * column, fastest * column, horizon * column, dt, 0, count, lines, out
    )
    return out, lines


@pytest.mark.long
def test_two_agents_take_the_steps_of_rvo2():
    """R 5, r 0.5, horizon 5, steps of 0.1: there after 106 steps, 1.0004 apart at the least, 9.58 each.

    These are of RVO2 itself, rounded, whose numbers have 32 bits, and so have the places and velocities here. It needs
    that: what parts the two is that the second does not stand exactly opposite, by the sine of pi in 32 bits.
    """
    places = np.array([[5.0, 0.0], [-5.0, -4.3711e-7]], dtype=np.float32)
    goals, velocities = -places, np.zeros((2, 2))
    nearest, steps, gone = math.inf, 0, np.zeros(2)
    while (np.hypot(*(goals - places).T) > 0.5).any():
        velocities, _ = step(places, velocities, goals)
        velocities = velocities.astype(np.float32)
        places = (places + velocities * np.float32(0.1)).astype(np.float32)
        gone += np.hypot(*velocities.T) * 0.1
        nearest = min(nearest, math.dist(*places))
        steps += 1
        assert steps < 300
    assert steps == 106
    assert abs(nearest - 1.0004) < 1e-4 + 0.5e-4
    assert abs(gone.mean() - 9.58) < 0.005


def test_the_velocity_is_the_nearest_that_is_permitted():
    random = np.random.default_rng(2)
    grid = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 201)] * 2), axis=-1).reshape(-1, 2)
    grid = grid[np.hypot(*grid.T) <= 1.0]
    solved = 0
    for _ in range(60):
        angles = random.uniform(0.0, 2.0 * math.pi, 4)
        lines = np.concatenate(
            (random.uniform(-0.7, 0.7, (4, 2)), np.stack((np.cos(angles), np.sin(angles)), axis=1)), axis=1
        )
        wanted = random.uniform(-1.0, 1.0, 2)
        out = np.empty(2)
        kept = nearest_velocity(lines, 4, 1.0, *wanted, np.empty((4, 4)), out)
        # Left of a border is permitted: the amount by which each point of the grid breaks the worst.
        broken = np.max([dx * (py - grid[:, 1]) - dy * (px - grid[:, 0]) for px, py, dx, dy in lines], axis=0)
        mine = max(dx * (py - out[1]) - dy * (px - out[0]) for px, py, dx, dy in lines)
        assert np.hypot(*out) <= 1.0 + 1e-9
        if kept:
            solved += 1
            assert mine <= 1e-9
            fine = grid[broken <= 0.0]
            if len(fine):
                assert math.dist(out, wanted) <= np.hypot(*(fine - wanted).T).min() + 1e-9
        else:
            assert (broken > -0.02).all()
            assert mine <= broken.min() + 0.02
    assert 20 < solved < 60


def test_four_agents_on_a_circle_do_not_get_through():
    """As the reference: exact circles deadlock."""
    angles = 2.0 * math.pi * np.arange(4) / 4
    places = 5.0 * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    goals, velocities = -places, np.zeros((4, 2))
    for _ in range(600):
        velocities, _ = step(places, velocities, goals)
        places = places + velocities * 0.1
    assert (np.hypot(*(goals - places).T) > 1.0).all()
