"""The schedule of a step: its order, its labels, and that bound components are called by the form that is theirs."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts.binding import SensorBinding
from amorsim.scenario.spec import MountedSensor
from amorsim.testing.failure import CheckError
from tests import building


def demo(**changes: Any) -> am.Simulation:
    return am.Simulation(building.scenario(building.robot(sensors=building.all_sensors(), **changes)))


def test_it_names_every_component_in_the_order_of_the_phases() -> None:
    sim = am.Simulation(am.load("demo"))
    assert str(sim.schedule).splitlines() == [
        "control   rover / controller: Wander",
        "actuate   rover / drive: Differential",
        "move      rover / path",
        "move      contact",
        "move      rover / arrival",
        "move      clocks",
        "sense     rover / mounts",
        "sense     rover / encoder: Encoder",
        "sense     rover / laser: Laser",
        "sense     rover / sonar: Sonar",
        "sense     rover / compass: Compass",
        "sense     rover / gyro: Gyro",
        "sense     rover / noise of encoder, laser, sonar, compass, gyro",
        "estimate  rover / dead_reckoning",
        "estimate  rover / check of numbers",
        "record    rover / fingerprint",
    ]


def test_a_profile_times_each_call_and_leaves_the_simulation_where_it_was() -> None:
    sim, alone = demo(), demo()
    sim.run(0.5)
    before = sim.digest()
    lines = sim.schedule.profile(3).splitlines()
    assert len(lines) == len(sim.schedule) + 1
    assert all(float(line.split()[0]) > 0.0 for line in lines)
    assert (sim.digest(), sim.time) == (before, 0.5)
    sim.schedule.profile(2)
    sim.run(0.5)
    alone.run(1.0)
    assert sim.digest() == alone.digest()


def test_a_simulation_that_nobody_holds_is_freed_at_once() -> None:
    sim = demo(controller=am.controllers.Wander())
    sim.step()
    seen = [weakref.ref(sim._fleet.world), weakref.ref(sim._fleet.groups[0])]
    gc.disable()
    try:
        sim.reset(seed=2)
        sim.step()
        assert seen[0]() is None
        seen = [weakref.ref(sim._fleet.world), weakref.ref(sim._fleet.groups[0])]
        del sim
        assert [one() for one in seen] == [None, None]
    finally:
        gc.enable()


def test_a_profile_of_no_steps_is_refused() -> None:
    with pytest.raises(am.ParameterError, match="steps"):
        demo().schedule.profile(0)


def test_a_schedule_follows_a_change_of_the_chain() -> None:
    sim = demo()
    schedule = sim.schedule
    plain = str(schedule)
    sim.set("rover", "sensors.laser.noise", [{"use": "latency_jitter", "spread": 0.05}])
    assert str(schedule) != plain


def test_readings_stay_as_they_are_when_a_chain_changes() -> None:
    sim = demo()
    sim.run(0.5)
    before = sim.robot("rover").readings["laser"]
    sim.set("rover", "sensors.laser.noise", [{"use": "gaussian", "std": 0.5}])
    for array, now in zip(before, sim.robot("rover").readings["laser"], strict=True):
        np.testing.assert_array_equal(array, now)


@attrs.frozen(kw_only=True)
class Shifted(am.sensors.Compass):
    """Overrides the simple form of a sensor that is bound."""

    def sense(self, view: Any, aim: Any, state: Any, draws: Any) -> Any:
        """The heading, and one radian more."""
        values, side = super().sense(view, aim, state, draws)
        return values + 1.0, side


@attrs.frozen(kw_only=True)
class Backwards(am.drives.Differential):
    """Overrides the simple form of a drive that is bound."""

    def advance(self, joints: Any, rates: Any, command: Any, dt: float, state: Any, draws: Any) -> Any:
        """As if the motors were connected the wrong way round."""
        return super().advance(joints, rates, -command, dt, state, draws)


def test_a_subclass_that_overrides_the_simple_form_is_called_by_it() -> None:
    fields = attrs.asdict(building.drive(), recurse=False)
    sim = am.Simulation(
        building.scenario(
            building.robot(
                drive=Backwards(**fields),
                controller=am.controllers.Manual(),
                sensors={"compass": MountedSensor(sensor=Shifted()), "encoder": building.encoder()},
            )
        )
    )
    rover = sim.robot("rover")
    rover.drive(forward=0.3)
    x = float(rover.true_pose[0])
    sim.run(1.0)
    assert rover.true_pose[0] < x
    assert rover.readings["compass"].true[0] == rover.true_pose[2] + 1.0


@attrs.frozen(kw_only=True)
class Silent(am.sensors.Sonar):
    """Overrides the simple form of an emission that is bound."""

    def emit(self, view: Any, state: Any) -> Any:
        """What a sonar emits, without the sound."""
        emission = super().emit(view, state)
        return emission._replace(fired=np.zeros_like(emission.fired))


def test_a_subclass_that_overrides_what_is_emitted_is_asked_for_it() -> None:
    heard = []
    for kind in (am.sensors.Sonar, Silent):
        elements = (am.Mount(heading=0.0), am.Mount(heading=0.1))
        sonar = kind(elements=elements, medium="ultrasound", firing=(0, 1), interval=0.001, range_min=0.0)
        noise = building.chain(am.noise.CrossTalk())
        sensors = {"sonar": MountedSensor(sensor=sonar, noise=noise), "encoder": building.encoder()}
        robot = building.robot(sensors=sensors)
        sim = am.Simulation(building.scenario(robot))
        sim.step()
        reading = sim.robot("rover").readings["sonar"]
        heard.append(bool((reading.measured < reading.true).any()))
    assert heard == [True, False]


class Reversed:
    """A mixin, which is not a sensor, that overrides a simple form."""

    def sense(self, view: Any, aim: Any, state: Any, draws: Any) -> Any:
        """The opposite."""
        values, side = super().sense(view, aim, state, draws)  # type: ignore[misc]
        return -values, side


@attrs.frozen(kw_only=True)
class ReversedGyro(Reversed, am.sensors.Gyro):
    """A gyro mounted upside down."""


def test_a_mixin_that_overrides_the_simple_form_is_called() -> None:
    sensors = {"gyro": MountedSensor(sensor=ReversedGyro())}
    robot = building.robot(controller=am.controllers.Manual(), sensors=sensors, estimators={})
    sim = am.Simulation(building.scenario(robot))
    sim.robot("rover").drive(turn=0.4)
    sim.run(1.0)
    assert sim.robot("rover").readings["gyro"].true[0] == -sim.robot("rover").true_twist[2] < 0.0


@attrs.frozen(kw_only=True)
class Clock(am.Sensor):
    """A bound sensor: the time since the start, kept in its state."""

    unit = "s"

    def size(self, drive: Any) -> int:
        """One value."""
        return 1

    def start(self, context: Any) -> Any:
        """Nothing passed."""
        return {"steps": np.full((context.rows, 1), -1.0)}

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Count, in place."""
        steps = at.state["steps"]

        def sense() -> None:
            steps[:] += 1.0
            np.multiply(steps, at.dt, out=at.out)

        return sense

    def sense(self, view: Any, aim: Any, state: Any, draws: Any) -> Any:
        """The same."""
        state["steps"] = state["steps"] + 1.0
        return state["steps"] * view.dt, {}


def test_a_bound_component_keeps_its_state_through_resets_snapshots_and_changes() -> None:
    sim = am.Simulation(
        building.scenario(building.robot(sensors={"clock": MountedSensor(sensor=Clock())}, estimators={})), replicas=2
    )

    def shown() -> list[float]:
        return [float(sim.robot("rover", one).readings["clock"].measured[0]) for one in range(2)]

    sim.run(0.5)
    assert shown() == [0.5, 0.5]
    kept = sim.snapshot()
    sim.reset(replicas=[1])
    sim.run(0.3)
    assert shown() == pytest.approx([0.8, 0.3])
    sim.set("rover", "drive.track", 0.4)
    sim.run(0.2)
    assert shown() == pytest.approx([1.0, 0.5])
    sim.restore(kept)
    sim.run(0.1)
    assert shown() == pytest.approx([0.6, 0.6])


def test_a_bound_sensor_counts_in_the_rows_that_are_due() -> None:
    clock = {"clock": MountedSensor(sensor=Clock(), rate=2.5)}
    sim = am.Simulation(building.scenario(building.robot(sensors=clock, estimators={})), replicas=2)
    sim.run(0.2)
    sim.reset(replicas=[1])
    sim.run(0.8)  # read at 0, 0.4 and 0.8 s of each; of the first at 0 to 1 s
    shown = [float(sim.robot("rover", one).readings["clock"].true[0]) for one in range(2)]
    assert shown == pytest.approx([0.2, 0.2])
    sim.run(0.3)
    shown = [float(sim.robot("rover", one).readings["clock"].true[0]) for one in range(2)]
    assert shown == pytest.approx([0.3, 0.2])


def test_readings_that_were_handed_out_stay_as_they_are() -> None:
    sim = demo(controller=am.controllers.Manual())
    sim.robot("rover").drive(forward=0.3, turn=0.2)
    sim.step()
    reading, pose = sim.robot("rover").readings["laser"], sim.true_pose
    kept = [array.copy() for array in (*reading, pose)]
    sim.run(1.0)
    for array, before in zip((*reading, pose), kept, strict=True):
        np.testing.assert_array_equal(array, before)


@attrs.frozen(kw_only=True)
class Meddling(am.sensors.Gyro):
    """A bound sensor that writes into an array of the engine."""

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Stop the robot."""
        sense = super().bind(at)

        def meddle() -> None:
            sense()
            at.twist[:] = 0.0

        return meddle


@attrs.frozen(kw_only=True)
class Different(am.sensors.Gyro):
    """A bound sensor whose two forms differ."""

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Twice the rate."""
        return lambda: np.multiply(at.twist[:, 2:], 2.0, out=at.out)


def test_check_component_compares_the_two_forms_of_a_component() -> None:
    with pytest.raises(CheckError, match=r"bind.*twist: expected an array of the engine to be left alone"):
        am.testing.check_component(Meddling())
    with pytest.raises(CheckError, match=r"bind.*what bind\(\) wrote in step 1: expected the bits of the simple form"):
        am.testing.check_component(Different())
