"""What robots cost that differ from the shipped Pioneer in one thing: a sensor, an element of noise, an estimator.

All follow commands in the office with a hall, in turn, round after round, and so do the peers. A row of amorsim's tells
how many times as long as the plain Pioneer's its step takes; a peer's, how much faster than it amorsim is with that
robot.
"""

from __future__ import annotations

import collections
import functools
import importlib.util
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am
from benchmarks import worlds
from benchmarks.contest import Clock, drive
from benchmarks.ours import Ours, UnderWay, given, pioneer
from benchmarks.peers.base import Contender, Peer
from benchmarks.results import Row, ratio_of
from benchmarks.task import DT

__all__ = ["measure"]

SECTION = "compositions"
Array = npt.NDArray[np.float64]
_STEPS = 60
_AT_LEAST = 0.4  # s timed in a round
_AT_MOST = 1.5  # s, after which a peer that is watched makes no new step; it is timed over as many
_RATES = (1.2, 1.8)  # rad/s of the wheels: a slow circle
_PLAIN = "as shipped, commands given"
_PYTHON = "a user's controller in Python"
_EKF = "an EKF of a plugin for dead reckoning"
_LESS = {_PYTHON: "the same, less the controller's own time", _EKF: "the same, less the EKF's own time"}


class _Own:
    """Seconds that code which is not amorsim's took, by the clock of the contest."""

    seconds = 0.0
    clock: Clock = staticmethod(time.perf_counter)


@attrs.frozen(kw_only=True)
class Heading(am.Sensor):
    """A sensor as a plugin has it, in NumPy: the heading in the world."""

    unit = "rad"

    def size(self, drive: am.Drive) -> int:
        """One value."""
        return 1

    def sense(self, view: am.View, aim: am.Aim, state: Any, draws: Any) -> tuple[Array, Mapping[str, Array]]:
        """Headings `(N, 1)` [rad]."""
        return view.pose[:, 2:].copy(), {}


def _by_python(readings: Any, _estimate: Any, _clock: Any, speed: float = 0.1) -> tuple[float, float]:
    """A user's controller: one robot, plain Python; it keeps count of its time."""
    began = _Own.clock()
    command = speed, 0.05 if readings["laser"].measured.min() > 0.3 else -0.05
    _Own.seconds += _Own.clock() - began
    return command


def measure(rounds: int, quick: bool, peers: list[type[Peer]], clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """The rows, of one robot, in turn with the peers, and of a thousand replicas of it."""
    rows: list[Row] = []
    _Own.clock = staticmethod(clock)
    for replicas, steps in ((1, _STEPS), (1000, 5)):
        if quick:
            replicas, steps = min(replicas, 50), min(steps, 10)
        where = f"{replicas} row{'s' if replicas > 1 else ''}"
        say(f"compositions: {where}")
        sides = {name: _side(make, replicas) for name, make in _COMPOSITIONS.items()}
        with_peers = _contenders(peers, steps) if replicas == 1 else []
        found: dict[str, list[float]] = collections.defaultdict(list)
        theirs: list[list[float]] = [[] for _ in with_peers]
        at_least = 0.05 if quick else _AT_LEAST
        for number in range(rounds):
            say(f"compositions: {where}, round {number + 1}")
            for name, side in sides.items():
                _Own.seconds = 0.0
                made = drive(side, steps, at_least, clock)
                found[name].append(made.seconds / made.steps * 1e6)
                if name in _LESS:
                    found[_LESS[name]].append((made.seconds - _Own.seconds) / made.steps * 1e6)
            for peer, times in zip(with_peers, theirs, strict=True):
                times.append(peer.seconds_a_step(at_least, clock) * 1e6)
        plain = found[_PLAIN]
        for name, times in found.items():
            if name == _PLAIN:
                rows.append(_row(f"{_PLAIN}, {where}", "us a step", plain))
            else:
                ratios = [a / b for a, b in zip(times, plain, strict=True)]
                rows.append(_row(f"{name}, {where}", "times as long", ratios))
            for peer, its in zip(with_peers, theirs, strict=True):
                row = _row(f"{name}, {where}", "us a step", its)
                ratio = peer.ratio(ratio_of(times, its, less_is_better=True))
                conduct = peer.seen.conduct if name == _PLAIN else None
                rows.append(attrs.evolve(row, side=peer.name, ratio=ratio, conduct=conduct))
    return rows


def _row(setting: str, unit: str, rounds: list[float]) -> Row:
    return Row(section=SECTION, setting=setting, side="amorsim", unit=unit, rounds=tuple(rounds))


def _contenders(peers: list[type[Peer]], steps: int) -> list[Contender]:
    """Those that drive through bitmaps, on the plain Pioneer's way."""
    task, track = Ours(worlds.office_with_hall(), [_plain()]).task(steps)
    return [Contender.of(peer(task), track, steps, _AT_MOST) for peer in peers if peer.in_bitmaps]


def _plain() -> am.Robot:
    """The Pioneer on a circle to the left, in a room that holds it."""
    left, right = _RATES
    model = pioneer("rover", np.zeros(3))
    radius = 0.5 * model.drive.track * (right + left) / (right - left)  # type: ignore[attr-defined]
    x0, y0, x1, y1 = worlds.HALL
    x, y = next(
        (x, y)
        for x, y, _ in worlds.places(worlds.office_with_hall(), 50, radius + 0.4).tolist()
        if not (x0 < x < x1 and y0 < y < y1)
    )
    return attrs.evolve(model, controller=given(*_RATES), pose=am.Pose(x=x, y=y - radius))


def _side(make: Callable[[am.Robot], am.Robot | tuple[am.Robot, am.Obstacle]], replicas: int) -> UnderWay:
    made = make(_plain())
    robot, *obstacles = made if isinstance(made, tuple) else (made,)
    scenario = am.Scenario(map=worlds.office_with_hall().map, robots=[robot], obstacles=obstacles, dt=DT, seed=11)
    return UnderWay(am.Simulation(scenario, replicas=replicas))


def _laser(robot: am.Robot, **changes: Any) -> am.Robot:
    laser = attrs.evolve(robot.sensors["laser"], **changes)
    return attrs.evolve(robot, sensors=dict(robot.sensors) | {"laser": laser})


def _noisier(robot: am.Robot, element: am.Noise) -> am.Robot:
    return _laser(robot, noise=(*robot.sensors["laser"].noise, element))


def _with_post(robot: am.Robot) -> tuple[am.Robot, am.Obstacle]:
    assert robot.pose is not None
    far = worlds.places(worlds.office_with_hall(), 50, 1.0)
    place = far[int(np.argmax(np.hypot(far[:, 0] - robot.pose.x, far[:, 1] - robot.pose.y)))]
    return robot, am.Obstacle(name="post", shape=am.Shape.circle(0.1), pose=am.Pose(x=place[0], y=place[1]))


def _estimators(robot: am.Robot) -> am.Robot:
    return attrs.evolve(robot, estimators=dict(robot.estimators) | {"second": am.estimators.DeadReckoning()})


def _ekf(robot: am.Robot) -> am.Robot:
    """With the estimator of `plugins_example`, which keeps count of its time."""
    return attrs.evolve(robot, estimators={"ekf": _timed_ekf()(compass_std=0.05, heading_variance=0.01)})


@functools.cache
def _timed_ekf() -> Any:
    file = Path(__file__).parents[1] / "plugins_example" / "src" / "amorsim_example" / "compass_odometry.py"
    spec = importlib.util.spec_from_file_location("benchmarks_compass_odometry", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    base: Any = module.CompassOdometry

    @attrs.frozen(kw_only=True)
    class Timed(base):  # type: ignore[misc]
        def update(self, *arguments: Any) -> Any:
            began = _Own.clock()
            found = base.update(self, *arguments)
            _Own.seconds += _Own.clock() - began
            return found

    return Timed


def _car(controller: am.Controller) -> am.Robot:
    """Straight on, slowly, or on its own, in the hall."""
    start = am.RandomStart(random=worlds.HALL, clearance=2.0, per="study")
    return attrs.evolve(am.load_robot("car"), name="rover", controller=controller, start=start)


def _typical(robot: am.Robot) -> am.Robot:
    model = am.load_robot("pioneer2dx-typical")
    return attrs.evolve(model, name=robot.name, controller=robot.controller, pose=robot.pose)


_COMPOSITIONS: Mapping[str, Callable[[am.Robot], Any]] = {
    _PLAIN: lambda robot: robot,
    _PYTHON: lambda robot: attrs.evolve(robot, controller=_by_python),
    "a sensor of a plugin": lambda robot: attrs.evolve(robot, sensors=dict(robot.sensors) | {"heading": Heading()}),
    "two estimators": _estimators,
    "an obstacle, far away": _with_post,
    "laser at 5 Hz": lambda robot: _laser(robot, rate=5.0),
    "laser with latency": lambda robot: _laser(robot, latency=0.2),
    "dropout on the laser": lambda robot: _noisier(robot, am.noise.Dropout(probability=0.01)),
    "GPS": lambda robot: attrs.evolve(robot, sensors=dict(robot.sensors) | {"gps": am.sensors.Gps()}),
    "wheel slip": lambda robot: attrs.evolve(robot, ground=(am.noise.Slip(at=0.0, duration=1e9, factor=0.98),)),
    _EKF: _ekf,
    "an Ackermann car, commands given": lambda _: _car(given(0.0, 0.2)),
    "an Ackermann car, wandering": lambda _: _car(am.controllers.Wander(speed=0.3)),
    "pioneer2dx-typical": _typical,
}
