"""Doors: on time, at their rate, stopped by a body that stands in them."""

from __future__ import annotations

import numpy as np
import pytest

import amorsim as am
from amorsim.motions import SlidingDoor, SwingDoor
from tests import building
from tests.motions.worlds import DT, obstacle, track, world

LEAF = am.Shape.rectangle(0.9, 0.04, x=0.46)
DAY = {"timetable": ((1.0, 3.0), (5.0, 5.5)), "period": 10.0}


def hinged(**changes: object) -> am.Obstacle:
    return obstacle(SwingDoor(**(DAY | changes)), name="door", shape=LEAF, pose=am.Pose(x=3.0, y=3.0, heading=0.5))


def test_a_hinged_door_keeps_its_timetable_and_its_rate() -> None:
    opening = track(world(hinged(rate=2.0, angle=1.2)), 250, "door")[:, 2] - 0.5
    for tick, angle in enumerate(opening):
        time = (DT * tick - 1.0) % 10.0 + 1.0 if tick > 10 else DT * tick  # s, of the timetable's round
        wanted = 0.0
        for opens, closes in ((1.0, 3.0), (5.0, 5.5), (11.0, 11.0)):
            wanted = max(wanted, np.clip(2.0 * (time - opens), 0, 1.2) - np.clip(2.0 * (time - closes), 0, 1.2))
        peak = 1.2 if time < 5.0 else 1.0  # the second time there is half a second only
        if time > 5.5:
            wanted = max(1.0 - 2.0 * (time - 5.5), 0.0)
        assert angle == pytest.approx(min(wanted, peak), abs=1e-9), tick


def test_it_opens_clockwise_too_and_only_once_without_a_period() -> None:
    angles = track(world(hinged(timetable=((0.0, 1.0),), period=None, angle=-1.0)), 300, "door")[:, 2] - 0.5
    assert angles[10] == pytest.approx(-1.0, abs=1e-9)
    assert np.abs(angles[20:]).max() < 1e-9


def test_a_sliding_door_slides_along_its_way() -> None:
    motion = SlidingDoor(timetable=((1.0, 4.0),), way=(0.0, 0.8), speed=0.5)
    poses = track(
        world(obstacle(motion, name="door", shape=LEAF, pose=am.Pose(x=3.0, y=3.0, heading=np.pi / 2))), 80, "door"
    )
    time = DT * np.arange(81)
    gone = np.clip(0.5 * (time - 1.0), 0.0, 0.8) - np.clip(0.5 * (time - 4.0), 0.0, 0.8)
    assert poses[:, 0] == pytest.approx(3.0 - gone, abs=1e-9)
    assert poses[:, 1] == pytest.approx(3.0, abs=1e-9)
    assert (poses[:, 2] == poses[0, 2]).all()


def standing_in_it(**changes: object) -> am.Simulation:
    """A door that is open from 0 to 2 s and then closes on a robot."""
    motion = SwingDoor(timetable=((0.0, 2.0), (6.0, 8.0)), angle=1.2, rate=2.0, **changes)
    door = obstacle(motion, name="door", shape=LEAF, pose=am.Pose(x=3.0, y=3.0))
    robot = building.robot(shape=am.Shape.circle(0.15), pose=am.Pose(x=3.6, y=3.2), on_collision="continue")
    return world(door, robot=robot)


def test_a_door_waits_for_who_stands_in_it() -> None:
    # It comes by the robot on its way up too, so let it start open.
    sim = standing_in_it()
    sim.set_pose("rover", (1.0, 1.0, 0.0))
    sim.run(1.5)
    sim.set_pose("rover", (3.6, 3.2, 0.0))
    sim.run(3.0)
    held = float(sim.obstacle("door").true_pose[2])
    assert 0.1 < held < 1.0
    assert [(event.name, event.other) for event in sim.events if event.kind == "collision"] == [
        ("rover", "door"), ("door", "rover")]  # fmt: skip
    sim.set_pose("rover", (1.0, 1.0, 0.0))
    sim.run(1.0)
    assert sim.obstacle("door").true_pose[2] == pytest.approx(0.0, abs=1e-9)


def test_a_door_that_skips_goes_back_until_the_next_time() -> None:
    sim = standing_in_it(blocked="skip", patience=0.4)
    sim.set_pose("rover", (1.0, 1.0, 0.0))
    sim.run(1.5)
    sim.set_pose("rover", (3.6, 3.2, 0.0))
    sim.run(2.5)
    assert sim.obstacle("door").true_pose[2] == pytest.approx(1.2, abs=1e-9)
    sim.set_pose("rover", (1.0, 1.0, 0.0))
    sim.run(3.5)
    assert sim.obstacle("door").true_pose[2] == pytest.approx(1.2, abs=1e-9)  # 7.5 s: open again, or still
    sim.run(1.5)
    assert sim.obstacle("door").true_pose[2] == pytest.approx(0.0, abs=1e-9)


def test_who_leans_on_a_standing_door_does_not_open_it() -> None:
    motion = SwingDoor(timetable=((0.0, 0.5),), angle=0.5, blocked="skip", patience=0.2)
    door = obstacle(motion, name="door", shape=LEAF, pose=am.Pose(x=3.0, y=3.0))
    pusher = building.robot(shape=am.Shape.circle(0.2), pose=am.Pose(x=3.5, y=2.2, heading=np.pi / 2),
                            on_collision="continue")  # fmt: skip
    sim = world(door, robot=pusher)
    sim.run(2.0)
    sim.robot("rover").drive(forward=0.5)
    sim.run(4.0)
    assert sim.robot("rover").true_pose[1] == pytest.approx(3.0 - 0.02 - 0.2, abs=1e-6)
    assert sim.obstacle("door").true_pose[2] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"timetable": ()}, "timetable: expected"),
        ({"timetable": ((2.0, 1.0),)}, "times that increase"),
        ({"timetable": ((-1.0, 1.0),)}, "times that increase"),
        ({"timetable": ((1.0, 5.0),), "period": 4.0}, "period: expected more than the 4 s"),
    ],
)
def test_timetables_that_make_no_sense(given: dict[str, object], message: str) -> None:
    with pytest.raises(am.ParameterError, match=message):
        SwingDoor(**given)
