"""What robots of the commonest kinds make in one call of a kernel, where several phases would take many.

Two driven wheels on firm ground roll; devices that have a twin among the kernels sense (`amorsim.simulation.plan`);
dead reckoning by a plain encoder concludes. Each is for exactly the classes that it names: a subclass may do anything.
What a group has of them is settled when its parameters are set, and whatever else it has goes phase by phase, component
by component, with the same bits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Estimate, State
from amorsim.drives.differential import Differential
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.kernels import stepping
from amorsim.kernels.sensing_among import sense_among
from amorsim.sensors.encoder import Encoder
from amorsim.simulation.bodies import World

if TYPE_CHECKING:
    from amorsim.simulation.fleet import Fleet
    from amorsim.simulation.group import Group

__all__ = ["Together"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_NO_NUMBERS = np.empty(0)
_NO_TICKS: Ints = np.empty(0, dtype=np.int64)
_NO_NOW = np.empty((0, 1), dtype=np.int64), np.empty((0, 1))
_NO_STATE: State = {"pose": np.empty((0, 3)), "covariance": np.empty((0, 3, 3)), "joints": np.empty((0, 2))}
_NO_RESULTS = np.empty((3, 0, 3)), np.empty((3, 0, 2)), np.empty((0, 3, 3))


class Together:
    """What a group makes in one call, and is given to it; made anew with the group's parameters.

    Attributes
    ----------
    rolls, concludes
        Whether its wheels roll, and whether it estimates and records, by this road.
    is_whole
        Whether a whole step after the command goes by it, where nothing is in the way.
    """

    def __init__(self, group: Group) -> None:
        self._group = group
        self._plan = plan = group.sensing
        self._rows = rows = group.rows
        wheels = np.zeros((stepping.ROLLING + stepping.RECKONING, rows, 1))
        self.rolls = _tell_rolling(group, wheels[: stepping.ROLLING])
        self._estimator, encoder = _tell_reckoning(group, wheels[stepping.ROLLING :])
        self.concludes = bool(self._estimator)
        self.is_whole = self.rolls and self.concludes and group.world.workers.threads == 1
        self._known = (*plan.given, wheels, encoder, group.moment.counter)
        # Shapes of what a step leaves: true poses, twists, estimated poses; joints, their rates, and those reckoned by.
        self._poses, self._joints = (3, rows, 3), (3, rows, 2)
        self._covariances, self._column = (rows, 3, 3), (rows, 1)

    def step(self, fleet: Fleet) -> bool:
        """Make a step but for the command, if it goes by this road whole and all have room; else nothing is made.

        For a group that is all there is, and of whom is known how far from walls it is.
        """
        group, batch = self._group, self._plan.batch
        moment, state = group.moment, group.estimator_states[self._estimator]
        results = np.empty(self._poses), np.empty(self._joints), np.empty(self._covariances)
        now = np.empty(self._column, dtype=np.int64), np.empty(self._column)
        read = np.empty(batch.size), np.empty(batch.size)
        goes = (True, self._plan.looks, True, True, 0, self._rows)
        if not self._advance(goes, fleet.world.room, fleet.ticks, state, results, now, read):
            return False
        self._roll(fleet.world, results, now)
        batch.take(*read, moment)
        self._conclude(state, results)
        return True

    def roll(self, fleet: Fleet) -> bool:
        """Make of a step the moving alone, and else as `step`; for a group that rolls."""
        results = np.empty(self._poses), np.empty(self._joints), _NO_RESULTS[2]
        now = np.empty(self._column, dtype=np.int64), np.empty(self._column)
        read = _NO_NUMBERS, _NO_NUMBERS
        goes = (True, False, False, False, 0, 0)
        if not self._advance(goes, fleet.world.room, fleet.ticks, _NO_STATE, results, now, read):
            return False
        self._roll(fleet.world, results, now)
        return True

    def sense(self) -> bool:
        """Sense where the group is now, and whether that concluded the step, where that goes by this road."""
        plan, group = self._plan, self._group
        if not plan.reads:
            return False
        state, results = _NO_STATE, _NO_RESULTS
        if self.concludes:
            state = group.estimator_states[self._estimator]
            results = np.empty(self._poses), np.empty(self._joints), np.empty(self._covariances)
        batch = plan.batch
        batch.take(np.empty(batch.size), np.empty(batch.size), group.moment)

        if plan.looks and group.world.has_company:
            among: Any = sense_among
            about = group.true_pose, group.true_twist, group.joints, group.command, *_of(state)
            given = *self._known, *about, *results, batch.true, batch.measured, group.fingerprint
            company = plan.company(group.view)
            plan.share_meeting(lambda share: among(share, self.concludes, *company, *given))
        else:
            read, looks, concludes = (batch.true, batch.measured), plan.looks, self.concludes

            def part(first: int, end: int) -> None:
                goes = (False, looks, True, concludes, first, end)
                self._advance(goes, _NO_NUMBERS, _NO_TICKS, state, results, _NO_NOW, read)

            plan.share(part)
        if self.concludes:
            self._conclude(state, results)
        return self.concludes

    def _advance(
        self,
        goes: tuple[Any, ...],
        room: Array,
        ticks: Ints,
        state: State,
        results: tuple[Array, Array, Array],
        now: tuple[Ints, Array],
        read: tuple[Array, Array],
    ) -> bool:
        """Call the kernel; what is asked for, and where that goes."""
        group = self._group
        advance: Any = stepping.advance
        made = advance(
            *goes,
            *self._known,
            group.dt,
            room,
            ticks,
            group.moment.tick,
            group.true_pose,
            group.true_twist,
            group.joints,
            group.joint_rates,
            group.command,
            *_of(state),
            *results,
            *now,
            *read,
            group.fingerprint,
        )
        return bool(made)

    def _roll(self, world: World, results: tuple[Array, Array, Array], now: tuple[Ints, Array]) -> None:
        """Take what a call made of those that rolled."""
        group, (poses, joints, _) = self._group, results
        group.true_pose, group.true_twist = poses[0], poses[1]
        group.joints, group.joint_rates = joints[0], joints[1]
        world.poses = world.room_at = group.true_pose
        group.moment.take(*now)
        group.streams.rewind()

    def _conclude(self, state: State, results: tuple[Array, Array, Array]) -> None:
        """Take what a call made of estimates."""
        poses, joints, covariances = results
        pose = poses[2]
        state["pose"], state["covariance"], state["joints"] = pose, covariances, joints[2]
        self._group.estimates[self._estimator] = Estimate(pose, covariances)


def _of(state: State) -> tuple[Array, Array, Array]:
    """The state of dead reckoning, as kernels take it."""
    return state["pose"], state["covariance"], state["joints"]


def _tell_rolling(group: Group, numbers: Array) -> bool:
    """Whether a group's wheels roll by this road; if so the numbers of that are written."""
    drive = group.drive
    if type(drive) is not Differential or group.devices or group.ground.elements or group.zones:
        return False
    told = (drive.rate_max, drive._acceleration(group.rows), drive.lag)
    wheels = (drive.wheel_radius_left, drive.wheel_radius_right, drive.track)
    for number, value in zip(numbers, (*told, *wheels, group.world.bodies.reach[group.bodies][:, None]), strict=True):
        number[:] = value
    return True


def _tell_reckoning(group: Group, numbers: Array) -> tuple[str, int]:
    """The estimator that goes by this road, if one does, and where in what is measured its counts begin.

    The numbers of that are written.
    """
    if group.sensing.others or len(group.estimators) != 1:
        return "", 0
    ((name, estimator),) = group.estimators.items()
    drive = group.robot.drive
    if type(estimator) is not DeadReckoning or type(drive) is not Differential:
        return "", 0
    sensor = group.robot.sensors[estimator.encoder].sensor
    if type(sensor) is not Encoder:
        return "", 0
    told = (drive.wheel_radius_left, drive.wheel_radius_right, drive.track, estimator.wheel_variance)
    for number, value in zip(numbers[:4], told, strict=True):
        number[:] = value
    numbers[4:].reshape(group.rows, 2)[:] = sensor.counts_per_revolution
    return name, group.sensors[estimator.encoder].first
