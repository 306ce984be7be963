"""One chunk of a study: all replicas of a point for one seed, simulated and measured."""

from __future__ import annotations

import contextlib
import math
import shutil
import signal
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Array, Bools, Ints
from amorsim.contracts import Episode
from amorsim.core.arguments import texts
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import AmorsimError, ComponentError, ScenarioError, StudyError
from amorsim.core.parameters import ParameterError
from amorsim.core.unknown_names import no_such
from amorsim.runs.session import RunSession
from amorsim.scenario.programs.programs import loaded_component
from amorsim.scenario.reading.read import load
from amorsim.scenario.spec import Scenario
from amorsim.simulation.kept_quantities import Keeper
from amorsim.simulation.simulation import Simulation
from amorsim.sweeps.plan import Chunk, Measured, Plan
from amorsim.worlds.drawn import origin_of

__all__ = [
    "Outcome",
    "episode_at",
    "measure_episode",
    "quantities",
    "robot_of",
    "run_chunk",
    "simulation_of",
    "with_metrics",
]


@attrs.frozen(kw_only=True)
class Outcome:
    """The outcome of a chunk: the values of each metric and a digest, for each replica; or an error.

    `seed` is the one that was simulated; below 0 if that is not known.
    """

    index: int
    seed: int = -1
    values: dict[str, list[float]] = attrs.field(factory=dict)
    digests: list[str] = attrs.field(factory=list)
    error: str = ""


def run_chunk(plan: Plan, index: int, folder: str = "") -> Outcome:
    """Simulate and measure a chunk; an error in it becomes its outcome.

    Parameters
    ----------
    folder
        Where the run is recorded, if it is kept.
    """
    try:
        return _run(with_metrics(plan), plan.chunk(index), folder)
    except AmorsimError as error:
        return Outcome(index=index, error=str(error))
    except RAISED as error:  # of a user's component
        return Outcome(index=index, error=error_in_words(error))


def ignore_interrupts() -> None:
    """Leave Ctrl-C to the process that spreads the work."""
    if threading.current_thread() is threading.main_thread():
        with contextlib.suppress(ValueError):
            signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextlib.contextmanager
def without_interrupts() -> Iterator[None]:
    """Ignore Ctrl-C for a moment: processes that are started meanwhile ignore it from their first line on.

    Else they would show Python's traceback, for a terminal sends it to all of them. It takes some 50 ms.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def simulation_of(plan: Plan, chunk: Chunk, replicas: int | Sequence[int]) -> Simulation:
    """The simulation of a chunk."""
    scenario = load(plan.scenario, chunk.settings)
    return Simulation(scenario, seed=None if chunk.seed < 0 else chunk.seed, replicas=replicas)


def with_metrics(plan: Plan) -> Plan:
    """The study with the metrics from users' files, which are run for that.

    Raises
    ------
    StudyError
        With all that is wrong with them.
    """
    try:
        metrics = [attrs.evolve(each, metric=loaded_component(each.metric)) for each in plan.metrics]
    except ScenarioError as error:
        raise StudyError(str(error)) from error
    return attrs.evolve(plan, metrics=tuple(metrics))


def quantities(plan: Plan) -> tuple[str, ...]:
    """The quantities that the metrics need."""
    return tuple(dict.fromkeys(name for each in plan.metrics for name in _needs(each)))


def _needs(measured: Measured) -> tuple[str, ...]:
    """The quantities that a metric needs.

    Raises
    ------
    ComponentError
        If it raises, or gives anything else than names.
    """
    who = f"metrics.{measured.name}: {type(measured.metric).__name__}.needs()"
    try:
        given = measured.metric.needs()
    except RAISED as error:
        raise ComponentError(f"{who} raised {error_in_words(error)}") from error
    try:
        return texts(given, who, "names")
    except ParameterError as error:
        raise ComponentError(str(error)) from None


def robot_of(measured: Measured, names: Sequence[str]) -> str:
    """The robot that a metric is of.

    Raises
    ------
    StudyError
        If there is none of that name, or several and none is named.
    """
    if measured.robot:
        if measured.robot not in names:
            raise StudyError(f"metrics.{measured.name}.robot: {no_such('robot', measured.robot, names)}")
        return measured.robot
    if len(names) > 1:
        raise StudyError(
            f"metrics.{measured.name}: there are several robots; say which with robot = one of: {', '.join(names)}"
        )
    return names[0]


def _run(plan: Plan, chunk: Chunk, folder: str) -> Outcome:
    simulation = simulation_of(plan, chunk, plan.replicas)
    robots = {each.name: robot_of(each, simulation.names) for each in plan.metrics}
    duration = simulation.scenario.duration if plan.duration is None else plan.duration
    steps = simulation.steps_of(duration)
    keeper = Keeper(simulation, quantities(plan), steps + 1)
    session = None
    if folder:
        shutil.rmtree(folder, ignore_errors=True)  # of an earlier try
        session = RunSession(simulation, Path(folder), duration=duration)
    ends, digests = _simulate(simulation, keeper, steps, plan.stop, session)
    values = {}
    for each in plan.metrics:
        found = np.full(len(simulation.replicas), math.nan)
        for end in np.unique(ends).tolist():
            rows = np.flatnonzero(ends == end)
            episode = episode_at(simulation, keeper.arrays, each.metric.needs(), robots[each.name], rows, end)
            found[rows] = measure_episode(each, episode)
        values[each.name] = found.tolist()
    return Outcome(index=chunk.index, seed=simulation.seed, values=values, digests=digests)


def _simulate(
    simulation: Simulation, keeper: Keeper, steps: int, stop: str, session: RunSession | None
) -> tuple[Ints, list[str]]:
    """The step at which each replica ended, and its digest then."""
    replicas = simulation.replicas
    ends = np.full(len(replicas), steps)
    digests = [""] * len(replicas)
    goes_on = np.ones(len(replicas), dtype=bool)
    ended = _ENDED[stop](simulation) if stop in _ENDED else None
    keeper.keep()
    with contextlib.ExitStack() as stack:
        if session is not None:
            stack.enter_context(session)
        for step in range(1, steps + 1):
            simulation.step()
            keeper.keep()
            if session is not None:
                session.keep()
            if ended is None:
                continue
            now = ended.look() & goes_on
            for row in np.flatnonzero(now).tolist():
                ends[row], digests[row], goes_on[row] = step, simulation.digest(replicas[row]), False
            if now.any():
                keeper.keep_last(now)
            if not goes_on.any():
                break
    keeper.keep_last(goes_on)
    for row, replica in enumerate(replicas):
        digests[row] = digests[row] or simulation.digest(replica)
    return ends, digests


class _Collided:
    """Replicas in which a robot ran into something, or something into a robot."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._robots = frozenset(simulation.names)  # obstacles that move collide too
        self._seen = 0
        self._places = {replica: row for row, replica in enumerate(simulation.replicas)}

    def look(self) -> Bools:
        """Those of the last step `(R,)`."""
        found = np.zeros(len(self._places), dtype=bool)
        for event in self._simulation.events[self._seen :]:
            if event.kind == "collision" and event.name in self._robots:
                found[self._places[event.replica]] = True
        self._seen = len(self._simulation.events)
        return found


class _Still:
    """Replicas in which no robot has moved for `_STILL`, after one had moved."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._poses = simulation.true_pose.copy()
        self._wanted = simulation.steps_of(_STILL)
        self._has_moved = np.zeros(len(simulation.replicas), dtype=bool)
        self._steps = np.zeros(len(simulation.replicas), dtype=np.int64)

    def look(self) -> Bools:
        """Those that are still by now `(R,)`."""
        poses = self._simulation.true_pose
        moves = (np.abs(poses - self._poses) > _STANDS).reshape(len(self._steps), -1).any(axis=1)
        self._poses = poses.copy()
        self._has_moved |= moves
        self._steps = np.where(moves, 0, self._steps + 1)
        return self._has_moved & (self._steps >= self._wanted)


_STILL = 1.0  # [s]
_STANDS = 1e-6  # [m, rad] in a step: motors with a lag come to rest only in the limit
_ENDED: Mapping[str, type[_Collided] | type[_Still]] = {"collision": _Collided, "still": _Still}


def episode_at(
    simulation: Simulation,
    arrays: Mapping[str, AnyArray],
    needs: Sequence[str],
    robot: str,
    rows: Ints,
    end: int,
) -> Episode:
    """A metric's view of a robot in some replicas, from the start to the step at which they ended.

    Parameters
    ----------
    arrays
        What was kept from the start on.
    needs
        What of it the metric asks for.
    rows
        The places of the replicas.
    """
    scenario: Scenario = simulation.scenario
    specified = next(each for each in scenario.robots if each.name == robot)
    names, dt = simulation.names, simulation.dt
    replicas = [simulation.replicas[row] for row in rows.tolist()]
    places = rows * len(names) + names.index(robot)
    wanted = set(replicas)
    return Episode(
        robot=robot,
        replicas=replicas,
        time=np.arange(end + 1, dtype=np.float64) * dt,
        kept={name: np.ascontiguousarray(arrays[name][: end + 1, places]) for name in needs},
        events=[
            event
            for event in simulation.events
            if event.name == robot and event.replica in wanted and event.time <= end * dt * (1.0 + 1e-12)
        ],
        map=scenario.map,
        shape=specified.shape,
        parts=specified.drive.parts,
        maps=() if origin_of(scenario.map) is None else [simulation.map_of(replica) for replica in replicas],
    )


def measure_episode(measured: Measured, episode: Episode) -> Array:
    """The metric's values of an episode `(R,)`.

    Raises
    ------
    ComponentError
        If it gives anything else.
    """
    values = measured.metric.measure(episode)
    if not isinstance(values, np.ndarray) or values.shape != (len(episode.replicas),):
        got = getattr(values, "shape", type(values).__name__)
        raise ComponentError(
            f"metrics.{measured.name}: {type(measured.metric).__name__}.measure() gave {got}; expected a number for "
            f"each of {len(episode.replicas)} replicas"
        )
    return values
