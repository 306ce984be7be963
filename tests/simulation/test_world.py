"""What sensors see of the world, and the world as a matrix."""

from __future__ import annotations

import math
import threading
import time

import numpy as np
import pytest

import amorsim as am
from amorsim.core.execution import workers
from amorsim.core.shapes import Shape
from amorsim.kernels.collision import body_hash
from tests import building


def looking(**changes: object) -> am.Robot:
    laser = am.sensors.Laser(beams=1, fov=0.1, range_max=20.0)
    return building.robot(sensors={"laser": laser}, estimators={}, **changes)


def test_robots_see_one_another_and_not_themselves() -> None:
    fleet = [
        looking(name="a", pose=am.Pose(x=1.0, y=2.0)),
        looking(name="b", pose=am.Pose(x=4.0, y=2.0), shape=Shape.circle(0.25)),
    ]
    sim = am.Simulation(building.scenario(*fleet), replicas=2)
    assert sim.robot("a", 1).readings["laser"].true[0] == pytest.approx(4.0 - 0.25 - 1.0)
    assert sim.robot("b", 1).readings["laser"].true[0] == pytest.approx(5.999 - 4.0)


def test_an_obstacle_is_seen_and_met() -> None:
    pillar = am.Obstacle(name="pillar", shape=Shape.circle(0.5), pose=am.Pose(x=4.0, y=2.0))
    sim = am.Simulation(building.scenario(looking(pose=am.Pose(x=2.0, y=2.0)), obstacles=[pillar]))
    assert sim.robot("rover").readings["laser"].true[0] == pytest.approx(1.5)
    sim.robot("rover").drive(forward=1.0)
    sim.run(3.0)
    assert sim.robot("rover").true_pose[0] == pytest.approx(3.3, abs=1e-9)
    assert [e.other for e in sim.events if e.kind == "collision" and e.name == "rover"] == ["pillar"]


@pytest.mark.parametrize("offset_deg", [-6.9, -3.33, 0.0, 5.05, 6.9])
def test_a_thin_post_in_a_sonars_cone_is_always_seen(offset_deg: float) -> None:
    sonar = am.sensors.Sonar(elements=(am.Mount(),), half_angle=math.radians(7.5), range_min=0.1, range_max=5.0)
    offset = math.radians(offset_deg)
    post = am.Obstacle(
        name="post",
        shape=Shape.circle(0.01),
        pose=am.Pose(x=1.0 + 3.0 * math.cos(offset), y=2.5 + 3.0 * math.sin(offset)),
    )
    robot = building.robot(sensors={"sonar": sonar}, estimators={}, pose=am.Pose(x=1.0, y=2.5))
    sim = am.Simulation(building.scenario(robot, obstacles=[post]))
    # Rays are 0.05 degrees apart, 2.6 mm at the post, so one of them meets it no farther than that from its nearest.
    assert sim.robot("rover").readings["sonar"].true[0] == pytest.approx(2.99, abs=2e-4)


def test_the_world_as_a_matrix() -> None:
    sim = am.Simulation(building.scenario(building.robot(pose=am.Pose(x=2.0, y=2.0))))
    cells = sim.occupancy(0.1)
    assert cells.dtype == np.uint8
    assert set(np.unique(cells)) == {0, 1, 2}
    assert cells[25, 40] == 0
    assert cells[0, 30] == 1
    assert cells[20, 20] == 2
    # The footprint is 0.5 m by 0.4 m: 20 cells where it lies on their borders, and this one does.
    assert (cells == 2).sum() == 20
    sim.set_pose("rover", (4.0, 2.0, 0.0))
    assert sim.occupancy(0.1)[20, 20] == 0
    with pytest.raises(am.MapError, match="resolution"):
        sim.occupancy(0.0)


def test_the_compass_and_the_gyro_tell_the_truth_without_noise() -> None:
    sensors = {
        "compass": am.MountedSensor(sensor=am.sensors.Compass(), mount=am.Mount(heading=0.2)),
        "gyro": am.sensors.Gyro(),
    }
    robot = building.robot(sensors=sensors, estimators={}, pose=am.Pose(heading=3.0))
    sim = am.Simulation(building.scenario(robot, map=building.empty()))
    sim.robot("rover").drive(turn=0.5)
    sim.step()
    expected = 3.0 + 0.05 + 0.2 - 2 * math.pi
    assert sim.robot("rover").readings["compass"].true[0] == pytest.approx(expected)
    assert sim.robot("rover").readings["gyro"].true[0] == pytest.approx(0.5)


def test_a_robot_is_not_put_outside_the_map_or_into_a_wall() -> None:
    sim = am.Simulation(building.scenario())
    before = sim.digest()
    with pytest.raises(
        am.AmorsimError, match=r"cannot stand at \(9.0, 2.0, 0.0\): that is outside the map, which is 6 m x"
    ):
        sim.set_pose("rover", (9.0, 2.0, 0.0))
    with pytest.raises(am.AmorsimError, match=r"cannot stand at \(6.0, 2.0, 0.0\): it would overlap a wall"):
        sim.set_pose("rover", (6.0, 2.0, 0.0))
    assert sim.digest() == before


@pytest.mark.parametrize("sensor", [am.sensors.Laser(beams=8), am.sensors.Sonar()])
def test_the_bodies_are_hashed_before_threads_look_for_them(sensor: am.Sensor, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two threads that found the hash stale once made it at the same time, which ended Python."""
    monkeypatch.setattr(workers, "LEAST_WORK", 0)
    monkeypatch.setattr(workers, "cores", lambda: 2)
    hashed: list[threading.Thread] = []
    hash_bodies = body_hash.hash_bodies

    def watched(*given: object) -> None:
        hashed.append(threading.current_thread())
        time.sleep(0.02)  # so that the other thread comes to it meanwhile, where it may
        hash_bodies(*given)

    monkeypatch.setattr(body_hash, "hash_bodies", watched)
    fleet = [
        building.robot(name=f"r{i}", sensors={"eye": sensor}, estimators={}, pose=am.Pose(x=1.0 + 0.8 * i, y=2.0))
        for i in range(4)
    ]
    sim = am.Simulation(building.scenario(*fleet), threads=2)
    for name in sim.names:
        sim.robot(name).drive(forward=0.05)
    sim.run(0.5)
    assert set(hashed) == {threading.main_thread()}
