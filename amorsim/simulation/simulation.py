"""A simulation: the robots of a scenario, in one or many replicas, step by step."""

from __future__ import annotations

import hashlib
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Frame, ObstacleFrame
from amorsim.core.errors import AmorsimError, ComponentError, ScenarioError, SnapshotError, did_you_mean
from amorsim.core.map import Map
from amorsim.core.memory import too_large
from amorsim.core.parameters import ParameterError, check_value, describe
from amorsim.core.starts import outside
from amorsim.core.trouble import in_words
from amorsim.scenario.chains import is_chain, read_elements, tables_of, with_chain
from amorsim.scenario.needs import least_bytes
from amorsim.scenario.paths import with_value
from amorsim.scenario.programs import loaded
from amorsim.scenario.spec import Obstacle, Robot, Scenario
from amorsim.simulation import phases
from amorsim.simulation.alike import group_key
from amorsim.simulation.contact.resolve import WALL
from amorsim.simulation.events import Event
from amorsim.simulation.fleet import Fleet
from amorsim.simulation.group import Group
from amorsim.simulation.handle import ObstacleHandle, Reading, Readings, RobotHandle, finite_numbers
from amorsim.simulation.keeping import Keeper
from amorsim.simulation.regroup import chains_of, frames_as, other_chains, regrouped
from amorsim.simulation.snapshot import Snapshot, fits, from_bytes, put_back, take_snapshot
from amorsim.simulation.world.occupancy import occupancy
from amorsim.simulation.world.terrain import Terrains

__all__ = ["MOST_STEPS", "Simulation"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

MOST_STEPS = 2**32 - 1  # a tick is a 32-bit word of the draws' counter
MAX_REPLICA = 2**32 - 2  # a 32-bit word of the draws' counter; one number is reserved for studies


class Simulation:
    """Robots as rows: one row is one robot in one replica, in order of replica, then of name.

    Controllers and motions that a scenario's file names as ``"FILE.py:NAME"`` are loaded now, which runs their files.

    Parameters
    ----------
    scenario
        The scenario to simulate.
    seed
        Replaces the scenario's seed.
    replicas
        The number of replicas, or their numbers. Replica 37 of many gives the same bits as replica 37 alone.
    threads
        The number of threads that share long work, useful from about a hundred robots; it does not change the bits.

    Raises
    ------
    ParameterError
        If it is given anything but a scenario; `am.load` makes one from a file or the name of a bundled one.
    ScenarioError
        With every fault that only shows now: a controller or motion in a file that cannot be loaded, a start in a wall
        or in another body, an error whose path leads nowhere or whose true value its field does not accept.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        seed: int | None = None,
        replicas: int | Sequence[int] = 1,
        threads: int = 1,
    ) -> None:
        if not isinstance(scenario, Scenario):
            raise ParameterError("scenario", f"expected a Scenario, as am.load('demo'), got {scenario!r}")
        if not isinstance(threads, int) or threads < 1:
            raise AmorsimError(f"expected a number of threads >= 1, got {threads!r}")
        self.threads = threads
        self.dt = scenario.dt
        replicas = _plain(replicas)
        if not (0 < replicas <= MAX_REPLICA + 1 if isinstance(replicas, int) else hasattr(replicas, "__len__")):
            raise _no_replicas(replicas)
        _check_memory(scenario, replicas if isinstance(replicas, int) else len(replicas))
        self.replicas = _replica_numbers(replicas)
        seed = scenario.seed if seed is None else _plain(seed)
        check_value(describe(Scenario)["seed"], seed)
        self.scenario = loaded(scenario)
        self._terrains = Terrains(self.replicas)
        self._build(seed)

    def _build(self, seed: int, scenario: Scenario | None = None) -> None:
        self._fleet = Fleet(scenario or self.scenario, seed, self.replicas, self.threads, self._terrains)
        # Recorders keep the groups of the beginning, whatever chains robots come to have.
        self._partition = tuple(tuple(group.names) for group in self._fleet.groups)
        phases.first_look(self._fleet)

    def __repr__(self) -> str:
        scenario, ticks = self.scenario, sorted(set(self._fleet.ticks.tolist()))
        name = scenario.source.stem if scenario.source else scenario.map.name
        counts = [
            (len(scenario.robots), "robot"),
            (len(scenario.obstacles), "obstacle"),
            (len(self.replicas), "replica"),
        ]
        told = [f"{count} {what}{'s' if count > 1 else ''}" for count, what in counts if count]
        times = " to ".join(f"{tick * self.dt:g}" for tick in dict.fromkeys((ticks[0], ticks[-1])))
        return f"<Simulation{f' of {name!r}' if name else ''}: {', '.join(told)}, seed {self.seed}, at {times} s>"

    @property
    def seed(self) -> int:
        """The seed of all random draws."""
        return self._fleet.seed

    @property
    def events(self) -> list[Event]:
        """The events so far, in order."""
        return self._fleet.events

    # ---------------------------------------------------------------------------------------------------- stepping

    def step(self) -> None:
        """Simulate one step: the `PHASES` in order, after robots that are kidnapped now were carried away."""
        if self._fleet.kidnappings:
            self._kidnap()
        phases.step(self._fleet)

    def _kidnap(self) -> None:
        for index, tick in enumerate(self._fleet.ticks.tolist()):
            for name, pose in self._fleet.kidnappings.get(tick, ()):
                self._put(self.robot(name, self.replicas[index]), pose, "kidnapped")

    @overload
    def run(self, duration: float | None = None) -> None: ...

    @overload
    def run(self, duration: float | None = None, *, keep: Iterable[str]) -> dict[str, npt.NDArray[Any]]: ...

    def run(
        self, duration: float | None = None, *, keep: Iterable[str] | None = None
    ) -> dict[str, npt.NDArray[Any]] | None:
        """Step for `duration` [s]; without it, for the scenario's duration.

        ::

            kept = simulation.run(60, keep=("true_pose", "estimated_pose", "readings.laser"))
            kept["readings.laser"]  # (steps, N, beams) as measured, after each step

        Parameters
        ----------
        keep
            Quantities to return, by name: arrays ``(steps, N, ...)`` of the values after each step, with rows as those
            of `true_pose`. Names are ``true_pose``, ``estimated_pose``, ``covariance``, ``true_twist``,
            ``joint_rates``, ``command``, ``active``, ``by_hand``, ``touching``; ``readings.NAME``, which is what was
            measured, or ``readings.NAME.true``, ``.stamp``, ``.age``, ``.fresh``; ``estimates.NAME.pose`` and
            ``.covariance``; ``beliefs.NAME.BELIEF``. What a robot does not have, and another has, is nan.

        Raises
        ------
        AmorsimError
            If the duration is not a number, below 0, or longer than 2^32 - 1 steps; if a name in `keep` is unknown, or
            the arrays would not fit into memory, before any step is made.
        """
        duration = self.scenario.duration if duration is None else duration
        most = MOST_STEPS * self.dt
        numbers = finite_numbers((duration,))
        if numbers is None or not 0.0 <= numbers[0] <= most:
            raise AmorsimError(
                f"duration: expected a number of seconds >= 0 and <= {most:g} "
                f"(2^32 - 1 steps of {self.dt:g} s), got {in_words(duration)}"
            )
        steps = self.steps_of(duration)
        if keep is None:
            for _ in range(steps):
                self.step()
            return None
        keeper = Keeper(self, keep, steps)
        for _ in range(steps):
            self.step()
            keeper.keep()
        return keeper.arrays

    def steps_of(self, duration: float) -> int:
        """The number of steps in a duration [s], rounded up."""
        return max(0, int(np.ceil(duration / self.dt - 1e-9)))

    # ------------------------------------------------------------------------------------------------ what there is

    @property
    def ticks(self) -> Ints:
        """The number of steps of each replica since its episode began, `(R,)`."""
        return self._fleet.ticks.copy()

    @property
    def tick(self) -> int:
        """The number of steps since the episode began, if all replicas agree; otherwise see `ticks`."""
        first = int(self._fleet.ticks[0])
        if (self._fleet.ticks != first).any():
            raise AmorsimError("the replicas are at different ticks; see `ticks`")
        return first

    @property
    def time(self) -> float:
        """Simulated time [s] since the episode began, if all replicas agree."""
        return self.tick * self.dt

    @property
    def names(self) -> tuple[str, ...]:
        """The robots' names, in the order of their rows within a replica."""
        return self._fleet.names

    @property
    def true_pose(self) -> Array:
        """True poses (x [m], y [m], heading [rad]) in the world `(N, 3)`, in order of replica, then of name."""
        return self._gather(lambda group: group.true_pose)

    @property
    def estimated_pose(self) -> Array:
        """Estimated poses `(N, 3)` in the world, as each robot's controller receives them."""
        return self._gather(lambda group: group.estimate.pose)

    @property
    def covariance(self) -> Array:
        """Covariances `(N, 3, 3)` of the estimated poses, by the robots' own estimators."""
        return self._gather(lambda group: group.estimate.covariance)

    @property
    def active(self) -> npt.NDArray[np.bool_]:
        """Whether each robot's controller has not ended, `(N,)`."""
        return self._gather(lambda group: group.driver.active)[:, 0]

    @property
    def by_hand(self) -> npt.NDArray[np.bool_]:
        """Whether each robot was handed over and is driven from outside, `(N,)`."""
        return self._gather(lambda group: group.driver.by_hand)[:, 0]

    @property
    def touching(self) -> npt.NDArray[np.bool_]:
        """Whether each robot touched something in the last step while still moving towards it, `(N,)`."""
        world = self._fleet.world
        found = np.zeros((len(self.replicas), world.count), dtype=bool)
        for pair in self._fleet.touching:
            found.flat[[world.owner[body] for body in pair if body != WALL]] = True
        return found[:, : len(self.names)].reshape(-1)

    def _gather(self, of: Callable[[Group], npt.NDArray[Any]]) -> npt.NDArray[Any]:
        if len(self._fleet.groups) == 1:
            whole = of(self._fleet.groups[0]).view()
        else:
            parts = np.concatenate([of(group) for group in self._fleet.groups])
            bodies = np.concatenate([group.bodies for group in self._fleet.groups])
            whole = parts[np.argsort(bodies)]
        whole.flags.writeable = False
        return whole

    @property
    def readings(self) -> Mapping[str, Reading]:
        """Readings `(N, k)` by sensor, true and measured, of all rows; for robots of several models, use `robot`."""
        if len(self._fleet.groups) > 1:
            raise AmorsimError(
                "the robots are of several kinds, whose readings differ in shape; take robot(name).readings"
            )
        return Readings(self._fleet.groups[0])

    @property
    def parts(self) -> tuple[str, ...]:
        """The names of the robots' parts within a replica, such as ``"rover.trailer"``; see `RobotHandle.parts`."""
        return self._fleet.world.names[self._fleet.world.named :]

    @property
    def part_pose(self) -> Array:
        """True poses `(R * P, 3)` of the robots' parts in the world, in order of replica, then as in `parts`."""
        whole = self._fleet.world.poses[self._fleet.world.parts]
        whole.flags.writeable = False
        return whole

    def robot(self, name: str, replica: int | None = None) -> RobotHandle:
        """One robot; `replica` is its replica's number, not needed if there is only one."""
        if name not in self.names:
            known = ", ".join(self.names)
            raise AmorsimError(f"there is no robot {name!r}, but: {known}.{did_you_mean(name, self.names)}")
        return RobotHandle(*self._fleet.robot_row(name, self._replica_index(replica)))

    def obstacle(self, name: str, replica: int | None = None) -> ObstacleHandle:
        """One obstacle; `replica` as for `robot`."""
        names = self._fleet.world.names[len(self.names) : self._fleet.world.named]
        if name not in names:
            known = ", ".join(names) or "none"
            raise AmorsimError(f"there is no obstacle {name!r}, but: {known}.{did_you_mean(name, names)}")
        first = int(self._fleet.world.first[self._replica_index(replica)])
        return ObstacleHandle(*self._fleet.row_of(first + len(self.names) + names.index(name)))

    def map_of(self, replica: int | None = None) -> Map:
        """The map of a replica; `replica` as for `robot`. Replicas have different ones if the scenario draws them."""
        return self._fleet.world.terrain.at(self._replica_index(replica))

    def _replica_index(self, replica: int | None) -> int:
        if replica is None:
            if len(self.replicas) > 1:
                raise AmorsimError("there are several replicas; say which one with replica=")
            return 0
        if replica not in self.replicas:
            raise AmorsimError(f"there is no replica {in_words(replica)}; there are {_in_words(self.replicas)}")
        return self.replicas.index(replica)

    def frames(self) -> list[Frame]:
        """The present step for recorders: all values, a frame for each group of robots that are alike at the start."""
        if self._fleet.scenario is self.scenario:
            return [group.frame() for group in self._fleet.groups]
        return frames_as(self._partition, self._fleet)

    def obstacle_frames(self) -> list[ObstacleFrame]:
        """The obstacles at the present step for recorders: a frame for each group."""
        return [group.frame() for group in self._fleet.obstacles]

    def digest(self, replica: int | None = None) -> str:
        """A fingerprint of all exact results since the start: equal for equal bits. For one replica or for all."""
        wanted = self.replicas if replica is None else (self.replicas[self._replica_index(replica)],)
        whole = hashlib.blake2b(digest_size=16)
        for number in wanted:
            world = self._fleet.world
            first = int(world.first[self.replicas.index(number)])
            for body in range(first, first + world.named):
                group, row = self._fleet.row_of(body)
                whole.update(world.name(body).encode() + group.fingerprint[row].astype("<u8").tobytes())
        return whole.hexdigest()

    # ------------------------------------------------------------------------------------------- changes from outside

    def set_pose(self, name: str, pose: Sequence[float], *, replica: int | None = None) -> None:
        """Move a robot to a pose (x [m], y [m], heading [rad]), at rest. Its own estimate does not change.

        Its parts move with it; their poses relative to the robot stay the same.
        """
        handle = self.robot(name, replica)
        numbers = finite_numbers(pose)
        if numbers is None or len(numbers) != 3:
            raise AmorsimError(f"robot {name!r}: expected a pose of three finite numbers, got {in_words(pose)}")
        self._put(handle, tuple(numbers), "pose_set")

    def _put(self, handle: RobotHandle, numbers: tuple[float, ...], kind: str) -> None:
        """Move a robot to a pose, which is an event of that kind."""
        group, row, name = handle._group, handle._row, handle.name
        wanted = np.array([numbers])
        beyond = outside(self.map_of(handle.replica), *wanted[0, :2].tolist())
        if beyond:
            raise AmorsimError(f"robot {name!r} cannot stand at {numbers}: that {beyond}")
        parts = np.empty((0, 3)) if group.parts is None else group.parts.of_row(row, wanted[0])
        found = self._fleet.overlap(group, row, np.concatenate((wanted, parts)))
        if found:
            raise AmorsimError(f"robot {name!r} cannot stand at {numbers}: it would overlap {found}")
        group.true_pose = _with_row(group.true_pose, row, wanted[0])
        if group.parts is not None:
            group.parts.put(row, parts)
        group.true_twist = _with_row(group.true_twist, row, 0.0)
        group.joint_rates = _with_row(group.joint_rates, row, 0.0)
        self._fleet.place()
        self._fleet.part_from_all(int(group.bodies[row]))
        self._log_change(handle, kind, "pose", numbers)

    def set(self, name: str, path: str, value: Any, *, replica: int | None = None) -> None:
        """Change a parameter of a robot from the next step on; in one replica, or in all if none is given.

        A path such as ``"drive.track"`` sets the nominal value (the true one follows, by its error),
        ``"errors.drive.track.scale"`` the error, ``"sensors.laser.noise.gaussian.std"`` an element of a chain.
        ``"errors.drive.track"`` takes a `Deviation`, or None, by which there is no error any more.

        ``"sensors.laser.noise"`` and ``"ground"`` take a whole chain, in all replicas: a list of noises or of tables as
        in files, ``[{"use": "gaussian", "std": 0.01}]``. Elements that stay keep their states, and nobody else's draws
        change. Handles to robots and `keep_stages` end with it: take new ones.
        """
        if is_chain(path):
            self._set_chain(name, path, value, replica)
            return
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
                self._move_parts(group, rows)
            except (LookupError, ParameterError, ScenarioError) as error:
                group.specified = before
                group.set_parameters()
                reason = error.problem if isinstance(error, ParameterError) else str(error.args[0])
                if isinstance(error, ScenarioError):  # it is about what follows from the value
                    reason = f"{in_words(value)} would be out of bounds, for by it {reason}"
                raise AmorsimError(f"robot {name!r}, {path}: {reason}") from None
        for handle in handles:
            self._log_change(handle, "parameter_set", path, value)

    def _set_chain(self, name: str, path: str, given: Any, replica: int | None) -> None:
        if replica is not None and len(self.replicas) > 1:
            raise AmorsimError(
                f"robot {name!r}, {path}: a chain changes in all replicas at once; leave out replica={replica}"
            )
        robot = self.robot(name, self.replicas[0]).nominal
        elements = read_elements(robot, path, given)
        tables = tables_of(with_chain(robot, path, elements), path)
        try:
            self._fleet = regrouped(self._fleet, {name: {**chains_of(robot), path: elements}})
        except (ComponentError, ScenarioError) as error:
            raise AmorsimError(f"robot {name!r}, {path}: {error}") from None
        for number in self.replicas:
            self._log_change(self.robot(name, number), "parameter_set", path, tables)

    def _move_parts(self, group: Group, rows: Sequence[int]) -> None:
        """Move the parts of some robots to where their drives place them; a `LookupError` names an obstruction."""
        if group.parts is None:
            return
        moved = [group.parts.of_row(row, group.true_pose[row]) for row in rows]
        for row, parts in zip(rows, moved, strict=True):
            found = self._fleet.overlap(group, row, np.concatenate((group.true_pose[row : row + 1], parts)))
            if found:
                raise LookupError(f"with it the robot would overlap {found}")
        for row, parts in zip(rows, moved, strict=True):
            group.parts.put(row, parts)
        self._fleet.place()

    def hand_over(self, name: str, to: str = "hand", *, replica: int | None = None) -> None:
        """Drive a robot from outside from the next step on, or by its controller again.

        By hand, it stands until ``robot(name).drive(...)`` or ``.command(...)`` is called, no collision ends it, and
        its controller is not called and keeps its state. When it is handed back, the controller continues from that
        state, even if a collision had ended it.

        Parameters
        ----------
        to
            ``"hand"`` or ``"controller"``. Nothing happens if the robot is already driven that way.

        Raises
        ------
        AmorsimError
            If the robot has no controller to hand back to.
        """
        handle = self.robot(name, replica)
        if to not in ("hand", "controller"):
            raise AmorsimError(f"robot {name!r}: expected to hand it over to 'hand' or 'controller', got {to!r}")
        if to == "controller" and handle._group.driver.controller is None:
            raise AmorsimError(f"robot {name!r} has no controller; it can only be driven by hand")
        if handle.is_by_hand == (to == "hand") and (to == "hand" or handle.is_active):
            return
        handle._group.driver.hand_over(handle._row, to == "hand")
        self._fleet.part_from_all(int(handle._group.bodies[handle._row]))
        self._log_change(handle, "handed_over", "driver", to)

    def _log_change(self, handle: RobotHandle, kind: str, path: str, value: Any) -> None:
        tick = int(self._fleet.ticks[self.replicas.index(handle.replica)])
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
        """Start all replicas again, or those with the given numbers.

        With a `seed`, everything starts from it, as in a new simulation. Without one, a new episode begins, whose
        draws differ from those of earlier episodes. Parameters that were set stay set.
        """
        if seed is not None:
            if replicas is not None:
                raise AmorsimError("a seed is for all replicas; reset some of them without one")
            seed = _plain(seed)
            check_value(describe(Scenario)["seed"], seed)
            self._build(seed)
            return
        chosen = range(len(self.replicas)) if replicas is None else [self._replica_index(r) for r in replicas]
        again = np.zeros(len(self.replicas), dtype=bool)
        again[list(chosen)] = True
        fleet = self._fleet
        kept = take_snapshot(fleet)
        fleet.ticks = np.zeros_like(fleet.ticks)
        fleet.touching = fleet.contacts = frozenset()
        fleet.episodes = fleet.episodes + again
        fleet.tell_time()  # initial beliefs are drawn at the start
        for group in fleet.everything:
            group.start()
        fleet.place()
        phases.first_look(fleet)
        put_back(fleet, kept, ~again)
        fleet.events = [event for event in kept.events if not again[self.replicas.index(event.replica)]]

    def snapshot(self) -> Snapshot:
        """A copy of all that changes, for `restore`.

        Raises
        ------
        SnapshotError
            If a user's controller cannot be copied; it names the robot.
        """
        return take_snapshot(self._fleet)

    def restore(self, snapshot: Snapshot | bytes) -> None:
        """Return to the state of a `snapshot`, to the bit; it may be restored any number of times.

        Bytes come from `Snapshot.to_bytes`, possibly in another process. They are unpickled, so only restore bytes
        from a source that you trust.

        Raises
        ------
        SnapshotError
            If it belongs to another simulation: other replicas, robots, obstacles or components. Nothing changes then.
        """
        if isinstance(snapshot, bytes):
            snapshot = from_bytes(self._fleet, snapshot)
        if not isinstance(snapshot, Snapshot):
            raise SnapshotError(f"expected what Simulation.snapshot() gave, or its bytes, got {snapshot!r}")
        fleet = self._fleet
        if not fits(fleet, snapshot) and (chains := other_chains(fleet, snapshot)):
            fleet = regrouped(fleet, chains)
        if not fits(fleet, snapshot):
            raise SnapshotError("this snapshot is of another simulation")
        self._fleet = fleet
        if snapshot.seed != self.seed:
            self._build(snapshot.seed, fleet.scenario)
        put_back(self._fleet, snapshot, np.ones(len(self.replicas), dtype=bool))
        self._fleet.events = list(snapshot.events)

    # -------------------------------------------------------------------------------------------------- a picture

    def occupancy(self, resolution: float, *, replica: int | None = None) -> npt.NDArray[np.uint8]:
        """The world as the paper's matrix: 0 free, 1 occupied, 2 a robot; row 0 at the bottom, in the map's frame.

        A cell of `resolution` [m] is occupied if anything in it is.
        """
        return occupancy(self._fleet.world, self._replica_index(replica), resolution)


def _plain(number: Any) -> Any:
    """A NumPy integer as a Python int; anything else unchanged."""
    return int(number) if isinstance(number, np.integer) else number


def _check_memory(scenario: Scenario, replicas: int) -> None:
    """Raise if the arrays would not fit into memory, before any is made."""
    bodies: list[Robot | Obstacle] = [*scenario.robots, *scenario.obstacles]
    each = sum(least_bytes(body, scenario.dt) for body in bodies)
    if problem := too_large(replicas, each):
        longest = max((unit.latency for robot in scenario.robots for unit in robot.sensors.values()), default=0.0)
        late = f" (readings with a latency of {longest:g} s wait for up to {longest / scenario.dt:.6g} steps)"
        hint = late if longest > 1000 * scenario.dt else ""
        who = f"{replicas} replicas: they" if replicas > 1 else "this scenario"
        raise AmorsimError(f"{who} {problem}{hint}")


def _replica_numbers(replicas: int | Sequence[int]) -> tuple[int, ...]:
    try:
        numbers = tuple(range(replicas)) if isinstance(replicas, int) else tuple(operator.index(n) for n in replicas)
    except TypeError:  # one is not an integer
        raise _no_replicas(replicas) from None
    if not numbers or len(set(numbers)) < len(numbers) or min(numbers) < 0 or max(numbers) > MAX_REPLICA:
        raise _no_replicas(replicas)
    return numbers


def _no_replicas(given: Any) -> AmorsimError:
    return AmorsimError(
        f"expected a number of replicas > 0, or a list of different numbers >= 0, got {in_words(given)}"
    )


def _with_row(array: Array, row: int, value: Any) -> Array:
    changed = array.copy()
    changed[row] = value
    return changed


def _in_words(numbers: Sequence[int]) -> str:
    return (
        ", ".join(map(str, numbers)) if len(numbers) < 9 else f"{len(numbers)}, from {min(numbers)} to {max(numbers)}"
    )
