"""A car: steering that moves at its own rate, and two rear wheels that roll as far as the curve makes them."""

from __future__ import annotations

from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt
import pytest

from amorsim.contracts import Draws, Drive, Joint, State, parameter
from amorsim.core.poses import logarithm
from amorsim.core.shapes import Shape
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.scenario.spec import Pose, Robot, Scenario
from amorsim.sensors.encoder import Encoder
from amorsim.simulation.simulation import Simulation
from tests.hard_cases.common import SLIP, Hold, Weave, advance, check_bits, room

Array = npt.NDArray[np.float64]

# Gauss's nodes and weights on [0, 1]: the path while the wheel turns is not an elementary function, its heading is.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


def mean_tangent(start: Array, end: Array) -> Array:
    """Mean of the tangent of angles `(N, k)` from `start` to `end`, in closed form."""
    width = end - start
    middle = 0.5 * (start + end)
    tangent = np.tan(middle)
    near = tangent * (1.0 + (1.0 + tangent * tangent) * width * width / 12.0)
    far = np.log(np.cos(start) / np.cos(end)) / np.where(width == 0.0, 1.0, width)
    return np.where(np.abs(width) < 1e-3, near, far)


@attrs.frozen(kw_only=True)
class Ackermann(Drive):
    """The base point is the middle of the rear axle; both rear wheels are driven, through a differential gear."""

    joints: ClassVar[tuple[Joint, ...]] = (
        Joint(name="steering", rolls=False),
        Joint(name="rear_left"),
        Joint(name="rear_right"),
    )
    channels: ClassVar[tuple[str, ...]] = ("steering", "rear")

    wheel_radius: float = parameter(0.1, unit="m", gt=0, help="radius of the rear wheels")
    wheelbase: float = parameter(0.5, unit="m", gt=0, help="from the rear axle to the front one")
    track: float = parameter(0.3, unit="m", gt=0, help="between the rear wheels")
    steering_max: float = parameter(0.6, unit="rad", gt=0, lt=1.5, help="largest steering angle")
    steering_rate: float = parameter(0.5, unit="rad/s", gt=0, help="how fast the steering moves")
    rate_max: float = parameter(20.0, unit="rad/s", gt=0, help="fastest mean rate of the rear wheels")

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        steering = joints[:, :1]
        target = np.clip(command[:, :1], -self.steering_max, self.steering_max)
        most = self.steering_rate * dt
        moved = steering + np.clip(target - steering, -most, most)
        turn = np.clip(command[:, 1:], -self.rate_max, self.rate_max) * dt
        skew = 0.5 * self.track / self.wheelbase * mean_tangent(steering, moved)
        after = np.concatenate((moved, joints[:, 1:2] + turn * (1 - skew), joints[:, 2:] + turn * (1 + skew)), axis=1)
        return after, (after - joints) / dt

    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        end = self.between(before, after, fraction)
        start, width = before[:, :1], (end - before)[:, :1]
        way = self._way(before, end)
        bend = way / self.wheelbase
        heading = bend * _NODES * mean_tangent(start + 0.0 * _NODES, start + width * _NODES)
        x, y = np.zeros_like(way), np.zeros_like(way)
        for i, weight in enumerate(_WEIGHTS):
            x += weight * np.cos(heading[:, i : i + 1])
            y += weight * np.sin(heading[:, i : i + 1])
        return np.concatenate((way * x, way * y, bend * mean_tangent(start, start + width)), axis=1)

    def twist(self, before: Array, after: Array) -> Array:
        return logarithm(self.displacement(before, after, np.ones((len(before), 1))))

    def travel(self, before: Array, after: Array) -> Array:
        # The turn is fastest where the steering stands most askew: a bound for every part of the step.
        steepest = np.maximum(np.abs(np.tan(before[:, :1])), np.abs(np.tan(after[:, :1])))
        way = np.abs(self._way(before, after))
        return np.concatenate((way, way / self.wheelbase * steepest), axis=1)

    def command_for(self, twist: Array, joints: Array) -> Array:
        forward, turn = twist[:, :1], twist[:, 2:]
        curvature = turn / np.where(forward == 0.0, 1.0, forward)
        steering = np.where(forward == 0.0, joints[:, :1], np.arctan(self.wheelbase * curvature))
        return np.concatenate((steering, forward / self.wheel_radius), axis=1)

    def rolling_radius(self) -> Array:
        return np.concatenate((self.wheel_radius, self.wheel_radius), axis=1)

    def _way(self, before: Array, after: Array) -> Array:
        return 0.5 * ((after - before)[:, 1:2] + (after - before)[:, 2:]) * self.wheel_radius


CAR = Shape.rectangle(0.7, 0.36, x=0.25)


def car(name: str, y: float, drive: Ackermann, controller: Hold | Weave, **others: object) -> Robot:
    return Robot(
        name=name,
        shape=CAR,
        drive=drive,
        sensors={"encoder": Encoder(counts_per_revolution=4096.0)},
        estimators={"odometry": DeadReckoning()},
        controller=controller,
        pose=Pose(x=5.0, y=y),
        **others,
    )


def test_circle_has_the_radius_of_its_wheelbase_and_steering() -> None:
    # Two rows of one group, with different parameters.
    drives = {"long": Ackermann(wheelbase=0.6, steering_rate=0.4), "short": Ackermann(wheelbase=0.3)}
    robots = [
        car(name, 2.0 + 5.0 * i, drive, Hold(channels=(0.35, 5.0))) for i, (name, drive) in enumerate(drives.items())
    ]
    sim = Simulation(Scenario(map=room(), robots=robots))
    steerings = {name: [] for name in drives}
    for _ in range(12):
        sim.step()
        for name in drives:
            steerings[name].append(sim.robot(name).joints[0])
    for name, drive in drives.items():
        expected = np.minimum(drive.steering_rate * sim.dt * np.arange(1, 13), 0.35)
        np.testing.assert_allclose(steerings[name], expected, rtol=0, atol=1e-12)

    centres = {name: [] for name in drives}
    for _ in range(60):
        sim.step()
        for name, drive in drives.items():
            x, y, heading = sim.robot(name).true_pose
            radius = drive.wheelbase / np.tan(0.35)
            centres[name].append((x - radius * np.sin(heading), y + radius * np.cos(heading)))
    for found in centres.values():
        np.testing.assert_allclose(found, np.broadcast_to(found[0], (60, 2)), rtol=0, atol=1e-9)
    assert not sim.events


def test_the_way_into_a_curve_is_that_of_fine_steps() -> None:
    drive, speed, dt = Ackermann(), 0.5, 0.1
    scenario = Scenario(map=room(), robots=[car("car", 5.0, drive, Hold(channels=(0.4, speed / drive.wheel_radius)))])
    sim = Simulation(scenario)
    advance(sim, 8)  # 0.8 s: the steering stands at 0.4 rad at the end
    assert sim.robot("car").joints[0] == pytest.approx(0.4, abs=1e-12)
    # The plain integral of v (cos h, sin h), v tan(steer) / L, by the midpoint rule.
    n = 200_000
    step = 8 * dt / n
    steer = drive.steering_rate * step * (np.arange(n) + 0.5)
    rate = speed * np.tan(steer) / drive.wheelbase
    heading = np.cumsum(rate) * step - 0.5 * rate * step
    expected = [5.0 + speed * step * np.cos(heading).sum(), 5.0 + speed * step * np.sin(heading).sum()]
    x, y, h = sim.robot("car").true_pose
    np.testing.assert_allclose([x, y, h], [*expected, rate.sum() * step], rtol=0, atol=1e-9)


def test_odometry_of_exact_encoders_is_the_truth_through_curves_and_a_wall() -> None:
    controller = Weave(middle=(0.1, 9.0), swing=(0.5, 2.0), period=3.0)
    sim = Simulation(Scenario(map=room(), robots=[car("car", 5.0, Ackermann(), controller)]))
    for _ in range(400):
        sim.step()
        if sim.events:
            break
    assert [event.kind for event in sim.events] == ["collision", "controller_ended"]
    assert sim.events[0].other == "wall"
    sim.step()
    np.testing.assert_allclose(sim.estimated_pose, sim.true_pose, rtol=0, atol=1e-9)


def test_bits() -> None:
    weave = Weave(middle=(0.1, 6.0), swing=(0.4, 2.0))
    robots = [
        car("a", 3.0, Ackermann(), weave, ground=SLIP),
        car("b", 7.0, Ackermann(wheelbase=0.4, track=0.35), weave, ground=SLIP),
    ]
    check_bits(Scenario(map=room(), robots=robots))
