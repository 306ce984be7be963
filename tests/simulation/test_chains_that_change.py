"""Elements of noise that come and go while a simulation runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.controllers.wander import Wander
from amorsim.noise.bias import Bias
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.latency_jitter import LatencyJitter
from tests import building

LASER = "sensors.laser.noise"


def simulation(names: tuple[str, ...] = ("rover",), **options: Any) -> am.Simulation:
    robots = [
        building.robot(
            name=name,
            sensors=building.all_sensors(),
            controller=Wander(sensor="sonar"),
            pose=am.Pose(x=1.5 + 1.2 * i, y=2.5),
        )
        for i, name in enumerate(names)
    ]
    return am.Simulation(building.scenario(*robots), **options)


def bias(value: float) -> list[dict[str, Any]]:
    return [{"use": "bias", "value": value}]


def readings(made: am.Simulation, sensor: str, robot: str = "rover") -> tuple[Any, Any]:
    reading = made.robot(robot).readings[sensor]
    return np.array(reading.true), np.array(reading.measured)


def test_an_element_acts_from_the_next_step_on_and_no_more_when_it_is_gone() -> None:
    made, same = simulation(), simulation()
    made.set("rover", LASER, [])
    for one in (made, same):
        one.run(1.0)
    true, measured = readings(made, "laser")
    assert np.array_equal(true, measured)
    made.set("rover", LASER, bias(0.25))
    made.step()
    true, measured = readings(made, "laser")
    assert measured == pytest.approx(true + 0.25)
    made.set("rover", LASER, [])
    made.step()
    assert np.array_equal(*readings(made, "laser"))
    # Nothing else of the robot changed, to the bit: what it drives does not depend on the laser.
    same.step()
    same.step()
    assert np.array_equal(made.true_pose, same.true_pose)
    assert np.array_equal(made.estimated_pose, same.estimated_pose)
    for sensor in ("sonar", "compass", "gyro", "encoder"):
        assert np.array_equal(readings(made, sensor)[1], readings(same, sensor)[1]), sensor


def test_an_element_that_is_taken_away_and_put_back_draws_what_it_would_have_drawn() -> None:
    made, same = simulation(), simulation()
    chain = made.robot("rover").nominal.sensors["laser"].noise
    for one in (made, same):
        one.run(1.0)
    made.set("rover", LASER, [])
    made.set("rover", LASER, chain)
    for one in (made, same):
        one.run(1.0)
    assert made.digest() == same.digest()


def test_elements_that_stay_keep_their_states() -> None:
    walk = am.NoiseElement(name="walk", noise=am.noise.BiasRandomWalk(std=0.1))
    gyro = am.MountedSensor(sensor=building.all_sensors()["gyro"].sensor, noise=(walk,))
    robot = building.robot(sensors={**building.all_sensors(), "gyro": gyro})
    made, same = (am.Simulation(building.scenario(robot)) for _ in range(2))
    for one in (made, same):
        one.run(2.0)
    made.set("rover", "sensors.gyro.noise", [walk, am.NoiseElement(name="more", noise=Bias(value=0.5))])
    for one in (made, same):
        one.run(1.0)
    assert readings(made, "gyro")[1] == pytest.approx(readings(same, "gyro")[1] + 0.5)


def test_one_robot_of_many_changes_and_recorders_see_the_groups_of_the_beginning(tmp_path: Path) -> None:
    names = ("a", "b", "c")
    alone = simulation(names)
    alone.run(1.0)
    made = simulation(names, replicas=2)
    with am.record(made, tmp_path / "run") as session:
        for tick in range(20):
            if tick == 10:
                made.set("b", LASER, bias(0.1))
                assert len(made._fleet.groups) == 2
            made.step()
            session.keep()
    (frame,) = made.frames()
    assert list(frame.names) == [*names, *names]
    assert np.array_equal(frame.true_pose, made.true_pose)
    measured = frame.readings["laser"][1].measured
    assert np.array_equal(measured[1], made.robot("b", 0).readings["laser"].measured)
    assert np.array_equal(frame.robot.drive.track, np.full((6, 1), building.TRACK))
    # What the others did is what they do without it.
    alone.run(1.0)
    assert np.array_equal(made.robot("a", 0).true_pose, alone.robot("a").true_pose)


def test_a_run_in_which_chains_changed_is_reproduced(tmp_path: Path) -> None:
    made = am.Simulation(am.load("demo"), replicas=2)
    with am.record(made, tmp_path / "run", duration=2.0) as session:
        for tick in range(20):
            if tick == 5:
                made.set("rover", LASER, [{"use": "gaussian", "std": 0.1}, {"use": "dropout", "probability": 0.2}])
                made.set("rover", "ground", [{"use": "slip", "name": "oil", "at": 0.0, "duration": 9.0, "factor": 0.5}])
            if tick == 12:
                made.set("rover", f"{LASER}.gaussian.std", 0.2)
                made.set("rover", "ground", [])
            made.step()
            session.keep()
    assert am.reproduce(tmp_path / "run").is_same
    assert "sensors.laser.noise = gaussian, dropout" in "\n".join(map(str, made.events))


def test_a_snapshot_leads_back_over_a_change_and_forward_again() -> None:
    made = simulation()
    made.run(0.5)
    before = made.snapshot()
    made.set("rover", LASER, bias(0.1))
    made.run(0.5)
    after, end = made.snapshot(), made.digest()
    made.restore(before)
    assert [element.name for element in made.robot("rover").nominal.sensors["laser"].noise] == ["gaussian", "quantize"]
    same = simulation()
    same.run(1.0)
    made.run(0.5)
    assert made.digest() == same.digest()
    made.restore(after)
    assert made.digest() == end
    # Another class under the same name is another chain, though neither has a state.
    made.set("rover", LASER, [am.NoiseElement(name="bias", noise=Gaussian(std=0.1))])
    made.restore(after)
    made.step()
    assert readings(made, "laser")[1] == pytest.approx(readings(made, "laser")[0] + 0.1)
    # In another process, after the same changes.
    other = simulation()
    other.set("rover", LASER, bias(0.1))
    other.restore(after.to_bytes())
    assert other.digest() == end


def test_numbers_that_were_set_stay_set_and_so_does_a_chain_at_a_reset() -> None:
    made = simulation()
    made.set("rover", "drive.track", 0.4)
    made.set("rover", "errors.drive.track", am.Deviation(scale=1.1))
    made.set("rover", LASER, bias(0.1))
    assert made.robot("rover").true.drive.track == pytest.approx(0.44)  # type: ignore[attr-defined]
    made.reset()
    assert [element.name for element in made.robot("rover").nominal.sensors["laser"].noise] == ["bias"]
    made.reset(seed=3)
    assert made.robot("rover").nominal.drive.track == building.TRACK  # type: ignore[attr-defined]
    made.set("rover", "errors.drive.track", am.Deviation(scale=1.1))
    made.set("rover", "errors.drive.track", None)
    assert made.robot("rover").nominal.errors == {}


def test_a_longer_delay_is_made_room_for() -> None:
    made = simulation()
    made.run(0.5)
    made.set("rover", "sensors.compass.noise", [LatencyJitter(spread=0.5)])
    held = readings(made, "compass")[1]
    made.run(1.0)
    assert not np.array_equal(readings(made, "compass")[1], held)


def test_what_is_wrong_is_said_and_changes_nothing() -> None:
    made = simulation()
    made.run(0.2)
    for given, words in (
        ("gaussian", "expected a list of noises"),
        ([{"use": "gausian"}], "Did you mean 'gaussian'"),
        ([{"use": "gaussian", "std": -1.0}], "std"),
        ([{"use": "slip", "at": 0.0, "duration": 1.0, "factor": 0.5}], "ground"),
        ([3], "expected a table"),
    ):
        with pytest.raises(am.AmorsimError, match=words) as caught:
            made.set("rover", LASER, given)
        assert "rover" in str(caught.value)
        assert LASER in str(caught.value)
    with pytest.raises(am.AmorsimError, match="has no sensor 'lasr'"):
        made.set("rover", "sensors.lasr.noise", [])
    same = simulation()
    same.run(0.2)
    assert made.digest() == same.digest()
    assert not made.events
    with pytest.raises(am.AmorsimError, match="all replicas at once"):
        simulation(replicas=2).set("rover", LASER, [], replica=1)


def test_a_chain_of_a_class_that_no_file_can_name_is_refused() -> None:
    @attrs.frozen(kw_only=True)
    class Mine(am.Noise):
        def corrupt(self, values: Any, side: Any, elapsed: Any, state: Any, draws: Any) -> Any:
            return np.asarray(values)

    made = simulation()
    with pytest.raises(am.AmorsimError, match="Mine"):
        made.set("rover", LASER, [Mine()])
