"""A simulation: the robots of a scenario, in one or many replicas, step by step."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Annotated, Any, overload

import numpy as np
import numpy.typing as npt

from amorsim.array_types import AnyArray, Array, Bools, Ints
from amorsim.contracts import Frame, ObstacleFrame, TrueState
from amorsim.core.arguments import check_kind, checked, real, whole
from amorsim.core.display import in_notebook
from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError
from amorsim.core.execution.interrupt import Interrupt
from amorsim.core.execution.progress import progress_shown
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.unknown_names import no_such
from amorsim.scenario.programs.programs import loaded
from amorsim.scenario.reading.chains import is_chain
from amorsim.scenario.spec import Scenario
from amorsim.simulation import phases
from amorsim.simulation.checked_arguments import (
    MAX_REPLICA,
    MOST_STEPS,
    checked_seed,
    numbers_in_words,
    replica_numbers,
)
from amorsim.simulation.events import Event
from amorsim.simulation.fleet.fleet import Fleet
from amorsim.simulation.handle import Known, ObstacleHandle, Reading, Readings, RobotHandle, finite_numbers
from amorsim.simulation.kept_quantities import Keeper
from amorsim.simulation.manual_driving import drive_all
from amorsim.simulation.schedule import Schedule
from amorsim.simulation.state import interventions
from amorsim.simulation.state.gathering import digest_of, gathered, touching_robots
from amorsim.simulation.state.regroup import frames_as
from amorsim.simulation.state.restart import begin_episode, fleet_fitting
from amorsim.simulation.state.snapshot import Snapshot, put_back, take_snapshot
from amorsim.simulation.state.true_state import true_state
from amorsim.simulation.world.occupancy import occupancy
from amorsim.simulation.world.terrain import Terrains

__all__ = ["MAX_REPLICA", "MOST_STEPS", "Simulation"]


class Simulation:
    """Robots as rows: one row is one robot in one replica, in order of replica, then of name.

    Components that a scenario's file names as ``"FILE.py:NAME"`` are loaded now, which runs their files.

    Parameters
    ----------
    scenario
        The scenario to simulate.
    seed
        Replaces the scenario's seed.
    replicas
        The number of replicas, or their numbers. Replica 37 of many gives the same bits as replica 37 alone.
    threads
        The number of threads that share long work, useful from some hundreds of robots; it does not change the bits.

    Raises
    ------
    ParameterError
        If it is given anything but a scenario; `am.load` makes one from a file or the name of a bundled one.
    ScenarioError
        With every fault that only shows now: a component in a file that cannot be loaded, a start in a wall
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
        check_kind(scenario, Scenario, "scenario", "a Scenario, as am.load('demo')")
        threads = whole(threads, "threads", "a number of threads >= 1", least=1)
        self.threads = threads
        self.dt = scenario.dt
        self.replicas = replica_numbers(scenario, replicas)
        seed = checked_seed(scenario.seed if seed is None else seed)
        self.scenario = loaded(scenario)
        self._terrains = Terrains(self.replicas)
        self._starts = 0  # how often it was made, reset or restored
        self._build(seed)

    def _build(self, seed: int, scenario: Scenario | None = None) -> None:
        self._hold(Fleet(scenario or self.scenario, seed, self.replicas, self.threads, self._terrains))
        # Recorders keep the groups of the beginning, whatever chains robots come to have.
        self._partition = tuple(tuple(group.names) for group in self._fleet.groups)
        self._starts += 1
        self._began: int | None = None  # the tick at which a step began that has not ended
        phases.first_look(self._fleet)

    _fleet: Fleet

    def _hold(self, fleet: Fleet) -> None:
        """Simulate with a fleet from now on, and let go of the one before."""
        before, self._fleet = vars(self).get("_fleet"), fleet
        if before is not None and before is not fleet:
            before.release()

    def __del__(self) -> None:
        if (fleet := vars(self).get("_fleet")) is not None:
            fleet.release()

    _repr_mimebundle_ = in_notebook

    def __repr__(self) -> str:
        scenario, ticks = self.scenario, sorted(set(self._fleet.ticks.tolist()))
        name = scenario.source.stem if scenario.source else scenario.map.name
        counts = [
            (len(scenario.robots), "robot"),
            (len(scenario.obstacles), "obstacle"),
            (len(self.replicas), "replica"),
        ]
        parts = [f"{count} {what}{'s' if count > 1 else ''}" for count, what in counts if count]
        times = " to ".join(f"{tick * self.dt:g}" for tick in dict.fromkeys((ticks[0], ticks[-1])))
        return f"<Simulation{f' of {name!r}' if name else ''}: {', '.join(parts)}, seed {self.seed}, at {times} s>"

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
        """Simulate one step: the `PHASES` in order, after robots that are kidnapped now were carried away.

        Raises
        ------
        AmorsimError
            If the step before was broken off: by Ctrl-C, or by an error of a component.
        """
        if self._began is not None:
            raise AmorsimError(
                f"the step after {self._began * self.dt:g} s was broken off, so some robots have made "
                "half of it; expected restore(snapshot), reset() or a new simulation before the next step"
            )
        self._began = int(self._fleet.ticks[0])
        if self._fleet.kidnappings:
            self._kidnap()
        phases.step(self._fleet)
        self._began = None

    @property
    def schedule(self) -> Schedule:
        """The calls of a step, in order: ``print(sim.schedule)``; with the time of each: ``sim.schedule.profile()``."""
        return Schedule(lambda: phases.calls_of(self._fleet), self._try_steps)

    def _try_steps(self, steps: int, step: Callable[[], None]) -> None:
        """Make steps in some way, and put everything back to where it was."""
        before = self.snapshot()
        try:
            for _ in range(steps):
                step()
        finally:
            self.restore(before)

    def _kidnap(self) -> None:
        moves = [
            (self.robot(name, replica), pose)
            for replica, tick in zip(self.replicas, self._fleet.ticks.tolist(), strict=True)
            for name, pose in self._fleet.kidnappings.get(tick, ())
        ]
        if moves:
            interventions.move(self._fleet, moves, "kidnapped")

    @overload
    def run(self, duration: float | None = None, *, progress: bool = True) -> None: ...

    @overload
    def run(
        self, duration: float | None = None, *, keep: Iterable[str], progress: bool = True
    ) -> dict[str, AnyArray]: ...

    def run(
        self, duration: float | None = None, *, keep: Iterable[str] | None = None, progress: bool = True
    ) -> dict[str, AnyArray] | None:
        """Step for `duration` [s]; without it, for the scenario's duration.

        Ctrl-C, or the stop of a notebook, raises `KeyboardInterrupt` after the present step, so `run` can go on from
        there. A controller or plugin that does not return is broken off at once.

        ::

            kept = simulation.run(60, keep=("true_pose", "estimated_pose", "readings.laser"))
            kept["readings.laser"]  # (steps, N, beams) as measured, after each step

        Parameters
        ----------
        keep
            Quantities to return, by name: arrays ``(steps, N, ...)`` of the values after each step, with rows as those
            of `true_pose`. Names are ``true_pose``, ``estimated_pose``, ``covariance``, ``true_twist``,
            ``joint_rates``, ``command``, ``active``, ``by_hand``, ``touching``; ``part_pose``, which is ``(steps, N,
            parts, 3)``; ``readings.NAME``, which is what was measured, or ``readings.NAME.true``, ``.stamp`` [steps],
            ``.age`` [s], ``.fresh``; ``estimates.NAME.pose`` and ``.covariance``; ``beliefs.NAME.BELIEF``. With
            ``last.`` before it, a quantity is ``(1, N, ...)``, of the last step alone. What a robot does not have, and
            another has, is nan.
        progress
            Whether a bar is shown after two seconds, in a terminal or a notebook.

        Raises
        ------
        AmorsimError
            If the duration is not a number, below 0, or longer than 2^32 - 1 steps; if a name in `keep` is unknown, or
            the arrays would not fit into memory, before any step is made.
        """
        steps = self.steps_of(self.scenario.duration if duration is None else duration)
        keeper = None if keep is None else Keeper(self, keep, steps)
        with Interrupt() as interrupt, progress_shown(progress, "simulating", float) as show:
            for done in range(1, steps + 1):
                interrupt.call(self.step)
                if show is not None:
                    show(done / steps)
                if keeper is not None:
                    keeper.keep()
                if interrupt.is_wanted:
                    raise KeyboardInterrupt
        if keeper is None:
            return None
        keeper.keep_last()
        return keeper.arrays

    def steps_of(self, duration: float) -> int:
        """The number of steps in a duration [s], rounded up.

        Raises
        ------
        ParameterError
            If the duration is not a number, below 0, or longer than 2^32 - 1 steps.
        """
        most = MOST_STEPS * self.dt
        expected = f"a number of seconds >= 0 and <= {most:g} (2^32 - 1 steps of {self.dt:g} s)"
        seconds = real(duration, "duration", expected)
        if not 0.0 <= seconds <= most:
            raise ParameterError("duration", f"expected {expected}, got {in_words(duration)}")
        return int(np.ceil(seconds / self.dt - 1e-9))

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
    def episodes(self) -> Ints:
        """The number of each replica's present episode, `(R,)`: 0 until it is reset."""
        return self._fleet.episodes.copy()

    @property
    def names(self) -> tuple[str, ...]:
        """The robots' names, in the order of their rows within a replica."""
        return self._fleet.names

    @property
    def true_pose(self) -> Array:
        """True poses (x [m], y [m], heading [rad]) in the world `(N, 3)`, in order of replica, then of name."""
        return gathered(self._fleet, lambda group: group.true_pose)

    @property
    def true_twist(self) -> Array:
        """True velocities (forward, left [m/s], turn [rad/s]) in each robot's frame `(N, 3)`, of the last step."""
        return gathered(self._fleet, lambda group: group.true_twist)

    @property
    def estimated_pose(self) -> Array:
        """Estimated poses `(N, 3)` in the world, as each robot's controller receives them."""
        return gathered(self._fleet, lambda group: group.estimate.pose)

    @property
    def covariance(self) -> Array:
        """Covariances `(N, 3, 3)` of the estimated poses, by the robots' own estimators."""
        return gathered(self._fleet, lambda group: group.estimate.covariance)

    @property
    def active(self) -> Bools:
        """Whether each robot's controller has not ended, `(N,)`."""
        return gathered(self._fleet, lambda group: group.driver.active)[:, 0]

    @property
    def by_hand(self) -> Bools:
        """Whether each robot was handed over and is driven from outside, `(N,)`."""
        return gathered(self._fleet, lambda group: group.driver.by_hand)[:, 0]

    @property
    def touching(self) -> Bools:
        """Whether each robot touched something in the last step while still moving towards it, `(N,)`."""
        return touching_robots(self._fleet)

    @property
    def readings(self) -> Mapping[str, Reading]:
        """Readings `(N, k)` by sensor, true and measured, of all rows; for robots of several models, use `robot`."""
        if len(self._fleet.groups) > 1:
            raise AmorsimError(
                "the robots are of several kinds, whose readings differ in shape; take robot(name).readings"
            )
        return Readings(self._fleet.groups[0])

    @checked
    def known(self, name: str | Sequence[str]) -> Known:
        """What a robot knows, a row for each replica: as its controller is given it. Read it again after a step.

        Of several robots that are alike, give the names of all, in the order of the rows: those of a frame's `names`.

        Raises
        ------
        AmorsimError
            If there is no such robot, or others of the same model, whose rows lie between its own.
        """
        names = [name] if isinstance(name, str) else list(name)
        if not names:
            raise AmorsimError(f"name: expected the name of a robot, or of several; the robots: {in_words(self.names)}")
        for one in names:
            if one not in self.names:
                raise AmorsimError(no_such("robot", one, self.names))
        group = next(group for group in self._fleet.groups if names[0] in group.names)
        if isinstance(name, str) and group.rows != len(self.replicas):
            raise AmorsimError(f"robot {name!r}: others are of the same model; take robot(name, replica) of each")
        if not isinstance(name, str) and group.names != names:
            raise AmorsimError(f"robots {', '.join(names)}: expected all that are alike, row by row, as in a frame")
        return Known(group.robot, group.readings, group.estimate)

    @checked
    def truth(self, rows: Sequence[int] | None = None) -> TrueState:
        """The true state of all robots, or of some rows of `true_pose`: as a task for learners is given it.

        Raises
        ------
        AmorsimError
            If there is no such row.
        """
        if rows is None:
            return true_state(self._fleet)
        count = len(self.replicas) * len(self.names)
        if not all(0 <= row < count for row in rows):
            raise AmorsimError(f"rows: expected numbers from 0 to {count - 1}, got {in_words(rows)}")
        return true_state(self._fleet, np.asarray(list(rows), dtype=np.int64))

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
        if not isinstance(name, str) or name not in self.names:
            raise AmorsimError(no_such("robot", name, self.names))
        return RobotHandle(lambda: self._fleet, self._fleet.body_of(name, self._replica_index(replica)))

    def obstacle(self, name: str, replica: int | None = None) -> ObstacleHandle:
        """One obstacle; `replica` as for `robot`."""
        names = self._fleet.world.names[len(self.names) : self._fleet.world.named]
        if not isinstance(name, str) or name not in names:
            raise AmorsimError(no_such("obstacle", name, names))
        return ObstacleHandle(lambda: self._fleet, self._fleet.body_of(name, self._replica_index(replica)))

    def map_of(self, replica: int | None = None) -> Map:
        """The map of a replica; `replica` as for `robot`. Replicas have different ones if the scenario draws them."""
        return self._fleet.world.terrain.at(self._replica_index(replica))

    def _replica_index(self, replica: int | None) -> int:
        if replica is None:
            if len(self.replicas) > 1:
                raise AmorsimError("there are several replicas; say which one with replica=")
            return 0
        number = int(replica) if isinstance(replica, (int, np.integer)) else -1
        if number not in self.replicas:
            raise AmorsimError(f"no replica {in_words(replica)}; known replicas: {numbers_in_words(self.replicas)}")
        return self.replicas.index(number)

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
        return digest_of(self._fleet, wanted)

    # ------------------------------------------------------------------------------------------- changes from outside

    def set_pose(self, name: str, pose: Sequence[float], *, replica: int | None = None) -> None:
        """Move a robot to a pose (x [m], y [m], heading [rad]), at rest. Its own estimate does not change.

        Its parts move with it; their poses relative to the robot stay the same.
        """
        handle = self.robot(name, replica)
        numbers = finite_numbers(pose)
        if numbers is None or len(numbers) != 3:
            raise AmorsimError(f"robot {name!r}: expected a pose of three finite numbers, got {in_words(pose)}")
        interventions.move(self._fleet, [(handle, tuple(numbers))], "pose_set")

    def set(self, name: str, path: str, value: Any, *, replica: int | None = None) -> None:
        """Change a parameter of a robot from the next step on; in one replica, or in all if none is given.

        A path such as ``"drive.track"`` sets the nominal value (the true one follows, by its error),
        ``"errors.drive.track.scale"`` the error, ``"sensors.laser.noise.gaussian.std"`` an element of a chain.
        ``"errors.drive.track"`` takes a `Deviation`, or None, which removes the error.

        ``"sensors.laser.noise"`` and ``"ground"`` take a whole chain, in all replicas: a list of noises or of tables as
        in files, ``[{"use": "gaussian", "std": 0.01}]``. Elements that stay keep their states, and no other draws
        change. `keep_stages` ends with it: take a new one.
        """
        if not is_chain(path):
            numbers = self.replicas if replica is None else (replica,)
            interventions.set_parameter(self._fleet, [self.robot(name, number) for number in numbers], path, value)
            return
        if replica is not None and len(self.replicas) > 1:
            raise AmorsimError(
                f"robot {name!r}, {path}: a chain changes in all replicas at once; leave out replica={replica}"
            )
        self.robot(name, self.replicas[0])  # is there one?
        self._hold(interventions.with_other_chain(self._fleet, name, path, value))

    def drive(self, name: str, forward: Any = 0.0, turn: Any = 0.0, left: Any = 0.0) -> None:
        """Set the velocity of a robot in all replicas at once: forward [m/s], turn [rad/s], left [m/s].

        It is held until the next. Each is a number, or an array `(R,)` in the order of `replicas`. In each replica it
        does what ``robot(name, replica).drive`` does.

        Raises
        ------
        AmorsimError
            If the robot is not driven from outside: its controller is not ``manual`` and it was not handed over; or if
            these are not finite numbers, of which 1e12 is the largest.
        """
        drive_all(self._fleet, name, forward, left, turn)

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
        interventions.hand_over(self._fleet, self.robot(name, replica), to)

    @checked
    def reset(
        self, seed: Annotated[int | None, "a whole number >= 0"] = None, replicas: Sequence[int] | None = None
    ) -> None:
        """Start all replicas again, or those with the given numbers.

        With a `seed`, everything starts from it, as in a new simulation, without the changes that were made to this
        one. Without a seed a new episode begins, whose draws differ from those of earlier episodes, and parameters that
        were set stay set.
        """
        if seed is not None:
            if replicas is not None:
                raise AmorsimError("a seed is for all replicas; reset some of them without one")
            self._build(checked_seed(seed))
            return
        chosen = range(len(self.replicas)) if replicas is None else [self._replica_index(r) for r in replicas]
        again = np.zeros(len(self.replicas), dtype=bool)
        again[list(chosen)] = True
        begin_episode(self._fleet, again)
        self._starts += 1
        if again.all():
            self._began = None

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
        fleet, snapshot = fleet_fitting(self._fleet, snapshot)
        self._hold(fleet)
        if snapshot.seed != self.seed:
            self._build(snapshot.seed, fleet.scenario)
        put_back(self._fleet, snapshot, np.ones(len(self.replicas), dtype=bool))
        self._starts += 1
        self._began = None
        self._fleet.events = list(snapshot.events)

    # -------------------------------------------------------------------------------------------------- a picture

    def occupancy(self, resolution: float, *, replica: int | None = None) -> npt.NDArray[np.uint8]:
        """The world as the paper's matrix: 0 free, 1 occupied, 2 a robot; row 0 at the bottom, in the map's frame.

        A cell of `resolution` [m] is occupied if anything in it is.
        """
        side = real(resolution, "resolution", "the side of a cell [m] > 0")
        return occupancy(self._fleet.world, self._replica_index(replica), side)
