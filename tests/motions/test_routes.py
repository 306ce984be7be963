"""Routes: exact in time, whatever the step; what is in the way is waited for, or the waypoint is left out."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import amorsim as am
from amorsim.motions import Loop, Oscillate, Waypoints
from tests import building
from tests.examples import settings
from tests.motions.worlds import DT, obstacle, track, world

SQUARE = ((2.0, 2.0), (4.0, 2.0), (4.0, 4.0), (2.0, 4.0))


def along(points: list[tuple[float, float]], distance: float) -> tuple[float, float]:
    """The place at a distance along lines from point to point; the last beyond the end."""
    for (ax, ay), (bx, by) in itertools.pairwise(points):
        length = float(np.hypot(bx - ax, by - ay))
        if distance <= length and length > 0:
            return ax + (bx - ax) * distance / length, ay + (by - ay) * distance / length
        distance -= length
    return points[-1]


def test_without_a_pose_it_starts_at_the_first_waypoint_and_looks_ahead() -> None:
    thing = obstacle(Loop(waypoints=((2.0, 1.0), (2.0, 4.0)), speed=0.6))
    assert thing.pose == am.Pose(x=2.0, y=1.0, heading=np.pi / 2)
    assert obstacle(Loop(waypoints=SQUARE), pose=am.Pose(x=1.0)).pose == am.Pose(x=1.0)
    assert obstacle(None).pose == am.Pose()


def test_once_and_then_it_stays() -> None:
    poses = track(world(obstacle(Waypoints(waypoints=SQUARE, speed=0.7))), 120)
    for tick, (x, y, _) in enumerate(poses):
        assert (x, y) == pytest.approx(along(list(SQUARE), 0.7 * DT * tick), abs=1e-9)
    assert poses[-1, :2].tolist() == [2.0, 4.0]


def test_round_and_round() -> None:
    poses = track(world(obstacle(Loop(waypoints=SQUARE, speed=0.9))), 200)
    ring = [*SQUARE, SQUARE[0]]
    for tick, (x, y, _) in enumerate(poses):
        assert (x, y) == pytest.approx(along(ring, (0.9 * DT * tick) % 8.0), abs=1e-9)


def test_there_and_back() -> None:
    poses = track(world(obstacle(Oscillate(waypoints=SQUARE[:3], speed=0.9))), 200)
    way = [*SQUARE[:3], SQUARE[1], SQUARE[0]]
    for tick, (x, y, _) in enumerate(poses):
        assert (x, y) == pytest.approx(along(way, (0.9 * DT * tick) % 8.0), abs=1e-9)


@pytest.mark.parametrize("kind", [Loop, Oscillate])
@pytest.mark.parametrize("pause", [0.0, 0.003])
def test_a_step_may_go_around_any_number_of_times(kind: Any, pause: float) -> None:
    motion = kind(waypoints=SQUARE[:3] if kind is Oscillate else SQUARE, speed=101.0, pause=pause)
    around = 8.0 / 101.0 + 4 * pause  # [s]
    poses = track(world(obstacle(motion), dt=10.0), 2)
    for tick in (1, 2):
        once = track(world(obstacle(motion), dt=10.0 * tick % around), 1)
        assert poses[tick, :2] == pytest.approx(once[1, :2], abs=1e-9)


@pytest.mark.parametrize("kind", [Waypoints, Loop, Oscillate])
def test_a_step_at_a_single_place_ends_there(kind: Any) -> None:
    poses = track(world(obstacle(kind(waypoints=SQUARE[:1], speed=101.0, pause=0.003)), dt=10.0), 2)
    assert poses[:, :2].tolist() == [[2.0, 2.0]] * 3


def test_once_through_more_waypoints_than_a_few() -> None:
    points = tuple((2.0 + 0.01 * i, 2.0) for i in range(300))
    assert track(world(obstacle(Waypoints(waypoints=points, speed=100.0)), dt=10.0), 1)[-1, 0] == 2.0 + 0.01 * 299


def test_a_pause_is_made_at_each_waypoint() -> None:
    poses = track(world(obstacle(Oscillate(waypoints=((2.0, 2.0), (3.0, 2.0)), speed=1.0, pause=0.55))), 40)
    # 0.55 s at the first, 1 s under way, 0.55 s at the second.
    for tick, x in enumerate(poses[:, 0]):
        time = (DT * tick) % 3.1
        expected = np.clip(time - 0.55, 0.0, 1.0) if time <= 2.1 else 1.0 - (time - 2.1)
        assert x - 2.0 == pytest.approx(expected, abs=1e-9)


def test_it_starts_elsewhere_and_makes_for_the_first() -> None:
    thing = obstacle(Waypoints(waypoints=SQUARE, speed=1.0), pose=am.Pose(x=2.0, y=1.0))
    poses = track(world(thing), 60)
    for tick, (x, y, _) in enumerate(poses):
        assert (x, y) == pytest.approx(along([(2.0, 1.0), *SQUARE], DT * tick), abs=1e-9)


@given(
    points=st.lists(st.tuples(st.floats(1.0, 7.0), st.floats(1.0, 7.0)), min_size=1, max_size=5),
    speed=st.floats(0.0, 5.0),
    kind=st.sampled_from([Waypoints, Loop, Oscillate]),
    pause=st.sampled_from([0.0, 0.07, 1.0]),
)
@settings(max_examples=30, deadline=None)
@example(points=[(1.0, 1.0), (1.0, 2.0)], speed=2e-309, kind=Waypoints, pause=0.0)
@example(points=[(1.0, 1.0), (1.0, 1.0 + 1e-300)], speed=1.0, kind=Loop, pause=0.0)
def test_it_never_goes_faster_than_its_speed_and_is_on_its_lines_at_slow_ones(
    points: list[tuple[float, float]], speed: float, kind: type, pause: float
) -> None:
    """Also for routes of one point, of the same point twice, and for none of any length."""
    poses = track(world(obstacle(kind(waypoints=tuple(points), speed=speed, pause=pause))), 25)
    moved = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert moved.max() <= speed * DT + 1e-9
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    assert (poses[:, :2] >= low - 1e-9).all()
    assert (poses[:, :2] <= high + 1e-9).all()


def test_it_turns_to_where_it_goes_at_its_rate_or_not_at_all() -> None:
    cart = am.Shape.rectangle(0.6, 0.3)
    ahead = track(world(obstacle(Loop(waypoints=SQUARE, speed=1.0, turn_rate=2.0), shape=cart)), 28)
    assert ahead[19, 2] == 0.0
    assert np.diff(ahead[20:28, 2]) == pytest.approx(0.2, abs=1e-9)
    assert ahead[28, 2] == pytest.approx(np.pi / 2, abs=0.01)
    fixed = track(world(obstacle(Loop(waypoints=SQUARE, speed=1.0, faces="fixed"), shape=cart)), 28)
    assert (fixed[:, 2] == 0.0).all()


def in_the_way(x: float, y: float) -> am.Robot:
    return building.robot(shape=am.Shape.circle(0.3), pose=am.Pose(x=x, y=y), on_collision="continue")


def test_blocked_it_waits_and_goes_on_when_the_way_is_free() -> None:
    sim = world(obstacle(Loop(waypoints=SQUARE, speed=1.0)), robot=in_the_way(3.0, 2.0))
    poses = track(sim, 20)
    assert poses[-1, :2] == pytest.approx([2.5, 2.0], abs=1e-9)  # touching
    assert {(event.name, event.other) for event in sim.events} == {("thing", "rover"), ("rover", "thing")}
    sim.set_pose("rover", (8.0, 8.0, 0.0))
    # What it has waited, it is late.
    poses = track(sim, 20)
    assert poses[-1, :2] == pytest.approx(along(list(SQUARE), 0.5 + 2.0), abs=1e-9)


def test_blocked_it_leaves_the_waypoint_out() -> None:
    motion = Loop(waypoints=SQUARE, speed=1.0, blocked="skip", patience=0.5)
    sim = world(obstacle(motion), robot=in_the_way(3.0, 2.0))
    poses = track(sim, 40)
    # Touches at 0.5 s, gives the waypoint up after half a second more, and makes for (4, 4); along the robot's side it
    # goes free, for that way leads away from it.
    assert poses[10, :2] == pytest.approx([2.5, 2.0], abs=1e-9)
    assert poses[-1, 1] > 2.5 or poses[-1, 0] < 2.4


def test_a_corner_that_was_not_reached_is_not_cut() -> None:
    # The robot stands just beyond the corner, so that the step in which it would be passed is stopped short.
    thing = obstacle(Waypoints(waypoints=((2.0, 2.0), (4.0, 2.0), (4.0, 5.0)), speed=0.95))
    sim = world(thing, robot=in_the_way(4.45, 2.0))
    poses = track(sim, 30)
    assert poses[-1, 0] < 4.0
    sim.set_pose("rover", (8.0, 8.0, 0.0))
    poses = track(sim, 10)
    assert poses[:, 0].max() == pytest.approx(4.0, abs=0.05)
    assert poses[-1, 1] > 2.5


def test_different_routes_of_one_length_are_one_group_and_keep_apart() -> None:
    things = [obstacle(Loop(waypoints=((1.0, 1.0 + i), (8.0, 1.0 + i)), speed=0.1 * i), name=f"t{i}") for i in range(6)]
    sim = world(*things)
    assert len(sim._fleet.obstacles) == 1
    sim.run(2.0)
    for i in range(6):
        assert sim.obstacle(f"t{i}").true_pose[:2] == pytest.approx([1.0 + 0.2 * i, 1.0 + i])


def test_none_at_all_is_a_mistake() -> None:
    with pytest.raises(am.ParameterError, match="waypoints: expected one waypoint"):
        Loop(waypoints=())
