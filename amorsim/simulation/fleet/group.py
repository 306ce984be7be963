"""A group: robots whose component classes, names and shape-fixing fields are equal, as rows of one set of arrays."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NoReturn

import attrs
import numpy as np

from amorsim.arrays import AnyArray, Array, Ints
from amorsim.contracts import (
    Beliefs,
    Context,
    Drive,
    DriveBinding,
    Estimate,
    Frame,
    Measurement,
    State,
)
from amorsim.core.errors import AmorsimError
from amorsim.core.execution.workers import in_turn
from amorsim.core.poses import compose, exponential
from amorsim.core.rows import stack, take
from amorsim.kernels.collision.paths import ARC, OTHER
from amorsim.kernels.kinematics.poses import logarithm, mean_twists
from amorsim.kernels.text import digest
from amorsim.scenario.spec import Robot, Zone
from amorsim.simulation.contact.moved_parts import Parts
from amorsim.simulation.contact.sliding import arcs, bounds, displaced, part_bounds
from amorsim.simulation.error_context import ErrorContext, of_drive
from amorsim.simulation.estimation.beliefs import BeliefsNow, beliefs_of_step
from amorsim.simulation.estimation.estimating import Estimators
from amorsim.simulation.estimation.first_beliefs import BELIEF, first_beliefs
from amorsim.simulation.fleet.alike import channels_of, poses_of, reading_size, robot_model
from amorsim.simulation.fleet.controlling import Driver
from amorsim.simulation.fleet.drive_check import check_drive
from amorsim.simulation.fleet.zones import Zones, contact_points
from amorsim.simulation.row_clock import RowClock
from amorsim.simulation.schedule import Call
from amorsim.simulation.sensing.copies import Copies
from amorsim.simulation.sensing.device import Device, place_mounts
from amorsim.simulation.sensing.noise_chain import Chain, Streams
from amorsim.simulation.sensing.plain_noise import PlainNoise
from amorsim.simulation.truth import true_robots
from amorsim.simulation.world.sensor_view import GroupView
from amorsim.simulation.world.world import World

__all__ = ["Group"]

_FLOAT = np.dtype(np.float64)

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
        joints = len(robots[0].drive.joints)
        self.true_pose, self.true_twist = np.zeros((self.rows, 3)), np.zeros((self.rows, 3))
        self.joints, self.joints_before = np.zeros((self.rows, joints)), np.zeros((self.rows, joints))
        self.joint_rates = np.zeros((self.rows, joints))
        self._moved_joints = np.zeros((2, self.rows, joints))  # positions and rates after the step
        self._after = self._moved_joints[0]
        self._ground_after = self._after  # the joints that match the wheels' travel over the ground
        self._drive_command = np.zeros((self.rows, len(robots[0].drive.channels)))
        self._slide: Array | None = None  # of the step, if the ground of any row makes one
        self.fingerprint = np.zeros((self.rows, 2), dtype=np.uint64)
        first = robots[0]
        self.ends_on_collision = first.on_collision == "end"
        self.streams = Streams(seed, self.names, self.row_clock.counter, world.workers)
        self.drive_draws = self.streams.draws("drive")
        self._belief_draws = self.streams.draws(*BELIEF)
        self.ground = Chain(first.ground, self.streams, self.whose, "ground")
        self.zones = Zones(zones, self.rows, self.streams, self.whose)
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
        self.drive: Drive = first.drive
        # The columns of each commanded device in a command, after the drive's.
        self.devices: dict[str, slice] = {}
        count = len(first.drive.channels)
        for name, unit in first.sensors.items():
            if unit.sensor.channels:
                self.devices[name] = slice(count, count + len(unit.sensor.channels))
                count += len(unit.sensor.channels)
        self.channels = channels_of(first)
        self.command = np.zeros((self.rows, len(self.channels)))
        draws = self.streams.draws("controller")
        self.driver = Driver(self.rows, self.channels, len(first.drive.channels), draws, self.whose)
        self.rolling = np.flatnonzero([joint.rolls for joint in first.drive.joints])
        self.parts: Parts | None = None
        self.set_parameters()
        self.start()
        if first.drive.parts:
            self.parts = Parts(self, world)

    # ------------------------------------------------------------------------------------------------- parameters

    def set_parameters(self) -> None:
        """Stack the components again from the specification of every row."""
        true = true_robots(self.specified, self.row_clock.replica, self.seed)
        self.true = true
        self.drive = stack([robot.drive for robot in true])
        self.ground.set_parameters([robot.ground for robot in true])
        for name, unit in self.sensors.items():
            unit.set_parameters([robot.sensors[name] for robot in true], self.dt)
        nominal = self.specified
        sizes = {name: unit.size for name, unit in self.sensors.items()}
        self.robot = robot_model(nominal, sizes, self.channels, self.dt)
        check_drive(self.drive, self.rows, self.whose)
        self._radius = self._rolling_radius()
        self.estimators.set_parameters(nominal)
        self.driver.set_parameters(nominal)
        self._asked = self.robot  # the robot as its controller knows it: with what its estimators believe
        if believers := self.estimators.believers():
            self._asked = attrs.evolve(self.robot, beliefs=BeliefsNow(believers))
        self.is_bound = False

    @of_drive
    def _rolling_radius(self) -> Array:
        return np.ascontiguousarray(self.drive.rolling_radius())

    # ---------------------------------------------------------------------------------------------------- episodes

    @of_drive
    def _start_drive(self, context: Context) -> State:
        return dict(self.drive.start(context))

    def start(self) -> None:
        """Start an episode in every row. Sensing and estimating follow when all bodies are placed."""
        rows = self.rows
        nominal, true = poses_of(self.specified), poses_of(self.true)
        is_drawn = ~np.isnan(self.drawn_start)
        starts = np.where(is_drawn, self.drawn_start, nominal)
        pose, covariance = first_beliefs(self.specified, starts, self._belief_draws)
        context = Context(rows=rows, dt=self.dt, robot=self.robot, pose=pose, names=self.names, covariance=covariance)
        self.true_pose[:] = np.where(is_drawn, starts + (true - nominal), true)
        for array in (self.true_twist, self.joints, self.joints_before, self.joint_rates, self.command):
            array[:] = 0.0
        self.drive_state: State = self._start_drive(context)
        self.ground.states = self.ground.start(attrs.evolve(context, size=len(self.rolling)))
        self.zones.start(attrs.evolve(context, size=len(self.rolling)))
        for unit in self.sensors.values():
            unit.start(attrs.evolve(context, size=unit.size))
        self.estimators.start(context)
        self.driver.start(attrs.evolve(context, robot=self._asked))
        self._moved_joints[:] = 0.0
        self._ground_after = self._after
        self._slide = None
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

    @property
    def label(self) -> str:
        """The robots, as the schedule names them."""
        robots = sorted(set(self.names))
        others = f" and {len(robots) - 1} more" if len(robots) > 1 else ""
        return f"{robots[0]}{others}" + (f" x {self.rows}" if self.rows > 1 else "")

    def bind(self) -> None:
        """Prepare what each step calls, for the present parameters and states."""
        devices = list(self.sensors.values())
        self._noise = PlainNoise(devices, self.rows)
        self._after = self._moved_joints[0]
        self._ground_after = self._after.copy() if self.ground.elements or self.zones else self._after
        self._place_mounts = place_mounts(devices, self.true_pose) if devices else None
        self._senses = [(device, device.bind(self)) for device in devices]
        live = {name: device.live for name, device in self.sensors.items()}
        given = live, Copies(live)
        clock = self.row_clock
        self._estimates = self.estimators.bind(self.robot, *given, self.command, clock)
        self._control = self.driver.bind(self._asked, *given, self.estimators.first, clock, self.command)
        self._advance = self.drive.bind(
            DriveBinding(
                rows=self.rows,
                dt=self.dt,
                joints=self.joints_before,
                joint_rates=self.joint_rates,
                command=self.command[:, : len(self.drive.channels)] if not self.devices else self._drive_command,
                state=self.drive_state,
                draws=self.drive_draws,
                out=self._moved_joints,
                answer=self._take_joints,
            )
        )
        results = [self.true_pose, self.joints, self.command]
        for estimate in self.estimates.values():
            results += [estimate.pose, estimate.covariance.reshape(self.rows, 9)]
        for unit in devices:
            results += [unit.true, unit.measured]
        self._record = digest.bind_absorb(results, self.fingerprint)
        self.is_bound = True

    _BOUND = ("_noise", "_place_mounts", "_senses", "_control", "_estimates", "_advance", "_record", "_motion")

    def __getstate__(self) -> dict[str, Any]:
        """All but what is bound, which a copy prepares again."""
        return {name: value for name, value in vars(self).items() if name not in self._BOUND} | {"is_bound": False}

    def unbind(self) -> None:
        """Drop what is bound: it refers to the group in a circle, which would keep the map in memory."""
        self.is_bound = False
        for name in self._BOUND:
            vars(self).pop(name, None)
        for device in self.sensors.values():
            device.unbind()

    def _take_joints(self, joints: Array, rates: Array) -> None:
        """Take what the drive's `advance` returned."""
        self._moved_joints[0], self._moved_joints[1] = joints, rates

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
        yield Call("actuate", f"{self.label} / drive: {type(self.drive).__name__}", self._move_joints, self.blame)
        if self.ground.elements or self.zones:
            yield Call("actuate", f"{self.label} / ground", self._move_over_ground, self.blame)

    def blame(self, error: BaseException) -> NoReturn:
        """Raise the drive's exception as `ErrorContext.blame` does."""
        self.whose.blame("drive", self.drive, error)

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

    # ------------------------------------------------------------------------------------------------------- phases

    def _actuate_device(self, device: Device, columns: slice) -> None:
        device.sensor.actuate(self.command[:, columns].copy(), self.dt, device.state, device.draws)

    def _move_joints(self) -> None:
        """Move the joints by the command."""
        np.copyto(self.joints_before, self.joints)
        if self.devices:
            np.copyto(self._drive_command, self.command[:, : len(self.drive.channels)])
        self._advance()
        np.copyto(self.joint_rates, self._moved_joints[1])

    def _move_over_ground(self) -> None:
        """Let ground effects act on the rolling joints."""
        elapsed = self.row_clock.step
        ground, self._slide = self._after, None
        if self.ground.elements:
            before = self.joints_before[:, self.rolling]
            travel = (self._after[:, self.rolling] - before) * self._radius
            ground = self._after.copy()
            slipped = self.ground.corrupt(travel, {}, elapsed)
            ground[:, self.rolling] = before + slipped / self._radius
            if self.ground.slides:
                self._slide = self.ground.slide(self.drive.twist(self.joints_before, ground), elapsed)
        if self.zones:
            ground, slide = self.zones.passed(
                self.drive, self.joints_before, ground, self.rolling, self._radius, self.true_pose, elapsed
            )
            if slide is not None:
                self._slide = slide if self._slide is None else self._slide + slide
        self._ground_after[...] = ground

    # The group as a mover (`amorsim.simulation.contact.resolve.Mover`): its bodies go where their wheels roll them.

    @of_drive
    def travel(self) -> Array:
        """Bounds of the paths: length [m] and turning [rad] `(N, 2)`."""
        return bounds(self.drive.travel(self.joints_before, self._ground_after), self._slide)

    def bind_path(self, motion: Array, travel: Array) -> tuple[int, Callable[[], None]]:
        """The form of the paths, and a function for their parameters: arcs, except for drives that define others."""
        drive, joints = self.drive, (self.joints_before, self._ground_after)
        self._motion = motion
        self._form = ARC if drive.goes_on_arcs else OTHER
        if drive.goes_on_arcs:
            calls = [drive.bind_twist(*joints, motion)]
        else:
            calls = [drive.bind_displacement(*joints, motion), drive.bind_travel(*joints, travel)]
        if self.ground.elements or self.zones:
            calls.append(functools.partial(self._add_slide, motion, travel))
        return self._form, in_turn(calls)

    def _add_slide(self, motion: Array, travel: Array) -> None:
        """Add the slide of this step, if there is one, to what the wheels make."""
        if self._slide is None:
            return
        if self._form == ARC:
            motion[:] = arcs(motion, self._slide)
        else:
            motion[:] = self._moved(np.ones((self.rows, 1)))
            travel[:] = bounds(travel, self._slide)

    def bad_motion(self, motion: Array) -> AmorsimError:
        """The error for displacements that are not all finite."""
        return self.whose.not_finite("drive", self.drive, "the displacement", motion)

    def _moved(self, fraction: Array) -> Array:
        """The bodies' displacements `(N, 3)` at fractions `(N, 1)` of the step."""
        return displaced(self.drive, self.joints_before, self._ground_after, self._slide, fraction)

    @of_drive
    def poses_at(self, which: Ints, fraction: Array) -> Array:
        """Poses of some of the bodies at fractions of the step."""
        drive, slide = take(self.drive, which), None if self._slide is None else self._slide[which]
        displacement = displaced(drive, self.joints_before[which], self._ground_after[which], slide, fraction[:, None])
        return compose(self.true_pose[which], displacement)

    @of_drive
    def part_travel(self) -> Array:
        """Bounds of the parts' paths: length [m] and turning [rad] `(N, p, 2)`."""
        return part_bounds(self.drive.part_travel(self.joints_before, self._ground_after), self._slide)

    @of_drive
    def parts_at(self, which: Ints, fraction: Array) -> tuple[Array, Array]:
        """Poses of robots if they stopped at fractions `(Q, 1)`, and of their parts in their frames `(Q, p, 3)`."""
        drive, poses = take(self.drive, which), self.true_pose[which]
        before, ground, after = self.joints_before[which], self._ground_after[which], self._after[which]
        slide = None if self._slide is None else self._slide[which]
        displacement = displaced(drive, before, ground, slide, fraction)
        joints = np.where(fraction < 1.0, drive.between(before, after, fraction), after)
        return compose(poses, displacement), drive.part_poses(drive.follow(joints, displacement))

    def bind_arrival(self, poses: Array, stop: Array) -> Callable[[], None]:
        """A function that takes the poses `(N, 3)` after contact, and stops the wheels of robots in contact."""
        calls = [functools.partial(self._arrive, poses, stop)]
        if type(self.drive).follow is not Drive.follow:
            calls.append(functools.partial(self._follow, stop))
        if self.zones:
            calls.append(functools.partial(self._halt_in_zones, stop))
        return in_turn(calls)

    def _arrive(self, poses: Array, stop: Array) -> None:
        if self._form == ARC:
            is_short = mean_twists(self._motion, stop, self.dt, self.true_twist)
        else:
            if is_short := bool((stop < 1.0).any()):
                np.copyto(self._motion, self._moved(stop[:, None]), where=(stop < 1.0)[:, None])
            logarithm(self._motion, self.true_twist)
            self.true_twist /= self.dt
        if is_short:
            self._halt(stop)
        np.copyto(self.true_pose, poses)
        np.copyto(self.joints, self._after)

    def _follow(self, stop: Array) -> None:
        """Let passive joints follow the body's motion."""
        displacement = exponential(self._motion, stop[:, None]) if self._form == ARC else self._motion
        self.joints[:] = self.drive.follow(self._after, displacement)
        self.joint_rates += (self.joints - self._after) / self.dt

    def _halt_in_zones(self, stop: Array) -> None:
        if (stop < 1.0).any():
            self.zones.halt(stop < 1.0, contact_points(self.drive, self.joints, self.true_pose))

    def _halt(self, stop: Array) -> None:
        """Stop the wheels of robots in contact at the fraction `(N,)` of the step at which they touched."""
        stopped = (stop < 1.0)[:, None]
        between = self.drive.between(self.joints_before, self._after, stop[:, None])
        np.copyto(self._after, between, where=stopped)
        np.copyto(self.joint_rates, 0.0, where=stopped)

    def record(self) -> None:
        """Mix the step's exact results into the fingerprint of each row."""
        for mix in self._record:
            mix()

    # ---------------------------------------------------------------------------------------------------- for others

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

    @property
    def mean_rates(self) -> Array:
        """Mean rates of the joints over the step `(N, j)` [rad/s]; those at its end are `joint_rates`."""
        return (self.joints - self.joints_before) / self.dt

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
            joint_rates=self.mean_rates,
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
        found = {"drive": self.drive_state, "controller": self.driver.state}
        found |= {f"estimator {name}": state for name, state in self.estimators.states.items()}
        found |= {f"ground {name}": s for name, s in zip(self.ground.names, self.ground.states, strict=True)}
        found |= self.zones.states()
        for name, unit in self.sensors.items():
            found[f"sensor {name}"] = unit.state
            for element, state in zip(unit.chain.names, unit.chain.states, strict=True):
                found[f"sensor {name} noise {element}"] = state
        return found

    def arrays(self) -> dict[str, Arrays]:
        """The engine's own arrays that change, by unit and name; after writing into them, it is to be bound again."""
        body = ("true_pose", "true_twist", "joints", "joints_before", "joint_rates", "command", "fingerprint")
        found: dict[str, Arrays] = {"body": {name: getattr(self, name) for name in body}}
        for name, estimate in self.estimates.items():
            found[f"estimate {name}"] = {"pose": estimate.pose, "covariance": estimate.covariance}
        for name, unit in self.sensors.items():
            found[f"sensor {name}"] = unit.arrays()
        found["driver"] = self.driver.arrays()
        if self.parts is not None:
            found["parts"] = self.parts.arrays()
        return found
