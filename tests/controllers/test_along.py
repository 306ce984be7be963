"""`pursuit`, `follow`, `follow_wall` and `braitenberg` in the engine, and what they refuse."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.controllers import Braitenberg, Follow, FollowWall, GoTo, Manual, Pursuit, Square, Wander
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import wrap_angle
from amorsim.core.rows import stack
from amorsim.sensors.fiducial import Fiducial
from amorsim.sensors.infrared import Infrared
from amorsim.sensors.laser import Laser
from amorsim.sensors.sonar import Sonar
from tests import building
from tests.drives.fleet import MAKERS, make

EVERY = sorted(MAKERS)
BODY = am.Shape.rectangle(0.5, 0.4, x=0.1)


def simulate(controller: Any, drive: Any = "differential", map_: Any = None, **changes: Any) -> am.Simulation:
    given = {
        "drive": drive if isinstance(drive, am.Drive) else make(drive),
        "controller": controller,
        "shape": BODY,
        "pose": am.Pose(),
    }
    return am.Simulation(building.scenario(building.robot(**(given | changes)), map=map_ or building.empty()))


def path_of(sim: am.Simulation, seconds: float, name: str = "rover") -> np.ndarray:
    path = []
    for _ in range(round(seconds / sim.dt)):
        sim.step()
        path.append(sim.robot(name).true_pose.copy())
    return np.array(path)


def distance_to(path: np.ndarray, corners: Any) -> np.ndarray:
    """How far each place of a path is from a line through corners."""
    shapely = pytest.importorskip("shapely")
    line = shapely.LineString(corners)
    return np.array([line.distance(shapely.Point(place)) for place in path[:, :2]])


@pytest.mark.parametrize("name", EVERY)
def test_pursuit_drives_any_drive_along_its_waypoints(name: str) -> None:
    corners = ((4.0, 0.0), (6.0, 3.0), (3.0, 6.0))
    sim = simulate(Pursuit(waypoints=corners, speed=0.4, lookahead=0.8), name)
    path = path_of(sim, 60.0)
    off = distance_to(path, [(0.0, 0.0), *corners])
    assert off.max() < 0.45  # it cuts corners, by less than it looks ahead
    assert np.hypot(*(path[-1, :2] - corners[-1])) < 0.1
    np.testing.assert_array_equal(path[-1], path[-5])  # and stands there


@pytest.mark.parametrize("name", EVERY)
def test_pursuit_goes_round_for_ever(name: str) -> None:
    square = ((5.0, 0.0), (5.0, 5.0), (0.0, 5.0), (0.0, 0.0))
    sim = simulate(Pursuit(waypoints=square, loop=True, speed=0.5, lookahead=0.7), name)
    path = path_of(sim, 100.0)
    off = distance_to(path, [(0.0, 0.0), *square])
    assert off.max() < 0.6
    rounds = np.unwrap(np.arctan2(path[:, 1] - 2.5, path[:, 0] - 2.5))
    assert rounds[-1] - rounds[0] > 4.0 * math.pi  # more than twice round


def test_pursuit_along_a_straight_line_stays_on_it_to_the_tolerance() -> None:
    sim = simulate(Pursuit(waypoints=((3.0, 0.0),), tolerance=0.02))
    path = path_of(sim, 20.0)
    assert np.abs(path[:, 1]).max() < 1e-9
    assert 3.0 - 0.02 - 1e-9 <= path[-1, 0] <= 3.0 + 1e-9


def test_pursuit_turns_a_robot_round_that_can_and_a_car_in_a_curve() -> None:
    behind = Pursuit(waypoints=((-4.0, 0.0),), lookahead=0.5)
    turning = path_of(simulate(behind), 30.0)
    assert np.abs(turning[:, 1]).max() < 0.1
    car = path_of(simulate(behind, "ackermann rear"), 40.0)
    assert np.hypot(*(car[-1, :2] - (-4.0, 0.0))) < 0.3
    assert np.abs(car[:, 1]).max() > 0.5 / math.tan(0.6)  # no sharper than it can


def speeds(path: np.ndarray) -> np.ndarray:
    """How far ahead each step of a path leads [m], along the heading in its middle."""
    step, heading = np.diff(path[:, :2], axis=0), path[:-1, 2] + 0.5 * wrap_angle(np.diff(path[:, 2]))
    return step[:, 0] * np.cos(heading) + step[:, 1] * np.sin(heading)


@pytest.mark.parametrize("name", EVERY)
def test_pursuit_backs_straight_up_to_a_place_behind(name: str) -> None:
    sim = simulate(Pursuit(waypoints=((-3.0, 0.0),), reverse="auto"), name)
    path = path_of(sim, 20.0)
    assert np.abs(path[:, 1:]).max() < 1e-9
    assert -3.0 - 1e-9 <= path[-1, 0] <= -3.0 + 0.02 + 1e-9
    np.testing.assert_array_equal(path[-1], path[-5])


CARS = [name for name in EVERY if stack([make(name)]).curvature_max() is not None]


@pytest.mark.parametrize("name", [*CARS, "differential", "mecanum"])
@pytest.mark.parametrize("reverse", ["auto", (2, 3)])
def test_pursuit_backs_into_a_bay_and_drives_out_again(name: str, reverse: Any) -> None:
    # Past the bay, back along a curve and into it; then out ahead.
    bay = ((4.0, 0.0), (7.0, 1.0), (3.4, 0.4), (0.0, 2.5), (6.0, -1.2))
    sim = simulate(Pursuit(waypoints=bay, reverse=reverse, speed=0.6, lookahead=0.9, turn_rate=0.8), name)
    path = path_of(sim, 70.0)
    assert distance_to(path, [(0.0, 0.0), *bay]).max() < 0.45
    assert np.hypot(*(path[-1, :2] - bay[-1])) < 0.12
    ahead = speeds(path)
    signs = np.sign(ahead[np.abs(ahead) > 1e-6])
    turns = np.flatnonzero(np.diff(signs))
    assert signs[[0, *(turns + 1)]].tolist() == [1.0, -1.0, 1.0]
    places = path[:-1, :2][np.abs(ahead) > 1e-6][turns + 1]
    assert np.hypot(*(places - [bay[1], bay[3]]).T).max() < 0.3  # it turns about where the legs meet
    assert np.abs(ahead).max() <= 1.01 * 0.6 * sim.dt


@pytest.mark.parametrize("name", CARS)
def test_pursuit_goes_to_and_fro_for_ever(name: str) -> None:
    sim = simulate(Pursuit(waypoints=((4.0, 0.0), (0.0, 0.0)), loop=True, reverse="auto", speed=0.5), name)
    path = path_of(sim, 60.0)
    assert np.abs(path[:, 1:]).max() < 1e-6
    assert np.ptp(path[200:, 0]) == pytest.approx(4.0, abs=0.05)
    assert np.count_nonzero(np.diff(np.sign(speeds(path)[np.abs(speeds(path)) > 1e-6]))) >= 5


@pytest.mark.parametrize(("reverse", "heading"), [("auto", 0.0), ((0, 1, 2), math.pi)])
def test_pursuit_turns_about_at_an_odd_number_of_corners_of_a_loop(reverse: Any, heading: float) -> None:
    corners = ((6.0, 0.0), (3.0, 5.2), (0.0, 0.0))  # all of them sharper than a right angle
    controller = Pursuit(waypoints=corners, loop=True, reverse=reverse, speed=0.8, lookahead=0.6)
    sim = simulate(controller, CARS[0], pose=am.Pose(heading=heading))
    path = path_of(sim, 90.0)
    assert distance_to(path, [(0.0, 0.0), *corners, corners[0]]).max() < 1.0
    ahead = speeds(path)
    rounds = np.ptp(np.unwrap(np.arctan2(path[:, 1] - 1.7, path[:, 0] - 3.0))) / (2.0 * math.pi)
    assert rounds > 3.0
    if reverse == "auto":
        turns = np.count_nonzero(np.diff(np.sign(ahead[np.abs(ahead) > 1e-6])))
        assert 3.0 * (rounds - 1.0) < turns < 3.0 * (rounds + 1.0)
    else:
        assert (ahead < 1e-9).all()


def test_pursuit_brakes_before_it_turns_about_and_stays_in_its_limits() -> None:
    slow = attrs.evolve(make(CARS[0]), lag=0.2, acceleration_max=8.0)
    sim = simulate(Pursuit(waypoints=((5.0, 0.0), (1.0, 0.8)), reverse="auto", speed=1.5), slow)
    path = path_of(sim, 40.0)
    assert path[:, 0].max() < 5.1
    assert np.hypot(*(path[-1, :2] - (1.0, 0.8))) < 0.15


def test_pursuit_refuses_to_back_up_to_a_waypoint_that_is_not_there() -> None:
    with pytest.raises(ParameterError, match="reverse: expected numbers of waypoints, 0 to 1, got 2"):
        Pursuit(waypoints=((1.0, 0.0), (2.0, 0.0)), reverse=(0, 2))
    with pytest.raises(ParameterError, match="'never' or 'auto' or a list"):
        Pursuit(waypoints=((1.0, 0.0),), reverse="sometimes")


@pytest.mark.parametrize(
    ("waypoints", "loop", "problem"),
    [((), False, "at least"), (((1.0, 1.0), (1.0, 1.0)), True, "two waypoints that differ")],
)
def test_pursuit_refuses_waypoints_that_lead_nowhere(waypoints: Any, loop: bool, problem: str) -> None:
    with pytest.raises((ParameterError, ComponentError), match=problem):
        simulate(Pursuit(waypoints=waypoints, loop=loop))


@pytest.mark.parametrize("controller", [GoTo(x=1.0, y=1.0), Square()])
def test_who_turns_in_place_refuses_a_car_by_name(controller: Any) -> None:
    with pytest.raises(ComponentError, match=r"cannot.*Ackermann.*radius of 0\.731 m.*'pursuit'"):
        simulate(controller, "ackermann rear", sensors={"encoder": building.encoder(), "laser": Laser()})


@pytest.mark.parametrize("name", [name for name in EVERY if not name.startswith("ackermann")])
def test_goto_comes_to_its_place_with_any_drive_that_turns_in_place(name: str) -> None:
    sim = simulate(GoTo(x=2.0, y=-1.5, tolerance=0.05), name)
    path = path_of(sim, 40.0)
    assert np.hypot(*(path[-1, :2] - (2.0, -1.5))) < 0.08


@pytest.mark.parametrize("name", [name for name in EVERY if not name.startswith("ackermann")])
def test_wander_roams_with_any_drive_that_turns_in_place(name: str) -> None:
    ring = tuple(am.Mount(x=0.0, heading=2.0 * math.pi * i / 16) for i in range(16))
    sensors = {"encoder": building.encoder(), "sonar": Sonar(elements=ring, half_angle=0.26, range_min=0.05)}
    room = building.room(6.0, 5.0, 0.01)
    sim = simulate(
        Wander(sensor="sonar", speed=0.3),
        name,
        room,
        sensors=sensors,
        shape=am.Shape.circle(0.2),
        pose=am.Pose(x=2.0, y=2.0, heading=0.3),
    )
    path = path_of(sim, 120.0)
    assert not sim.events
    assert np.ptp(path[:, 0]) > 2.0
    assert np.ptp(path[:, 1]) > 2.0


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "fov"),
    [
        ("narrow tricycle", 180.0),
        *(
            pytest.param(name, fov, marks=pytest.mark.long)
            for name in ("ackermann rear", "ackermann front", "narrow tricycle")
            for fov in (180.0, 360.0)
            if (name, fov) != ("narrow tricycle", 180.0)
        ),
    ],
)
def test_wander_roams_with_a_car(name: str, fov: float) -> None:
    """It cannot turn in place: it takes arcs, and goes back where none has room."""
    drive = make("tricycle", steering_max=0.7) if name == "narrow tricycle" else make(name)
    walls = [(0, 0, 9, 0), (9, 0, 9, 7), (9, 7, 0, 7), (0, 7, 0, 0), (4, 0, 4, 2), (6, 7, 6, 5.2), (2, 4.5, 3, 4.5)]
    sensors = {
        "encoder": building.encoder(),
        "laser": am.MountedSensor(
            sensor=Laser(beams=361, fov=math.radians(fov)), mount=am.Mount(x=0.55 if fov < 200 else 0.2)
        ),
    }
    sim = simulate(
        Wander(speed=0.4),
        drive,
        am.Map.from_segments(np.array(walls, dtype=float), resolution=0.01),
        sensors=sensors,
        shape=am.Shape.rectangle(0.7, 0.36, x=0.2),
        pose=am.Pose(x=2.0, y=2.0, heading=0.3),
    )
    path = path_of(sim, 240.0)
    assert not sim.events
    assert np.ptp(path[:, 0]) > 5.0
    assert np.ptp(path[:, 1]) > 4.0
    moved = np.hypot(*np.diff(path[:, :2], axis=0).T)
    assert moved.sum() > 30.0


def test_wander_refuses_a_body_that_does_not_turn_and_sees_ahead_only() -> None:
    with pytest.raises(ComponentError, match=r"does not see all around: it leaves out 180 degrees"):
        simulate(Wander(), "synchro fixed", sensors={"encoder": building.encoder(), "laser": Laser()})


@pytest.mark.parametrize("name", EVERY)
def test_follow_keeps_its_distance_behind_the_leader_on_its_trail(name: str) -> None:
    corners = ((4.0, 0.0), (6.0, 2.5), (4.0, 6.0))
    leader = building.robot(
        name="leader", controller=Pursuit(waypoints=corners, speed=0.25, lookahead=0.8), pose=am.Pose(), fiducial=7
    )
    finder = Fiducial(fov=2.0 * math.pi, range_max=6.0, range_max_id=6.0)
    follower = building.robot(
        name="tail",
        drive=make(name),
        shape=BODY,
        sensors={"encoder": building.encoder(), "marks": finder},
        controller=Follow(leader=7, sensor="marks", gap=0.8, gain=1.0),
        pose=am.Pose(x=-1.5),
    )
    sim = am.Simulation(building.scenario(leader, follower, map=building.empty()))
    gaps, path = [], []
    for _ in range(700):
        sim.step()
        front, back = sim.robot("leader").true_pose, sim.robot("tail").true_pose
        gaps.append(np.hypot(*(front - back)[:2]))
        path.append(back.copy())
    assert not sim.events
    # On the straight it is where the gap and the leader's speed over the gain put it.
    assert gaps[130] == pytest.approx(0.8 + 0.25, abs=0.05)
    assert min(gaps) > 0.7
    assert gaps[-1] == pytest.approx(0.8, abs=0.05)  # the leader stands
    assert distance_to(np.array(path), [(-1.5, 0.0), (0.0, 0.0), *corners]).max() < 0.5


def test_follow_goes_where_the_leader_was_seen_last_and_stops() -> None:
    leader = building.robot(name="leader", controller=Manual(), pose=am.Pose(x=3.0), fiducial=1)
    follower = building.robot(
        name="tail",
        shape=BODY,
        sensors={"encoder": building.encoder(), "fiducial": Fiducial()},
        controller=Follow(patience=4.0),
        pose=am.Pose(),
    )
    sim = am.Simulation(building.scenario(leader, follower, map=building.empty()))
    sim.run(1.0)
    sim.set_pose("leader", (-20.0, 5.0, 0.0))
    path = path_of(sim, 10.0, "tail")
    assert 1.0 < path[-1, 0] < 3.1
    np.testing.assert_array_equal(path[-1], path[-20])


def test_follow_tells_what_it_lacks() -> None:
    with pytest.raises(ComponentError, match="does not have; its sensors: 'encoder'"):
        simulate(Follow())
    sensors = {"encoder": building.encoder(), "fiducial": Laser()}
    with pytest.raises(ComponentError, match="a Laser does not tell range"):
        simulate(Follow(), sensors=sensors)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("name", ["differential", "mecanum", "ackermann rear"])
def test_follow_wall_keeps_its_distance(side: str, name: str) -> None:
    distance = 0.8
    sensors = {"encoder": building.encoder(), "laser": Laser(beams=271, fov=math.radians(270.0))}
    sim = simulate(
        FollowWall(side=side, distance=distance, speed=0.3),
        name,
        building.room(8.0, 6.0, 0.01),
        sensors=sensors,
        pose=am.Pose(x=3.0, y=3.0, heading=0.2),
        shape=am.Shape.rectangle(0.4, 0.3),
    )
    path = path_of(sim, 120.0)
    assert not sim.events
    x, y = path[400:, 0], path[400:, 1]  # by then it has met a wall
    gap = np.minimum(np.minimum(x, 8.0 - x), np.minimum(y, 6.0 - y))
    assert np.median(gap) == pytest.approx(distance, abs=0.05)
    assert gap.min() > 0.5
    around = np.unwrap(np.arctan2(y - 3.0, x - 4.0))
    assert (around[-1] - around[0]) * (-1.0 if side == "left" else 1.0) > 5.0  # the wall on its left: clockwise


def test_follow_wall_refuses_a_distance_that_the_drive_cannot_keep() -> None:
    sensors = {"encoder": building.encoder(), "laser": Laser()}
    with pytest.raises(ComponentError, match=r"its smallest curve ask for 0\.731 m"):
        simulate(FollowWall(distance=0.5), "ackermann rear", sensors=sensors)


def infrared() -> Infrared:
    headings = (90.0, 45.0, 10.0, -10.0, -45.0, -90.0, 180.0, 180.0)
    return Infrared(elements=tuple(am.Mount(x=0.02, heading=math.radians(h)) for h in headings))


@pytest.mark.parametrize("name", ["differential", "tricycle", "mecanum"])
def test_braitenberg_feels_its_way_about(name: str) -> None:
    if name == "differential":
        drive: Any = building.drive(wheel_radius_left=0.008, wheel_radius_right=0.008, track=0.05)
    else:
        fields = {"tricycle": {"wheelbase": 0.03}, "mecanum": {"track": 0.04, "wheelbase": 0.03}}[name]
        drive = make(name, **fields)
    sim = simulate(
        Braitenberg(),
        drive,
        building.room(0.6, 0.5),
        sensors={"encoder": building.encoder(), "infrared": infrared()},
        shape=am.Shape.circle(0.0275),
        pose=am.Pose(x=0.3, y=0.2, heading=0.4),
    )
    path = path_of(sim, 120.0)
    assert not [event for event in sim.events if event.kind == "collision"]
    assert np.hypot(*np.diff(path[:, :2], axis=0).T).sum() > 3.0  # 60 mm/s, less what it slows down


def test_braitenberg_goes_by_ranges_as_well_and_counts_its_weights() -> None:
    sensors = {"encoder": building.encoder(), "sonar": building.ring(4)}
    with pytest.raises(ComponentError, match=r"a weight in 'left' for each of the 4 values"):
        simulate(Braitenberg(sensor="sonar"), sensors=sensors)
    # Straight before a wall, half a metre off: what is felt ahead drives the left wheel and brakes the right one.
    sim = simulate(
        Braitenberg(sensor="sonar", left=(0.5, 0.5, 0.0, 0.0), right=(-0.5, 0.0, 0.0, 0.5), speed=0.1, reach=1.0),
        sensors=sensors,
        map_=building.room(),
        pose=am.Pose(x=5.4, y=2.5),
    )
    felt = 1.0 - (6.0 - 5.4 - 0.1) / 1.0
    sim.step()
    wheels = np.array(sim.robot("rover").true_twist[0] + np.array([-0.16, 0.16]) * sim.robot("rover").true_twist[2])
    assert wheels == pytest.approx([0.1 * (1.0 + 0.5 * felt), 0.1 * (1.0 - 0.5 * felt)], abs=2e-4)
    with pytest.raises(ComponentError, match="neither ranges, nor reflectances, nor counts"):
        simulate(Braitenberg(sensor="encoder"))


def test_a_hand_is_held_to_the_limits_of_manual() -> None:
    sim = simulate(Manual(speed=0.2, turn_rate=0.5))
    rover = sim.robot("rover")
    rover.drive(forward=0.8, turn=0.4)
    sim.run(1.0)
    assert rover.true_twist == pytest.approx([0.2, 0.0, 0.1], abs=1e-9)
    rover.drive(forward=0.1, turn=1.0)
    sim.run(1.0)
    assert rover.true_twist == pytest.approx([0.05, 0.0, 0.5], abs=1e-9)


@pytest.mark.parametrize("name", EVERY)
def test_a_hand_drives_any_drive_ahead(name: str) -> None:
    sim = simulate(Manual(), name)
    sim.robot("rover").drive(forward=0.3)
    sim.run(3.0)
    x, y, heading = sim.robot("rover").true_pose
    assert (x, y, heading) == pytest.approx((0.9, 0.0, 0.0), abs=1e-9)
