"""What robots of the commonest kinds make in one call of a kernel, where several phases would take many.

Two driven wheels on firm ground roll; devices that have a twin among the kernels sense (`amorsim.simulation.plan`);
dead reckoning by a plain encoder concludes. Each is for exactly the classes that it names: a subclass may do anything.
What a group has of them is settled when its parameters are set, and whatever else it has goes phase by phase, component
by component, with the same bits.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Estimate, State
from amorsim.drives.differential import Differential
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.kernels import stepping
from amorsim.kernels.known import lay_out
from amorsim.kernels.sensing_among import sense_among
from amorsim.sensors.encoder import Encoder
from amorsim.simulation.bodies import World
from amorsim.simulation.contact import LOOK, Contact, Rolling, roll

if TYPE_CHECKING:
    from amorsim.simulation.fleet import Fleet
    from amorsim.simulation.group import Group

__all__ = ["Together"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_WHOLE = np.dtype(np.int64)
# In the place of what a call neither reads nor writes.
_NO_ROOM = np.empty(0)
_NO_TICKS: Ints = np.empty(0, dtype=np.int64)
_NO_NOW = np.empty((0, 1), dtype=np.int64), np.empty((0, 1))
_NO_STATE: State = {"pose": np.empty((0, 3)), "covariance": np.empty((0, 3, 3)), "joints": np.empty((0, 2))}
_NO_POSES, _NO_JOINTS, _NO_COVARIANCES = np.empty((3, 0, 3)), np.empty((3, 0, 2)), np.empty((0, 3, 3))
_NO_VALUES = np.empty((2, 0))


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
        self._wheels = wheels = np.zeros((stepping.ROLLING + stepping.RECKONING, rows, 1))
        self.rolls = _tell_rolling(group, wheels[: stepping.ROLLING])
        self._estimator, encoder = _tell_reckoning(group, wheels[stepping.ROLLING :])
        self.concludes = bool(self._estimator)
        self.is_whole = self.rolls and self.concludes and group.world.workers.threads == 1
        self._known = plan.known(wheels, encoder, group.moment.counter, group.dt)
        self._lay_out()
        # Shapes of what a step leaves: true poses, twists, estimated poses; joints, their rates, and those reckoned by.
        self._poses, self._joints = (3, rows, 3), (3, rows, 2)
        self._covariances, self._column = (rows, 3, 3), (rows, 1)

    def _lay_out(self) -> None:
        # What is known stays beside its table, which does not keep alive what it leads to.
        self._table = lay_out(self._known)
        advance: Any = stepping.advance
        self._whole = functools.partial(advance, True, self._plan.looks, True, True, 0, self._rows, self._table)

    def __getstate__(self) -> dict[str, Any]:
        state = dict(self.__dict__)
        del state["_table"], state["_whole"]  # a copy's arrays lie elsewhere
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lay_out()

    def step(self, fleet: Fleet) -> bool:
        """Make a step but for the command, if it goes by this road whole and all have room; else nothing is made.

        For a group that is all there is, and of whom is known how far from walls it is.
        """
        # Written out, and not by way of `_about`, `_roll` and `_conclude`: every call counts here.
        group, world, batch, empty = self._group, fleet.world, self._plan.batch, np.empty
        moment, state = group.moment, group.estimator_states[self._estimator]
        poses, joints, covariances = empty(self._poses), empty(self._joints), empty(self._covariances)
        tick, time, values = empty(self._column, _WHOLE), empty(self._column), empty(batch.shape)
        if not self._whole(
            world.room,
            fleet.ticks,
            moment.tick,
            group.true_pose,
            group.true_twist,
            group.joints,
            group.joint_rates,
            group.command,
            state["pose"],
            state["covariance"],
            state["joints"],
            poses,
            joints,
            covariances,
            tick,
            time,
            values,
            group.fingerprint,
        ):
            return False
        world.poses = world.room_at = group.true_pose = poses[0]
        group.joints_before = group.joints
        group.true_twist, group.joints, group.joint_rates = poses[1], joints[0], joints[1]
        moment.take(tick, time)
        group.streams.rewind()
        batch.take(values, moment)
        pose = poses[2]
        state["pose"], state["covariance"], state["joints"] = pose, covariances, joints[2]
        group.estimates[self._estimator] = Estimate(pose, covariances)
        return True

    def look_ahead(self, world: World) -> bool:
        """See how far from walls a robot is, if it is one, so that it may step again; whether that is of use.

        It is not where the robot stood, or was near a wall.
        """
        if self._rows > 1 or (world.room_at is world.poses and world.room[0] == 0.0):
            return False
        ahead, left, turn = np.abs(self._group.true_twist[0]).tolist()
        last = (ahead + left + turn * float(world.bodies.reach[0])) * self._group.dt  # no point went farther
        world.room, _ = world.wall_gaps(world.everyone, world.poses, np.array([LOOK * last]))
        world.room_at = world.poses
        return bool(world.room[0] > 2.0 * last)

    def roll(self, fleet: Fleet) -> bool:
        """Make of a step the moving alone, and else as `step`; for a group that rolls."""
        group = self._group
        poses, joints = np.empty(self._poses), np.empty(self._joints)
        tick, time = np.empty(self._column, _WHOLE), np.empty(self._column)
        about, results = self._about(_NO_STATE), (poses, joints, _NO_COVARIANCES, tick, time, _NO_VALUES)
        advance: Any = stepping.advance
        goes = True, False, False, False, 0, 0
        if not advance(*goes, self._table, fleet.world.room, fleet.ticks, *about, *results, group.fingerprint):
            return False
        self._roll(fleet.world, poses, joints, tick, time)
        return True

    def set_out(self, world: World) -> tuple[Array, Array, list[Contact]]:
        """Let wheels and bodies move among others, as `contact.move` tells; for a group that rolls, and is all bodies.

        Without contacts the group is where that led.
        """
        group = self._group
        wheels, twists = np.empty((2, *group.joints.shape)), np.empty((self._rows, 3))
        rolling = Rolling(group.joints, group.joint_rates, group.command, self._wheels, group.dt)
        poses, stop, contacts, motion = roll(world, rolling, wheels, twists)
        group.set_off(wheels[0], wheels[1], motion)
        if not contacts:
            group.true_pose, group.true_twist, group.joints = poses, twists, wheels[0]
        return poses, stop, contacts

    def sense(self) -> bool:
        """Sense where the group is now, and whether that concluded the step, where that goes by this road."""
        plan, group, concludes = self._plan, self._group, self.concludes
        if not plan.reads:
            return False
        state, results = _NO_STATE, (_NO_POSES, _NO_JOINTS, _NO_COVARIANCES)
        if concludes:
            state = group.estimator_states[self._estimator]
            results = np.empty(self._poses), np.empty(self._joints), np.empty(self._covariances)
        batch = plan.batch
        batch.take(np.empty(batch.shape), group.moment)
        about, values = self._about(state), batch.values
        if plan.looks and group.world.has_company:
            among: Any = sense_among
            # But for the tick and the rates of joints, which those that do not roll need not know.
            known = self._table, *about[1:4], *about[5:]
            given = *plan.company(group.view), *known, *results
            plan.share_meeting(lambda share: among(share, concludes, *given, values, group.fingerprint))
        else:
            advance: Any = stepping.advance
            told = self._table, _NO_ROOM, _NO_TICKS, *about, *results, *_NO_NOW, values, group.fingerprint
            plan.share(lambda first, end: advance(False, plan.looks, True, concludes, first, end, *told))
        if concludes:
            self._conclude(state, *results)
        return concludes

    def _about(self, state: State) -> tuple[Any, ...]:
        """What a call must know of how things are: `tick` to `reckoned`, as kernels take them."""
        group = self._group
        return (
            group.moment.tick,
            group.true_pose,
            group.true_twist,
            group.joints,
            group.joint_rates,
            group.command,
            state["pose"],
            state["covariance"],
            state["joints"],
        )

    def _roll(self, world: World, poses: Array, joints: Array, tick: Ints, time: Array) -> None:
        """Take what a call made of those that rolled."""
        group = self._group
        group.true_pose, group.true_twist = poses[0], poses[1]
        group.joints_before = group.joints
        group.joints, group.joint_rates = joints[0], joints[1]
        world.poses = world.room_at = group.true_pose
        group.moment.take(tick, time)
        group.streams.rewind()

    def _conclude(self, state: State, poses: Array, joints: Array, covariances: Array) -> None:
        """Take what a call made of estimates."""
        pose = poses[2]
        state["pose"], state["covariance"], state["joints"] = pose, covariances, joints[2]
        self._group.estimates[self._estimator] = Estimate(pose, covariances)


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
