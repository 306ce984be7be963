"""A simulation: the robots of a scenario, in one or many replicas, step by step."""

from __future__ import annotations

import hashlib
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Frame
from amorsim.core.draws import check_collisions
from amorsim.core.errors import AmorsimError, Fault, ScenarioError, SnapshotError, did_you_mean
from amorsim.core.parameters import ParameterError
from amorsim.scenario.paths import with_value
from amorsim.scenario.spec import Obstacle, Robot, Scenario
from amorsim.simulation.bodies import World
from amorsim.simulation.contact import WALL, Contact, move
from amorsim.simulation.events import Event
from amorsim.simulation.group import Group, group_key
from amorsim.simulation.handle import Reading, Readings, RobotHandle
from amorsim.simulation.obstacles import ObstacleGroup
from amorsim.simulation.snapshot import GroupSnapshot, Snapshot, copy_arrays, copy_state

__all__ = ["PHASES", "Simulation"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

PHASES = ("control", "actuate", "move", "sense", "estimate", "record")
"""The phases of a step, in order. All rows finish one before the next begins."""

MAX_REPLICA = 2**32 - 2  # a 32-bit word of the draws' counter, and one number kept for studies


class Simulation:
    """Robots as rows: one row is one robot in one replica, in order of replica, then of name.

    Parameters
    ----------
    scenario
        What is simulated.
    seed
        In place of the scenario's.
    replicas
        How many replicas, or their numbers. Replica 37 of many has the same bits as replica 37 alone.

    Raises
    ------
    ScenarioError
        With every fault that shows only now: a start in a wall or in another body, an error whose path leads
        nowhere or whose true value its field does not take.
    """

    def __init__(self, scenario: Scenario, *, seed: int | None = None, replicas: int | Sequence[int] = 1) -> None:
        self.scenario = scenario
        self.dt = scenario.dt
        self.replicas = _replica_numbers(replicas)
        self._robots = sorted(scenario.robots, key=lambda robot: robot.name)
        self._obstacles = sorted(scenario.obstacles, key=lambda obstacle: obstacle.name)
        self._build(scenario.seed if seed is None else seed)

    def _build(self, seed: int) -> None:
        self.seed = seed
        bodies: list[Robot | Obstacle] = [*self._robots, *self._obstacles]
        count = len(self.replicas)
        self._world = World(self.scenario.map, [body.name for body in bodies], [body.shape for body in bodies], count)
        self._groups = [
            Group(*self._rows(members), world=self._world, seed=seed, dt=self.dt)
            for members in _partition(self._robots, group_key)
        ]
        offset = len(self._robots)
        self._obstacle_groups = [
            ObstacleGroup(*self._rows(members, offset), world=self._world, seed=seed, dt=self.dt)
            for members in _partition(self._obstacles, lambda obstacle: type(obstacle.motion))
        ]
        self._everything: list[Group | ObstacleGroup] = [*self._groups, *self._obstacle_groups]
        streams = [(robot.name, *stream) for robot in self._robots for stream in _stream_names(robot)]
        check_collisions(seed, streams)
        self._ticks = np.zeros(count, dtype=np.int64)
        self._episodes = np.zeros(count, dtype=np.int64)
        self.events: list[Event] = []
        self._place()
        self._check_starts()
        self._first_look()

    def _rows(self, members: Sequence[tuple[int, Any]], offset: int = 0) -> tuple[list[Any], Ints, Ints]:
        """What is specified of each row, its body in the world, and its replica's number."""
        specified, bodies, replica = [], [], []
        for index, number in enumerate(self.replicas):
            for position, thing in members:
                specified.append(thing)
                bodies.append(index * self._world.count + offset + position)
                replica.append(number)
        return specified, np.array(bodies, dtype=np.int64), np.array(replica, dtype=np.int64)

    def _place(self) -> None:
        poses = self._world.poses.copy()
        for group in self._groups:
            poses[group.bodies] = group.true_pose
        for obstacles in self._obstacle_groups:
            poses[obstacles.bodies] = obstacles.pose
        self._world.poses = poses

    def _check_starts(self) -> None:
        world = self._world
        everyone = np.arange(len(world.poses), dtype=np.int64)
        gaps, where = world.wall_gaps(everyone, world.poses, np.zeros(len(everyone)))
        faults = []
        for body in np.flatnonzero(gaps < 0.0):
            x, y, _ = world.poses[body]
            faults.append(
                self._start_fault(
                    int(body),
                    f"at ({x:.3f}, {y:.3f}) m the footprint overlaps a wall near "
                    f"({where[body, 0]:.3f}, {where[body, 1]:.3f}) m; expected a free place",
                )
            )
        a, b = world.pairs_within(world.poses, np.zeros(len(everyone)))
        if len(a):
            overlaps = world.body_gaps(a, world.poses[a], b, world.poses[b], np.zeros(len(a))) < 0.0
            for first, second in zip(a[overlaps].tolist(), b[overlaps].tolist(), strict=True):
                faults.append(self._start_fault(second, f"overlaps {world.name(first)!r}; expected room between them"))
        if faults:
            raise ScenarioError(dict.fromkeys(faults))

    def _start_fault(self, body: int, message: str) -> Fault:
        index = body % self._world.count
        kind = "robots" if index < len(self._robots) else "obstacles"
        source = self.scenario.source
        return Fault(file=str(source) if source else "", path=f"{kind}.{self._world.name(body)}.pose", message=message)

    def _first_look(self) -> None:
        """Sense and estimate once, so that a controller never sees an empty reading."""
        for group in self._groups:
            group.streams.rewind()
        self._sense()
        self._estimate()
        self._record()

    # ---------------------------------------------------------------------------------------------------- stepping

    def step(self) -> None:
        """Simulate one step: the `PHASES` in order."""
        self._control()
        self._actuate()
        self._move()
        self._sense()
        self._estimate()
        self._record()

    def run(self, duration: float | None = None) -> None:
        """Step until `duration` [s] more have passed; without it, the scenario's duration."""
        for _ in range(self.steps_of(self.scenario.duration if duration is None else duration)):
            self.step()

    def steps_of(self, duration: float) -> int:
        """How many steps a duration [s] takes, the last one whole."""
        return max(0, int(np.ceil(duration / self.dt - 1e-9)))

    def _control(self) -> None:
        for group in self._groups:
            group.control()

    def _actuate(self) -> None:
        for group in self._groups:
            group.actuate()
        for obstacles in self._obstacle_groups:
            obstacles.actuate()

    def _move(self) -> None:
        movers: list[Group | ObstacleGroup] = [
            *self._groups,
            *(o for o in self._obstacle_groups if o.motion is not None),
        ]
        poses, stop, contacts = move(self._world, movers)
        for contact in contacts:
            self._log_contact(contact)
        self._world.poses = poses
        for mover in movers:
            mover.arrive(poses[mover.bodies], stop[mover.bodies])
        self._ticks = self._ticks + 1
        self._tell_time()

    def _tell_time(self) -> None:
        for group in self._everything:
            index = self._world.replica_index[group.bodies]
            group.moment.set_tick(self._ticks[index][:, None])
            group.moment.set_episode(self._episodes[index])
            group.streams.rewind()

    def _log_contact(self, contact: Contact) -> None:
        for body, other in ((contact.body, contact.other), (contact.other, contact.body)):
            if body == WALL:
                continue
            index = int(self._world.replica_index[body])
            tick = int(self._ticks[index])
            event = Event(
                tick=tick,
                time=(tick + contact.fraction) * self.dt,
                replica=self.replicas[index],
                kind="collision",
                name=self._world.name(body),
                other="wall" if other == WALL else self._world.name(other),
                point=contact.point,
                speed=self._speed_before(body),
            )
            self.events.append(event)
            group, row = self._row_of(body)
            if isinstance(group, Group) and group.ends_on_collision and group.active[row, 0]:
                group.active = group.active.copy()
                group.active[row] = False
                if group.controller is not None:
                    self.events.append(attrs.evolve(event, kind="controller_ended", other="", point=None, speed=None))

    def _speed_before(self, body: int) -> float:
        group, row = self._row_of(body)
        return float(group.travel()[row, 0] / self.dt)

    def _row_of(self, body: int) -> tuple[Group | ObstacleGroup, int]:
        for group in self._everything:
            row = int(np.searchsorted(group.bodies, body))
            if row < len(group.bodies) and group.bodies[row] == body:
                return group, row
        raise LookupError(body)

    def _sense(self) -> None:
        for group in self._groups:
            group.sense()

    def _estimate(self) -> None:
        for group in self._groups:
            group.estimate_pose()

    def _record(self) -> None:
        for group in self._groups:
            group.record()

    # ------------------------------------------------------------------------------------------------ what there is

    @property
    def ticks(self) -> Ints:
        """How many steps each replica has made since its episode began, `(R,)`."""
        return self._ticks.copy()

    @property
    def tick(self) -> int:
        """How many steps have been made since the episode began, where all replicas agree; else see `ticks`."""
        first = int(self._ticks[0])
        if (self._ticks != first).any():
            raise AmorsimError("the replicas are at different ticks; see `ticks`")
        return first

    @property
    def time(self) -> float:
        """Simulated time [s] since the episode began, where all replicas agree."""
        return self.tick * self.dt

    @property
    def names(self) -> tuple[str, ...]:
        """The robots' names, in the order of their rows within a replica."""
        return tuple(robot.name for robot in self._robots)

    @property
    def true_pose(self) -> Array:
        """True poses (x [m], y [m], heading [rad]) in the world `(N, 3)`, in order of replica, then of name."""
        return self._gather(lambda group: group.true_pose)

    @property
    def estimated_pose(self) -> Array:
        """Estimated poses `(N, 3)` in the world: what each robot's controller is told."""
        return self._gather(lambda group: group.estimate.pose)

    @property
    def covariance(self) -> Array:
        """Covariances `(N, 3, 3)` of the estimated poses, as the robots believe."""
        return self._gather(lambda group: group.estimate.covariance)

    def _gather(self, of: Callable[[Group], Array]) -> Array:
        if len(self._groups) == 1:
            whole = of(self._groups[0]).view()
        else:
            parts = np.concatenate([of(group) for group in self._groups])
            bodies = np.concatenate([group.bodies for group in self._groups])
            whole = parts[np.argsort(bodies)]
        whole.flags.writeable = False
        return whole

    @property
    def readings(self) -> Mapping[str, Reading]:
        """Readings `(N, k)` by sensor, true and measured, of all rows; robots of several models: see `robot`."""
        if len(self._groups) > 1:
            raise AmorsimError(
                "the robots are of several kinds, whose readings differ in shape; take robot(name).readings"
            )
        return Readings(self._groups[0])

    def robot(self, name: str, replica: int | None = None) -> RobotHandle:
        """One robot; `replica` is its replica's number, which one replica alone needs not be told."""
        if name not in self.names:
            known = ", ".join(self.names)
            raise AmorsimError(f"there is no robot {name!r}, but: {known}.{did_you_mean(name, self.names)}")
        body = self._replica_index(replica) * self._world.count + self.names.index(name)
        group, row = self._row_of(body)
        assert isinstance(group, Group)
        return RobotHandle(group, row)

    def _replica_index(self, replica: int | None) -> int:
        if replica is None:
            if len(self.replicas) > 1:
                raise AmorsimError("there are several replicas; say which one with replica=")
            return 0
        if replica not in self.replicas:
            raise AmorsimError(f"there is no replica {replica}; there are {_in_words(self.replicas)}")
        return self.replicas.index(replica)

    def frames(self) -> list[Frame]:
        """The present step as recorders get it: everything, a frame for each group."""
        return [group.frame() for group in self._groups]

    def digest(self, replica: int | None = None) -> str:
        """A fingerprint of all exact results since the start: equal for equal bits. Of one replica, or of all."""
        wanted = self.replicas if replica is None else (self.replicas[self._replica_index(replica)],)
        whole = hashlib.blake2b(digest_size=16)
        for number in wanted:
            first = self.replicas.index(number) * self._world.count
            for position, name in enumerate(self.names):
                group, row = self._row_of(first + position)
                assert isinstance(group, Group)
                whole.update(name.encode() + group.fingerprint[row].astype("<u8").tobytes())
        return whole.hexdigest()

    # ------------------------------------------------------------------------------------------- changes from outside

    def set_pose(self, name: str, pose: Sequence[float], *, replica: int | None = None) -> None:
        """Put a robot elsewhere, standing: (x [m], y [m], heading [rad]). Its own estimate is not told."""
        handle = self.robot(name, replica)
        group, row = handle._group, handle._row
        if len(pose) != 3 or not np.isfinite(pose).all():
            raise AmorsimError(f"robot {name!r}: expected a pose of three finite numbers, got {pose!r}")
        wanted = np.array([pose], dtype=float)
        body = group.bodies[row : row + 1]
        world = self._world
        if world.wall_gaps(body, wanted, np.zeros(1))[0][0] < 0.0:
            raise AmorsimError(f"robot {name!r} cannot stand at {tuple(pose)}: it would overlap a wall")
        first = int(world.first[world.replica_index[body[0]]])
        others = np.array([b for b in range(first, first + world.count) if b != body[0]], dtype=np.int64)
        if len(others):
            again = np.repeat(body, len(others))
            gaps = world.body_gaps(
                again, np.repeat(wanted, len(others), axis=0), others, world.poses[others], np.zeros(len(others))
            )
            if (gaps < 0.0).any():
                who = world.name(int(others[int(np.argmax(gaps < 0.0))]))
                raise AmorsimError(f"robot {name!r} cannot stand at {tuple(pose)}: it would overlap {who!r}")
        group.true_pose = _with_row(group.true_pose, row, wanted[0])
        group.true_twist = _with_row(group.true_twist, row, 0.0)
        group.joint_rates = _with_row(group.joint_rates, row, 0.0)
        self._place()
        self._log_change(handle, "pose_set", "pose", tuple(float(part) for part in pose))

    def set(self, name: str, path: str, value: Any, *, replica: int | None = None) -> None:
        """Change a parameter of a robot from the next step on; in one replica, or in all if none is named.

        ``"drive.track"`` and its like are the nominal value (the true one follows, by its error),
        ``"errors.drive.track.scale"`` the error, ``"sensors.laser.noise.gaussian.std"`` an element of a chain.
        """
        numbers = self.replicas if replica is None else (replica,)
        handles = [self.robot(name, number) for number in numbers]
        for group in {id(handle._group): handle._group for handle in handles}.values():
            rows = [handle._row for handle in handles if handle._group is group]
            before = list(group.specified)
            key = group_key(before[rows[0]])
            known: dict[int, Robot] = {}
            try:
                for row in rows:
                    robot = before[row]
                    changed = known.get(id(robot)) or known.setdefault(id(robot), with_value(robot, path, value))
                    if group_key(changed) != key:
                        raise LookupError("this fixes the shape of the robot's arrays")
                    group.specified[row] = changed
                group.set_parameters()
            except (LookupError, ParameterError, ScenarioError) as error:
                group.specified = before
                group.set_parameters()
                reason = error.problem if isinstance(error, ParameterError) else str(error.args[0])
                raise AmorsimError(f"robot {name!r}, {path}: {reason}") from None
        for handle in handles:
            self._log_change(handle, "parameter_set", path, value)

    def _log_change(self, handle: RobotHandle, kind: str, path: str, value: Any) -> None:
        tick = int(self._ticks[self.replicas.index(handle.replica)])
        self.events.append(
            Event(
                tick=tick,
                time=tick * self.dt,
                replica=handle.replica,
                kind=kind,
                name=handle.name,
                path=path,
                value=value,
            )
        )

    def reset(self, seed: int | None = None, replicas: Sequence[int] | None = None) -> None:
        """Begin anew, all or the numbered replicas.

        With a `seed` everything starts from it, as a new simulation would; without one, a new episode begins, whose
        draws differ from those of the episodes before. Parameters that were set stay set.
        """
        if seed is not None:
            if replicas is not None:
                raise AmorsimError("a seed is for all replicas; reset some of them without one")
            self._build(operator.index(seed))
            return
        chosen = range(len(self.replicas)) if replicas is None else [self._replica_index(r) for r in replicas]
        again = np.zeros(len(self.replicas), dtype=bool)
        again[list(chosen)] = True
        kept = self.snapshot()
        self._ticks = np.zeros_like(self._ticks)
        self._episodes = self._episodes + again
        self._tell_time()
        for group in self._groups:
            group.start()
        for obstacles in self._obstacle_groups:
            obstacles.start()
        self._place()
        self._first_look()
        self._put_back(kept, ~again)
        self.events = [event for event in self.events if not again[self.replicas.index(event.replica)]]

    def snapshot(self) -> Snapshot:
        """A copy of all that changes, for `restore`.

        Raises
        ------
        SnapshotError
            If a user's controller cannot be copied; it names the robot.
        """
        return Snapshot(
            seed=self.seed,
            replicas=self.replicas,
            tick=self._ticks.copy(),
            poses=self._world.poses.copy(),
            groups=tuple(
                GroupSnapshot(
                    specified=tuple(group.specified),
                    tick=group.moment.tick.copy(),
                    episode=self._episodes.copy(),
                    arrays=copy_arrays(group.arrays()),
                    states={
                        where: copy_state(f"{where} of robot {group.names[0]!r}", state)
                        for where, state in group.states().items()
                    },
                )
                for group in self._groups
            ),
            obstacles=tuple(
                {
                    "body": {"pose": group.pose.copy(), "twist": group.twist.copy()},
                    "state": copy_state("motion of obstacles", group.state),
                }
                for group in self._obstacle_groups
            ),
            events=tuple(self.events),
        )

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to what `snapshot` gave, to the bit; it may be restored any number of times."""
        if snapshot.replicas != self.replicas or len(snapshot.groups) != len(self._groups):
            raise SnapshotError("this snapshot is of another simulation")
        if snapshot.seed != self.seed:
            self._build(snapshot.seed)
        self._episodes = snapshot.groups[0].episode.copy()
        self._put_back(snapshot, np.ones(len(self.replicas), dtype=bool))
        self.events = list(snapshot.events)

    def _put_back(self, snapshot: Snapshot, which: npt.NDArray[np.bool_]) -> None:
        """Put the replicas marked in `which` `(R,)` back to the snapshot, and leave the others as they are."""
        self._ticks = np.where(which, snapshot.tick, self._ticks)
        for group, held in zip(self._groups, snapshot.groups, strict=True):
            if any(a is not b for a, b in zip(group.specified, held.specified, strict=True)):
                group.specified = list(held.specified)
                group.set_parameters()
            rows = which[self._world.replica_index[group.bodies]]
            now = group.arrays()
            group.set_arrays(
                {
                    unit: {name: _merge(rows, array, now[unit][name]) for name, array in arrays.items()}
                    for unit, arrays in held.arrays.items()
                }
            )
            for where, state in group.states().items():
                for name, array in copy_state(where, held.states[where]).items():
                    state[name] = _merge(rows, array, state[name])
        for obstacles, kept in zip(self._obstacle_groups, snapshot.obstacles, strict=True):
            rows = which[self._world.replica_index[obstacles.bodies]]
            obstacles.pose = _merge(rows, kept["body"]["pose"], obstacles.pose)
            obstacles.twist = _merge(rows, kept["body"]["twist"], obstacles.twist)
            for name, array in copy_state("motion", kept["state"]).items():
                obstacles.state[name] = _merge(rows, array, obstacles.state[name])
        self._place()
        self._tell_time()

    # -------------------------------------------------------------------------------------------------- a picture

    def occupancy(self, resolution: float, *, replica: int | None = None) -> npt.NDArray[np.uint8]:
        """The world as the paper's matrix: 0 free, 1 occupied, 2 a robot; row 0 at the bottom, in the map's frame.

        A cell of `resolution` [m] is occupied if anything in it is.
        """
        from amorsim.simulation.occupancy import occupancy

        return occupancy(self._world, self._replica_index(replica), resolution)


def _replica_numbers(replicas: int | Sequence[int]) -> tuple[int, ...]:
    numbers = tuple(range(replicas)) if isinstance(replicas, int) else tuple(operator.index(n) for n in replicas)
    if not numbers or len(set(numbers)) < len(numbers) or min(numbers) < 0 or max(numbers) > MAX_REPLICA:
        raise AmorsimError(f"expected a number of replicas > 0, or different numbers >= 0, got {replicas!r}")
    return numbers


def _partition(things: Sequence[Any], key: Callable[[Any], Any]) -> list[list[tuple[int, Any]]]:
    """Things with their positions, those of equal keys together, in order of their first."""
    parts: dict[Any, list[tuple[int, Any]]] = {}
    for position, thing in enumerate(things):
        parts.setdefault(key(thing), []).append((position, thing))
    return list(parts.values())


def _stream_names(robot: Robot) -> list[tuple[str, ...]]:
    names: list[tuple[str, ...]] = [("drive",), ("controller",)]
    names += [("estimator", name) for name in robot.estimators]
    names += [("ground", "noise", element.name) for element in robot.ground]
    for name, unit in robot.sensors.items():
        names += [("sensor", name), *(("sensor", name, "noise", element.name) for element in unit.noise)]
    names += [("errors", path, role) for path in robot.errors for role in ("scale", "add", "value")]
    return names


def _with_row(array: Array, row: int, value: Any) -> Array:
    changed = array.copy()
    changed[row] = value
    return changed


def _merge(rows: npt.NDArray[np.bool_], yes: npt.NDArray[Any], no: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if rows.all():
        return yes.copy()
    return np.where(rows.reshape(len(rows), *([1] * (yes.ndim - 1))), yes, no)


def _in_words(numbers: Sequence[int]) -> str:
    return (
        ", ".join(map(str, numbers)) if len(numbers) < 9 else f"{len(numbers)}, from {min(numbers)} to {max(numbers)}"
    )
