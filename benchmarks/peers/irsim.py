"""IR-SIM (Python on shapely): a world from YAML, robots as circles, a lidar on each."""

from __future__ import annotations

import contextlib
import importlib
import io
import json
import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.peers.base import Peer
from benchmarks.task import BEAMS, DT, FOV, RADIUS, RANGE_MAX, RANGE_STD, Task

__all__ = ["IrSim"]

Array = npt.NDArray[np.float64]

_FREE = 1e9  # no limit of speed or acceleration that a replayed twist could meet


class IrSim(Peer):
    """Differential robots that are given their twists; a bitmap goes in as IR-SIM's own obstacle map."""

    name = "IR-SIM"
    distribution = "ir-sim"
    computes = (
        "moves circles (differential), stops them on collision, and scans 181 beams against polygons, map and circles "
        "with white noise; no sonars, encoder, compass or gyro; commands replayed"
    )

    most_robots = 100  # with 1000 a step takes 20 s, and making them a minute

    @classmethod
    def prepare(cls) -> None:
        """Import it; it complains that there is no screen."""
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            importlib.import_module("irsim")

    def __init__(self, task: Task) -> None:
        irsim: Any = importlib.import_module("irsim")
        self._task = task
        self._ids = list(range(task.rows))
        width, height = task.world.size
        world: dict[str, Any] = {
            "width": width,
            "height": height,
            "step_time": DT,
            "control_mode": "auto",
            "collision_mode": "stop",
        }
        document: dict[str, Any] = {"world": world, "robot": [_robot(start) for start in task.starts.tolist()]}
        if task.world.map.segments is not None:
            lines = task.world.walls.reshape(-1, 2, 2).tolist()
            document["obstacle"] = [
                {"shape": {"name": "linestring", "vertices": line}, "state": [0.0, 0.0, 0.0]} for line in lines
            ]
        with tempfile.TemporaryDirectory() as folder:
            if task.world.map.segments is None:
                # An image has its first row at the top, and is dark where it is occupied.
                image = Path(folder) / "map.png"
                pillow: Any = importlib.import_module("PIL.Image")
                pillow.fromarray(np.flipud(255 * (1 - task.world.cells)).astype(np.uint8)).save(image)
                world["obstacle_map"] = str(image)
            file = Path(folder) / "world.yaml"
            file.write_text(json.dumps(document), encoding="utf-8")  # JSON is YAML
            self._env = irsim.make(str(file), display=False, save_ani=False, log_level="ERROR")
        self._robots = list(self._env.robot_list)

    def reset(self) -> None:
        """Reset the environment."""
        self._env.reset()

    def step(self, index: int) -> None:
        """One step with each robot's twist."""
        self._env.step(list(self._task.twists[index]), self._ids)

    def ranges(self) -> Array:
        """What the lidars hold."""
        return np.array([robot.lidar.range_data for robot in self._robots])

    def poses(self) -> Array:
        """Of the robots."""
        return np.array([robot.state[:3, 0] for robot in self._robots])


def _robot(start: list[float]) -> dict[str, Any]:
    return {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": RADIUS},
        "state": [start[0], start[1], math.remainder(start[2], 2.0 * math.pi)],
        "vel_max": [_FREE, _FREE],
        "vel_min": [-_FREE, -_FREE],
        "acce": [_FREE, _FREE],
        "sensors": [
            {
                "name": "lidar2d",
                "range_min": 0.0,
                "range_max": RANGE_MAX,
                "angle_range": FOV,
                "number": BEAMS,
                "noise": True,
                "std": RANGE_STD,
            }
        ],
    }
