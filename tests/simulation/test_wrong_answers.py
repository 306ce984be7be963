"""Answers of components that are not of the contract's shapes are refused with the component's name."""

from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

import amorsim as am
from tests import building


@attrs.frozen(kw_only=True)
class Stepping(am.Noise):
    """An element whose steps are given."""

    kind: str = am.parameter("one", help="what steps() returns")

    def steps(self) -> Any:
        """Not as the contract says."""
        add = am.NoiseStep.add
        return {"one": add(0.1), "pairs": [("add", 0.1)], "wide": [add(np.zeros(7))], "none": None}[self.kind]


@attrs.frozen(kw_only=True)
class Late(am.Noise):
    """An element whose delay is given."""

    kind: str = am.parameter("flat", help="what delay() returns")

    def delay(self, elapsed: Any, state: Any, draws: Any) -> Any:
        """Not as the contract says."""
        return {"flat": elapsed[:, 0], "long": elapsed + 3.0, "nan": elapsed * np.nan}[self.kind]

    def longest_delay(self) -> Any:
        """A tenth of a second."""
        return np.full((1, 1), 0.1)


@attrs.frozen(kw_only=True)
class Sliding(am.Noise):
    """A slide with one column."""

    for_ground: ClassVar[bool] = True

    def slide(self, motion: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        """Not as the contract says."""
        return motion[:, :1].copy()


@attrs.frozen(kw_only=True)
class Aiming(am.Noise):
    """An aim of one angle for all beams."""

    kind: str = am.parameter("narrow", help="what aim() returns")

    def aim(self, aim: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        """Not as the contract says."""
        return am.Aim(bearing=np.zeros((len(elapsed), 1))) if self.kind == "narrow" else elapsed


@attrs.frozen(kw_only=True)
class Calling(am.Sensor):
    """A sensor whose emission is given."""

    unit: ClassVar[str] = "count"
    medium: ClassVar[str] = "air"
    kind: str = am.parameter("flat", help="what emit() returns")

    def size(self, drive: Any) -> int:
        """One value."""
        return 1

    def emit(self, view: Any, state: Any) -> Any:
        """Not as the contract says."""
        n = view.rows
        poses, angle, fired = view.pose[:, None, :].copy(), np.ones((n, 1)), np.full((n, 1), True)
        return {
            "flat": am.Emission(view.pose, angle, fired),
            "number": am.Emission(poses, np.pi, fired),  # type: ignore[arg-type]
            "true": am.Emission(poses, angle, True),  # type: ignore[arg-type]
            "late": am.Emission(poses, angle, fired, time=np.zeros(n)),
        }[self.kind]

    def sense(self, view: Any, aim: Any, state: Any, draws: Any) -> Any:
        """Nothing."""
        return np.zeros((view.rows, 1)), {}


def noisy(noise: am.Noise) -> am.Robot:
    laser = am.MountedSensor(sensor=am.sensors.Laser(beams=5), noise=building.chain(noise))
    return building.robot(sensors={"encoder": building.encoder(), "laser": laser})


STEPS = "noise element 'stepping' of sensor 'laser' (Stepping) of robot 'rover' at 0 s: steps(): expected "
LATE = "noise element 'late' of sensor 'laser' (Late) of robot 'rover' at 0 s: expected delays of "
AIM = "sensor 'laser' (Laser) of robot 'rover' at 0 s: expected "
CALL = "sensor 'ear' (Calling) of robot 'rover' at 0 s: expected "


@pytest.mark.parametrize(
    ("robot", "words"),
    [
        (lambda: noisy(Stepping(kind="one")), f"{STEPS}a list of NoiseStep, got NoiseStep("),
        (lambda: noisy(Stepping(kind="pairs")), f"{STEPS}a list of NoiseStep, got [('add', 0.1)]"),
        (lambda: noisy(Stepping(kind="none")), f"{STEPS}a list of NoiseStep, got None"),
        (lambda: noisy(Stepping(kind="wide")), f"{STEPS}numbers, or arrays (3, 1) as fields are in a run, got the sha"),
        (lambda: noisy(Late(kind="flat")), f"{LATE}the shape (3, 1) from delay(), got the shape (3,)"),
        (lambda: noisy(Late(kind="long")), f"{LATE}at most longest_delay() from delay(), got longer ones or nan"),
        (lambda: noisy(Late(kind="nan")), f"{LATE}at most longest_delay() from delay(), got longer ones or nan"),
        (
            lambda: building.robot(ground=building.chain(Sliding())),
            "(Sliding) of robot 'rover' at 0 s: expected slides of the shape (3, 3) from slide(), got the shape (3, 1)",
        ),
        (lambda: noisy(Aiming()), f"{AIM}bearings of the shape (3, 5) from the aim() of its noise, got the shape"),
        (lambda: noisy(Aiming(kind="array")), f"{AIM}an Aim from the aim() of its noise, got array("),
        (lambda: calling("flat"), f"{CALL}poses of the shape (3, 1, 3) from emit(), got the shape (3, 3)"),
        (lambda: calling("number"), f"{CALL}half angles of the shape (3, 1) from emit(), got a float"),
        (lambda: calling("true"), "robot 'rover' at 0 s: fired from emit(): expected bool (3, 1), got a bool"),
        (lambda: calling("late"), f"{CALL}times of the shape (3, 1) from emit(), got the shape (3,)"),
    ],
)
def test_an_answer_of_another_shape_is_refused_by_name(robot: Any, words: str) -> None:
    with pytest.raises(am.ComponentError) as caught:
        am.Simulation(building.scenario(robot()), replicas=3).run(0.3)
    assert words in str(caught.value)


def calling(kind: str) -> am.Robot:
    return building.robot(sensors={"encoder": building.encoder(), "ear": Calling(kind=kind)})
