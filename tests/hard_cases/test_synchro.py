"""A synchro drive: all wheels steer and roll together, and the body keeps looking the way it does."""

from __future__ import annotations

from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Drive, Joint, State, parameter
from amorsim.core.shapes import Shape
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.scenario.spec import Pose, Robot, Scenario
from amorsim.sensors.encoder import Encoder
from amorsim.simulation.simulation import Simulation
from tests.hard_cases.common import SLIP, Hold, Weave, advance, check_bits, room

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Synchro(Drive):
    """Commands are the rate at which the wheels steer and the rate at which they roll."""

    joints: ClassVar[tuple[Joint, ...]] = (Joint(name="steering", rolls=False), Joint(name="wheels"))
    channels: ClassVar[tuple[str, ...]] = ("steering", "wheels")

    wheel_radius: float = parameter(0.05, unit="m", gt=0, help="radius of the wheels")
    steering_rate_max: float = parameter(2.0, unit="rad/s", gt=0, help="how fast the wheels steer")
    rate_max: float = parameter(20.0, unit="rad/s", gt=0, help="how fast the wheels roll")

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        most = np.concatenate((self.steering_rate_max, self.rate_max), axis=1)
        now = np.clip(command, -most, most)
        return joints + now * dt, now

    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        # The direction turns evenly while the body does not: the chord of an arc, but with no turn.
        half = 0.5 * (after - before)[:, :1] * fraction
        middle = before[:, :1] + half
        way = (after - before)[:, 1:] * self.wheel_radius * fraction
        chord = way * np.where(half == 0.0, 1.0, np.sin(half) / np.where(half == 0.0, 1.0, half))
        return np.concatenate((chord * np.cos(middle), chord * np.sin(middle), np.zeros_like(way)), axis=1)

    def twist(self, before: Array, after: Array) -> Array:
        return self.displacement(before, after, np.ones((len(before), 1)))

    def travel(self, before: Array, after: Array) -> Array:
        way = np.abs((after - before)[:, 1:]) * self.wheel_radius
        return np.concatenate((way, np.zeros_like(way)), axis=1)

    def command_for(self, twist: Array, joints: Array) -> Array:
        # Nearest in this instant: the part of the wanted velocity that lies along the wheels.
        along = twist[:, :1] * np.cos(joints[:, :1]) + twist[:, 1:2] * np.sin(joints[:, :1])
        return np.concatenate((np.zeros_like(along), along / self.wheel_radius), axis=1)

    def rolling_radius(self) -> Array:
        return np.array(self.wheel_radius)


def robot(name: str, y: float, drive: Synchro, controller: Hold | Weave, **others: object) -> Robot:
    return Robot(
        name=name,
        shape=Shape.rectangle(0.5, 0.3),
        drive=drive,
        sensors={"encoder": Encoder(counts_per_revolution=1000.0)},
        estimators={"odometry": DeadReckoning()},
        controller=controller,
        pose=Pose(x=6.0, y=y, heading=0.7),
        **others,
    )


def test_drives_a_circle_without_turning() -> None:
    drives = {"a": Synchro(), "b": Synchro(wheel_radius=0.08)}
    turning = Hold(channels=(0.5, 6.0))
    robots = [robot(name, 3.0 + 4.0 * i, drive, turning) for i, (name, drive) in enumerate(drives.items())]
    sim = Simulation(Scenario(map=room(), robots=robots))
    path = np.array(advance(sim, 100))
    assert (path[:, :, 2] == 0.7).all()
    time = sim.dt * np.arange(1, 101)
    for i, drive in enumerate(drives.values()):
        radius = drive.wheel_radius * 6.0 / 0.5
        expected = np.stack(
            (
                6.0 + radius * (np.sin(0.7 + 0.5 * time) - np.sin(0.7)),
                3.0 + 4.0 * i - radius * (np.cos(0.7 + 0.5 * time) - np.cos(0.7)),
            ),
            axis=1,
        )
        np.testing.assert_allclose(path[:, i, :2], expected, rtol=0, atol=1e-10)
    np.testing.assert_allclose(sim.estimated_pose, sim.true_pose, rtol=0, atol=1e-10)


def test_stops_at_a_wall_on_its_own_path() -> None:
    """The path of a step is bent though the body does not turn: an arc of a constant twist would end elsewhere."""
    drive = Synchro(steering_rate_max=20.0)
    scenario = Scenario(
        map=room(), robots=[robot("r", 6.0, drive, Hold(channels=(1.0, 4.0)))], dt=3.0
    )  # in one step: three quarters of half a circle of 0.2 m radius, then again
    sim = Simulation(scenario)
    sim.step()
    angle = 3.0
    np.testing.assert_allclose(
        sim.robot("r").true_pose,
        [6.0 + 0.2 * (np.sin(0.7 + angle) - np.sin(0.7)), 6.0 - 0.2 * (np.cos(0.7 + angle) - np.cos(0.7)), 0.7],
        rtol=0,
        atol=1e-12,
    )
    # Now a half circle of 1.5 m radius that would end in free space, but whose belly lies in the wall: a chord tunnels.
    start = Pose(x=11.0, y=6.0, heading=0.0)
    bulging = attrs.evolve(
        robot("r", 6.0, Synchro(wheel_radius=0.05, rate_max=100.0), Hold(channels=(np.pi / 3.0, 0.5 * np.pi / 0.05))),
        pose=start,
    )
    sim = Simulation(Scenario(map=room(), robots=[bulging], dt=3.0))
    sim.step()
    assert [event.kind for event in sim.events] == ["collision", "controller_ended"]
    x, y, _ = sim.robot("r").true_pose
    # Half the body is 0.25 m long; the wall's face is at 12 m (its cells begin there, or one cell before).
    assert 12.0 - 0.25 - 0.011 <= x <= 12.0 - 0.25 + 1e-9
    np.testing.assert_allclose((x - 11.0) ** 2 + (y - 7.5) ** 2, 1.5**2, rtol=1e-9)
    np.testing.assert_allclose(sim.estimated_pose, sim.true_pose, rtol=0, atol=1e-10)


def test_bits() -> None:
    weave = Weave(middle=(0.3, 6.0), swing=(1.0, 4.0))
    robots = [
        robot("a", 3.0, Synchro(), weave, ground=SLIP),
        robot("b", 7.0, Synchro(wheel_radius=0.06), weave, ground=SLIP),
    ]
    check_bits(Scenario(map=room(), robots=robots))
