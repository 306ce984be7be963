"""A camera on a head that pans and tilts: a device that takes commands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Context, Draws, Drive, Sensor, State, View, parameter
from amorsim.core.poses import compose
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.scenario.spec import Mount, MountedSensor, Pose, Robot, Scenario
from amorsim.sensors.encoder import Encoder
from amorsim.simulation.simulation import Simulation
from tests.hard_cases.common import SLIP, Hold, Weave, advance, check_bits, room

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class DepthCamera(Sensor):
    """Depths [m] on the horizon of a camera that sits on the head, and how far it can see there: one value a column.

    Tilted by t, the camera sees the horizon only if it lies within its vertical field of view. Pan and tilt follow
    their commands at a rate.
    """

    unit: ClassVar[str] = "m"
    channels: ClassVar[tuple[str, ...]] = ("pan", "tilt")

    width: int = parameter(5, ge=2, static=True, help="columns of the picture")
    fov: float = parameter(0.6, unit="rad", gt=0, help="angle between the outer columns")
    fov_vertical: float = parameter(0.6, unit="rad", gt=0, help="angle between the uppermost and the lowest row")
    range_max: float = parameter(20.0, unit="m", gt=0, help="longest range that is seen")
    head_rate: float = parameter(1.0, unit="rad/s", gt=0, help="how fast the head pans and tilts")
    pan_max: float = parameter(1.7, unit="rad", gt=0, help="how far it pans to either side")
    tilt_max: float = parameter(0.5, unit="rad", gt=0, help="how far it tilts up and down")

    def size(self, drive: Drive) -> int:
        return self.width

    def start(self, context: Context) -> State:
        return {"angles": np.zeros((context.rows, 2))}

    def actuate(self, command: Array, dt: float, state: State, draws: Draws) -> None:
        limit = np.concatenate((self.pan_max, self.tilt_max), axis=1)
        most = self.head_rate * dt
        angles = state["angles"]
        state["angles"] = angles + np.clip(np.clip(command, -limit, limit) - angles, -most, most)

    def bearings(self) -> Array:
        return (np.linspace(-0.5, 0.5, self.width) * self.fov).reshape(-1, self.width)

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        pan, tilt = state["angles"][:, 0], state["angles"][:, 1:]
        turned = np.zeros((view.rows, 3))
        turned[:, 2] = pan
        depths = view.cast(compose(view.pose, turned), self.bearings(), self.range_max)
        return np.where(np.abs(tilt) <= 0.5 * self.fov_vertical, depths, np.inf), {}


def robot(name: str, x: float, y: float, controller: Hold | Weave, rate: float, **others: object) -> Robot:
    return Robot(
        name=name,
        shape=Shape.circle(0.25),
        drive=Differential(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.4, rate_max=20.0),
        sensors={
            "encoder": Encoder(counts_per_revolution=4096.0),
            "camera": MountedSensor(sensor=DepthCamera(head_rate=rate), mount=Mount(x=0.1)),
        },
        estimators={"odometry": DeadReckoning()},
        controller=controller,
        pose=Pose(x=x, y=y),
        **others,
    )


def pan_of(sim: Simulation, row: int = 0) -> float:
    return float(sim._fleet.groups[0].sensors["camera"].state["angles"][row, 0])


def test_head_turns_at_its_rate_and_the_camera_looks_where_it_points() -> None:
    still = Hold(channels=(0.0, 0.0, 1.2, 0.0))
    robots = [robot("fast", 4.0, 4.0, still, 2.0), robot("slow", 4.0, 8.0, still, 0.5)]
    sim = Simulation(Scenario(map=room(resolution=0.001), robots=robots))
    for step in range(1, 30):
        sim.step()
        for name, rate in (("fast", 2.0), ("slow", 0.5)):
            angle = min(rate * sim.dt * step, 1.2)
            handle = sim.robot(name)
            assert abs(pan_of(sim, sim.names.index(name)) - angle) < 1e-12
            middle = handle.readings["camera"].true[2]
            x, y, _ = handle.true_pose
            wall = min((12.0 - x - 0.1) / np.cos(angle), (12.0 - y) / max(np.sin(angle), 1e-9))
            assert abs(middle - wall) < 0.005


def test_tilted_too_far_it_sees_no_horizon() -> None:
    sim = Simulation(Scenario(map=room(), robots=[robot("r", 6.0, 6.0, Hold(channels=(0.0, 0.0, 0.0, 0.45)), 0.9)]))
    seen = []
    for _ in range(6):
        sim.step()
        seen.append(bool(np.isfinite(sim.robot("r").readings["camera"].true).all()))
    assert seen == [True, True, True, False, False, False]


def test_the_head_goes_on_when_the_body_is_stopped() -> None:
    sim = Simulation(
        Scenario(
            map=room(),
            robots=[robot("r", 11.0, 6.0, Hold(channels=(10.0, 10.0, 1.5, 0.0)), 1.0, on_collision="continue")],
        )
    )
    advance(sim, 10)
    assert sim.events[0].kind == "collision"
    assert abs(pan_of(sim) - 1.0) < 1e-12
    np.testing.assert_allclose(sim.estimated_pose, sim.true_pose, rtol=0, atol=1e-9)


def test_bits() -> None:
    weave = Weave(middle=(5.0, 6.0, 0.0, 0.0), swing=(2.0, 3.0, 1.5, 0.4))
    robots = [robot("a", 3.0, 3.0, weave, 2.0, ground=SLIP), robot("b", 3.0, 8.0, weave, 0.7, ground=SLIP)]
    check_bits(Scenario(map=room(), robots=robots))
