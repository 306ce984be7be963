"""Hybrid A*: plans that a car drives, and a tractor with its trailer, end where they say and touch nothing."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.algorithms.speed_profile import pieces_of

DT = 0.1
SPEED = 0.5  # [m/s]
WHEELBASE, WHEEL = 1.0, 0.2  # [m]
CAR = am.Shape.rectangle(1.6, 0.8, x=0.5)
TRACTOR = am.Shape.rectangle(0.8, 0.6, x=0.1)
TRAILER = {"trailer_length": 0.9, "hitch_offset": 0.3, "hitch_max": 0.9, "trailer_width": 0.6}
OUTLINE = {"trailer_front": 0.4, "trailer_rear": 0.3}


def moves_of(plan: am.Plan) -> list[tuple[float, float]]:
    """Curvature [1/m] and length [m] of the plan's pieces, equal ones in turn as one."""
    pieces = pieces_of(plan.poses)
    assert not pieces.in_place.any()  # a car cannot
    found: list[list[float]] = []
    for length, turn in zip(pieces.lengths.tolist(), pieces.turns.tolist(), strict=True):
        bend = turn / length
        if found and abs(found[-1][0] - bend) < 1e-6 and found[-1][1] * length > 0.0:
            found[-1][1] += length
        else:
            found.append([bend, length])
    return [(bend, length) for bend, length in found]


def as_steps(plan: am.Plan) -> list[tuple[float, float]]:
    """Speed [m/s] and curvature [1/m] of each step; before each piece one in which the robot only steers."""
    steps: list[tuple[float, float]] = []
    for bend, length in moves_of(plan):
        count = max(1, math.ceil(abs(length) / (SPEED * DT)))
        steps += [(0.0, bend), *[(length / (count * DT), bend)] * count]
    return steps


def replay(world: am.Map, plan: am.Plan, start, robot: am.Robot, command) -> am.Simulation:
    """The plan driven without noise, by its lengths and bends alone."""
    steps = as_steps(plan)

    def controller(readings, estimate, clock):
        return command(*steps[clock.tick]) if clock.tick < len(steps) else command(0.0, 0.0)

    pose = am.Pose(x=start[0], y=start[1], heading=start[2])
    robot = attrs.evolve(robot, pose=pose, controller=controller)
    simulation = am.Simulation(am.Scenario(map=world, robots=[robot], dt=DT))
    simulation.run((len(steps) + 3) * DT)
    return simulation


def drive_car(world: am.Map, plan: am.Plan, start) -> am.Simulation:
    drive = am.drives.Ackermann(
        wheel_radius=WHEEL, wheelbase=WHEELBASE, track=0.6, steering_max=1.2, steering_rate=1e5, rate_max=1e3
    )
    robot = am.Robot(shape=CAR, drive=drive, estimators={"dead": am.estimators.DeadReckoning()}, sensors=ENCODER)
    return replay(world, plan, start, robot, lambda v, bend: [math.atan(bend * WHEELBASE), v / WHEEL])


def drive_tractor(world: am.Map, plan: am.Plan, start) -> am.Simulation:
    drive = am.drives.Tractor(
        wheel_radius_left=WHEEL, wheel_radius_right=WHEEL, track=0.5, rate_max=1e3, **TRAILER, **OUTLINE
    )
    robot = am.Robot(shape=TRACTOR, drive=drive, estimators={"dead": am.estimators.DeadReckoning()}, sensors=ENCODER)
    return replay(world, plan, start, robot, lambda v, bend: am.Twist(forward=v, turn=v * bend))


ENCODER = {"encoder": am.sensors.Encoder(counts_per_revolution=1e6)}


def check_driven(simulation: am.Simulation, plan: am.Plan) -> None:
    assert [event for event in simulation.events if "collision" in event.kind] == []
    x, y, heading = simulation.true_pose[0]
    assert math.hypot(x - plan.poses[-1, 0], y - plan.poses[-1, 1]) < 0.02
    assert abs(math.remainder(heading - plan.poses[-1, 2], 2.0 * math.pi)) < math.radians(0.5)


def car_park() -> am.Map:
    """Two rows of bays, 1.4 m x 2.4 m, with a car in each but two, and an aisle of 3.2 m."""
    walls = [(0, 0, 12, 0), (12, 0, 12, 8), (12, 8, 0, 8), (0, 8, 0, 0)]
    for bay in range(8):
        x = 0.4 + 1.4 * bay
        for low, free in ((0.4, 5), (5.8, 2)):
            if bay != free:
                a, b, c, d = x + 0.25, low, x + 1.15, low + 1.8
                walls += [(a, b, c, b), (c, b, c, d), (c, d, a, d), (a, d, a, b)]
    return am.Map.from_segments(walls, resolution=0.02)


CASES = {
    "nose first": ((1.5, 4.0, 0.0), (8.1, 2.0, -math.pi / 2)),
    "tail first": ((1.5, 4.0, 0.0), (8.1, 0.6, math.pi / 2)),
    "facing the wall": ((10.2, 4.0, 0.0), (2.0, 4.0, math.pi)),
    "U-turn in the aisle": ((6.0, 3.6, 0.0), (6.0, 4.4, math.pi)),
}


@pytest.mark.parametrize("case", CASES, ids=str)
def test_a_cars_plan_is_driven(case):
    start, goal = CASES[case]
    planner = am.planners.HybridAStar(radius=1.5)
    plan = planner.plan(car_park(), start, goal, footprint=CAR)
    assert plan.status == "found", plan.message
    assert plan.poses[[0, -1]].tolist() == [list(start), list(goal)]
    assert plan.length >= am.algorithms.reeds_shepp(start, goal, 1.5).length - 1e-9
    assert plan.cost >= plan.length
    assert all(abs(bend) <= 1.0 / 1.5 + 1e-6 for bend, _ in moves_of(plan))
    query, _ = planner.query(car_park(), start, goal, CAR)
    assert query.gaps(plan.poses).min() >= 0.01  # half the clearance
    check_driven(drive_car(car_park(), plan, start), plan)


TRAILER_CASES = {
    "into a bend": ((2.2, 6.0, 0.0), (6.0, 4.0, -1.57)),
    "round a corner": ((2.2, 1.5, 0.0), (8.5, 6.5, math.pi / 2)),
    "turned about": ((3.0, 4.0, 0.0), (3.0, 4.0, math.pi)),
}


def yard() -> am.Map:
    walls = [(0, 0, 10, 0), (10, 0, 10, 8), (10, 8, 0, 8), (0, 8, 0, 0), (5, 0, 5, 2.5), (7, 5, 10, 5)]
    return am.Map.from_segments(walls[:5], resolution=0.02)


@pytest.mark.parametrize(
    "case",
    ["into a bend", *(pytest.param(case, marks=pytest.mark.long) for case in ("round a corner", "turned about"))],
    ids=str,
)
def test_a_trailers_plan_is_driven(case):
    start, goal = TRAILER_CASES[case]
    plan = am.planners.HybridAStar(radius=1.2, **TRAILER, **OUTLINE).plan(yard(), start, goal, footprint=TRACTOR)
    assert plan.status == "found", plan.message
    assert math.dist(plan.poses[-1, :2], goal[:2]) <= 0.1
    assert abs(math.remainder(plan.poses[-1, 2] - goal[2], 2.0 * math.pi)) <= math.radians(5.0)
    hitches = plan.poses[:, 2] - plan.trailer[:, 2]
    assert np.abs(hitches).max() < TRAILER["hitch_max"]
    assert abs(hitches[-1]) <= 0.05
    simulation = drive_tractor(yard(), plan, start)
    check_driven(simulation, plan)
    assert np.hypot(*(simulation.part_pose[0, :2] - plan.trailer[-1, :2])) < 0.03


def test_a_door_that_is_too_narrow_is_reported():
    cells = np.zeros((80, 120))
    cells[:, 60] = 1
    cells[30:36, 60] = 0
    world = am.Map.from_array(cells, resolution=0.1)
    plan = am.planners.HybridAStar().plan(world, (2, 4, 0), (10, 4, 0), footprint=am.Shape.circle(0.5))
    assert (plan.status, plan.expanded) == ("unreachable", 0)
    assert "one that reaches 0.2 m would pass" in plan.message


def test_a_lattice_that_is_used_up_is_reported():
    """A point fits through, but no car can turn in a cell of 1 m."""
    cells = np.ones((30, 30))
    cells[10:20, 10:20] = 0
    world = am.Map.from_array(cells, resolution=0.1)
    car = am.Shape.rectangle(0.8, 0.3)
    plan = am.planners.HybridAStar(radius=2.0).plan(world, (1.5, 1.5, 0.0), (1.5, 1.5, 1.57), footprint=car)
    assert plan.status == "unreachable"
    assert "no arcs of radius 2 m lead from start to goal with 0.02 m to the walls" in plan.message
    assert plan.expanded == len(plan.searched) > 0


@pytest.mark.parametrize("budget", [0, 1, 7])
def test_a_budget_ends_the_search(budget):
    start, goal = CASES["tail first"]
    plan = am.planners.HybridAStar(radius=1.5, budget=budget).plan(car_park(), start, goal, footprint=CAR)
    assert (plan.status, plan.expanded) == ("budget", budget)
    assert f"the budget of {budget} poses was used up" in plan.message


def test_backing_is_avoided_at_a_price():
    start, goal = (3.0, 4.0, 0.0), (2.0, 4.0, 0.0)
    world = am.Map.from_array(np.zeros((80, 120)), resolution=0.1)
    back = am.planners.HybridAStar(radius=1.0).plan(world, start, goal, footprint=CAR)
    assert pieces_of(back.poses).lengths.min() < 0.0
    assert back.length == pytest.approx(1.0)
    assert back.cost == pytest.approx(1.5)
    round_ = am.planners.HybridAStar(radius=1.0, backward=50.0).plan(world, start, goal, footprint=CAR)
    assert pieces_of(round_.poses).lengths.min() > 0.0


def test_where_the_trailer_does_not_fit_is_blocked():
    world = am.Map.from_array(np.zeros((80, 120)), resolution=0.1)
    planner = am.planners.HybridAStar(**TRAILER, **OUTLINE)
    plan = planner.plan(world, (0.6, 4.0, 0.0), (6.0, 4.0, 0.0), footprint=TRACTOR)
    assert plan.status == "start_blocked"
    assert "at the start the trailer, straight behind, overlaps a wall" in plan.message
    with pytest.raises(am.ParameterError, match="trailer_rear: expected"):
        am.planners.HybridAStar(trailer_front=0.5, trailer_rear=-0.5)
