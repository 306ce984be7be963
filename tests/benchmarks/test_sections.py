"""The sections of crowds, mixed fleets and compositions: that what they time is what they say."""

from __future__ import annotations

import re
import time
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from benchmarks import compositions, crowd, mixed
from benchmarks.contest import drive
from benchmarks.ours import given


def test_a_crowd_walks_and_is_timed_in_simulated_seconds() -> None:
    rows = crowd._contest(9, 16.0, 2, 0.02, time.perf_counter, lambda _: None)
    assert rows[0].side == "amorsim"
    assert rows[0].unit == "simulated s/s"
    assert all(len(row.rounds) == 2 for row in rows)
    walked = re.search(r"people went (.*) m/s", rows[0].note)
    assert walked is not None
    assert 0.3 < float(walked.group(1)) < crowd.SPEED


def test_a_crowd_has_as_much_room_as_it_says() -> None:
    side, starts, goals = crowd._people(100, 4.0)
    assert side == pytest.approx(20.0)
    gaps = np.linalg.norm(starts[:, None] - starts[None], axis=2) + 10.0 * np.eye(100)
    assert gaps.min() > 2.0 * crowd.RADIUS
    for places in (starts, goals):
        assert places.min() > 0.5
        assert places.max() < side - 0.5


def test_commands_given_make_one_group() -> None:
    assert given(1.0, 2.0) is given(1.0, 2.0)
    command = given(1.0, 2.0).command(type("Robot", (), {"rows": 3}), {}, None, None, {}, None)
    np.testing.assert_array_equal(command, [[1.0, 2.0]] * 3)


def test_all_models_that_ship_are_in_the_mixed_fleet() -> None:
    folder = Path(am.__file__).parent / "robots"
    assert set(mixed.MODELS) == {file.stem for file in folder.glob("*.toml")}


@pytest.mark.parametrize("name", [compositions._PLAIN, compositions._EKF, "an Ackermann car, commands given"])
def test_a_composition_goes_its_way_and_meets_nothing(name: str) -> None:
    side = compositions._side(compositions._COMPOSITIONS[name], 1)
    before = side.simulation.true_pose.copy()
    drive(side, 20, 0.0, time.perf_counter)
    assert np.hypot(*(side.simulation.true_pose - before)[0, :2]) > 0.05
    assert not side.simulation.events


def test_an_estimator_keeps_count_of_its_own_time() -> None:
    side = compositions._side(compositions._COMPOSITIONS[compositions._EKF], 1)
    compositions._Own.seconds = 0.0
    made = drive(side, 20, 0.0, time.perf_counter)
    assert 0.0 < compositions._Own.seconds < made.seconds


def test_the_far_obstacle_is_far() -> None:
    robot, post = compositions._with_post(compositions._plain())
    assert isinstance(post, am.Obstacle)
    assert robot.pose is not None
    assert np.hypot(post.pose.x - robot.pose.x, post.pose.y - robot.pose.y) > 20.0
