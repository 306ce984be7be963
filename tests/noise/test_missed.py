"""Missed detections: whole slots, as often as configured."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.core.errors import ComponentError
from amorsim.core.shapes import Shape
from amorsim.noise import Missed
from amorsim.scenario.spec import Landmark, MountedSensor, Pose
from amorsim.sensors import Camera, Compass, Fiducial
from tests.building import empty, robot, scenario
from tests.noise.sampling import SIGMAS, Samples

PLACES = [(1.0, 0.2), (2.0, 0.0), (4.0, -0.5)]


def simulate(sensor, noise, replicas=1, **more):
    unit = MountedSensor(sensor=sensor, noise=(noise,))
    one = robot(shape=Shape.circle(0.1), pose=Pose(), sensors={"eye": unit}, estimators={})
    marks = [Landmark(id=i, x=x, y=y, colour="red") for i, (x, y) in enumerate(PLACES, start=1)]
    return am.Simulation(scenario(one, map=empty(50.0), landmarks=marks, **more), replicas=replicas)


@pytest.mark.parametrize(("probability", "per_metre"), [(0.3, 0.0), (0.05, 0.15), (0.0, 0.2)])
def test_slots_are_missed_as_often_as_set_each_on_its_own(probability, per_metre):
    sim = simulate(Fiducial(slots=5), Missed(probability=probability, per_metre=per_metre), replicas=4000)
    true = sim.readings["eye"].true.reshape(-1, 5, 3)
    found = sim.readings["eye"].measured.reshape(-1, 5, 3)
    missed = found[:, :3, 2] == -1.0
    assert (np.where(missed[:, :, None], [math.inf, math.inf, -1.0], true[:, :3]) == found[:, :3]).all()
    assert (found[:, 3:] == [math.inf, math.inf, -1.0]).all()
    expected = probability + per_metre * np.hypot(*np.transpose(PLACES))
    bound = SIGMAS * np.sqrt(expected * (1.0 - expected) / 4000)
    assert (np.abs(missed.mean(axis=0) - expected) < bound).all()
    # Independent: the correlation of two has a standard deviation of 1 / sqrt(n).
    assert np.abs(np.corrcoef(missed.T) - np.eye(3)).max() < SIGMAS / math.sqrt(4000)


def test_a_camera_misses_blobs():
    sim = simulate(Camera(slots=4), Missed(probability=1.0))
    reading = sim.robot("rover").readings["eye"]
    assert (reading.true.reshape(-1, 7)[:3, 0] == 0.0).all()
    assert (reading.measured.reshape(-1, 7) == [-1.0, *[math.inf] * 6]).all()


def test_missing_nothing_leaves_every_bit():
    samples = Samples(Missed(), rows=2)
    values = np.array([[0.0, -0.0, 1.0 / 3.0, -1e-300], [math.inf, 1e300, -2.5, 7.0]])
    side = {"slot": 0.0, "range": math.inf, "empty": math.inf}
    assert samples.take(values, side=side).tobytes() == values.tobytes()


def test_a_sensor_without_slots_is_refused_in_words():
    with pytest.raises(ComponentError, match="has a slot for each"):
        simulate(Compass(), Missed(probability=0.5))
