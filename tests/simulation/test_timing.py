"""When readings are taken, when they arrive, and what order a step has."""

from __future__ import annotations

import numpy as np
import pytest

import amorsim as am
from tests import building


def with_gyro(dt: float = 0.1, **changes: object) -> am.Simulation:
    sensors = {"gyro": am.MountedSensor(sensor=am.sensors.Gyro(), **changes)}
    robot = building.robot(sensors=sensors, estimators={}, pose=am.Pose())
    return am.Simulation(building.scenario(robot, map=building.empty(), dt=dt))


def test_the_phases_are_in_the_papers_order() -> None:
    assert am.PHASES == ("control", "actuate", "move", "sense", "estimate", "record")
    sim = am.Simulation(building.scenario())
    assert tuple(dict.fromkeys(call.phase for call in sim.schedule)) == am.PHASES
    assert sim.robot("rover").readings["encoder"].stamp == 0  # sensed once: no controller sees an empty reading


def test_a_reading_is_of_the_step_that_was_just_made() -> None:
    sim = with_gyro()
    sim.robot("rover").drive(turn=0.7)
    sim.step()
    reading = sim.robot("rover").readings["gyro"]
    assert reading.true[0] == pytest.approx(0.7)
    assert reading.stamp[0] == 1
    assert reading.age[0] == 0.0
    assert reading.fresh[0]


@pytest.mark.parametrize(
    ("rate", "dt", "due"),
    [
        (5.0, 0.1, [0, 2, 4, 6, 8, 10]),
        (4.0, 0.1, [0, 3, 5, 8, 10]),  # 0.25 s, 0.5 s, 0.75 s, 1 s: the first tick at or after each
        (10.0, 0.1, list(range(11))),
        (1000.0, 0.1, list(range(11))),
        (3.0, 0.1, [0, 4, 7, 10]),
    ],
)
def test_a_rate_is_met_at_the_first_tick_at_or_after_each_due_time(rate: float, dt: float, due: list[int]) -> None:
    sim = with_gyro(dt, rate=rate)
    seen = [0] if sim.robot("rover").readings["gyro"].fresh[0] else []
    for tick in range(1, 11):
        sim.step()
        reading = sim.robot("rover").readings["gyro"]
        if reading.fresh[0]:
            seen.append(tick)
        assert reading.stamp[0] == max(t for t in due if t <= tick)
        assert reading.age[0] == pytest.approx((tick - reading.stamp[0]) * dt)
    assert seen == due


def test_latency_delays_the_arrival_and_holds_the_first_value_until_then() -> None:
    sim = with_gyro(latency=0.25)  # three steps of 0.1 s
    robot = sim.robot("rover")
    robot.drive(turn=1.0)
    arrived = []
    for tick in range(1, 9):
        robot.drive(turn=float(tick))
        sim.step()
        reading = robot.readings["gyro"]
        assert reading.age[0] == pytest.approx(tick * 0.1 if tick < 3 else 0.3)
        if reading.fresh[0]:
            arrived.append((tick, int(reading.stamp[0])))
        expected = 0.0 if tick <= 3 else float(tick - 3)
        assert reading.true[0] == pytest.approx(expected)
        assert reading.measured[0] == reading.true[0]
    assert arrived == [(tick, tick - 3) for tick in range(3, 9)]


def test_latency_and_rate_together() -> None:
    sim = with_gyro(latency=0.3, rate=5.0)
    arrivals = []
    for tick in range(1, 11):
        sim.step()
        reading = sim.robot("rover").readings["gyro"]
        if reading.fresh[0]:
            arrivals.append((tick, int(reading.stamp[0])))
    assert arrivals == [(3, 0), (5, 2), (7, 4), (9, 6)]


def test_time_is_a_multiple_and_does_not_add_up() -> None:
    sim = am.Simulation(building.scenario(dt=0.1))
    for _ in range(1000):
        sim.step()
    assert sim.time == 1000 * 0.1
    assert sim.tick == 1000


def test_a_run_takes_the_whole_duration() -> None:
    sim = am.Simulation(building.scenario(dt=0.3, duration=1.0))
    sim.run()
    assert sim.tick == 4
    sim.run(0.3)
    assert sim.tick == 5


def test_readings_held_by_someone_do_not_change() -> None:
    sim = am.Simulation(building.scenario(building.robot(sensors=building.all_sensors(), controller=building.Roam())))
    sim.step()
    held = {name: (reading.measured, reading.measured.copy()) for name, reading in sim.readings.items()}
    pose, copy = sim.true_pose, sim.true_pose.copy()
    for _ in range(5):
        sim.step()
    assert (pose == copy).all()
    for array, before in held.values():
        np.testing.assert_array_equal(array, before)
    with pytest.raises(ValueError, match="read-only"):
        sim.true_pose[0, 0] = 1.0


def test_a_plain_function_controls_a_robot() -> None:
    seen = []

    def drive(readings, estimate, clock):  # type: ignore[no-untyped-def]
        seen.append((clock.tick, estimate.x if hasattr(estimate, "x") else estimate.pose[0]))
        return am.Twist(0.5, 0.0)

    sim = am.Simulation(building.scenario(building.robot(controller=drive, pose=am.Pose(x=2.0, y=2.0))))
    sim.run(1.0)
    assert sim.true_pose[0, 0] == pytest.approx(2.5)
    assert [tick for tick, _ in seen] == list(range(10))
