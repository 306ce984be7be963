"""How recorders are tried."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from amorsim.contracts import Recorder, RunInfo
from amorsim.controllers.goto import GoTo
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.motions import Loop
from amorsim.scenario.spec import MountedSensor, Obstacle, Pose, Robot, Scenario
from amorsim.sensors.encoder import Encoder
from amorsim.sensors.laser import Laser
from amorsim.simulation.simulation import Simulation
from amorsim.testing.failure import Who

__all__ = ["check_recorder"]

_STEPS = 12


def check_recorder(who: Who, recorder: Recorder) -> None:
    """Let copies of a recorder record a run of one replica and one of three, in which a robot meets a wall.

    It must end when it was never opened, when no step was made, and as it should; and let alone what it is given.
    """
    with who.calling("making another with its parameters, as each run does,"):
        copies = [recorder.fresh() for _ in range(4)]
    with who.calling("close() of one that was never opened"):
        copies[0].close()
    with tempfile.TemporaryDirectory() as folder:
        _write(who, copies[1], Path(folder) / "none", [0], 0)
        _write(who, copies[2], Path(folder) / "one", [0], _STEPS)
        _write(who, copies[3], Path(folder) / "three", [0, 1, 7], _STEPS)


def _write(who: Who, recorder: Recorder, folder: Path, replicas: list[int], steps: int) -> None:
    folder.mkdir()
    simulation = Simulation(_scenario(), replicas=replicas)
    info = RunInfo(folder=folder, dt=simulation.dt, replicas=simulation.replicas, with_sensors=True)
    with who.calling("open"), _let_alone(who, simulation.frames(), "open") as frames:
        recorder.open(info, frames)
    _write_obstacles(who, recorder, simulation)
    reported = 0
    for _ in range(steps):
        simulation.step()
        events = simulation.events
        with who.calling("write"), _let_alone(who, simulation.frames(), "write") as frames:
            recorder.write(frames, events[reported:])
        _write_obstacles(who, recorder, simulation)
        reported = len(events)
    assert not steps or reported  # the robot has met the wall
    with who.calling("close"):
        recorder.close()


def _write_obstacles(who: Who, recorder: Recorder, simulation: Simulation) -> None:
    frames = simulation.obstacle_frames()
    with who.calling("write_obstacles"), _let_alone(who, frames, "write_obstacles"):
        recorder.write_obstacles(frames)


class _let_alone:  # noqa: N801 - reads as a clause
    """Gives frames out, and looks whether they came back as they were."""

    def __init__(self, who: Who, frames: Sequence[Any], method: str) -> None:
        self._who, self._frames, self._method = who, frames, method
        self._before = dict(_arrays(frames))

    def __enter__(self) -> Any:
        self._copies = {name: array.copy() for name, array in self._before.items()}
        return self._frames

    def __exit__(self, kind: Any, *_: object) -> None:
        if kind is not None:
            return
        for name, array in self._before.items():
            same = array.tobytes() == self._copies[name].tobytes()
            self._who.require(same, "given", f"{self._method}: {name}", "it let alone", "other values in it")


def _arrays(things: Any, name: str = "frames") -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    if isinstance(things, np.ndarray):
        yield name, things
    elif isinstance(things, Mapping):
        for key, value in things.items():
            yield from _arrays(value, f"{name}[{key!r}]")
    elif hasattr(things, "_fields"):
        for key in things._fields:
            yield from _arrays(getattr(things, key), f"{name}.{key}")
    elif isinstance(things, Sequence) and not isinstance(things, str):
        for index, value in enumerate(things):
            yield from _arrays(value, f"{name}[{index}]")


def _scenario() -> Scenario:
    drive = Differential(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.35, rate_max=15.0)
    sensors = {
        "encoder": MountedSensor(sensor=Encoder(counts_per_revolution=1000.0)),
        "laser": MountedSensor(sensor=Laser(beams=5, range_max=3.0)),
    }
    room = Map.from_segments(np.array([(0, 0, 4, 0), (4, 0, 4, 3), (4, 3, 0, 3), (0, 3, 0, 0.0)]), resolution=0.05)
    driver = Robot(
        name="driver",
        shape=Shape.circle(0.2),
        drive=drive,
        sensors=sensors,
        estimators={"dead_reckoning": DeadReckoning()},
        pose=Pose(x=3.5, y=1.0),
        controller=GoTo(x=9.0, y=1.0, speed=1.0),
    )
    # A second one without sensors, of another group: its columns are not those of the first.
    bare = attrs.evolve(driver, name="bare", sensors={}, estimators={}, controller=None, pose=Pose(x=1.0, y=2.0))
    # Two groups of obstacles: one stands, one moves.
    post = Obstacle(name="post", shape=Shape.circle(0.1), pose=Pose(x=0.5, y=0.5))
    cart = Obstacle(name="cart", shape=Shape.circle(0.1), motion=Loop(waypoints=((2.0, 0.5), (2.0, 1.5))))
    return Scenario(map=room, robots=[driver, bare], obstacles=[post, cart])
