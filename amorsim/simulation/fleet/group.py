"""A group: robots whose component classes, names and shape-fixing fields are equal, as rows of one set of arrays."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Ints
from amorsim.contracts import (
    Beliefs,
    Context,
    Drive,
    Estimate,
    Frame,
    Measurement,
    State,
)
from amorsim.kernels.text import digest
from amorsim.scenario.spec import Robot, Zone
from amorsim.simulation.contact.moved_parts import Parts
from amorsim.simulation.error_context import ErrorContext
from amorsim.simulation.estimation.beliefs import BeliefsNow, beliefs_of_step
from amorsim.simulation.estimation.estimating import Estimators
from amorsim.simulation.estimation.first_beliefs import BELIEF, first_beliefs
from amorsim.simulation.fleet.controlling import Driver
from amorsim.simulation.fleet.grouping import channels_of, poses_of, reading_size, robot_model
from amorsim.simulation.fleet.locomotion import Locomotion
from amorsim.simulation.row_clock import RowClock
from amorsim.simulation.schedule import Call
from amorsim.simulation.sensing.copied_readings import Copies
from amorsim.simulation.sensing.device import Device, place_mounts
from amorsim.simulation.sensing.noise_chain import Streams
from amorsim.simulation.sensing.plain_noise import PlainNoise
from amorsim.simulation.truth import true_robots
from amorsim.simulation.world.sensor_view import GroupView
from amorsim.simulation.world.world import World

__all__ = ["Group"]

Arrays = dict[str, AnyArray]


class Group:
    """Robots as rows: their specifications, the components stacked from them, and all that changes.

    Arrays of poses, joints, commands, readings and estimates keep their place: a step writes into them.
    """

    def __init__(
        self,
        robots: Sequence[Robot],
        bodies: Ints,
        replica: Ints,
        world: World,
        seed: int,
        dt: float,
        zones: Sequence[Zone] = (),
    ) -> None:
        self.specified = list(robots)
        self.names = [robot.name for robot in robots]
        self.rows = len(self.names)  # robots, over all replicas
        self._rows_by_name: dict[str, Ints] = {}
        self.bodies = bodies
        self.dt = dt
        self.seed = seed
        self.row_clock = RowClock(replica, dt)
        self.whose = ErrorContext("robot", self.names, self.row_clock)
        self.world = world
        self.drawn_start = np.full((self.rows, 3), np.nan)  # of a later episode, where starts are random
        self.is_bound = False  # whether `calls` are those for the present parameters and states
        self.fingerprint = np.zeros((self.rows, 2), dtype=np.uint64)
        first = robots[0]
        self.ends_on_collision = first.on_collision == "end"
        self.streams = Streams(seed, self.names, self.row_clock.counter, world.workers)
        self._belief_draws = self.streams.draws(*BELIEF)
        self.sensors = {
            name: Device(
                *(name, unit, reading_size(first, name), self.streams),
                *(self.whose, self.row_clock, GroupView(world, bodies, dt)),
            )
            for name, unit in first.sensors.items()
        }
        self.estimators = Estimators(
            {name: self.streams.draws("estimator", name) for name in first.estimators}, self.whose, self.row_clock
        )
        self.true: list[Robot] = []
        # The columns of each commanded device in a command, after the drive's.
        self.devices: dict[str, slice] = {}
        count = len(first.drive.channels)
        for name, unit in first.sensors.items():
            if unit.sensor.channels:
                self.devices[name] = slice(count, count + len(unit.sensor.channels))
                count += len(unit.sensor.channels)
        self.channels = channels_of(first)
        self.command = np.zeros((self.rows, len(self.channels)))
        self.label = _label(self.names)
        """The robots, as the schedule names them."""
        self.locomotion = Locomotion(first, zones, bodies, self.command, self.streams, self.whose, self.label, dt)
        self.true_pose, self.true_twist = self.locomotion.true_pose, self.locomotion.true_twist
        self.joints, self.joint_rates = self.locomotion.joints, self.locomotion.joint_rates
        draws = self.streams.draws("controller")
        self.driver = Driver(self.rows, self.channels, len(first.drive.channels), draws, self.whose)
        self.parts: Parts | None = None
        self.set_parameters()
        self.start()
        if first.drive.parts:
            self.parts = Parts(self.locomotion, world)

    # ------------------------------------------------------------------------------------------------- parameters

    def set_parameters(self) -> None:
        """Stack the components again from the specification of every row."""
        true = true_robots(self.specified, self.row_clock.replica, self.seed)
        self.true = true
        self.locomotion.set_parameters(true)
        for name, unit in self.sensors.items():
            unit.set_parameters([robot.sensors[name] for robot in true], self.dt)
        nominal = self.specified
        sizes = {name: unit.size for name, unit in self.sensors.items()}
        self.robot = robot_model(nominal, sizes, self.channels, self.dt)
        self.estimators.set_parameters(nominal)
        self.driver.set_parameters(nominal)
        self._asked = self.robot  # the robot as its controller knows it: with what its estimators believe
        if believers := self.estimators.believers():
            self._asked = attrs.evolve(self.robot, beliefs=BeliefsNow(believers))
        self.is_bound = False

    # ---------------------------------------------------------------------------------------------------- episodes

    def start(self) -> None:
        """Start an episode in every row. Sensing and estimating follow when all bodies are placed."""
        rows = self.rows
        nominal, true = poses_of(self.specified), poses_of(self.true)
        is_drawn = ~np.isnan(self.drawn_start)
        starts = np.where(is_drawn, self.drawn_start, nominal)
        pose, covariance = first_beliefs(self.specified, starts, self._belief_draws)
        context = Context(rows=rows, dt=self.dt, robot=self.robot, pose=pose, names=self.names, covariance=covariance)
        self.true_pose[:] = np.where(is_drawn, starts + (true - nominal), true)
        self.command[:] = 0.0
        self.locomotion.start(context)
        for unit in self.sensors.values():
            unit.start(attrs.evolve(context, size=unit.size))
        self.estimators.start(context)
        self.driver.start(attrs.evolve(context, robot=self._asked))
        self.fingerprint[:] = 0
        if self.parts is not None:
            self.parts.start()
        self.is_bound = False

    def rows_of(self, name: str) -> Ints:
        """The rows of a robot, in order of replica."""
        if name not in self._rows_by_name:
            self._rows_by_name[name] = np.flatnonzero([one == name for one in self.names])
        return self._rows_by_name[name]

    # ------------------------------------------------------------------------------------------------ the schedule

    def bind(self) -> None:
        """Prepare what each step calls, for the present parameters and states."""
        devices = list(self.sensors.values())
        self._noise = PlainNoise(devices, self.rows)
        self._place_mounts = place_mounts(devices, self.true_pose) if devices else None
        self._senses = [(device, device.bind(self.locomotion)) for device in devices]
        live = {name: device.live for name, device in self.sensors.items()}
        given = live, Copies(live)
        clock = self.row_clock
        self._estimates = self.estimators.bind(self.robot, *given, self.command, clock)
        self._control = self.driver.bind(self._asked, *given, self.estimators.first, clock, self.command)
        self.locomotion.bind()
        results = [self.true_pose, self.joints, self.command]
        for estimate in self.estimates.values():
            results += [estimate.pose, estimate.covariance.reshape(self.rows, 9)]
        for unit in devices:
            results += [unit.true, unit.measured]
        self._record = digest.bind_absorb(results, self.fingerprint)
        self.is_bound = True

    _BOUND = ("_noise", "_place_mounts", "_senses", "_control", "_estimates", "_record")

    def __getstate__(self) -> dict[str, Any]:
        """All but what is bound, which a copy prepares again."""
        return {name: value for name, value in vars(self).items() if name not in self._BOUND} | {"is_bound": False}

    def unbind(self) -> None:
        """Drop what is bound: it refers to the group in a circle, which would keep the map in memory."""
        self.is_bound = False
        for name in self._BOUND:
            vars(self).pop(name, None)
        self.locomotion.unbind()
        for device in self.sensors.values():
            device.unbind()

    def control_calls(self) -> Iterator[Call]:
        """The call for the commands of all robots."""
        controller = self.driver.controller
        what = "no controller" if controller is None else f"controller: {type(controller).__name__}"
        yield Call("control", f"{self.label} / {what}", self._control, self.driver.blame)

    def actuate_calls(self) -> Iterator[Call]:
        """The calls that move joints: those of devices that take commands, the drive's, and what the ground does."""
        for name, columns in self.devices.items():
            device = self.sensors[name]
            act = functools.partial(self._actuate_device, device, columns)
            yield Call("actuate", f"{self.label} / {name}: {type(device.sensor).__name__}", act, device.blame)
        yield from self.locomotion.actuate_calls()

    def estimate_calls(self) -> Iterator[Call]:
        """The calls that update the estimators."""
        for name, update, blame in self._estimates:
            yield Call("estimate", f"{self.label} / {name}", update, blame)
        if self._estimates:
            yield Call("estimate", f"{self.label} / check of numbers", self.estimators.conclude)

    def sense_calls(self) -> Iterator[Call]:
        """The calls that read all sensors, one after another, and the noise of those that are plain."""
        label = self.label
        for device, sense in self._senses:
            yield Call("sense", f"{label} / {device.name}: {type(device.sensor).__name__}", sense, device.blame)
        if self._noise.devices:
            yield Call("sense", f"{label} / noise of {self._noise.names}", self._noise.apply)

    def place_calls(self) -> Iterator[Call]:
        """The call that puts the mounts of all sensors to where the robots are."""
        if self._place_mounts is not None:
            yield Call("sense", f"{self.label} / mounts", self._place_mounts)

    def _actuate_device(self, device: Device, columns: slice) -> None:
        device.sensor.actuate(self.command[:, columns].copy(), self.dt, device.state, device.draws)

    def record(self) -> None:
        """Mix the step's exact results into the fingerprint of each row."""
        for mix in self._record:
            mix()

    # ---------------------------------------------------------------------------------------------------- for others

    @property
    def drive(self) -> Drive:
        """The drives, with true parameters."""
        return self.locomotion.drive

    @property
    def readings(self) -> Mapping[str, Measurement]:
        """The current readings, as the robots receive them, in copies."""
        return Copies({name: device.live for name, device in self.sensors.items()})

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The estimate of every estimator; the controller receives the first."""
        return self.estimators.estimates

    @property
    def estimate(self) -> Estimate:
        """The estimate that the controller receives."""
        return self.estimators.first

    def frame(self) -> Frame:
        """The step for recorders, in copies: a recorder that writes into an array moves no robot."""
        clock = self.row_clock
        parts = self.drive.parts
        return Frame(
            names=self.names,
            replica=clock.replica,
            tick=clock.tick.flatten(),
            time=clock.time.flatten(),
            true_pose=self.true_pose.copy(),
            true_twist=self.true_twist.copy(),
            joint_names=[joint.name for joint in self.drive.joints],
            joint_rates=self.locomotion.mean_rates,
            estimates={name: Estimate(its.pose.copy(), its.covariance.copy()) for name, its in self.estimates.items()},
            readings={name: (unit.true.copy(), unit.reading) for name, unit in self.sensors.items()},
            channels=self.channels,
            command=self.command.copy(),
            robot=self.robot,
            parts=tuple(part.name for part in parts),
            part_pose=np.empty((self.rows, 0, 3)) if self.parts is None else self.parts.per_robot,
            beliefs=self.beliefs(),
        )

    def beliefs(self) -> Mapping[str, Beliefs]:
        """The beliefs of the estimators, by name, and of the controller, as ``"controller"``, where they have any.

        Of an estimator with the name ``"controller"`` and the controller, the estimator's are there.
        """
        believers = self.estimators.believers()
        if self.driver.believes:
            believers.setdefault("controller", self.driver.beliefs)
        return beliefs_of_step(believers, lambda: self.estimators.updates)

    def states(self) -> Mapping[str, State]:
        """The states of all components, by their place; the dicts themselves, not copies."""
        found = {**self.locomotion.states(), "controller": self.driver.state}
        found |= {f"estimator {name}": state for name, state in self.estimators.states.items()}
        for name, unit in self.sensors.items():
            found[f"sensor {name}"] = unit.state
            for element, state in zip(unit.chain.names, unit.chain.states, strict=True):
                found[f"sensor {name} noise {element}"] = state
        return found

    def arrays(self) -> dict[str, Arrays]:
        """The engine's own arrays that change, by unit and name; after writing into them, it is to be bound again."""
        own = {"command": self.command, "fingerprint": self.fingerprint}
        found: dict[str, Arrays] = {"body": self.locomotion.arrays() | own}
        for name, estimate in self.estimates.items():
            found[f"estimate {name}"] = {"pose": estimate.pose, "covariance": estimate.covariance}
        for name, unit in self.sensors.items():
            found[f"sensor {name}"] = unit.arrays()
        found["driver"] = self.driver.arrays()
        if self.parts is not None:
            found["parts"] = self.parts.arrays()
        return found


def _label(names: Sequence[str]) -> str:
    """The robots of these rows, as the schedule names them."""
    robots = sorted(set(names))
    others = f" and {len(robots) - 1} more" if len(robots) > 1 else ""
    return f"{robots[0]}{others}" + (f" x {len(names)}" if len(names) > 1 else "")
