"""Wandering: its spread is the random walk's, and it gets away from what is in its way."""

from __future__ import annotations

import numpy as np
import pytest

import amorsim as am
from amorsim.motions import Wander
from tests.motions.worlds import obstacle, track, world


def test_the_course_drifts_as_it_says() -> None:
    # 400 replicas for 2 s: the course turns by a normal angle of standard deviation 0.4 sqrt(2); of 400 draws the
    # standard deviation is within 4 / sqrt(2 * 400) = 14 % of it, but for one seed in 16,000.
    thing = obstacle(Wander(speed=0.5, course_std=0.4), pose=am.Pose(x=5.0, y=5.0))
    sim = world(thing, replicas=400)
    sim.step()
    first = np.array([np.arctan2(*sim.obstacle("thing", r).true_twist[1::-1]) for r in range(400)])
    first += np.array([sim.obstacle("thing", r).true_pose[2] for r in range(400)]) * 0.0
    course = sim._fleet.obstacles[0].state["course"].copy()
    sim.run(2.0)
    turned = (sim._fleet.obstacles[0].state["course"] - course)[:, 0]
    assert np.std(turned) == pytest.approx(0.4 * np.sqrt(2.0), rel=0.142)
    assert abs(np.mean(turned)) < 4.0 * 0.4 * np.sqrt(2.0) / 20.0
    # The first course is any: mean of its direction within four standard errors of nowhere.
    assert np.hypot(np.cos(course).mean(), np.sin(course).mean()) < 4.0 / np.sqrt(400.0)


def test_it_keeps_its_speed_in_the_open_and_stays_in_the_room() -> None:
    poses = track(world(obstacle(Wander(speed=0.8), pose=am.Pose(x=2.0, y=2.0)), size=4.0), 600)
    moved = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert moved.max() <= 0.08 + 1e-12
    assert np.median(moved) == pytest.approx(0.08)
    assert poses[:, :2].min() > 0.2
    assert poses[:, :2].max() < 3.8 + 0.02


def test_blocked_it_waits_for_ever_if_set_so() -> None:
    poses = track(
        world(obstacle(Wander(speed=0.8, course_std=0.0, blocked="wait"), pose=am.Pose(x=2.0, y=2.0)), size=4.0), 100
    )
    assert (poses[-1] == poses[-20]).all()
