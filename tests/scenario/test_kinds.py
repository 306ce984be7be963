"""A scenario built in Python with a wrong kind of value: the error names the field and what it expects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import amorsim as am
from tests import building


def robot(**changes: Any) -> Callable[[], object]:
    return lambda: building.robot(**changes)


def obstacle(**changes: Any) -> Callable[[], object]:
    return lambda: am.Obstacle(**({"name": "o", "shape": am.Shape.circle(0.2)} | changes))


def sensor(**changes: Any) -> Callable[[], object]:
    return lambda: am.MountedSensor(**({"sensor": building.encoder()} | changes))


def scenario(**changes: Any) -> Callable[[], object]:
    return lambda: am.Scenario(**({"map": building.room(), "robots": [building.robot()]} | changes))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (robot(pose=(1, 1, 0)), r"pose: expected a Pose, as am\.Pose\(x=1\.0\), got \(1, 1, 0\)"),
        (robot(start=(1, 1, 0)), "start: expected a RandomStart"),
        (robot(shape="circle"), r"shape: expected a Shape, as am\.Shape\.circle\(0\.2\), got 'circle'"),
        (robot(drive="differential"), "drive: expected a Drive"),
        (robot(drive=am.drives.Differential), r"drive: .*, and not the class: Differential\(\.\.\.\)"),
        (robot(sensors=[building.encoder()]), "sensors: expected a dict by names"),
        (robot(sensors={"encoder": am.sensors.Encoder}), r"sensor: .*, and not the class: Encoder\(\.\.\.\)"),
        (robot(sensors={"encoder": 3}), "sensor: expected a Sensor"),
        (robot(estimators={"x": am.estimators.DeadReckoning}), r"estimators: x: .*: DeadReckoning\(\.\.\.\)"),
        (robot(estimators=am.estimators.DeadReckoning()), "estimators: expected a dict by names"),
        (robot(controller=am.controllers.Wander), "controller: expected a controller, a function or a class"),
        (robot(ground=am.noise.Diffusion(variance_per_length=1e-6)), "noise: expected a list of noises"),
        (scenario(zones=[building.robot()]), "zones: expected a list of Zone, got one with <Robot 'rover'"),
        (robot(ground=[3]), "noise: expected a list of noises, got one with 3"),
        (robot(knowledge=building.room()), "knowledge: expected a Knowledge"),
        (obstacle(shape=0.2), "shape: expected a Shape"),
        (obstacle(pose=(1, 2)), "pose: expected a Pose"),
        (obstacle(motion=am.motions.Pedestrian), "motion: expected a motion, a function or a class"),
        (sensor(mount=(0, 0, 0)), "mount: expected a Mount"),
        (sensor(noise={"g": am.noise.Gaussian(std=1.0)}), "noise: expected a list of noises"),
        (scenario(map="room.wld"), r"map: expected a Map, as am\.load_map\('room\.wld'\), got 'room\.wld'"),
        (
            scenario(robots=building.robot()),
            r"robots: expected a list of Robot, got one alone; put it in brackets: \[\.\.\.\]$",
        ),
        (scenario(robots=["rover"]), "robots: expected a list of Robot, got one with 'rover'"),
        (scenario(landmarks=[(1, 2)]), r"landmarks: expected a list of Landmark, got one with \(1, 2\)"),
        (scenario(zones=3), "zones: expected a list of Zone, got 3"),
        (
            lambda: am.Knowledge(map="rooms.wld"),
            r"map: expected a Map, as am\.load_map\('rooms\.wld'\), got 'rooms\.wld'",
        ),  # type: ignore[arg-type]
        (lambda: am.Knowledge(map=5), "map: expected a Map, as .*, got 5"),  # type: ignore[arg-type]
        (lambda: am.Knowledge(landmarks=[(1, 2, 3)]), "landmarks: expected points"),
        (lambda: am.Knowledge(landmarks=[(1, float("nan"))]), "landmarks: expected points"),
        (lambda: am.Knowledge(landmarks=5), "landmarks: expected points"),  # type: ignore[arg-type]
        (lambda: am.Knowledge(landmarks=[(1, 2)], landmark_ids=[1.5]), "landmark_ids: expected whole numbers"),  # type: ignore[list-item]
        (lambda: am.Deviation(scale="a"), "scale: expected a number, got 'a'"),  # type: ignore[arg-type]
        (lambda: am.Simulation(building.scenario(), seed=1.5), "seed: expected a whole number"),  # type: ignore[arg-type]
        (lambda: am.Simulation(building.scenario(), replicas=2.5), "expected a number of replicas > 0"),  # type: ignore[arg-type]
    ],
)
def test_what_is_of_another_kind_is_reported(make: Callable[[], object], message: str) -> None:
    with pytest.raises(am.AmorsimError, match=message):
        make()


@pytest.mark.parametrize("given", [[(1, 2), (3, 4)], ((1.0, 2.0), (3.0, 4.0)), np.array([[1.0, 2.0], [3.0, 4.0]])])
def test_landmarks_may_be_any_points(given: Any) -> None:
    knowledge = am.Knowledge(landmarks=given, landmark_ids=range(1, 3))
    assert knowledge.landmarks == ((1.0, 2.0), (3.0, 4.0))
    assert knowledge.landmark_ids == (1, 2)
    sim = am.Simulation(building.scenario(building.robot(knowledge=knowledge)), replicas=np.int64(2), seed=np.int64(4))
    assert (sim.replicas, sim.seed) == ((0, 1), 4)
    assert am.Knowledge(landmarks=np.empty((0, 2))).landmarks == ()
