"""Locomotion of a group: drives move the joints by commands, and over the ground the bodies by the joints."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NoReturn

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Array, Ints
from amorsim.contracts import Context, Drive, DriveBinding, State
from amorsim.core.errors import AmorsimError
from amorsim.core.execution.workers import in_turn
from amorsim.core.poses import compose, exponential
from amorsim.core.rows import stack, take
from amorsim.kernels.collision.paths import ARC, OTHER
from amorsim.kernels.kinematics.poses import logarithm, mean_twists
from amorsim.scenario.spec import Robot, Zone
from amorsim.simulation.contact.sliding import arcs, bounds, displaced, part_bounds
from amorsim.simulation.error_context import ErrorContext, of_drive
from amorsim.simulation.fleet.drive_check import check_drive
from amorsim.simulation.fleet.zones import Zones, contact_points
from amorsim.simulation.schedule import Call
from amorsim.simulation.sensing.noise_chain import Chain, Streams

__all__ = ["Locomotion"]


class Locomotion:
    """The true drives of a group's robots, with the ground under them: a `Mover` of `amorsim.simulation.contact`.

    Attributes
    ----------
    true_pose, true_twist
        (N, 3) of the bodies, in the world and in their own frames. They and the joints' arrays keep their place.
    joints, joint_rates
        (N, j) [rad, rad/s] after the step, `joints_before` before it.
    """

    def __init__(
        self,
        first: Robot,
        zones: Sequence[Zone],
        bodies: Ints,
        command: Array,
        streams: Streams,
        whose: ErrorContext,
        label: str,
        dt: float,
    ) -> None:
        rows, joints = len(bodies), len(first.drive.joints)
        self.drive: Drive = first.drive
        self.bodies, self.rows, self.dt = bodies, rows, dt
        self.whose, self.label = whose, label
        self.true_pose, self.true_twist = np.zeros((rows, 3)), np.zeros((rows, 3))
        self.joints, self.joints_before = np.zeros((rows, joints)), np.zeros((rows, joints))
        self.joint_rates = np.zeros((rows, joints))
        self._moved_joints = np.zeros((2, rows, joints))  # positions and rates after the step
        self._after = self._moved_joints[0]
        self._ground_after = self._after  # the joints that match the wheels' travel over the ground
        self._slide: Array | None = None  # of the step, if the ground of any row makes one
        # The drive's part of the command: all of it, or a copy where devices take commands, too.
        self._whole_command, channels = command, len(first.drive.channels)
        self._command = command if command.shape[1] == channels else np.zeros((rows, channels))
        self._draws, self._row_clock = streams.draws("drive"), whose.row_clock
        self.ground = Chain(first.ground, streams, whose, "ground")
        self.zones = Zones(zones, rows, streams, whose)
        self.rolling = np.flatnonzero([joint.rolls for joint in first.drive.joints])

    def set_parameters(self, true: Sequence[Robot]) -> None:
        """Take the true parameters of every row."""
        self.drive = stack([robot.drive for robot in true])
        self.ground.set_parameters([robot.ground for robot in true])
        check_drive(self.drive, self.rows, self.whose)
        self._radius = self._rolling_radius()

    @of_drive
    def _rolling_radius(self) -> Array:
        return np.ascontiguousarray(self.drive.rolling_radius())

    @of_drive
    def _start_drive(self, context: Context) -> State:
        return dict(self.drive.start(context))

    def start(self, context: Context) -> None:
        """Start an episode in every row, at rest."""
        for array in (self.true_twist, self.joints, self.joints_before, self.joint_rates, self._moved_joints):
            array[:] = 0.0
        self._state: State = self._start_drive(context)
        over_ground = attrs.evolve(context, size=len(self.rolling))
        self.ground.states = self.ground.start(over_ground)
        self.zones.start(over_ground)
        self._ground_after = self._after
        self._slide = None

    def bind(self) -> None:
        """Prepare what each step calls, for the present parameters and states."""
        self._after = self._moved_joints[0]
        self._ground_after = self._after.copy() if self.ground.elements or self.zones else self._after
        self._advance = self.drive.bind(
            DriveBinding(
                rows=self.rows,
                dt=self.dt,
                joints=self.joints_before,
                joint_rates=self.joint_rates,
                command=self._command,
                state=self._state,
                draws=self._draws,
                out=self._moved_joints,
                answer=self._take_joints,
            )
        )

    _BOUND = ("_advance", "_motion")

    def __getstate__(self) -> dict[str, Any]:
        """All but what is bound, which a copy prepares again."""
        return {name: value for name, value in vars(self).items() if name not in self._BOUND}

    def unbind(self) -> None:
        """Drop what is bound: it refers to these robots in a circle, which would keep the map in memory."""
        for name in self._BOUND:
            vars(self).pop(name, None)

    def _take_joints(self, joints: Array, rates: Array) -> None:
        """Take what the drive's `advance` returned."""
        self._moved_joints[0], self._moved_joints[1] = joints, rates

    def actuate_calls(self) -> Iterator[Call]:
        """The calls that move the joints, and the wheels over the ground."""
        yield Call("actuate", f"{self.label} / drive: {type(self.drive).__name__}", self._move_joints, self.blame)
        if self.ground.elements or self.zones:
            yield Call("actuate", f"{self.label} / ground", self._move_over_ground, self.blame)

    def blame(self, error: BaseException) -> NoReturn:
        """Raise the drive's exception as `ErrorContext.blame` does."""
        self.whose.blame("drive", self.drive, error)

    def _move_joints(self) -> None:
        """Move the joints by the command."""
        np.copyto(self.joints_before, self.joints)
        if self._command is not self._whole_command:
            np.copyto(self._command, self._whole_command[:, : self._command.shape[1]])
        self._advance()
        np.copyto(self.joint_rates, self._moved_joints[1])

    def _move_over_ground(self) -> None:
        """Let ground effects act on the rolling joints."""
        elapsed = self._row_clock.step
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

    # As a mover (`amorsim.simulation.contact.resolve.Mover`): the bodies go where their wheels roll them.

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

    @property
    def mean_rates(self) -> Array:
        """Mean rates of the joints over the step `(N, j)` [rad/s]; those at its end are `joint_rates`."""
        return (self.joints - self.joints_before) / self.dt

    def states(self) -> dict[str, State]:
        """The states of the drive and of the ground's noise, by their place; the dicts themselves, not copies."""
        ground = {f"ground {name}": s for name, s in zip(self.ground.names, self.ground.states, strict=True)}
        return {"drive": self._state, **ground, **self.zones.states()}

    def arrays(self) -> dict[str, AnyArray]:
        """All arrays that change, by name."""
        names = ("true_pose", "true_twist", "joints", "joints_before", "joint_rates")
        return {name: getattr(self, name) for name in names}
