"""Robots of several parts: what a part meets stops the robot, all of it, and others see it."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import pytest
import shapely
import shapely.affinity

import amorsim as am
from amorsim.core.poses import compose
from amorsim.core.rows import stack
from tests import building
from tests.simulation.rigs import least_gap, rig, stone, tractor, yard


def outline(shape: am.Shape, pose: Any) -> shapely.Polygon:
    """A footprint in the world."""
    turned = shapely.affinity.rotate(shapely.Polygon(shape.outline), pose[2], (0, 0), use_radians=True)
    return shapely.affinity.translate(turned, pose[0], pose[1])


def drive(sim: am.Simulation, rates: tuple[float, float], steps: int = 1, name: str = "rig") -> None:
    sim.robot(name).command(*rates)
    for _ in range(steps):
        sim.step()


# ---------------------------------------------------------------------------------------------------------- contact


def test_a_trailer_backed_into_a_wall_stops_the_tractor() -> None:
    sim = am.Simulation(yard(rig(x=3.0, y=5.0)))
    drive(sim, (-5.0, -5.0), 60)
    found = sim.robot("rig")
    # The wall is a cell thick, from 0 to 1 cm, and the trailer's rear 1.5 m behind the base point.
    assert found.true_pose[0] == pytest.approx(1.51, abs=1e-9)
    assert found.parts["trailer"] == pytest.approx([0.41, 5.0, 0.0], abs=1e-9)
    assert 0.0 <= least_gap(sim) < 1e-9
    met = sim.events[0]
    assert (met.kind, met.name, met.part, met.other, met.other_part) == ("collision", "rig", "trailer", "wall", "")
    assert " s: rig.trailer met wall at (0.010, " in str(met)
    assert met.point == pytest.approx((0.01, 5.0), abs=0.26)
    assert met.speed == pytest.approx(0.5)
    assert len(sim.events) == 1  # it leans on, and collides once
    assert sim.touching.tolist() == [True]
    assert found.joints[0] == pytest.approx(-14.9, abs=1e-9)  # its wheels stopped, too


def test_a_trailer_that_swings_into_something_tells_its_own_speed() -> None:
    # The tractor turns on the spot: it goes nowhere, but its hitch, and with it the trailer, goes aside.
    free = am.Simulation(yard(rig(x=5.0, y=5.0), dt=1e-4))
    sim = am.Simulation(yard(rig(x=5.0, y=5.0), obstacles=[stone("post", 4.15, 4.6, 0.1)]))
    free.robot("rig").command(-5.0, 5.0)
    drive(sim, (-5.0, 5.0), 20)
    met = next(event for event in sim.events if event.name == "rig")
    assert (met.part, met.other) == ("trailer", "post")
    assert met.point is not None
    before = {}
    steps = round(met.time / 1e-4)
    for step in range(1, steps + 2):
        free.step()
        if step >= steps - 1:
            before[step] = free.robot("rig").parts["trailer"]
    x, y, heading = before[steps]
    c, s = math.cos(heading), math.sin(heading)
    dx, dy = met.point[0] - x, met.point[1] - y
    inside = np.array([[c * dx + s * dy, c * dy - s * dx, 0.0]])
    one, other = (compose(before[step][None], inside)[0, :2] for step in (steps - 1, steps + 1))
    expected = math.hypot(*(other - one)) / 2e-4
    assert expected > 0.05
    assert met.speed == pytest.approx(expected, rel=1e-3)
    assert [event.speed for event in sim.events if event.name == "post"] == [0.0]
    assert sim.robot("rig").true_pose[:2] == pytest.approx([5.0, 5.0])


def test_those_in_contact_can_part() -> None:
    sim = am.Simulation(yard(rig(x=1.6, y=5.0)))
    drive(sim, (-5.0, -5.0), 10)
    assert least_gap(sim) < 1e-9
    drive(sim, (5.0, 5.0), 4)
    assert sim.robot("rig").true_pose[0] == pytest.approx(1.51 + 0.2, abs=1e-9)
    assert not sim.touching.any()


def test_the_hitch_stops_where_the_trailer_does() -> None:
    """Turning on the spot, the tractor swings the trailer against a post; the joint is that of the instant."""
    sim = am.Simulation(yard(rig(x=5.0, y=5.0), obstacles=[stone("post", 3.75, 4.62)]))
    drive(sim, (4.0, -4.0), 40)
    found = sim.robot("rig")
    assert {event.other for event in sim.events if event.name == "rig"} == {"post"}
    assert 0.0 < abs(found.joints[2]) < 1.4
    inside = stack([tractor()]).part_poses(found.joints[None])[0]
    assert compose(found.true_pose[None], inside)[0] == pytest.approx(found.parts["trailer"], abs=1e-12)
    post = shapely.Point(3.75, 4.62).buffer(0.1, quad_segs=256)
    assert outline(tractor().parts[0].shape, found.parts["trailer"]).distance(post) == pytest.approx(0.0, abs=1e-5)


def free_until(scene: Any, at: Any, parts: int = 400) -> float:
    """The fraction of a step at which some outline of `at` first overlaps the scene: by looking, then by halving."""
    free = 0.0
    for i in range(1, parts + 1):
        if any(shape.intersection(scene).area > 1e-10 for shape in at(i / parts)):
            hit = i / parts
            while hit - free > 1e-9:
                middle = 0.5 * (free + hit)
                if any(shape.intersection(scene).area > 1e-10 for shape in at(middle)):
                    hit = middle
                else:
                    free = middle
            return free
        free = i / parts
    return 1.0


@pytest.mark.parametrize("seed", range(12))
def test_the_sweep_finds_the_contact_that_looking_along_the_path_finds(seed: int) -> None:
    """Among posts and slanted walls, in one long step, against shapely's outlines of tractor and trailer."""
    random = np.random.default_rng(seed)
    hitch, before = float(random.uniform(-1.2, 1.2)), np.zeros((1, 3))
    before[0, 2] = hitch
    robot = rig(x=5.0, y=5.0, heading=float(random.uniform(-3.0, 3.0)))
    one = stack([robot.drive])
    shapes = [robot.shape, robot.drive.parts[0].shape]
    rates = random.uniform(-12.0, 12.0, 2)
    start = np.array([[5.0, 5.0, robot.pose.heading]])

    def at(fraction: float) -> list[shapely.Polygon]:
        after = before + np.array([[*rates, 0.0]]) * 1.0
        moved = one.displacement(before, after, np.array([[fraction]]))
        body = compose(start, moved)
        joints = one.follow(before + (after - before) * fraction, moved)
        return [outline(shapes[0], body[0]), outline(shapes[1], compose(body, one.part_poses(joints)[:, 0])[0])]

    stones = []
    straight = compose(start, one.part_poses(np.zeros((1, 3)))[:, 0])[0]  # as it stands before its hitch is turned
    standing = shapely.union_all([*at(0.0), outline(shapes[1], straight)])
    while len(stones) < 5:
        x, y = random.uniform(3.0, 7.0, 2)
        shape = am.Shape.rectangle(*random.uniform(0.05, 0.5, 2).tolist())
        heading = float(random.uniform(-3.0, 3.0))
        if outline(shape, (x, y, heading)).distance(standing) > 0.01:
            name, pose = f"s{len(stones)}", am.Pose(x=float(x), y=float(y), heading=heading)
            stones.append(am.Obstacle(name=name, shape=shape, pose=pose))
            standing = standing.union(outline(shape, (x, y, heading)))
    scene = shapely.union_all([outline(s.shape, (s.pose.x, s.pose.y, s.pose.heading)) for s in stones])
    sim = am.Simulation(yard(robot, obstacles=stones, dt=1.0))
    group = sim._fleet.groups[0]
    group.joints[:] = before
    group.parts.start()
    sim._fleet.place()
    drive(sim, tuple(rates.tolist()))
    expected = free_until(scene, at)
    found = sim.robot("rig")
    assert found.joints[:2] == pytest.approx(rates * expected, abs=2e-4)  # areas of 1e-10 m^2 see a corner late
    if expected == 1.0:
        assert not sim.events
    assert found.joints[2] == pytest.approx(
        one.follow(before + np.array([[*rates, 0.0]]) * expected, one.displacement(
            before, before + np.array([[*rates, 0.0]]), np.array([[expected]])))[0, 2],
        abs=2e-4,
    )  # fmt: skip
    for shape, pose in zip(shapes, (found.true_pose, found.parts["trailer"]), strict=True):
        assert outline(shape, pose).intersection(scene).area < 1e-10


def test_two_rigs_stop_each_other_whatever_of_them_meets() -> None:
    """One drives into the other's trailer, far from its tractor; both are named in the event, with their parts."""
    sim = am.Simulation(yard(rig("a", 5.0, 5.0), rig("b", 3.8, 3.5, math.pi / 2.0)))
    drive(sim, (5.0, 5.0), 60, name="b")
    assert {(event.name, event.other) for event in sim.events} == {("a", "b"), ("b", "a")}
    assert {(event.name, event.part, event.other_part) for event in sim.events} == {
        ("a", "trailer", ""),
        ("b", "", "trailer"),
    }
    assert any("b met a.trailer at" in str(event) for event in sim.events)
    # The trailer's side is at 4.75, the tractor's front a quarter of a metre ahead of its base point.
    assert sim.robot("b").true_pose[1] == pytest.approx(4.5, abs=1e-9)
    assert 0.0 <= least_gap(sim) < 1e-9


def test_a_moving_obstacle_stops_at_a_trailer() -> None:
    ball = stone("ball", 3.9, 2.0, 0.2, motion=am.motions.Loop(waypoints=((3.9, 2.0), (3.9, 8.0)), speed=1.0))
    sim = am.Simulation(yard(rig(x=5.0, y=5.0), obstacles=[ball]))
    for _ in range(40):
        sim.step()
    assert sim.obstacle("ball").true_pose[1] == pytest.approx(5.0 - 0.25 - 0.2, abs=1e-6)
    assert {event.name for event in sim.events} == {"ball", "rig"}


def test_the_parts_of_one_robot_do_not_collide() -> None:
    """Folded as far as its hitch goes, the trailer's outline crosses the tractor's; it drives on."""
    folds = tractor(hitch_offset=0.1, trailer_length=0.5)
    sim = am.Simulation(yard(rig(x=5.0, y=5.0, drive=folds), side=14.0))
    drive(sim, (-4.0, -4.2), 60)
    found = sim.robot("rig")
    assert abs(found.joints[2]) == pytest.approx(1.4)
    own = outline(am.Shape.rectangle(0.5, 0.5), found.true_pose)
    assert own.intersection(outline(folds.parts[0].shape, found.parts["trailer"])).area > 0.01
    assert not sim.events


def test_a_hitch_at_its_end_turns_with_the_tractor_and_comes_back() -> None:
    """Whatever the step: the equation of the hitch holds no time, so cutting off what is beyond is exact."""
    ends = []
    for dt in (0.01, 0.1, 0.5):
        sim = am.Simulation(yard(rig(x=7.0, y=7.0), side=14.0, dt=dt))
        drive(sim, (-2.0, 3.0), round(2.0 / dt))
        folded = float(sim.robot("rig").joints[2])
        assert folded == pytest.approx(1.4, abs=1e-12)
        drive(sim, (6.0, 6.0), round(1.0 / dt))
        ends.append([*sim.robot("rig").joints, *sim.robot("rig").parts["trailer"]])
    assert ends[0][2] < 1.0
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)
    assert ends[0] == pytest.approx(ends[2], abs=1e-9)


@attrs.frozen(kw_only=True)
class Spade(am.drives.Differential):
    """A round body with an arm that its motor swings, while the wheels stand: a part that moves by itself."""

    joints = (*am.drives.Differential.joints, am.Joint(name="arm", rolls=False))
    channels = (*am.drives.Differential.channels, "arm")
    parts = (am.Part("arm", am.Shape.rectangle(0.6, 0.1, x=0.5)), am.Part("tip", am.Shape.circle(0.1)))

    def advance(self, joints: Any, rates: Any, command: Any, dt: float, state: Any, draws: Any) -> Any:
        return joints + command * dt, command.copy()

    def twist(self, before: Any, after: Any) -> Any:
        return super().twist(before[:, :2].copy(), after[:, :2].copy())

    def command_for(self, twist: Any, joints: Any) -> Any:
        return np.concatenate((super().command_for(twist, joints), np.zeros((len(twist), 1))), axis=1)

    def part_poses(self, joints: Any) -> Any:
        poses = np.zeros((len(joints), 2, 3))
        poses[:, :, 2] = joints[:, 2:]
        poses[:, 1, 0], poses[:, 1, 1] = 0.8 * np.cos(joints[:, 2]), 0.8 * np.sin(joints[:, 2])
        return poses

    def part_travel(self, before: Any, after: Any) -> Any:
        way, turn = self.travel(before, after).T
        turn = turn + np.abs(after - before)[:, 2]
        return np.stack((np.stack((way, turn), 1), np.stack((way + 0.8 * turn, turn), 1)), 1)


def test_an_arm_that_swings_stops_at_a_wall_though_the_body_stands() -> None:
    arm = building.drive()
    spade = Spade(**attrs.asdict(arm))
    am.testing.check_component(spade)
    sim = am.Simulation(yard(rig(x=5.0, y=0.7, shape=am.Shape.circle(0.2), drive=spade)))
    sim.robot("rig").command(0.0, 0.0, -2.0)
    for _ in range(20):
        sim.step()
    # The tip is round, a tenth of a metre about its middle, and the wall ends a centimetre above 0.
    assert sim.robot("rig").joints[2] == pytest.approx(-math.asin((0.69 - 0.1) / 0.8), abs=1e-9)
    assert 0.0 <= least_gap(sim) < 1e-9
    assert [(event.name, event.other) for event in sim.events] == [("rig", "wall")]
    assert sim.robot("rig").true_pose.tolist() == [5.0, 0.7, 0.0]
