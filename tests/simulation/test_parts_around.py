"""Robots of several parts: how others sense them, where they may start, and that their bits depend on nothing else."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

import amorsim as am
from amorsim.motions import Loop, Oscillate, Pedestrian
from tests import building
from tests.examples import settings
from tests.simulation.rigs import least_gap, map_with, rig, stone, tractor, yard


def watcher(
    name: str = "watcher", x: float = 3.9, y: float = 1.0, heading: float = math.pi / 2.0, **sensors: Any
) -> Any:
    """A small robot that looks at the trailer of a rig at (5, 5), which is around (3.9, 5)."""
    return rig(
        name, x, y, heading, shape=am.Shape.circle(0.1), drive=building.drive(), sensors=sensors,
    )  # fmt: skip


# ---------------------------------------------------------------------------------------------------------- sensing


def test_a_beam_meets_the_trailer_where_its_outline_is() -> None:
    """Against shapely, from places all around, with the trailer at some angle."""
    random = np.random.default_rng(5)
    pair = yard(rig(x=5.0, y=5.0), watcher(laser=am.sensors.Laser(beams=361, range_max=20.0)))
    sim = am.Simulation(pair)
    sim.robot("rig").command(3.0, -3.0)
    for _ in range(4):
        sim.step()
    sim.robot("rig").command(0.0, 0.0)
    found = sim.robot("rig")
    outlines = [_outline(rig().shape, found.true_pose), _outline(tractor().parts[0].shape, found.parts["trailer"])]
    bearings = pair.robots[1].sensors["laser"].sensor
    hits = 0
    for _ in range(12):
        pose = random.uniform((1.0, 1.0, -3.0), (9.0, 2.5, 3.0))
        sim.set_pose("watcher", pose.tolist())
        sim.step()
        ranges = sim.robot("watcher").readings["laser"].true
        for value, bearing in zip(ranges, am.stack([bearings]).bearings()[0], strict=True):
            heading = pose[2] + bearing
            beam = shapely.LineString([pose[:2], pose[:2] + 14.0 * np.array([math.cos(heading), math.sin(heading)])])
            near = min(
                shapely.Point(pose[:2]).distance(beam.intersection(o)) if beam.intersects(o) else 99.0 for o in outlines
            )
            if near < 99.0:
                assert value == pytest.approx(near, abs=1e-6)
                hits += outlines[1].intersects(beam)
    assert hits > 50


def _outline(shape: am.Shape, pose: Any) -> shapely.Polygon:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return shapely.Polygon(shape.outline @ np.array([[c, s], [-s, c]]) + pose[:2])


def test_a_robot_does_not_see_its_own_trailer() -> None:
    behind = am.MountedSensor(
        sensor=am.sensors.Laser(beams=3, fov=0.02, range_max=20.0), mount=am.Mount(heading=math.pi)
    )
    sim = am.Simulation(yard(rig(x=5.0, y=5.0, sensors={"laser": behind})))
    assert sim.robot("rig").readings["laser"].true == pytest.approx([4.99] * 3, abs=1e-3)


def test_a_trailer_hides_marks_and_other_robots() -> None:
    marks = am.sensors.Fiducial(range_max=20.0, range_max_id=20.0)
    with_mark = stone("post", 3.9, 8.0, 0.2, fiducial=7)
    robots = rig(x=5.0, y=5.0), watcher(marks=marks)
    sim = am.Simulation(yard(*robots, obstacles=[with_mark]))
    assert (sim.robot("watcher").readings["marks"].true.reshape(-1, 3)[:, 2] == -1.0).all()
    sim.set_pose("rig", (8.0, 5.0, 0.0))
    sim.step()
    assert sim.robot("watcher").readings["marks"].true[:3] == pytest.approx([7.0, 0.0, 7.0])


def test_a_camera_sees_tractor_and_trailer_in_the_tractors_colour() -> None:
    camera = am.sensors.Camera(width=400, colours=("red",), fov=math.pi / 2.0, range_max=20.0)
    sim = am.Simulation(yard(rig(x=5.0, y=5.0, colour="red"), watcher(camera=camera)))
    blobs = sim.robot("watcher").readings["camera"].true.reshape(-1, 7)
    blobs = blobs[blobs[:, 0] == 0.0]
    # The trailer from 3.5 to 4.2 at 3.75 m, the tractor from 4.75 to 5.25; nearest first, with half a column's width.
    pixel = math.pi / 2.0 / 400.0
    edges = [[math.atan2(0.4, 3.75), math.atan2(-0.3, 3.75)], [math.atan2(-0.85, 4.25), math.atan2(-1.35, 3.75)]]
    assert len(blobs) == 2
    for blob, (left, right) in zip(blobs, edges, strict=True):
        assert 199.5 - blob[1] == pytest.approx(left / pixel, abs=1.0)
        assert 199.5 - blob[2] == pytest.approx(right / pixel, abs=1.0)
    assert blobs[0, 5] == pytest.approx(3.75, abs=1e-3)


def test_a_bumper_is_pressed_by_a_trailer() -> None:
    sim = am.Simulation(yard(rig(x=5.0, y=5.0), watcher(bumper=am.sensors.Bumper())))
    assert sim.robot("watcher").readings["bumper"].true.tolist() == [0.0, 0.0]
    sim.robot("watcher").command(10.0, 10.0)
    for _ in range(60):
        sim.step()
    assert sim.robot("watcher").readings["bumper"].true.tolist() == [1.0, 1.0]
    assert {(event.name, event.other) for event in sim.events} == {("watcher", "rig"), ("rig", "watcher")}


def test_a_pedestrian_gives_way_to_a_trailer() -> None:
    """Beside the trailer of one whom he minds he goes farther off than beside the same robot without one."""
    sides = []
    for drive, minds in ((tractor(), True), (building.drive(), True), (tractor(), False)):
        walker = stone("walker", 6.7, 2.0, 0.2, motion=Pedestrian(goals=((6.7, 8.0),), avoid_robots=minds))
        sim = am.Simulation(yard(rig(x=5.0, y=5.0, heading=math.pi, drive=drive), obstacles=[walker]))
        sim.run(2.2)
        assert not sim.events
        sides.append(float(sim.obstacle("walker").true_pose[0]))
    assert sides[0] > sides[1] + 0.05
    assert sides[1] > sides[2]


def test_the_papers_picture_has_the_trailer() -> None:
    cells = am.Simulation(yard(rig(x=5.0, y=5.0))).occupancy(0.1)
    assert (cells[48:52, 36:42] == 2).all()
    assert (cells[48:52, 43:46] == 0).all()  # between the two
    assert (cells[48:52, 48:52] == 2).all()


# --------------------------------------------------------------------------------------------------- starts, changes


def test_a_trailer_that_starts_in_a_wall_or_in_another_is_refused() -> None:
    with pytest.raises(am.ScenarioError, match=r"robots\.rig\.pose.*'rig\.trailer' overlaps a wall"):
        am.Simulation(yard(rig(x=1.4, y=5.0)))
    with pytest.raises(am.ScenarioError, match=r"robots\.b\.pose: overlaps 'a\.trailer'"):
        am.Simulation(yard(rig("a", 5.0, 5.0), rig("b", 3.9, 5.4)))
    with pytest.raises(am.ScenarioError, match=r"obstacles\.post\.pose: overlaps 'rig\.trailer'"):
        am.Simulation(yard(rig(x=5.0, y=5.0), obstacles=[stone("post", 3.9, 5.0)]))


SCENARIO = """
format = 1
[world]
map = "room.wld"
[[robots]]
name = "rig"
count = 4
start = { grid = [2.0, 1.5], spacing = SPACING, columns = 2 }
shape = { rectangle = [0.5, 0.5] }
drive = { use = "tractor", wheel_radius_left = 0.1, wheel_radius_right = 0.1, track = 0.4, rate_max_deg = 3000.0, \
trailer_length = 0.8, hitch_offset = 0.3, hitch_max_deg = 80.0, trailer_width = 0.5, trailer_front = 0.3, \
trailer_rear = 0.4 }
"""
ROOM = "width 10000\nheight 10000\n0 0 10000 0\n10000 0 10000 10000\n10000 10000 0 10000\n0 10000 0 0\n"


def test_a_file_is_reported_where_trailers_have_no_room(tmp_path: Path) -> None:
    (tmp_path / "room.wld").write_text(ROOM)
    path = tmp_path / "yard.toml"
    path.write_text(SCENARIO.replace("SPACING", "2.0"))
    scenario = am.load(path)
    assert scenario.robots[0].drive.hitch_max == pytest.approx(math.radians(80.0))
    assert least_gap(am.Simulation(scenario)) > 0.0
    path.write_text(SCENARIO.replace("SPACING", "1.7"))
    with pytest.raises(am.ScenarioError) as caught:
        am.load(path)
    assert [str(fault).partition(": ")[2] for fault in caught.value.faults]
    assert "rig1: overlaps 'rig0'" in str(caught.value)
    path.write_text(SCENARIO.replace("SPACING", "2.0").replace("[2.0, 1.5]", "[1.4, 1.5]"))
    with pytest.raises(am.ScenarioError, match=r"rig0: at \(0\.300, 1\.500\) m its trailer overlaps"):
        am.load(path)


def test_a_robot_that_has_no_place_finds_one_for_its_trailer_too() -> None:
    """In a corridor that is longer than the tractor and narrower than both are long."""
    corridor = map_with((0.0, 8.4, 10.0, 8.4), (7.0, 8.4, 7.0, 10.0), side=10.0)
    sim = am.Simulation(yard(rig(pose=None), map=corridor))
    assert least_gap(sim) > 0.0
    tight = building.room(1.9, 1.9, 0.01)
    with pytest.raises(am.MapError, match="no place"):
        am.Simulation(yard(rig(pose=None), map=tight))


def test_starts_at_random_leave_room_for_trailers() -> None:
    errors = {"drive.trailer_length": am.Deviation(scale=am.Distribution(kind="normal", values=(1.0, 0.2)))}
    robots = [
        rig(f"r{i:02d}", pose=None, start=am.RandomStart(clearance=0.05), errors=errors if i % 2 else {})
        for i in range(20)
    ]
    sim = am.Simulation(yard(*robots), replicas=6)
    world = sim._fleet.world
    gaps, _ = world.wall_gaps(world.everyone, world.poses, np.ones(len(world.everyone)))
    assert gaps.min() >= 0.05
    a, b = world.pairs_within(world.poses, np.ones(len(world.everyone)))
    assert world.body_gaps(a, world.poses[a], b, world.poses[b], np.ones(len(a))).min() >= 0.05
    assert len({tuple(pose) for pose in sim.true_pose.tolist()}) == 120
    alone = am.Simulation(yard(*robots), replicas=[4])
    np.testing.assert_array_equal(alone.part_pose, sim.part_pose[80:100])


def test_who_is_put_elsewhere_takes_his_trailer_along() -> None:
    sim = am.Simulation(yard(rig(x=5.0, y=5.0), rig("other", 8.0, 8.0)))
    for pose, what in (((1.4, 5.0, 0.0), "a wall"), ((8.4, 6.9, -math.pi / 2.0), "'other")):
        with pytest.raises(am.AmorsimError, match=what):
            sim.set_pose("rig", pose)
    assert sim.robot("rig").parts["trailer"] == pytest.approx([3.9, 5.0, 0.0])
    sim.set_pose("rig", (5.0, 5.0, math.pi / 2.0))
    assert sim.robot("rig").parts["trailer"] == pytest.approx([5.0, 3.9, math.pi / 2.0])
    np.testing.assert_array_equal(sim.part_pose[1], sim.robot("rig").parts["trailer"])
    assert sim.parts == ("other.trailer", "rig.trailer")


def test_a_drive_that_changes_moves_its_trailer_or_is_refused() -> None:
    sim = am.Simulation(yard(rig(x=5.0, y=5.0)))
    sim.set("rig", "drive.trailer_length", 1.0)
    assert sim.robot("rig").parts["trailer"][0] == pytest.approx(3.7)
    with pytest.raises(am.AmorsimError, match=r"drive\.trailer_length: with it the robot would overlap a wall"):
        sim.set("rig", "drive.trailer_length", 4.5)
    assert sim.robot("rig").nominal.drive.trailer_length == 1.0
    assert sim.robot("rig").parts["trailer"][0] == pytest.approx(3.7)
    with pytest.raises(am.AmorsimError, match="fixed"):
        sim.set("rig", "drive.trailer_width", 1.0)


def test_a_hitch_whose_end_is_set_nearer_does_not_jump() -> None:
    """It comes back as the tractor pulls; and at no instant is the trailer in the wall beside it."""
    sim = am.Simulation(yard(rig(x=5.0, y=5.0)))
    sim.robot("rig").command(-2.0, 3.0)
    for _ in range(20):
        sim.step()
    folded = float(sim.robot("rig").joints[2])
    assert folded == pytest.approx(1.4)
    sim.set("rig", "drive.hitch_max", 0.3)
    sim.step()
    assert float(sim.robot("rig").joints[2]) == folded
    sim.robot("rig").command(2.0, 2.0)
    before = sim.robot("rig").parts["trailer"]
    for _ in range(60):
        sim.step()
        now = sim.robot("rig").parts["trailer"]
        assert np.hypot(*(now - before)[:2]) < 0.03
        before = now
    assert abs(float(sim.robot("rig").joints[2])) < 0.5 * folded


# -------------------------------------------------------------------------------------------------------------- bits


def mixed(count: int = 6, order: int = 1, **changes: Any) -> am.Scenario:
    """Rigs and others of several kinds, with noise, that drive at random and meet."""
    errors = {"drive.trailer_length": am.Deviation(scale=am.Distribution(kind="normal", values=(1.0, 0.05)))}
    robots = []
    for i in range(count):
        more: dict[str, Any] = {}
        if i % 3 == 2:
            more = {"shape": am.Shape.circle(0.3), "drive": building.drive()}
        elif i % 3 == 1:
            more = {"errors": errors, "drive": tractor(trailer_width=0.4, trailer_front=0.2)}
        robots.append(
            rig(
                f"r{i}", 1.7 + 2.6 * (i % 3), 2.0 + 2.5 * (i // 3), 0.2 * i,
                controller=building.Roam(rate=12.0),
                sensors={"encoder": building.encoder(), "laser": am.sensors.Laser(beams=9, range_max=9.0)},
                estimators={"odometry": am.estimators.DeadReckoning()},
                ground=building.chain(am.noise.Gaussian(std=1e-3)),
                **more,
            )
        )  # fmt: skip
    posts = [stone("post", 5.0, 8.0, 0.3, motion=Oscillate(waypoints=((1.0, 8.5), (9.0, 8.5)), speed=1.5))]
    return yard(*robots[::order], obstacles=posts, **changes)


def run(sim: am.Simulation, steps: int = 50) -> am.Simulation:
    for _ in range(steps):
        sim.step()
    return sim


def test_bits_depend_on_no_order_no_replicas_and_no_threads() -> None:
    one = run(am.Simulation(mixed(), replicas=[7]))
    assert any(event.kind == "collision" for event in one.events)
    backwards = run(am.Simulation(mixed(order=-1), replicas=[7]))
    many = run(am.Simulation(mixed(), replicas=9, threads=2))
    assert one.digest() == backwards.digest() == many.digest(7)
    assert many.digest(6) != one.digest()
    parts = len(one.parts)
    np.testing.assert_array_equal(one.part_pose, backwards.part_pose)
    np.testing.assert_array_equal(one.part_pose, many.part_pose[7 * parts : 8 * parts])
    assert [e for e in many.events if e.replica == 7] == one.events


def test_replicas_never_meet() -> None:
    """Two at one place in two replicas: neither the beams nor the bodies of the one find the other."""
    laser = am.sensors.Laser(beams=9, range_max=9.0)
    crowd = am.Simulation(yard(rig(x=5.0, y=5.0, sensors={"laser": laser})), replicas=3)
    alone = am.Simulation(yard(rig(x=5.0, y=5.0, sensors={"laser": laser})))
    np.testing.assert_array_equal(crowd.readings["laser"].true, np.repeat(alone.readings["laser"].true, 3, axis=0))


def test_a_snapshot_brings_the_trailers_back() -> None:
    sim = run(am.Simulation(mixed(), replicas=2), 25)
    held = sim.snapshot()
    first = run(sim, 25).digest()
    parts = sim.part_pose.copy()
    sim.restore(held)
    assert run(sim, 25).digest() == first
    np.testing.assert_array_equal(sim.part_pose, parts)
    sim.reset(replicas=[1])
    fresh = am.Simulation(mixed(), replicas=2)
    half = len(sim.parts)
    np.testing.assert_array_equal(sim.part_pose[half:], fresh.part_pose[half:])
    np.testing.assert_array_equal(sim.part_pose[:half], parts[:half])


def test_parts_are_where_the_joints_have_them() -> None:
    """After any number of steps and contacts: what contact keeps and what the joints tell do not drift apart."""
    sim = am.Simulation(mixed(), replicas=2)
    for _ in range(60):
        sim.step()
        for group in sim._fleet.groups:
            if group.parts is None:
                continue
            inside = group.drive.part_poses(group.joints)[:, 0]
            there = am.compose(group.true_pose, inside)
            assert np.abs(am.relative(group.parts.poses, there)).max() < 1e-12


def check(sim: am.Simulation) -> None:
    assert least_gap(sim) >= -1e-9


def crowd_of(seed: int, rigs: int, others: int, dt: float, side: float, rate: float) -> am.Simulation | None:
    start = am.RandomStart()
    lengths, offsets = (0.5, 0.8, 1.1), (0.3, 0.0, -0.1)
    robots = [
        rig(
            f"r{i:03d}", pose=None, start=start, controller=building.Roam(rate=rate),
            drive=tractor(trailer_length=lengths[i % 3], hitch_offset=offsets[i % 3], hitch_max=(1.4, 3.0)[i % 2]),
        )
        for i in range(rigs)
    ]  # fmt: skip
    motions = (Loop(waypoints=((1.0, 1.0), (side - 1.0, side - 1.0)), speed=3.0, blocked="skip", patience=0.1), None)
    things = [
        am.Obstacle(name=f"o{i:03d}", shape=am.Shape.rectangle(0.4, 0.2), motion=motions[i % 2], start=start)
        for i in range(others)
    ]
    try:
        return am.Simulation(yard(*robots, obstacles=things, dt=dt, seed=seed, side=side))
    except am.ScenarioError:  # too dense to be placed at random
        return None


@pytest.mark.long
@given(
    seed=st.integers(0, 2**32),
    rigs=st.integers(1, 12),
    others=st.integers(0, 12),
    dt=st.sampled_from([0.02, 0.1, 0.5]),
    rate=st.sampled_from([5.0, 40.0]),
)
@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_nothing_of_anybody_overlaps(seed: int, rigs: int, others: int, dt: float, rate: float) -> None:
    sim = crowd_of(seed, rigs, others, dt, 7.0, rate)
    if sim is None:
        return
    check(sim)
    for _ in range(10):
        sim.step()
        check(sim)


@pytest.mark.parametrize(
    ("rigs", "side", "dt"),
    [
        pytest.param(60, 14.0, 0.1, marks=pytest.mark.long),
        pytest.param(200, 24.0, 0.1, marks=pytest.mark.long),
        pytest.param(200, 30.0, 0.5, marks=pytest.mark.nightly),
    ],
)
def test_nothing_overlaps_among_hundreds_of_bodies(rigs: int, side: float, dt: float) -> None:
    sim = crowd_of(1, rigs, 60, dt, side, 20.0)
    assert sim is not None
    for _ in range(40):
        sim.step()
        check(sim)
    assert len(sim.events) > 50


def test_a_run_with_trailers_reproduces(tmp_path: Path) -> None:
    wander = am.controllers.Wander(sensor="laser", speed=0.8)
    scenario = mixed(duration=2.0)
    robots = tuple(attrs.evolve(robot, controller=wander) for robot in scenario.robots)
    am.run(attrs.evolve(scenario, robots=robots), tmp_path / "run", replicas=2)
    assert am.reproduce(tmp_path / "run").is_exact
