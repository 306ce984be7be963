"""What is done for all devices in one call has the bits of what every component does by itself."""

from __future__ import annotations

import copy
import functools
import pickle
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.scenario.spec import MountedSensor, NoiseElement, Robot
from amorsim.testing.failure import CheckError
from tests import building


def itself(thing: Any) -> Any:
    """The same component as one of a subclass, which may do anything, and so is asked by itself."""
    kind = type(thing)
    return own(kind)(**{field.name: getattr(thing, field.name) for field in attrs.fields(kind)})


@functools.cache
def own(kind: type) -> Any:
    body = {"steps": lambda self: (), "corrupt": IN_NUMPY[kind]} if kind in IN_NUMPY else {}
    return attrs.frozen(kw_only=True)(type(f"Own{kind.__name__}", (kind,), body))


def scattered(self: Any, values: Any, _side: Any, _elapsed: Any, _state: Any, draws: am.Draws) -> Any:
    deviation = self.std + self.proportional * np.abs(np.where(np.isfinite(values), values, 0.0))
    noise = deviation * draws.normal(values.shape[1])
    return np.where(np.isfinite(values) & (deviation > 0.0), np.where(np.isfinite(values), values, 0.0) + noise, values)


def rounded(self: Any, values: Any, *_: Any) -> Any:
    return (np.rint if self.rounding == "nearest" else np.floor)(values / self.step) * self.step


def clipped(self: Any, values: Any, *_: Any) -> Any:
    held = np.where(values < self.minimum, self.minimum, values)
    return np.where((held > self.maximum) & (held < np.inf), self.maximum, held)


def lost(self: Any, values: Any, _side: Any, _elapsed: Any, _state: Any, draws: am.Draws) -> Any:
    return np.where(draws.uniform(values.shape[1]) < self.probability, np.inf, values)


IN_NUMPY: dict[type, Callable[..., Any]] = {
    am.noise.Gaussian: scattered,
    am.noise.Bias: lambda self, values, *_: values - (0.0 - self.value),
    am.noise.Scale: lambda self, values, *_: values * self.factor,
    am.noise.Quantize: rounded,
    am.noise.Saturate: clipped,
    am.noise.Dropout: lost,
}


def own_noise(robot: Robot) -> Robot:
    def changed(unit: MountedSensor) -> MountedSensor:
        chain = tuple(attrs.evolve(element, noise=itself(element.noise)) for element in unit.noise)
        return attrs.evolve(unit, noise=chain)

    return attrs.evolve(robot, sensors={name: changed(unit) for name, unit in robot.sensors.items()})


def own_drive(robot: Robot) -> Robot:
    return attrs.evolve(robot, drive=itself(robot.drive))


def own_estimators(robot: Robot) -> Robot:
    return attrs.evolve(robot, estimators={name: itself(it) for name, it in robot.estimators.items()})


def chain(*noise: Any) -> tuple[NoiseElement, ...]:
    return tuple(
        NoiseElement(name=f"{type(element).__name__.lower()}{n}", noise=element) for n, element in enumerate(noise)
    )


def sensors() -> dict[str, MountedSensor]:
    """Several kinds, with chains of all elements that are steps, two of a kind among them, and others between them."""
    mount = am.Mount(x=0.05, y=-0.02, heading=0.4)
    white = am.noise.Gaussian(std=0.005, proportional=0.01)
    return {
        "encoder": MountedSensor(sensor=building.encoder(), noise=chain(am.noise.Quantize(step=1.0, rounding="floor"))),
        "each": MountedSensor(sensor=building.encoder(counts_per_revolution=(500.0, 3600.0))),
        "laser": MountedSensor(
            sensor=am.sensors.Laser(beams=20, range_max=3.0),
            mount=mount,
            noise=chain(white, am.noise.Quantize(step=0.01)),
        ),
        "rear": MountedSensor(
            sensor=am.sensors.Laser(beams=7, fov=6.28),
            mount=am.Mount(heading=3.0),
            noise=chain(am.noise.Scale(factor=1.1), am.noise.Saturate(minimum=0.4, maximum=2.0)),
        ),
        "sonar": MountedSensor(sensor=building.ring(5), mount=mount, noise=chain(am.noise.Bias(value=-0.0), white)),
        "compass": MountedSensor(
            sensor=am.sensors.Compass(), mount=mount, noise=chain(white, white, am.noise.Quantize(step=0.03))
        ),
        "gyro": MountedSensor(sensor=am.sensors.Gyro(), noise=chain(am.noise.Scale(factor=0.9), white)),
        "lossy": MountedSensor(
            sensor=am.sensors.Laser(beams=5), rate=4.0, noise=chain(white, am.noise.Dropout(probability=0.3))
        ),
        "mixed": MountedSensor(
            sensor=am.sensors.Gyro(),
            latency=0.25,
            noise=chain(white, am.noise.BiasRandomWalk(std=0.1), white, am.noise.Quantize(step=0.001)),
        ),
        "bare": MountedSensor(sensor=am.sensors.Gyro()),
    }


def scenario(robots: int) -> am.Scenario:
    errors = {
        "drive.track": am.Deviation(scale=am.Distribution(kind="normal", values=(1.0, 0.02))),
        "sensors.laser.mount.heading": am.Deviation(add=am.Distribution(kind="uniform", values=(-0.1, 0.1))),
        "sensors.sonar.range_max": am.Deviation(scale=am.Distribution(kind="uniform", values=(0.3, 1.0))),
    }
    return building.scenario(
        *(
            building.robot(
                name=f"r{n}",
                sensors=sensors(),
                controller=building.Roam(),
                on_collision="continue",
                errors=errors,
                pose=am.Pose(x=1.5 + 1.5 * n, y=2.0 + 0.4 * n, heading=0.5 * n),
            )
            for n in range(robots)
        ),
        dt=0.1,
        seed=5,
    )


def changed(made: am.Scenario, change: Callable[[Robot], Robot]) -> am.Scenario:
    return attrs.evolve(made, robots=[change(robot) for robot in made.robots])


def run(made: am.Scenario, **settings: Any) -> am.Simulation:
    sim = am.Simulation(made, **settings)
    for _ in range(40):
        sim.step()
    return sim


@pytest.mark.parametrize(("robots", "replicas", "threads"), [(1, 1, 1), (1, 5, 1), (3, 2, 2)])
def test_bits_do_not_tell_whether_a_kernel_does_the_noise(robots: int, replicas: int, threads: int) -> None:
    made = scenario(robots)
    together = run(made, replicas=replicas, threads=threads)
    alone = run(changed(made, own_noise), replicas=replicas)
    for name, reading in together.readings.items():
        np.testing.assert_array_equal(reading.true, alone.readings[name].true, err_msg=name)
        np.testing.assert_array_equal(reading.measured, alone.readings[name].measured, err_msg=name)
    assert together.digest() == alone.digest()


@pytest.mark.parametrize("counts", [39400.0, (39400.0, 512.0)])
@pytest.mark.parametrize("replicas", [1, 4])
def test_a_drive_of_a_users_own_is_reckoned_to_the_same_bits(replicas: int, counts: Any) -> None:
    made = changed(
        scenario(2),
        lambda robot: attrs.evolve(
            robot, sensors={**robot.sensors, "encoder": building.encoder(counts_per_revolution=counts)}
        ),
    )
    together = run(made, replicas=replicas)
    alone = run(changed(made, own_drive), replicas=replicas)
    np.testing.assert_array_equal(together.covariance, alone.covariance)
    np.testing.assert_array_equal(together.estimated_pose, alone.estimated_pose)
    assert together.digest() == alone.digest()


@pytest.mark.parametrize("change", [own_drive, own_estimators])
@pytest.mark.parametrize("replicas", [1, 4])
def test_components_of_a_users_own_give_the_same_bits(change: Any, replicas: int) -> None:
    made = scenario(1)
    together, alone = am.Simulation(made, replicas=replicas), am.Simulation(changed(made, change), replicas=replicas)
    for step in range(300):
        if step == 200:  # before a wall, so that it runs into it
            together.set_pose("r0", (0.45, 2.0, np.pi), replica=0)
            alone.set_pose("r0", (0.45, 2.0, np.pi), replica=0)
        together.step()
        alone.step()
    assert any(event.kind == "collision" for event in together.events)
    np.testing.assert_array_equal(together.true_pose, alone.true_pose)
    np.testing.assert_array_equal(together.covariance, alone.covariance)
    assert together.digest() == alone.digest()


def test_a_restored_simulation_gives_the_same_bits() -> None:
    made = scenario(1)
    together, alone = am.Simulation(made), am.Simulation(changed(made, own_drive))
    for sim in (together, alone):
        sim.run(1.0)
        start = sim.snapshot()
        sim.run(1.0)
        digest = sim.digest()
        sim.restore(start)
        sim.run(1.0)
        assert sim.digest() == digest
    assert together.digest() == alone.digest()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda sim: pickle.loads(pickle.dumps(sim))], ids=["copy", "pickle"])
def test_a_copy_of_a_simulation_goes_its_own_way_to_the_same_bits(copied: Any) -> None:
    sim = am.Simulation(scenario(1))
    sim.run(1.0)
    other = copied(sim)
    before = other.digest()
    sim.run(1.0)
    assert other.digest() == before
    digest = sim.digest()
    del sim
    other.run(0.9)
    other.step()
    assert other.digest() == digest


def test_a_parameter_that_is_set_is_taken_from_the_next_step_on() -> None:
    sim = run(scenario(1))
    sim.set("r0", "sensors.gyro.noise.scale0.factor", 2.0)
    sim.set("r0", "sensors.gyro.noise.gaussian1.std", 0.0)
    sim.set("r0", "sensors.gyro.noise.gaussian1.proportional", 0.0)
    sim.step()
    gyro = sim.readings["gyro"]
    assert gyro.true[0, 0] != 0.0
    assert gyro.measured[0, 0] == 2.0 * gyro.true[0, 0]


@attrs.frozen(kw_only=True)
class Doubled(am.noise.Bias):
    """Steps are inherited, and `corrupt` overrides them."""

    def corrupt(self, values: Any, side: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        return 2.0 * super().corrupt(values, side, elapsed, state, draws)


@attrs.frozen(kw_only=True)
class Stepped(am.Noise):
    """Steps of a plugin that are wrong."""

    step: float = am.parameter(0.0, help="between two values")

    def steps(self) -> Any:
        if np.all(self.step < 0.0):
            raise ZeroDivisionError("by design")
        return [am.NoiseStep.round(self.step)]


def with_noise(noise: am.Noise) -> am.Scenario:
    unit = MountedSensor(sensor=am.sensors.Compass(), noise=chain(noise))
    return building.scenario(building.robot(sensors={"encoder": building.encoder(), "compass": unit}))


def test_a_corrupt_that_overrides_inherited_steps_is_called() -> None:
    compass = am.Simulation(with_noise(Doubled(value=0.25))).readings["compass"]
    assert compass.measured[0, 0] == 2.0 * (compass.true[0, 0] + 0.25)


def test_steps_that_raise_name_their_element() -> None:
    with pytest.raises(am.ComponentError, match=r"noise element 'stepped0' of sensor 'compass'.*ZeroDivisionError"):
        am.Simulation(with_noise(Stepped(step=-1.0)))


def test_steps_that_make_nan_are_refused() -> None:
    with pytest.raises(am.ComponentError, match=r"sensor 'compass'.*its chain of noise \(stepped0\)"):
        am.Simulation(with_noise(Stepped(step=0.0)))


def test_an_element_that_is_all_steps_is_tried_by_check_component() -> None:
    with pytest.raises(CheckError, match=r"corrupt.*nan"):
        am.testing.check_component(Stepped(step=0.0))
