"""Driving along planned paths as they are, forwards and backwards; navigation of cars."""

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.controllers.planning import PLACES, lay_path, no_path, polyline
from amorsim.core.parameters import ParameterError
from tests.controllers.test_dwa import ROOM, make, said, simulate

# A path by hand: ahead, a curve to the left, and straight back into a place behind the start of the curve.
RADIUS = 1.0


def path_with_a_cusp():
    """Poses (M, 3): 1 m ahead, a quarter of a circle to the left, and 2 m straight back."""
    straight = [(x, 0.0, 0.0) for x in np.linspace(0.0, 1.0, 21)]
    turn = [(1.0 + math.sin(a), 1.0 - math.cos(a), a) for a in np.linspace(0.0, 0.5 * math.pi, 41)[1:]]
    back = [(2.0, 1.0 - s, 0.5 * math.pi) for s in np.linspace(0.0, 2.0, 41)[1:]]
    return np.array([*straight, *turn, *back])


@attrs.frozen(kw_only=True)
class ByHand(am.Planner):
    """A planner with headings whose answer is always the same; by default the path above."""

    plans_headings = True
    poses: tuple[tuple[float, float, float], ...] = tuple(map(tuple, path_with_a_cusp().tolist()))

    def plan(self, world, start, goal, *, footprint=None):
        return am.Plan(status="found", poses=np.array(self.poses), length=1.0 + 0.5 * math.pi + 2.0)


def navigator(**changes):
    given = {
        "goals": ((2.0, -1.0),),
        "planner": ByHand(),
        "avoider": am.controllers.PathPursuit(speed=0.5, lookahead=0.3),
        "tolerance": 0.05,
    }
    return am.controllers.Navigate(**(given | changes))


def test_it_changes_direction_where_the_path_does_and_backs_to_the_goal():
    simulation = simulate([make(navigator())], duration=8.0)
    assert simulation.true_pose[0, 1] > 0.3
    simulation.run(12.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]
    assert [event for event in simulation.events if event.kind == "collision"] == []
    x, y, heading = simulation.true_pose[0]
    assert math.dist((x, y), (2.0, -1.0)) < 0.1
    assert heading == pytest.approx(0.5 * math.pi, abs=0.1)


def test_a_goal_is_not_reached_where_the_path_only_passes_it():
    """The path leads over the goal, and comes back to it from the other side."""
    poses = tuple((x, 0.0, 0.0) for x in (0.0, 0.5, 1.0, 1.5, 2.0, 1.5, 1.0))
    simulation = simulate([make(navigator(goals=((1.0, 0.0),), planner=ByHand(poses=poses)))], duration=12.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]
    (reached,) = (event for event in simulation.events if event.kind == "report")
    assert reached.time > 5.0  # 3 m at 0.5 m/s
    assert simulation.true_pose[0, 0] == pytest.approx(1.0, abs=0.06)


def test_it_brakes_before_what_it_sees_on_its_path():
    box = am.Obstacle(name="box", shape=am.Shape.rectangle(0.3, 0.3), pose=am.Pose(x=1.6, y=0.3))
    simulation = simulate([make(navigator(recovery=("stop",), rounds=1))], obstacles=[box], duration=20.0)
    assert [event for event in simulation.events if event.kind == "collision"] == []
    assert ("rover", "gave_up", "goal 1 of 1: it does not get on") in said(simulation)


def test_by_itself_it_drives_straight_for_its_goals():
    controller = am.controllers.PathPursuit(goals=((2.0, 0.5), (1.0, -1.0)), speed=0.5)
    simulation = simulate([make(controller)], duration=25.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 2"), ("rover", "goal_reached", "2 of 2")]


def test_rows_and_replicas_change_nothing():
    robots = [make(navigator(), name=f"r{n}", start=am.Pose(y=y)) for n, y in enumerate((0.0, 0.05))]
    robots = [attrs.evolve(robot, on_collision="continue") for robot in robots]
    together = simulate(robots[:1], duration=5.0, replicas=3)
    assert simulate(robots[:1], duration=5.0, replicas=[2]).digest(2) == together.digest(2)


def test_a_snapshot_goes_on_to_the_same_bits():
    simulation = simulate([make(navigator())], duration=4.0)
    kept = simulation.snapshot()
    simulation.run(4.0)
    digest = simulation.digest()
    simulation.restore(kept)
    simulation.run(4.0)
    assert simulation.digest() == digest


def test_few_points_stand_for_a_path_with_its_ends_and_the_place_where_it_turns_back():
    poses = path_with_a_cusp()
    points = polyline(poses)
    assert points[0].tolist() == [0.0, 0.0]
    assert points[-1].tolist() == pytest.approx([2.0, -1.0])
    assert (2.0, 1.0) in {tuple(point) for point in points.round(9).tolist()}
    assert len(points) < 25
    legs = np.diff(points, axis=0)
    for place in poses[:, :2]:  # a chord of 0.1 rad and one step of the curve more is off by r (0.14 / 2)^2 / 2
        t = np.clip(((place - points[:-1]) * legs).sum(axis=1) / (legs**2).sum(axis=1), 0.0, 1.0)
        assert np.hypot(*(points[:-1] + t[:, None] * legs - place).T).min() < RADIUS * 0.07**2 / 2 + 1e-9


def test_a_path_of_many_turns_has_no_more_points_than_a_robot_keeps():
    angles = np.linspace(0.0, 40.0 * math.pi, 4000)
    poses = np.stack((np.sin(angles), 1.0 - np.cos(angles), angles), axis=1)
    assert len(polyline(poses)) <= PLACES


def test_a_path_that_is_one_place_has_one_point():
    """As that of a trailer that is near enough to its goal already."""
    assert polyline(np.array([(1.0, 2.0, 0.3)])).tolist() == [[1.0, 2.0]]
    assert polyline(np.array([(1.0, 2.0, 0.3), (1.0, 2.0, 0.3)])).tolist() == [[1.0, 2.0]]


def test_a_path_that_goes_back_on_the_same_line_keeps_its_turning_place():
    state = no_path(np.zeros((1, 3)))
    lay_path(np.array([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.5, 0.0)]), 0, state)
    assert state["path"][0, : state["count"][0]].tolist() == [[0.0, 0.0], [2.0, 0.0], [0.5, 0.0]]


@pytest.mark.parametrize("far", [0.0, 1e4, 3e6])
def test_a_straight_path_of_many_places_has_two_corners_wherever_it_is(far):
    """As that of RRT*, which draws its samples on the shortest path when it has found it."""
    along = np.sort(np.random.default_rng(1).uniform(0.0, 3.0, 2000))[:, None]
    state = no_path(np.zeros((1, 3)))
    lay_path(np.array([far, -2.0 * far]) + along * (math.cos(0.5), math.sin(0.5)), 0, state)
    assert state["count"][0] == 2
    assert state["along"][0, 1] == pytest.approx(along[-1, 0] - along[0, 0])
    assert not state["cut"][0, 0]


def test_headings_are_of_goals_and_for_planners_with_headings():
    with pytest.raises(ParameterError, match="headings: expected one for each of 1 goals, got 2"):
        navigator(headings=(0.0, 1.0))
    with pytest.raises(ParameterError, match="headings: expected none, as AStar plans without headings"):
        navigator(headings=(0.0,), planner=am.planners.AStar())


@pytest.mark.long
def test_a_car_comes_to_its_goal_with_the_heading_that_was_asked_for():
    """Round, in a room in which it must back; the map that it was given is that of the room."""
    known = am.Knowledge(map=am.Map.from_segments(ROOM, resolution=0.05))
    controller = navigator(
        goals=((5.0, 1.5),),
        headings=(math.pi,),
        planner=am.planners.HybridAStar(radius=1.6, clearance=0.1),
        avoider=am.controllers.PathPursuit(speed=0.4, lookahead=0.4),
    )
    simulation = simulate([make(controller, knowledge=known)], duration=60.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]
    x, y, heading = simulation.true_pose[0]
    assert math.dist((x, y), (5.0, 1.5)) < 0.1
    assert abs(math.remainder(heading - math.pi, 2.0 * math.pi)) < 0.2
