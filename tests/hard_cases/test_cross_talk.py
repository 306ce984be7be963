"""Sonars that hear one another: a sensor that must know who fired when."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Draws, Drive, Emission, Sensor, State, View, parameter
from amorsim.core.poses import relative
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.scenario.spec import Mount, MountedSensor, Pose, Robot, Scenario
from amorsim.simulation.simulation import Simulation
from tests.hard_cases.common import SLIP, Hold, check_bits, room

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class HearingSonar(Sensor):
    """One transducer that fires every few ticks and, when it does, takes the first sound for its own echo."""

    unit: ClassVar[str] = "m"
    medium: ClassVar[str] = "ultrasound"

    half_angle: float = parameter(0.26, unit="rad", ge=0, help="between the cone's axis and its edge")
    range_max: float = parameter(5.0, unit="m", gt=0, help="longest range that is seen")
    period: int = parameter(4, ge=1, help="ticks from firing to firing")
    phase: int = parameter(0, ge=0, help="tick at which it fires first")

    def size(self, drive: Drive) -> int:
        return 1

    def fires(self, view: View) -> npt.NDArray[np.bool_]:
        return np.asarray((view.tick - self.phase) % self.period == 0)

    def emit(self, view: View, state: State) -> Emission:
        half = np.array(np.broadcast_to(self.half_angle, (view.rows, 1)))
        return Emission(view.pose[:, None, :].copy(), half, self.fires(view))

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        echo = view.cone(view.pose, self.half_angle, self.range_max)
        heard = np.full((view.rows, 1), np.inf)
        sound = view.emissions(self.medium)
        for i in range(sound.poses.shape[1]):
            other = np.ascontiguousarray(sound.poses[:, i])
            there, back = relative(view.pose, other), relative(other, view.pose)
            way = np.sqrt(there[:, :1] ** 2 + there[:, 1:2] ** 2)
            hears = np.abs(np.arctan2(there[:, 1:2], there[:, :1])) <= self.half_angle
            aims = np.abs(np.arctan2(back[:, 1:2], back[:, :1])) <= sound.half_angle[:, i : i + 1]
            towards = np.arctan2(there[:, 1:2], there[:, :1])
            # The ray to the other ends at his body at the latest; whatever ends it well before is in between.
            free = view.cast(view.pose, towards, self.range_max * 2.0) >= way - 0.35
            counts = sound.fired[:, i : i + 1] & ~sound.own[:, i : i + 1] & hears & aims & free
            # Fired at the same instant, the sound comes the way once, and the device halves it.
            heard = np.where(counts, np.minimum(heard, 0.5 * way), heard)
        first = np.minimum(echo, np.where(heard <= self.range_max, heard, np.inf))
        return np.where(self.fires(view), first, np.inf), {}


def robot(name: str, x: float, heading: float, sonar: HearingSonar, speed: float = 0.0, **others: object) -> Robot:
    return Robot(
        name=name,
        shape=Shape.circle(0.25),
        drive=Differential(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.3, rate_max=30.0),
        sensors={"sonar": MountedSensor(sensor=sonar, mount=Mount(x=0.25))},
        controller=Hold(channels=(speed / 0.1, speed / 0.1)),
        pose=Pose(x=x, y=6.0, heading=heading),
        **others,
    )


def readings(robots: list[Robot], ticks: int) -> dict[str, list[float]]:
    sim = Simulation(Scenario(map=room(), robots=robots))
    found: dict[str, list[float]] = {r.name: [] for r in robots}
    for _ in range(ticks):
        for name, values in found.items():
            values.append(float(sim.robot(name).readings["sonar"].true[0]))
        sim.step()
    return found


def test_two_that_fire_together_read_half_the_way_between_them() -> None:
    # Transducers 3.5 m apart; the other's body is seen at 3.5 m by its echo.
    face_to_face = [robot("a", 4.0, 0.0, HearingSonar(period=2)), robot("b", 8.0, np.pi, HearingSonar(period=4))]
    found = readings(face_to_face, 5)
    np.testing.assert_allclose(found["a"], [1.75, np.inf, 3.5, np.inf, 1.75], atol=1e-9)
    np.testing.assert_allclose(found["b"], [1.75, np.inf, np.inf, np.inf, 1.75], atol=1e-9)


def test_who_looks_away_or_fires_at_another_time_is_not_heard() -> None:
    turned = [robot("a", 4.0, 0.0, HearingSonar(period=1)), robot("b", 8.0, np.pi / 2, HearingSonar(period=1))]
    assert readings(turned, 1)["a"][0] > 3.4
    late = [robot("a", 4.0, 0.0, HearingSonar(period=2)), robot("b", 8.0, np.pi, HearingSonar(period=2, phase=1))]
    np.testing.assert_allclose(readings(late, 2)["a"], [3.5, np.inf], atol=1e-9)


def test_bits() -> None:
    robots = [
        robot("a", 4.0, 0.1, HearingSonar(period=1), 0.3, ground=SLIP),
        robot("b", 8.0, np.pi, HearingSonar(period=2, half_angle=0.3), 0.2, ground=SLIP),
    ]
    check_bits(Scenario(map=room(), robots=robots), steps=12)
