"""Navigation: planned paths, what blocks them, recovery, and giving up."""

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.controllers.planning import Ways
from amorsim.core.parameters import ParameterError
from amorsim.kernels.avoidance.seen_window import Window
from amorsim.scenario.files.resolved import resolved_table
from tests.building import write_rover
from tests.controllers.test_dwa import ROOM, make, said, simulate

WALL = (3.0, -3.0, 3.0, 1.5)  # a door of 1.5 m at the top


def navigate(*goals, **changes):
    given = {"planner": am.planners.ThetaStar(cell=0.05), "avoider": am.controllers.Dwa(speed=0.6, clearance=0.03)}
    return am.controllers.Navigate(goals=goals, **(given | changes))


def knowing(robot, *walls):
    """The robot with a map of the room and some walls."""
    return attrs.evolve(robot, knowledge=am.Knowledge(map=am.Map.from_segments([*ROOM, *walls], resolution=0.05)))


def test_it_reaches_one_goal_after_another_on_the_map_that_it_was_given():
    robot = knowing(make(navigate((6.0, -1.0), (0.0, 1.0))), WALL)
    simulation = simulate([robot], [WALL], duration=60.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 2"), ("rover", "goal_reached", "2 of 2")]
    assert 0.0 < simulation.events[0].time < simulation.events[1].time < 55.0
    assert not [event for event in simulation.events if event.kind == "collision"]
    beliefs = simulation.frames()[0].beliefs["controller"]
    assert beliefs["goal"].tolist() == [[2]]
    assert beliefs["plans"][0, 0] >= 2


def test_its_path_is_a_belief_and_keeps_the_reach_of_the_footprint():
    robot = knowing(make(navigate((6.0, -1.0))), WALL)
    simulation = simulate([robot], [WALL], duration=1.0)
    path = simulation.frames()[0].beliefs["controller"]["path"][0]
    path = path[np.isfinite(path[:, 0])]
    assert math.dist(path[0], (0.0, 0.0)) < 0.1
    assert path[-1].tolist() == [6.0, -1.0]
    assert gap_of(path) >= robot.shape.reach - 1e-6


def test_its_path_keeps_what_its_avoider_keeps_free():
    avoider = am.controllers.Dwa(speed=0.6, clearance=0.2)
    robot = knowing(make(navigate((6.0, -1.0), avoider=avoider)), WALL)
    path = simulate([robot], [WALL], duration=1.0).frames()[0].beliefs["controller"]["path"][0]
    assert gap_of(path[np.isfinite(path[:, 0])]) >= robot.shape.reach + 0.2 - 1e-6


def test_a_goal_near_a_wall_does_not_take_the_room_to_turn_from_its_way():
    """There is the reach of the footprint around the goal, and not the avoider's clearance as well."""
    reach = make(None).shape.reach
    goal = 6.0, -(3.0 - reach - 0.15)  # above the room's lower wall
    robot = knowing(make(navigate(goal, avoider=am.controllers.Dwa(speed=0.6, clearance=0.3))), WALL)
    path = simulate([robot], [WALL], duration=1.0).frames()[0].beliefs["controller"]["path"][0]
    path = path[np.isfinite(path[:, 0])]
    assert tuple(path[-1]) == goal
    assert gap_of(path) >= reach - 1e-6


def gap_of(path):
    """How near a path comes to the upper end of `WALL` [m]."""
    corner = np.array([3.0, 1.5])
    legs = np.diff(path, axis=0)
    t = np.clip(((corner - path[:-1]) * legs).sum(axis=1) / (legs**2).sum(axis=1), 0.0, 1.0)
    return np.hypot(*(path[:-1] + t[:, None] * legs - corner).T).min()


@pytest.mark.parametrize("least", [0.45, 0.6])
def test_its_path_keeps_a_clearance_larger_than_the_reach_of_the_footprint(least):
    robot = knowing(make(navigate((6.0, -1.0), least_clearance=least)), WALL)
    path = simulate([robot], [WALL], duration=1.0).frames()[0].beliefs["controller"]["path"][0]
    assert robot.shape.reach < least <= gap_of(path[np.isfinite(path[:, 0])]) + 1e-6


def test_it_plans_again_where_the_map_is_wrong():
    """The map shows a straight way; there is a wall, which leaves a door. It is seen only from near."""
    short = am.sensors.Laser(beams=121, fov=math.radians(240.0), range_max=2.0)
    simulation = simulate([knowing(make(navigate((6.0, -1.0)), sensor=short))], [WALL], duration=60.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]
    assert simulation.frames()[0].beliefs["controller"]["plans"][0, 0] > 1


def test_without_a_map_it_plans_on_what_it_sees():
    simulation = simulate([make(navigate((6.0, -1.0)))], [WALL], duration=60.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]


@pytest.mark.long
def test_it_gives_up_a_goal_that_it_cannot_reach_and_goes_on():
    closed = [(5.0, -2.9, 5.0, -1.0), (5.0, -1.0, 7.0, -1.0), (7.0, -1.0, 7.0, -2.9), (5.0, -2.9, 7.0, -2.9)]
    controller = navigate((6.0, -2.0), (4.0, 1.0), rounds=1, stuck_after=4.0, recovery=("stop", "turn"))
    simulation = simulate([knowing(make(controller), *closed)], closed, duration=60.0)
    assert said(simulation) == [
        ("rover", "recovery", "stop"),
        ("rover", "recovery", "turn"),
        ("rover", "gave_up", "goal 1 of 2: no path: unreachable"),
        ("rover", "goal_reached", "2 of 2"),
    ]


def test_backing_up_meets_nothing_and_moves_away():
    controller = navigate((6.0, -2.0), rounds=1, stuck_after=1.0, recovery=("back",))
    closed = [(5.0, -2.9, 5.0, -1.0), (5.0, -1.0, 7.0, -1.0), (7.0, -1.0, 7.0, -2.9), (5.0, -2.9, 7.0, -2.9)]
    simulation = simulate([knowing(make(controller), *closed)], closed, duration=10.0)
    assert simulation.true_pose[0, 0] < -0.1
    assert not [event for event in simulation.events if event.kind == "collision"]


def test_backing_up_heeds_what_it_saw_before_its_trouble_began():
    """In a closed box it turns its back to a wall, forgets it while it waits, and has to back up; then it turns again.

    The box leaves no room for that.
    """
    x, y = 0.44, 0.48
    box = [(-x, -y, x, -y), (x, -y, x, y), (x, y, -x, y), (-x, y, -x, -y)]
    recovery = ("turn", "stop", "back")
    controller = navigate((6.0, 0.0), rounds=1, stuck_after=2.0, memory=4.0, recovery=recovery, cell=0.02, window=2.0)
    simulation = simulate([make(controller)], box, duration=12.2)
    before = simulation.true_pose[0, 2]
    simulation.run(2.0)
    assert said(simulation) == [("rover", "recovery", name) for name in recovery]
    assert not [event for event in simulation.events if event.kind == "collision"]
    assert simulation.true_pose[0, 2] - before > 0.05


@pytest.mark.parametrize("goal", [(20.0, 0.0), (3.0, 0.0)])
def test_goals_outside_or_in_walls_are_given_up(goal):
    controller = navigate(goal, rounds=0, stuck_after=1.0)
    simulation = simulate([knowing(make(controller), WALL)], [WALL], duration=3.0)
    assert said(simulation) == [("rover", "gave_up", "goal 1 of 1: no path: goal blocked")]


def test_rows_and_threads_change_nothing():
    robots = [
        knowing(make(navigate((5.5, y)), name=f"r{n}", start=am.Pose(y=y)), WALL)
        for n, y in enumerate((-2.0, 0.0, 2.0))
    ]
    together = simulate(robots, [WALL], duration=5.0, replicas=2)
    assert simulate(robots, [WALL], duration=5.0, replicas=2, threads=2).digest() == together.digest()
    assert simulate(robots, [WALL], duration=5.0, replicas=[1]).digest(1) == together.digest(1)


def test_a_snapshot_goes_on_to_the_same_bits():
    robot = knowing(make(navigate((5.5, 0.0))), WALL)
    simulation = simulate([robot], [WALL], duration=3.0)
    kept = simulation.snapshot()
    simulation.run(3.0)
    digest = simulation.digest()
    simulation.restore(kept)
    simulation.run(3.0)
    assert simulation.digest() == digest


def test_it_needs_a_goal():
    with pytest.raises(ParameterError, match="goals: expected one goal at least, got none"):
        navigate()


def test_a_file_names_planner_and_avoider(tmp_path):
    path = write_rover(
        tmp_path,
        "[robots.controller]",
        'use = "navigate"',
        "goals = [[1.0, 2.0], [3.0, 2.5]]",
        'planner = { use = "theta_star", lazy = true }',
        'avoider = { use = "dwa", turn_rate_deg = 90.0 }',
    )
    text = path.read_text()
    controller = am.load(path).robots[0].controller
    assert controller.planner == am.planners.ThetaStar(lazy=True)
    assert controller.avoider == am.controllers.Dwa(turn_rate=math.radians(90.0))
    written = resolved_table(am.load(path))["robots"][0]["controller"]
    assert written["planner"]["use"] == "theta_star"
    assert written["avoider"]["turn_rate_deg"] == pytest.approx(90.0)
    for given, wrong in (
        ('{ use = "theta_stra" }', "theta_star"),
        ('{ use = "theta_star", sell = 1.0 }', "sell"),
        ('"theta_star"', "a table with use = one of"),
        ("{ cell = 1.0 }", "the name of a planner"),
    ):
        path.write_text(text.replace('{ use = "theta_star", lazy = true }', given))
        with pytest.raises(am.ScenarioError, match=wrong):
            am.load(path)
    path.write_text(text.replace('use = "dwa", turn_rate_deg = 90.0', 'use = "wander"'))
    with pytest.raises(am.ScenarioError, match="the controller 'wander' cannot be used here"):
        am.load(path)


MAPPER = {"wheels": am.estimators.GridMapping(width=14.0, height=10.0, center_x=3.0, center_y=0.0)}


def test_it_plans_on_the_map_that_it_makes_and_again_as_that_grows():
    """It knows nothing of the wall; its map shows it, and its path goes through the door."""
    robot = attrs.evolve(
        make(navigate((6.0, -1.0), mapper="wheels", planner=am.planners.DStarLite())), estimators=MAPPER
    )
    simulation = simulate([robot], [WALL], duration=3.0)
    frame = simulation.frames()[0]
    mapped = am.estimated_map(frame.beliefs["wheels"])
    assert mapped.occupied([(2.98, -1.0), (3.02, -1.0)]).any()
    path = frame.beliefs["controller"]["path"][0]
    path = path[np.isfinite(path[:, 0])]
    assert path[:, 1].max() > 1.5
    assert frame.beliefs["controller"]["plans"][0, 0] >= 3  # each second


def test_beliefs_are_computed_once_for_all_robots_that_plan_in_a_step(monkeypatch):
    asked = []
    beliefs = am.estimators.GridMapping.beliefs
    monkeypatch.setattr(
        am.estimators.GridMapping, "beliefs", lambda self, state: asked.append(1) or beliefs(self, state)
    )
    robots = [
        attrs.evolve(make(navigate((5.5, y), mapper="wheels"), name=f"r{n}", start=am.Pose(y=y)), estimators=MAPPER)
        for n, y in enumerate((-2.0, 0.0, 2.0))
    ]
    simulation = simulate(robots, duration=0.1)
    assert simulation.frames()[0].beliefs["controller"]["plans"].ravel().tolist() == [1, 1, 1]
    assert len(asked) == 2  # at the start, to see that it maps, and for the plans


def test_a_robot_driven_by_hand_does_not_change_what_the_others_map():
    robots = [
        attrs.evolve(make(navigate((5.5, y), mapper="wheels"), name=f"r{n}", start=am.Pose(y=y)), estimators=MAPPER)
        for n, y in enumerate((-2.0, 2.0))
    ]
    alone = simulate(robots, [WALL], duration=3.0)
    other = simulate(robots, [WALL], duration=0.0)
    other.hand_over("r0")
    other.run(3.0)
    assert other.true_pose[1].tolist() == alone.true_pose[1].tolist()


@pytest.mark.parametrize("name", ["maper", "wheels"])
def test_a_mapper_must_make_a_map(name):
    with pytest.raises(am.ComponentError, match=f"the map of the estimator '{name}', but robot 'rover' has no such"):
        simulate([make(navigate((6.0, -1.0), mapper=name))], duration=0.1)


def test_each_row_plans_on_the_map_that_it_knows():
    """One knows of the wall, the other does not, and plans straight through it."""
    maps = tuple(am.Map.from_segments([*ROOM, *walls], resolution=0.05) for walls in ([WALL], []))
    robot = simulate([make(navigate((6.0, -1.0)))], duration=0.0).frames()[0].robot
    ways = Ways.of(attrs.evolve(robot, rows=2, map=None, maps=maps), am.planners.ThetaStar(), "", 0.05, None)
    never = {"seen": np.full((2, 2, 2), -1e30, np.float32), "corner": np.zeros((2, 2), np.int64), "side": 0.05}
    never["place"] = np.zeros((2, 2, 2, 2), np.int8)
    nothing_seen = Window(*(never[field] for field in Window._fields))
    plans = [ways.plan(np.zeros(3), np.array([6.0, -1.0]), nothing_seen, row, 0.0) for row in (0, 1)]
    assert (plans[1][0], len(plans[1][1])) == ("found", 2)
    assert plans[0][0] == "found"
    assert plans[0][1][:, 1].max() > 1.5


def test_where_no_way_is_wide_enough_none_with_more_room_is_looked_for(monkeypatch):
    """The goal is nearer to the wall than the reach, and closed off: that it cannot be reached is the answer."""
    asked = []
    plan = am.planners.ThetaStar.plan
    monkeypatch.setattr(
        am.planners.ThetaStar, "plan", lambda self, *given, **named: asked.append(1) or plan(self, *given, **named)
    )
    closed = [(5.0, -2.9, 5.0, -2.2), (5.0, -2.2, 7.0, -2.2), (7.0, -2.2, 7.0, -2.9), (5.0, -2.9, 7.0, -2.9)]
    robot = knowing(make(navigate((6.0, -2.6), rounds=0)), *closed)
    simulation = simulate([robot], closed, duration=10.0)
    assert said(simulation) == [("rover", "gave_up", "goal 1 of 1: no path: unreachable")]
    assert len(asked) == 2 * simulation.frames()[0].beliefs["controller"]["plans"][0, 0]


@pytest.mark.parametrize("answer", [lambda: None, lambda: 1 / 0])
def test_a_planner_that_gives_no_plan_is_named_with_its_robot(monkeypatch, answer):
    monkeypatch.setattr(am.planners.ThetaStar, "plan", lambda *_, **__: answer())
    with pytest.raises(am.ControllerError, match=r"robot 'rover': planner \(ThetaStar\): ") as caught:
        simulate([make(navigate((6.0, -1.0)))], duration=1.0)
    assert caught.value.robot == "rover"


def test_a_path_of_more_corners_than_it_keeps_is_planned_again_on_the_way(monkeypatch):
    """It would end before the goal, and the robot would stand there and recover."""

    def zigzag(self, world, start, goal, *, footprint=None):
        ahead = np.arange(0.0, goal[0] - start[0], 0.01)
        aside = 0.005 * (-1.0) ** np.arange(len(ahead))
        poses = np.stack((start[0] + ahead, start[1] + aside, 0.0 * ahead), axis=1)
        return am.Plan(status="found", poses=np.vstack((poses, [*goal[:2], 0.0])), length=goal[0] - start[0])

    monkeypatch.setattr(am.planners.ThetaStar, "plan", zigzag)
    simulation = simulate([knowing(make(navigate((6.0, 0.0))))], duration=30.0)
    assert said(simulation) == [("rover", "goal_reached", "1 of 1")]
    assert 3 <= simulation.frames()[0].beliefs["controller"]["plans"][0, 0] <= 10
