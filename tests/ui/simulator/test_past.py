"""What plots need of the past: kept in bounds, and the same as in the frames."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

import amorsim as am
from amorsim.noise.gaussian import Gaussian
from amorsim.ui.simulator.frames.frames import upper_triangle
from amorsim.ui.simulator.sources import past
from amorsim.ui.simulator.sources.player import Player
from tests import building

POSES, TWISTS, JOINTS = 12, 6, 4  # of a robot on two wheels


def player(robots: int = 1) -> Player:
    noisy = am.MountedSensor(sensor=building.ring(4), noise=building.chain(Gaussian(std=0.01)))
    fleet = [
        building.robot(
            name=f"r{i:02}",
            pose=am.Pose(x=0.5 + i % 6, y=0.5 + 0.6 * (i // 6)),
            shape=am.Shape.circle(0.1),
            controller=building.Roam(),
            on_collision="continue",
            sensors={"encoder": building.encoder(), "sonar": noisy, "laser": am.sensors.Laser(beams=19, range_max=8.0)},
        )
        for i in range(robots)
    ]
    return Player(am.Simulation(building.scenario(*fleet)))


def past_lines(one: Player, robot: int = 0, most: int = 3000) -> tuple[list[int], Any]:
    answer = one.pasts.of(robot, most)
    values = np.frombuffer(base64.b64decode(answer["values"]), "<f8")
    return answer["ticks"], values.reshape(len(answer["ticks"]), -1 if answer["ticks"] else 0)


def test_it_tells_what_the_frames_show() -> None:
    one = player()
    seen = []
    for _ in range(30):
        seen.append((one.frames(version=1, number=1, speed=1.0, achieved=1.0, flags=0)[0], one.simulation.covariance))
        one.step()
    ticks, lines = past_lines(one)
    assert ticks == list(range(31))
    for (moment, covariance), line in zip(seen, lines, strict=False):
        selected = moment.selected
        poses = [moment.true_pose[0], moment.estimated_pose[0], upper_triangle(covariance)[0]]
        twists = [selected.true_twist, selected.estimated_twist, selected.true_rates, selected.measured_rates]
        np.testing.assert_array_equal(line[: POSES + TWISTS + JOINTS], np.concatenate(poses + twists))
        # The encoder has two values, the sonar four, the laser nineteen; of that one eight are kept.
        first = np.r_[0:14]
        wanted = [selected.true[first], selected.measured[first]]
        wanted += [np.array([v[:2].min(), v[2:6].min(), v[6:].min()]) for v in (selected.true, selected.measured)]
        np.testing.assert_array_equal(line[POSES + TWISTS + JOINTS :], np.concatenate(wanted))


def test_going_on_from_the_past_forgets_what_came_after() -> None:
    one = player()
    for _ in range(30):
        one.step()
    one.scrub(12)
    assert past_lines(one)[0][-1] == 30
    one.go_on()
    assert past_lines(one)[0] == list(range(13))
    one.step()
    assert past_lines(one)[0] == list(range(14))
    one.reset()
    assert past_lines(one)[0] == [0]


def test_a_past_that_is_simulated_again_is_the_same() -> None:
    one = player()
    for _ in range(20):
        one.step()
    before = past_lines(one)
    one.resume(20)
    again = past_lines(one)
    assert again[0] == before[0]
    np.testing.assert_array_equal(again[1], before[1])


def test_it_stays_within_bounds_and_keeps_both_ends(monkeypatch: Any) -> None:
    monkeypatch.setattr(past, "MOST", 64)
    one = player()
    for _ in range(500):
        one.step()
    ticks, lines = past_lines(one)
    assert len(ticks) == len(lines) <= 64
    assert (ticks[0], ticks[-1]) == (0, 500)
    assert np.all(np.diff(ticks) > 0)
    ticks, lines = past_lines(one, most=10)
    assert len(ticks) <= 10
    assert ticks[-1] == 500
    np.testing.assert_array_equal(lines[-1][:3], one.simulation.true_pose[0])


def test_of_many_robots_only_those_that_somebody_looks_at_are_kept() -> None:
    one = player(past.FEW + 1)
    one.step()
    one.watched = (3,)
    one.step()
    assert past_lines(one, 0)[0] == [0, 1]
    assert past_lines(one, 3)[0] == [2]
    assert past_lines(one, 5)[0] == []
