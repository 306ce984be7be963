"""amorsim's side of a fleet's contest: it drives by itself once, and all follow that way when they are timed."""

from __future__ import annotations

import functools
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am
from amorsim.simulation.state.snapshot import Snapshot
from benchmarks.results import mean_range
from benchmarks.task import DT, RADIUS, RANGE_MAX, RANGE_STD, Task, Track
from benchmarks.worlds import World

__all__ = ["DISCS", "PIONEER", "Ours", "UnderWay", "disc", "given", "pioneer"]

Array = npt.NDArray[np.float64]

PIONEER = (
    "moves a Pioneer 2DX by its wheels, sweeps its footprint against the cells, senses 181 beams, 16 sonars with "
    "cones, encoder, compass and gyro with all their noise, true and measured, and estimates its pose"
)
DISCS = (
    "moves discs by their wheels, sweeps them against the cells and one another, senses 181 beams with white noise "
    "against cells and discs and encoders, true and measured, and estimates poses"
)
_UNDER_WAY = 30  # steps before a contest begins, so that robots that start from rest are moving


def pioneer(name: str, pose: Array) -> am.Robot:
    """The Pioneer 2DX that ships, its laser moved to the base point, where the peers have theirs."""
    model = am.load("demo").robots[0]
    sensors = dict(model.sensors) | {"laser": attrs.evolve(model.sensors["laser"], mount=am.Mount())}
    return attrs.evolve(
        model, name=name, sensors=sensors, errors={}, controller=am.controllers.Wander(speed=0.4), pose=_pose(pose)
    )


def disc(name: str, pose: Array) -> am.Robot:
    """A disc with encoders and a laser with white noise, as the peers have it."""
    return am.Robot(
        name=name,
        shape=am.Shape.circle(RADIUS),
        drive=am.drives.Differential(wheel_radius_left=0.0825, wheel_radius_right=0.0825, track=0.33, rate_max=20.0),
        sensors={
            "encoder": am.sensors.Encoder(counts_per_revolution=39400.0),
            "laser": am.MountedSensor(
                sensor=am.sensors.Laser(range_max=RANGE_MAX), noise=(am.noise.Gaussian(std=RANGE_STD),)
            ),
        },
        estimators={"dead_reckoning": am.estimators.DeadReckoning()},
        controller=am.controllers.Wander(speed=0.4),
        on_collision="continue",
        pose=_pose(pose),
    )


@functools.cache  # robots of one group have controllers of one class
def given(*values: float) -> am.Controller:
    """A controller that gives one command for ever, without a thought."""

    @attrs.frozen(kw_only=True)
    class Given(am.Controller):
        def command(self, robot: Any, readings: Any, estimate: Any, clock: Any, state: Any, draws: Any) -> Array:
            return np.full((robot.rows, len(values)), values)

    return Given()


class UnderWay:
    """A simulation that has made some steps, and goes back to there."""

    def __init__(self, simulation: am.Simulation, steps: int = _UNDER_WAY) -> None:
        self.simulation = simulation
        for _ in range(steps):
            simulation.step()
        self._start: Snapshot = simulation.snapshot()

    def reset(self) -> None:
        """Go back to the start of the contest, to the bit."""
        self.simulation.restore(self._start)

    def step(self, index: int) -> None:
        """One step."""
        self.simulation.step()


class Ours:
    """A simulation under way, that can be put back to where a contest starts."""

    def __init__(self, world: World, robots: list[am.Robot], threads: int = 1, replicas: int = 1) -> None:
        self._world, self._robots, self._threads, self._replicas = world, robots, threads, replicas
        scenario = am.Scenario(map=world.map, robots=robots, dt=DT, seed=11)
        self.simulation = am.Simulation(scenario, threads=threads, replicas=replicas)
        self._commands = [self._stepped() for _ in range(_UNDER_WAY)]
        self._start: Snapshot = self.simulation.snapshot()

    def _stepped(self) -> Array:
        """Make a step; the command `(N, 2)` that was followed."""
        self.simulation.step()
        (frame,) = self.simulation.frames()
        return np.array(frame.command)

    def repeated(self, steps: int) -> Ours:
        """The same drive over again, by the commands that were given: the others get theirs too, and decide nothing."""
        self.reset()
        commands = np.array([*self._commands, *(self._stepped() for _ in range(steps))])
        controller = _repeating(commands)
        robots = [attrs.evolve(robot, controller=controller) for robot in self._robots]
        return Ours(self._world, robots, self._threads, self._replicas)

    def reset(self) -> None:
        """Go back to the start of the contest, to the bit."""
        self.simulation.restore(self._start)

    def step(self, index: int) -> None:
        """One step."""
        self.simulation.step()

    def scan(self) -> Array:
        """The true ranges `(N, beams)` [m] of the present scans."""
        return self.simulation.readings["laser"].true

    def task(self, steps: int) -> tuple[Task, Track]:
        """Drive `steps` steps, not timed: what the others have to do, and what was seen and driven.

        The twists are what the bodies really did, after limits of acceleration and after contact, so that a peer that
        follows them makes the same way.
        """
        self.reset()
        sim = self.simulation
        starts = sim.true_pose.copy()
        ranges, way, stopped, twists = [mean_range(self.scan(), RANGE_MAX)], [], [], []
        before = starts
        for _ in range(steps):
            sim.step()
            after = sim.true_pose.copy()
            drove = np.hypot(after[:, 0] - before[:, 0], after[:, 1] - before[:, 1])
            turned = after[:, 2] - before[:, 2]
            turned = np.arctan2(np.sin(turned), np.cos(turned))
            ahead = np.cos(before[:, 2]) * (after[:, 0] - before[:, 0])
            ahead += np.sin(before[:, 2]) * (after[:, 1] - before[:, 1])
            twists.append(np.column_stack([np.copysign(drove, ahead), turned]) / DT)
            ranges.append(mean_range(self.scan(), RANGE_MAX))
            way.append(drove.mean())
            stopped.append(np.mean((drove < 1e-9) & (np.abs(turned) < 1e-9)))
            before = after
        self.reset()
        task = Task(world=self._world, starts=starts, twists=np.array(twists))
        return task, Track(mean_range=np.array(ranges), way=np.array(way), stopped=np.array(stopped))


def _repeating(commands: Array) -> am.Controller:
    """Gives commands `(T, N, 2)`, one for each tick, to all robots, who must be of one group."""
    given = list(commands)  # looked up sooner than a part of an array is made

    @attrs.frozen(kw_only=True)
    class Repeat(am.Controller):
        def command(self, robot: Any, readings: Any, estimate: Any, clock: Any, state: Any, draws: Any) -> Array:
            now: Array = given[clock.tick.item(0)]
            return now

    return Repeat()


def _pose(pose: Array) -> am.Pose:
    return am.Pose(x=float(pose[0]), y=float(pose[1]), heading=float(pose[2]))
