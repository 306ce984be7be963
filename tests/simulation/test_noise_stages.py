"""Each stage of each reading is worked out again from what was kept, bit for bit."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim import noise
from amorsim.plugins.manager import make_registry
from amorsim.sensors import Compass, Gyro, Laser, Sonar
from tests import building

# Every element that changes values, on a sensor whose values it is for.
LASER, GYRO = Laser(beams=19), Gyro()
CASES: dict[str, tuple[Any, am.Noise]] = {
    "angle_random_walk": (GYRO, noise.AngleRandomWalk(density=0.1)),
    "beam_model": (LASER, noise.BeamModel(hit=0.7, short=0.1, max=0.1, random=0.1, std=0.05, range_max=8.0)),
    "bias": (GYRO, noise.Bias(value=0.1)),
    "bias_instability": (GYRO, noise.BiasInstability(std=0.1, correlation_time=0.5)),
    "bias_random_walk": (GYRO, noise.BiasRandomWalk(std=0.1)),
    "compass_deviation": (Compass(), noise.CompassDeviation(a=0.1, b=0.2, d=0.1)),
    "cross_talk": (
        Sonar(medium="ultrasound", elements=(am.Mount(y=-0.1), am.Mount(y=0.1)), firing=(0, 1), interval=0.002),
        noise.CrossTalk(probability=0.6),
    ),
    "dropout": (GYRO, noise.Dropout(probability=0.4, report="last")),
    "gaussian": (GYRO, noise.Gaussian(std=0.1, proportional=0.1, per="increment")),
    "missed": (am.sensors.Fiducial(), noise.Missed(probability=0.5)),
    "noise_floor": (GYRO, noise.NoiseFloor(level=0.3)),
    "outliers": (GYRO, noise.Outliers(probability=0.4, std=1.0)),
    "quantize": (GYRO, noise.Quantize(step=0.07)),
    "saturate": (GYRO, noise.Saturate(minimum=-0.1, maximum=0.1)),
    "scale": (GYRO, noise.Scale(factor=1.1)),
    "specular_loss": (LASER, noise.SpecularLoss(critical=0.6)),
    "stuck": (GYRO, noise.Stuck(rate=3.0, duration=0.3)),
}
WHEELS = {"bump", "diffusion", "odometry_model", "slip", "velocity_model"}  # of the ground: no reading has such a stage
NO_VALUES = {"aim_gaussian", "latency_jitter", "motion_distortion"}


def test_every_element_that_is_registered_is_tried() -> None:
    assert set(make_registry(entry_points=[]).names("noise")) == {*CASES, *WHEELS, *NO_VALUES}


def simulate(unit: am.MountedSensor, replicas: int = 3) -> am.Simulation:
    robot = building.robot(
        sensors={"encoder": building.encoder(), "sensor": unit},
        controller=building.Roam(),
        on_collision="continue",
    )
    marks = [am.Landmark(id=1, x=5.5, y=4.5), am.Landmark(id=2, x=5.5, y=0.5), am.Landmark(id=3, x=0.5, y=2.5)]
    return am.Simulation(building.scenario(robot, landmarks=marks), replicas=replicas)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("prompt", [True, False])
def test_the_last_stage_is_worked_out_again(name: str, prompt: bool) -> None:
    sensor, element = CASES[name]
    before, after = noise.Gaussian(std=0.01), (noise.AimGaussian(std=0.01), noise.LatencyJitter(spread=0.2))
    first = (element,) if name == "missed" else (before, element)  # which is of whole slots, before is of no column
    chain = first if prompt else (*first, *after)
    unit = am.MountedSensor(sensor=sensor, noise=chain, rate=None if prompt else 7.0, latency=0.0 if prompt else 0.15)
    sim = simulate(unit)
    kept = am.keep_stages(sim)
    seen = 0
    for _ in range(25):
        sim.step()
        for replica in sim.replicas:
            reading = sim.robot("rover", replica).readings["sensor"]
            if reading.stamp[0] == 0:
                continue  # taken before they were kept
            stages = kept.stages("rover", "sensor", replica=replica)
            assert [type(stage.noise) for stage in stages] == [type(part) for part in first]
            assert all(stage.tick == reading.stamp[0] for stage in stages)
            assert stages[-1].recompute().tobytes() == reading.measured.tobytes()
            for stage, following in itertools.pairwise(stages):
                assert stage.recompute().tobytes() == stage.result.tobytes() == following.values.tobytes()
            if prompt:
                assert stages[0].values.tobytes() == reading.true.tobytes()
            seen += int((reading.measured != reading.true).any())
    assert seen > 10


def test_keeping_changes_no_bit_and_ends() -> None:
    unit = am.MountedSensor(sensor=LASER, noise=(noise.Gaussian(std=0.01), noise.Quantize(step=0.01)))
    plain, watched = simulate(unit), simulate(unit)
    plain.run(1.0)
    with am.keep_stages(watched) as kept:
        watched.run(0.5)
    watched.run(0.5)
    assert plain.digest() == watched.digest()
    with pytest.raises(am.AmorsimError, match="its reading of tick 10 were not kept"):
        kept.last_stage("rover", "sensor", replica=0)


def test_parameters_that_change_meanwhile_are_those_of_the_stage() -> None:
    sim = simulate(am.MountedSensor(sensor=GYRO, noise=(noise.Scale(factor=1.5),), latency=0.3), replicas=1)
    kept = am.keep_stages(sim)
    sim.run(0.5)
    sim.set("rover", "sensors.sensor.noise.scale.factor", 2.0)
    sim.step()
    stage = kept.last_stage("rover", "sensor")
    assert (stage.tick, float(stage.noise.factor[0, 0])) == (3, 1.5)  # type: ignore[attr-defined]
    assert stage.recompute().tobytes() == sim.readings["sensor"].measured[0].tobytes()


def test_elements_of_one_column_have_stages_of_that_column() -> None:
    marks = [am.Landmark(id=1, x=4.0, y=2.0), am.Landmark(id=2, x=3.0, y=4.0)]
    finder = am.MountedSensor(
        sensor=am.sensors.Fiducial(),
        noise=(
            am.NoiseElement(name="range", noise=noise.Gaussian(proportional=0.05), column="range"),
            am.NoiseElement(name="bearing", noise=noise.Gaussian(std=math.radians(2.0)), column="bearing"),
        ),
    )
    robot = building.robot(sensors={"finder": finder}, estimators={})
    sim = am.Simulation(building.scenario(robot, landmarks=marks))
    kept = am.keep_stages(sim)
    sim.run(0.3)
    reading = sim.readings["finder"]
    columns = len(am.sensors.Fiducial().columns())
    for stage, column in zip(kept.stages("rover", "finder"), (0, 1), strict=True):
        assert stage.recompute().tobytes() == np.ascontiguousarray(reading.measured[0, column::columns]).tobytes()


def test_what_cannot_be_known_is_said() -> None:
    sim = simulate(am.MountedSensor(sensor=GYRO, latency=0.2), replicas=1)
    kept = am.keep_stages(sim, samples=1)
    sim.step()
    with pytest.raises(am.AmorsimError, match="no element of its chain changes values"):
        kept.last_stage("rover", "sensor")
    with pytest.raises(
        am.AmorsimError, match=r"no sensor 'senor'; known sensors: encoder, sensor. Did you mean 'sensor'"
    ):
        kept.stages("rover", "senor")
    with pytest.raises(am.AmorsimError, match="expected a whole number > 0"):
        am.keep_stages(sim, samples=0)
