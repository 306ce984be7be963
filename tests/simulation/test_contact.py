"""Bodies stop where they touch, and nothing gets through."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.contracts import Draws, Drive, Motion, State, View
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.simulation.contact import resolve as contact
from amorsim.simulation.fleet.locomotion import Locomotion
from tests import building
from tests.examples import settings
from tests.some_cases import one_in


def placed(sim: am.Simulation, name: str) -> shapely.Polygon:
    robot = next(r for r in sim.scenario.robots if r.name == name)
    x, y, heading = sim.robot(name).true_pose
    shape = shapely.Polygon(robot.shape.outline)
    turned = shapely.affinity.rotate(shape, heading, origin=(0, 0), use_radians=True)
    return shapely.affinity.translate(turned, x, y)


def drive_at_wall(**changes: object) -> am.Simulation:
    robot = building.robot(pose=am.Pose(x=3.0, y=2.5), **changes)
    sim = am.Simulation(building.scenario(robot))
    sim.robot("rover").drive(forward=1.0)
    sim.run(5.0)
    return sim


def test_a_robot_stops_at_the_wall_and_says_so() -> None:
    sim = drive_at_wall()
    # The wall's line fills the cells on both sides of x = 6 m: 5.999 m to 6.001 m. The front is 0.2 m ahead.
    assert sim.true_pose[0] == pytest.approx([5.799, 2.5, 0.0], abs=1e-9)
    collision, ended = sim.events
    assert (collision.kind, collision.name, collision.other) == ("collision", "rover", "wall")
    assert collision.time == pytest.approx(2.799, abs=1e-6)
    assert collision.speed == pytest.approx(1.0)
    assert collision.point == pytest.approx((5.999, 2.5), abs=0.25)
    assert ended.kind == "controller_ended"
    assert not sim.robot("rover").is_active
    assert sim.robot("rover").true_twist.tolist() == [0.0, 0.0, 0.0]


def test_a_setting_lets_the_controller_go_on() -> None:
    sim = drive_at_wall(on_collision="continue")
    assert sim.robot("rover").is_active
    sim.robot("rover").drive(forward=-0.5)
    sim.run(2.0)
    assert sim.true_pose[0, 0] == pytest.approx(5.799 - 1.0, abs=1e-6)  # touching is not a bond


def test_encoders_count_only_what_the_wheels_turned() -> None:
    sim = drive_at_wall()
    assert sim.robot("rover").joints * building.RADIUS == pytest.approx([2.799, 2.799], abs=1e-9)
    assert sim.estimated_pose[0] == pytest.approx(sim.true_pose[0], abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(
    speed=st.floats(0.01, 300.0),
    turn=st.floats(-20.0, 20.0),
    heading=st.floats(-math.pi, math.pi),
    dt=st.sampled_from([0.01, 0.1, 1.0]),
    resolution=st.sampled_from([0.001, 0.05]),
)
def test_nothing_tunnels(speed: float, turn: float, heading: float, dt: float, resolution: float) -> None:
    """At any speed and step the footprint stays within one-cell walls, and overlaps none."""
    robot = building.robot(pose=am.Pose(x=3.0, y=2.5, heading=heading), on_collision="continue")
    sim = am.Simulation(building.scenario(robot, map=building.room(resolution=resolution), dt=dt))
    sim.robot("rover").drive(forward=speed, turn=turn)
    inside = shapely.box(0.0, 0.0, 6.0, 5.0)
    for _ in range(3):
        sim.step()
        assert placed(sim, "rover").difference(inside).area < 1e-9
        gap, _ = sim._fleet.world.wall_gaps(np.array([0]), sim._fleet.world.poses, np.array([1.0]))
        assert gap[0] >= 0.0


@settings(max_examples=30, deadline=None)
@given(
    speeds=st.lists(st.tuples(st.floats(-3.0, 3.0), st.floats(-5.0, 5.0)), min_size=4, max_size=4),
    dt=st.sampled_from([0.05, 0.5]),
)
def test_robots_never_overlap(speeds: list[tuple[float, float]], dt: float) -> None:
    fleet = [
        building.robot(name=f"r{i}", pose=am.Pose(x=2.0 + (i % 2), y=2.0 + i // 2, heading=i), on_collision="continue")
        for i in range(4)
    ]
    sim = am.Simulation(building.scenario(*fleet, dt=dt))
    for i, (forward, turn) in enumerate(speeds):
        sim.robot(f"r{i}").drive(forward, turn)
    for _ in range(6):
        sim.step()
        shapes = [placed(sim, f"r{i}") for i in range(4)]
        for i in range(4):
            for j in range(i):
                assert shapes[i].intersection(shapes[j]).area < 1e-9


def test_two_that_meet_both_stop_and_a_third_goes_on() -> None:
    fleet = [
        building.robot(name="east", pose=am.Pose(x=1.0, y=1.0, heading=0.0)),
        building.robot(name="west", pose=am.Pose(x=3.0, y=1.0, heading=math.pi)),
        building.robot(name="other", pose=am.Pose(x=1.0, y=4.0, heading=0.0)),
    ]
    sim = am.Simulation(building.scenario(*fleet))
    for name in sim.names:
        sim.robot(name).drive(forward=0.5)
    sim.run(3.0)
    # Fronts 0.2 m ahead of each: they meet in the middle, at x = 2 m.
    assert sim.robot("east").true_pose[0] == pytest.approx(1.8, abs=1e-9)
    assert sim.robot("west").true_pose[0] == pytest.approx(2.2, abs=1e-9)
    assert sim.robot("other").true_pose[0] == pytest.approx(2.5, abs=1e-9)
    met = {(event.name, event.other): event for event in sim.events if event.kind == "collision"}
    assert set(met) == {("east", "west"), ("west", "east")}
    assert met["east", "west"].time == pytest.approx(1.6, abs=1e-6)
    assert met["east", "west"].point == pytest.approx((2.0, 1.0), abs=0.01)


def test_one_that_stopped_is_an_obstacle_for_the_rest_of_the_step() -> None:
    """In one long step: the first stops at the wall, and the one behind him stops at him, not where he would be."""
    fleet = [
        building.robot(name="first", pose=am.Pose(x=5.0, y=1.0)),
        building.robot(name="second", pose=am.Pose(x=3.0, y=1.0)),
    ]
    sim = am.Simulation(building.scenario(*fleet, dt=1.0))
    for name in sim.names:
        sim.robot(name).drive(forward=4.0)
    sim.step()
    assert sim.robot("first").true_pose[0] == pytest.approx(5.799, abs=1e-9)
    assert sim.robot("second").true_pose[0] == pytest.approx(5.799 - 0.3 - 0.2, abs=1e-9)
    assert [event.other for event in sim.events if event.kind == "collision"] == ["wall", "second", "first"]


def test_replicas_never_meet() -> None:
    sim = am.Simulation(building.scenario(building.robot(controller=building.Roam())), replicas=20)
    for _ in range(30):
        sim.step()
    assert all(event.other == "wall" for event in sim.events if event.kind == "collision")


@pytest.mark.parametrize(
    ("pose", "message"),
    [((5.95, 2.0, 0.0), "wall"), ((9.0, 2.0, 0.0), "is outside the map"), ((2.1, 2.1, 0.0), "overlaps 'rover'")],
)
def test_a_start_that_is_not_free_is_refused(pose: tuple[float, float, float], message: str) -> None:
    x, y, heading = pose
    other = building.robot(name="second", pose=am.Pose(x=x, y=y, heading=heading))
    with pytest.raises(am.ScenarioError, match=message) as caught:
        am.Simulation(building.scenario(building.robot(), other))
    assert caught.value.faults[0].path == "robots.second.pose"


def test_set_pose_refuses_walls_and_others_and_does_not_tell_the_robot() -> None:
    fleet = [building.robot(), building.robot(name="second", pose=am.Pose(x=4.0, y=4.0))]
    sim = am.Simulation(building.scenario(*fleet))
    with pytest.raises(am.AmorsimError, match="wall"):
        sim.set_pose("rover", (0.0, 0.0, 0.0))
    with pytest.raises(am.AmorsimError, match="'second'"):
        sim.set_pose("rover", (4.1, 4.1, 0.0))
    before = sim.robot("rover").estimated_pose.copy()
    sim.set_pose("rover", (1.0, 4.0, 1.0))
    assert sim.robot("rover").true_pose.tolist() == [1.0, 4.0, 1.0]
    sim.step()
    assert sim.robot("rover").estimated_pose.tolist() == before.tolist()
    assert sim.events[-1].kind == "pose_set"


# Poses on arcs and lines are worked out by the kernel that finds contacts; others are asked of their drives.


@attrs.frozen(kw_only=True)
class Other(Differential):
    """The same drive, but one whose paths nobody can know to be arcs."""

    def displacement(self, before: Any, after: Any, fraction: Any) -> Any:
        return Drive.displacement(self, before, after, fraction)


@attrs.frozen(kw_only=True)
class Shove(Motion):
    """Wants to go on to the left, turning; into any body that is there."""

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Any:
        return np.tile([0.3 * dt, 0.2 * dt, 2.0 * dt], (view.rows, 1))


SHAPES = [
    Shape.polygon([(-0.3, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.3, 0.2)]),
    Shape.circle(0.2, x=0.1),
    Shape.polygon([(0, 0), (0.25, 0.2), (-0.2, 0), (0.25, -0.2)], rounding=0.02),
]


def crowd(seed: int, others: frozenset[int], *, resolution: float = 0.001, replicas: int = 1) -> am.Simulation:
    """Sixteen robots in a small room, driving anywhere, two obstacles that move and one that stands."""
    rng = np.random.default_rng(seed)
    drive = {
        "wheel_radius_left": building.RADIUS,
        "wheel_radius_right": building.RADIUS,
        "track": building.TRACK,
        "rate_max": 1e6,
    }
    robots = [
        building.robot(
            name=f"r{i:02}",
            shape=SHAPES[i % 3],
            drive=(Other if i in others else Differential)(**drive),
            pose=am.Pose(x=0.5 + i % 4, y=0.5 + i // 4, heading=float(rng.uniform(-3, 3))),
            controller=building.Roam(rate=float(rng.uniform(2.0, 20.0))),
            on_collision="end" if i == 7 else "continue",
        )
        for i in range(16)
    ]
    obstacles = [
        am.Obstacle(
            name=f"o{i}",
            shape=Shape.circle(0.15),
            pose=am.Pose(x=1.0 + i, y=3.0),
            motion=Shove() if i < 2 else None,
        )
        for i in range(3)
    ]
    room = building.room(4.2, 4.2, resolution)
    return am.Simulation(building.scenario(*robots, obstacles=tuple(obstacles), map=room, seed=seed), replicas=replicas)


@pytest.mark.parametrize("resolution", [0.001, 0.05])
@pytest.mark.parametrize("seed", one_in(2, [1, 2]))
@pytest.mark.parametrize("others", [frozenset(range(16)), frozenset({0, 5})], ids=["all", "some"])
def test_poses_asked_of_drives_give_the_bits_of_those_worked_out_by_the_kernel(
    seed: int, resolution: float, others: frozenset[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    slow = crowd(seed, others, resolution=resolution, replicas=2)
    fast = crowd(seed, frozenset(), resolution=resolution, replicas=2)
    asked = []
    poses_at = Locomotion.poses_at
    monkeypatch.setattr(Locomotion, "poses_at", lambda self, *given: asked.append(self) or poses_at(self, *given))
    for _ in range(40):
        slow.step()
        fast.step()
        assert np.array_equal(fast._fleet.world.poses, slow._fleet.world.poses)
        assert fast._fleet.touching == slow._fleet.touching
    assert fast.events == slow.events
    assert asked
    assert set(asked) <= {group.locomotion for group in slow._fleet.groups}
    met = {event.other for event in fast.events if event.kind == "collision"}
    assert "wall" in met
    assert met & {"o0", "o1", "o2"}
    assert len(met) > 5
    for name in fast.names:
        assert fast.robot(name, replica=0).joints.tolist() == slow.robot(name, replica=0).joints.tolist()


def test_a_crowd_in_one_replica_is_a_crowd_alone() -> None:
    """Contacts of the one never touch the other's, bit for bit."""
    together, alone = crowd(4, frozenset(), replicas=3), crowd(4, frozenset())
    for _ in range(20):
        together.step()
        alone.step()
    count = alone._fleet.world.count
    assert np.array_equal(together._fleet.world.poses[:count], alone._fleet.world.poses)
    assert [event for event in together.events if event.replica == 0] == list(alone.events)
    times = [event.time for event in together.events if event.kind == "collision"]
    assert times == sorted(times)


def test_a_robot_in_the_open_that_looks_at_no_wall_still_meets_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    """Walls are looked at again before the clearance has been used up, and after a jump."""
    looks = []
    look_around = contact.look_around
    monkeypatch.setattr(contact, "look_around", lambda *given: looks.append(1) or look_around(*given))
    sim = am.Simulation(building.scenario(building.robot(pose=am.Pose(x=1.0, y=2.5), on_collision="continue"), dt=0.02))
    sim.robot("rover").drive(forward=0.5)
    sim.run(8.0)
    assert 5 <= len(looks) < 100  # of 400 steps, and some of them against the wall
    sim.robot("rover").drive(forward=20.0)
    sim.run(1.0)
    assert sim.true_pose[0, 0] == pytest.approx(5.799, abs=1e-9)
    sim.set_pose("rover", (2.0, 1.0, -math.pi / 2))
    sim.run(1.0)
    assert sim.true_pose[0, 1] == pytest.approx(0.201, abs=1e-9)
