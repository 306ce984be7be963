"""Worlds of robots that learn: all in one simulation, a row for each robot of each world.

All environments are made of these: those of one robot, of agents in one world, and of many such worlds.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import attrs
import gymnasium as gym
import numpy as np

from amorsim.array_types import AnyArray, Array, Bools, Ints
from amorsim.contracts import Controller, Draws, Observable, State, StepOutcome, Task
from amorsim.controllers.manual import Manual
from amorsim.core.draws import stream_key
from amorsim.core.errors import AmorsimError
from amorsim.scenario.spec import Scenario
from amorsim.simulation.simulation import MAX_REPLICA, Simulation

if TYPE_CHECKING:
    from amorsim.ui.watch import Watch

__all__ = ["STUDY", "Worlds"]


STUDY = 0
"""The seed of every simulation here. A world's own seed is the number of its replica."""


class _Kind(NamedTuple):
    """Robots that are alike, in all worlds: what they know comes together."""

    whose: str | list[str]  # as `Simulation.known` takes it
    rows: Ints  # of what each of its robots knows, the row among all robots of all worlds
    columns: dict[int, Ints]  # by the robot's number in a world, where its own rows `(W,)` are among these


class Worlds:
    """The replicas of a scenario, and the task of each of their robots.

    Parameters
    ----------
    scenario
        With robots whose controllers the actions replace.
    task
        What each robot observes, is rewarded for, and draws.
    count
        Number of worlds.
    dtype
        Of observations and actions.
    threads
        That share the simulation's work.
    controller
        That drives all robots in place of the actions.

    Attributes
    ----------
    agents
        The robots' names, in the order of a world's columns.
    simulation
        Whose replicas are the worlds.
    episode
        The task's arrays of the present episodes, with a row for each robot of each world.
    horizon
        Number of actions after which an episode is over.
    low, high
        Bounds of an action.
    action_space
        Of every robot.
    observation_spaces
        In the order of `agents`.

    Raises
    ------
    AmorsimError
        If a period is not a whole number of the scenario's steps.
    """

    def __init__(
        self,
        scenario: Scenario,
        task: Task,
        count: int,
        *,
        dtype: str,
        threads: int = 1,
        controller: Controller | None = None,
    ) -> None:
        self.task, self.count, self.dtype = task, count, np.dtype(dtype)
        self._watch: Watch | None = None
        # Held while the simulation moves, so that a window does not read it meanwhile.
        self._turn: contextlib.AbstractContextManager[Any] = contextlib.nullcontext()
        self._is_driven = controller is None
        driver = Manual() if controller is None else controller
        robots = [attrs.evolve(robot, controller=driver) for robot in scenario.robots]
        self._scenario, self._threads = attrs.evolve(scenario, robots=robots), threads
        self._steps_per_action = _whole_steps(task.period, scenario.dt, "period")
        self.horizon = _whole_steps(task.horizon, task.period, "horizon")
        self.low, self.high = task.action_bounds
        self.begin(range(count))
        self.agents = list(self.simulation.names)
        number = self.dtype.type
        self.action_space = gym.spaces.Box(self.low.astype(number), self.high.astype(number), dtype=number)
        spaces: dict[int, gym.spaces.Box] = {}
        for kind in self._kinds:
            low, high = (bound.astype(number) for bound in task.bounds(self.simulation.known(kind.whose).robot))
            spaces |= {column: gym.spaces.Box(low, high, dtype=number) for column in kind.columns}
        self.observation_spaces = [spaces[column] for column in range(len(self.agents))]

    def begin(self, seeds: Sequence[int]) -> None:
        """Begin the first episodes of these seeds.

        Raises
        ------
        ValueError
            If they are not so many different whole numbers from 0 to 2^32 - 2.
        """
        are_fine = all(isinstance(one, (int, np.integer)) and 0 <= one <= MAX_REPLICA for one in seeds)
        if not are_fine or len(set(seeds)) != self.count:
            raise ValueError(
                f"seed: expected {self.count} different whole numbers from 0 to {MAX_REPLICA}, got {list(seeds)!r}"
            )
        numbers = [int(one) for one in seeds]
        self.simulation = Simulation(self._scenario, seed=STUDY, replicas=numbers, threads=self._threads)
        self._kinds = _kinds_of(self.simulation)
        self._action = np.zeros((self.count, len(self.simulation.names), len(self.low)))
        self._begin_task(np.arange(self.count))
        self._take_window()

    def begin_again(self, which: Bools) -> None:
        """Begin the next episodes of some worlds `(W,)`."""
        numbers, worlds = self.simulation.replicas, np.flatnonzero(which)
        with self._turn:
            self.simulation.reset(replicas=[numbers[world] for world in worlds.tolist()])
            self._begin_task(worlds)
        self._take_window()

    def _begin_task(self, worlds: Ints) -> None:
        robots = len(self.simulation.names)
        rows = (worlds[:, None] * robots + np.arange(robots)).reshape(-1)
        counter = np.zeros((len(rows), 3), dtype=np.uint32)
        counter[:, 0] = np.array(self.simulation.replicas, dtype=np.uint32)[rows // robots]
        counter[:, 1] = self.simulation.episodes[rows // robots]
        counter[:, 2] = rows % robots
        draws = Draws(np.full(len(rows), stream_key(STUDY, "task"), dtype=np.uint64), counter)
        begun = self.task.begin(self.simulation.truth(rows.tolist()), draws)
        if len(worlds) == self.count:
            self.episode: State = begun
        else:
            for name, array in begun.items():
                self.episode[name][rows] = array
        self._action[worlds] = 0.0

    def act(self, actions: Array, is_on: Bools | None = None) -> StepOutcome:
        """Take actions `(W, A, a)`, of robots that are on `(W, A)`; others stand. Returns the outcome `(W * A,)`."""
        self._action = np.minimum(np.maximum(actions, self.low), self.high)
        if is_on is not None:
            self._action[~is_on] = 0.0
        step = self.simulation.step if self._watch is None else self._watch.step
        with self._turn:
            if self._is_driven:
                self._drive(is_on)
            for _ in range(self._steps_per_action):
                step()
            return self.task.judge(self.simulation.truth(), self.episode)

    def _drive(self, is_on: Bools | None) -> None:
        parts: Sequence[Array] = self.task.velocities(self._action.reshape(-1, len(self.low)))
        if is_on is not None:
            parts = [np.where(is_on.reshape(-1), part, 0.0) for part in parts]
        for column, name in enumerate(self.agents):
            forward, turn, left = (part[column :: len(self.agents)] for part in parts)
            self.simulation.drive(name, forward=forward, turn=turn, left=left)

    def observe(self) -> list[AnyArray]:
        """The observations `(W, k)` of each robot of a world, arrays of their own."""
        found: dict[int, AnyArray] = {}
        actions = self._action.reshape(-1, len(self.low))
        for kind in self._kinds:
            known = self.simulation.known(kind.whose)
            if len(self.agents) == 1:
                return [self.task.observe(Observable(*known, actions), self.episode).astype(self.dtype)]
            episode = {name: array[kind.rows] for name, array in self.episode.items()}
            seen = self.task.observe(Observable(*known, actions[kind.rows]), episode).astype(self.dtype)
            found |= {column: seen[rows] for column, rows in kind.columns.items()}
        return [found[column] for column in range(len(self.agents))]

    def privileged(self) -> AnyArray:
        """True quantities for a critic `(W, A, p)`."""
        found = self.task.privileged(self.simulation.truth(), self.episode).astype(self.dtype)
        return found.reshape(self.count, len(self.simulation.names), -1)

    # ---------------------------------------------------------------------------------------------------- the window

    def show(self) -> None:
        """Show the one world in the Simulator's window, at most as fast as its robots act; the first call opens it.

        Raises
        ------
        AmorsimError
            If there are several worlds, or the extra ``ui`` is not installed.
        """
        if self._watch is None:
            from amorsim.ui.watch import Watch

            self._watch = Watch(self.simulation, name=type(self.task).__name__, goal_of=self._goal_of)
            self._turn = self._watch.lock
        self._watch.show(self.task.period)

    def _goal_of(self, robot: int) -> Array | None:
        goal = self.episode.get("goal")
        return None if goal is None else goal[robot, :2]

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._watch is not None:
            self._watch.close()

    def _take_window(self) -> None:
        """Let the window show the episode that has begun, whose world may be another one."""
        if self._watch is not None:
            self._watch.take(self.simulation)


def _kinds_of(simulation: Simulation) -> list[_Kind]:
    names, kinds = simulation.names, []
    world = {number: place for place, number in enumerate(simulation.replicas)}
    for frame in simulation.frames():
        place = np.array([world[int(number)] for number in frame.replica])
        column = np.array([names.index(name) for name in frame.names])
        columns = {}
        for one in np.unique(column).tolist():
            own = np.flatnonzero(column == one)
            columns[one] = own[np.argsort(place[own])]
        kinds.append(_Kind(names[0] if len(names) == 1 else list(frame.names), place * len(names) + column, columns))
    return kinds


def _whole_steps(time: float, step: float, name: str) -> int:
    """How many steps [s] a time [s] has; raises `AmorsimError` if they are not a whole number."""
    count = round(time / step)
    if count < 1 or abs(count * step - time) > 1e-9 * time:
        raise AmorsimError(f"{name}: expected a whole number of steps of {step:g} s, got {time:g} s")
    return count
