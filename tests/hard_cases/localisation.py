"""What the two estimators with a map share: the world they are lost in, and the ranges that a pose should see."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Estimator, RobotModel
from amorsim.core.errors import ComponentError
from amorsim.core.maps.map import Map
from amorsim.core.poses import compose
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.noise.gaussian import Gaussian
from amorsim.scenario.knowledge import Knowledge
from amorsim.scenario.spec import Deviation, Mount, MountedSensor, NoiseElement, Pose, Robot, Scenario
from amorsim.sensors.encoder import Encoder
from amorsim.sensors.laser import Laser
from tests.hard_cases.common import SLIP, Weave

Array = npt.NDArray[np.float64]


def needs_map(estimator: Estimator, context: Context) -> None:
    """Refuse a robot that knows no map."""
    if context.robot.map is None:
        raise ComponentError(f"{type(estimator).__name__} needs `knowledge.map`, and the robot has none")


def expected_ranges(robot: RobotModel, sensor: str, poses: Array, beams: npt.NDArray[np.int64]) -> Array:
    """Ranges [m] `(N, m, b)` that the sensor's `beams` should see from `poses` `(N, m, 3)`, inf beyond its range.

    Every beam is a pose of its own with one bearing: so rows whose nominal sensors differ need no loop.
    """
    assert robot.map is not None
    model = robot.sensors[sensor]
    device: Any = model.sensor
    rows, count = poses.shape[:2]
    offsets = np.zeros((rows, count, 3))
    for column, value in enumerate((model.mount.x, model.mount.y, model.mount.heading)):
        offsets[:, :, column] = value
    eyes = compose(poses.reshape(-1, 3), offsets.reshape(-1, 3)).reshape(rows, count, 1, 3)
    bearings = np.broadcast_to(device.bearings(), (rows, model.size))[:, None, beams]
    rays = np.repeat(eyes, len(beams), axis=2)
    rays[..., 2] += bearings
    ranges = robot.map.cast_rays(rays.reshape(-1, 3), np.zeros(1), np.inf).reshape(rows, count, len(beams))
    return np.where(ranges > device.range_max[:, :, None], np.inf, ranges)


def hall() -> Map:
    """A hall with a pillar and an alcove, so that no two places look alike."""
    walls = [
        (0, 0, 10, 0),
        (10, 0, 10, 5),
        (10, 5, 7, 5),
        (7, 5, 7, 8),
        (7, 8, 0, 8),
        (0, 8, 0, 0),
        (3, 5, 4, 5),
        (4, 5, 4, 6),
        (4, 6, 3, 6),
        (3, 6, 3, 5),
    ]
    return Map.from_segments(np.array(walls, dtype=float), resolution=0.02)


def lost_robots(estimators: dict[str, Estimator], offset: float, *, errors: bool = True) -> Scenario:
    """Two robots with a bad wheel, whose nominal start is `offset` [m] from the true one."""
    deviations = {"pose.x": Deviation(add=offset), "pose.y": Deviation(add=-offset)}
    if errors:
        deviations["drive.wheel_radius_left"] = Deviation(scale=1.02)
    world = hall()
    robots = [
        Robot(
            name=name,
            shape=Shape.circle(0.25),
            drive=Differential(wheel_radius_left=0.1, wheel_radius_right=0.1, track=track, rate_max=20.0),
            sensors={
                "encoder": Encoder(counts_per_revolution=4096.0),
                "laser": MountedSensor(
                    sensor=Laser(beams=61, fov=fov),
                    mount=Mount(x=0.1),
                    noise=(NoiseElement(name="white", noise=Gaussian(std=0.01)),),
                ),
            },
            ground=SLIP,
            estimators={**estimators, "odometry": DeadReckoning()},
            controller=Weave(middle=(4.5, 6.5), swing=(1.0, 1.0)),
            errors=deviations,
            pose=Pose(x=x, y=2.2),
            knowledge=Knowledge(map=world),
        )
        for name, x, track, fov in (("a", 2.4, 0.4, 4.0), ("b", 6.5, 0.35, 5.0))
    ]
    return Scenario(map=world, robots=robots)


def position_errors(true: Array, estimated: Array) -> Array:
    """Distances [m] between true and estimated positions."""
    return np.hypot(true[:, 0] - estimated[:, 0], true[:, 1] - estimated[:, 1])
