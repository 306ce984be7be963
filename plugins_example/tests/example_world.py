"""What the tests share: open ground, a command that stays the same, and a fork lift without any noise."""

from typing import Any

import amorsim_example as example
import attrs
import numpy as np

import amorsim as am


@attrs.frozen(kw_only=True)
class Hold(am.Controller):
    """The same command for ever."""

    channels: tuple[float, ...] = am.parameter(help="the command, channel by channel")

    def command(self, robot, readings, estimate, clock, state, draws):
        return np.array(self.channels)


def open_ground(*walls: tuple[float, float, float, float], half: float = 50.0) -> am.Map:
    return am.Map.from_segments(
        np.array(walls, dtype=float).reshape(-1, 4), resolution=0.01, extent=(-half, -half, half, half)
    )


def tricycle(**changes: Any) -> example.Tricycle:
    return example.Tricycle(**({"wheel_radius": 0.1, "wheelbase": 0.5, "rate_max": 10.0} | changes))


def robot(**changes: Any) -> am.Robot:
    given: dict[str, Any] = {
        "name": "lift",
        "shape": am.Shape.rectangle(0.8, 0.5, x=0.25),
        "drive": tricycle(),
        "sensors": {"encoder": am.sensors.Encoder(counts_per_revolution=4096.0)},
        "estimators": {"odometry": am.estimators.DeadReckoning()},
        "controller": am.controllers.Manual(),
        "pose": am.Pose(),
    }
    return am.Robot(**(given | changes))


def simulation(*robots: am.Robot, replicas: int = 1, **changes: Any) -> am.Simulation:
    given: dict[str, Any] = {"map": open_ground(), "robots": robots, "seed": 5}
    return am.Simulation(am.Scenario(**(given | changes)), replicas=replicas)
