"""Robots and rooms that several tests build on."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import attrs
import numpy as np

import amorsim as am
from amorsim.contracts import Clock, Context, Controller, Draws, Estimate, RobotModel, State, parameter
from amorsim.controllers.manual import Manual
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.drives.tractor import Tractor
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.quantize import Quantize
from amorsim.scenario.spec import MountedSensor, NoiseElement, Pose, Robot, Scenario
from amorsim.sensors.compass import Compass
from amorsim.sensors.encoder import Encoder
from amorsim.sensors.gyro import Gyro
from amorsim.sensors.laser import Laser
from amorsim.sensors.sonar import Sonar

RADIUS = 0.0825
TRACK = 0.33


def drive(**changes: Any) -> Differential:
    """The Pioneer's drive, with rates that no test reaches."""
    given = {"wheel_radius_left": RADIUS, "wheel_radius_right": RADIUS, "track": TRACK, "rate_max": 1e6}
    return Differential(**(given | changes))


def tractor(**changes: Any) -> Tractor:
    """The Pioneer's drive with a trailer."""
    given = {"trailer_length": 0.5, "trailer_width": 0.3, "trailer_front": 0.1, "trailer_rear": 0.1}
    wheels = {"wheel_radius_left": RADIUS, "wheel_radius_right": RADIUS, "track": TRACK, "rate_max": 1e6}
    return Tractor(**(wheels | given | changes))


def encoder(**changes: Any) -> Encoder:
    """An encoder without noise, not even quantisation."""
    return Encoder(**({"counts_per_revolution": 39400.0} | changes))


def ring(count: int = 4) -> Sonar:
    """A ring of narrow sonars."""
    mounts = tuple(am.Mount(x=0.1, heading=2.0 * np.pi * i / count) for i in range(count))
    return Sonar(elements=mounts, half_angle=np.radians(1.0), range_min=0.1, range_max=5.0)


def chain(*noise: Any) -> tuple[NoiseElement, ...]:
    """A chain of elements called after their classes."""
    return tuple(NoiseElement(name=type(element).__name__.lower(), noise=element) for element in noise)


def all_sensors() -> dict[str, MountedSensor]:
    """Each built-in sensor, with noise, one of them with a rate and one with a latency."""
    return {
        "encoder": MountedSensor(sensor=encoder(), noise=chain(Quantize(step=1.0, rounding="floor"))),
        "laser": MountedSensor(
            sensor=Laser(beams=19, range_max=8.0),
            mount=am.Mount(x=0.05, heading=0.1),
            noise=chain(Gaussian(std=0.005), Quantize(step=0.01)),
        ),
        "sonar": MountedSensor(sensor=ring(), rate=4.0, noise=chain(Gaussian(std=0.01))),
        "compass": MountedSensor(sensor=Compass(), latency=0.25, noise=chain(Gaussian(std=0.01))),
        "gyro": MountedSensor(sensor=Gyro(), noise=chain(Gaussian(std=0.002))),
    }


@attrs.frozen(kw_only=True)
class Roam(Controller):
    """Random wheel rates, held for ten steps: drives anywhere, into walls too."""

    rate: float = parameter(6.0, unit="rad/s", ge=0, help="largest rate")

    def start(self, context: Context) -> State:
        return {"command": np.zeros((context.rows, 2))}

    def command(
        self,
        robot: RobotModel,
        readings: Any,
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Any:
        fresh = (2.0 * draws.uniform(2) - 0.6) * self.rate
        state["command"] = np.where(clock.tick % 10 == 0, fresh, state["command"])
        return state["command"].copy()


def robot(**changes: Any) -> Robot:
    """A Pioneer with an encoder that tells its wheels exactly, and dead reckoning; driven by hand."""
    given: dict[str, Any] = {
        "name": "rover",
        "shape": Shape.polygon([(-0.3, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.3, 0.2)]),
        "drive": drive(),
        "sensors": {"encoder": encoder()},
        "estimators": {"dead_reckoning": DeadReckoning()},
        "controller": Manual(),
        "pose": Pose(x=2.0, y=2.0, heading=0.3),
    }
    return Robot(**(given | changes))


@functools.cache  # hundreds of tests have the same one
def room(width: float = 6.0, height: float = 5.0, resolution: float = 0.001) -> Map:
    """A room of four walls, its lower left corner at the origin."""
    corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    walls = [(*a, *b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    return Map.from_segments(np.array(walls), resolution=resolution)


def empty(size: float = 1000.0) -> Map:
    """Nothing but free space, `size` [m] square about the origin."""
    half = size / 2.0
    return Map.from_segments(np.empty((0, 4)), resolution=0.5, extent=(-half, -half, half, half))


def scenario(*robots: Robot, **changes: Any) -> Scenario:
    """A scenario of these robots (or the one of `robot`) in the room."""
    given: dict[str, Any] = {"map": room(), "robots": robots or (robot(),), "seed": 3}
    return Scenario(**(given | changes))


def rover_text(*lines: str) -> str:
    """The file of a scenario: a Pioneer in `room.wld`, and lines that say more of it."""
    head = ("format = 1", "[world]", 'map = "room.wld"', "", "[[robots]]", 'name = "rover"', 'model = "pioneer2dx"')
    return "".join(f"{line}\n" for line in (*head, "pose = { x = 1.0, y = 1.5 }", *lines))


def write_rover(folder: Path, *lines: str) -> Path:
    """The same as a file, with its room."""
    (folder / "room.wld").write_text("width 4000\nheight 3000\n", encoding="utf-8")
    (folder / "one.toml").write_text(rover_text(*lines), encoding="utf-8")
    return folder / "one.toml"
