"""The tasks that come with amorsim, by their names in Gymnasium."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import gymnasium as gym

from amorsim.contracts import Controller, Task
from amorsim.core.errors import AmorsimError
from amorsim.core.unknown_names import no_such
from amorsim.learning.many_worlds import SimulationParallelVectorEnv
from amorsim.learning.single import SimulationEnv
from amorsim.learning.vector import SimulationVectorEnv
from amorsim.scenario.reading.read import load
from amorsim.scenario.spec import Scenario

if TYPE_CHECKING:
    from amorsim.learning.parallel import SimulationParallelEnv

__all__ = ["TASKS", "load_environment", "make", "make_parallel", "make_parallel_vec", "make_vec", "register_all"]

_SCENARIOS = Path(__file__).parent / "scenarios"


TASKS = {
    "amorsim/PointGoal-v0": "point-goal.toml",
    "amorsim/Maze-v0": "maze.toml",
    "amorsim/Barn-v0": "barn.toml",
    "amorsim/Crowd-v0": "crowd.toml",
    "amorsim/Doors-v0": "doors.toml",
    "amorsim/Corridor-v0": "corridor.toml",
    "amorsim/FindYourself-v0": "find-yourself.toml",
    "amorsim/Follow-v0": "follow.toml",
    "amorsim/Dock-v0": "dock.toml",
    "amorsim/Trailer-v0": "trailer.toml",
    "amorsim/Line-v0": "line.toml",
}
"""The scenario of each, by the name that Gymnasium has for it."""

_OF_MANY = {"amorsim/Crossing-v0": "crossing.toml"}


def register_all() -> None:
    """Make the tasks known to Gymnasium."""
    for name in TASKS:
        gym.register(
            name,
            entry_point="amorsim.learning.registration:make",
            vector_entry_point="amorsim.learning.registration:make_vec",
            kwargs={"what": name},
            disable_env_checker=True,  # the tests run it; it would reset every environment that is made
            order_enforce=False,
        )


def make_vec(
    what: str | os.PathLike[str] | Scenario,
    num_envs: int = 1,
    *,
    task: Task | None = None,
    autoreset_mode: Any = "NextStep",
    privileged: bool = False,
    dtype: str = "float32",
    threads: int = 1,
    render_mode: str | None = None,
    controller: Controller | None = None,
    drawn: bool = False,
    **parameters: Any,
) -> SimulationVectorEnv:
    """A vector environment: of a task by its name, or of a scenario of your own.

    ::

        envs = make_vec("amorsim/PointGoal-v0", 64, distance=(1.0, 3.0))
        envs = make_vec("my-office.toml", 64)  # whose [task] names the task
        envs = make_vec("demo", 64, task=PointGoal(sensor="sonar"))

    Parameters
    ----------
    what
        The name of a task, or a scenario: its file, its bundled name or the object. It has one robot, whose
        controller the actions replace.
    num_envs, autoreset_mode, privileged, dtype, threads, render_mode, controller, drawn
        As of `SimulationVectorEnv`.
    task
        In place of the scenario's own.
    parameters
        Of the task, in place of those that the scenario has.
    """
    scenario, chosen = _chosen(what, task, parameters)
    given = {"autoreset_mode": autoreset_mode, "privileged": privileged, "dtype": dtype, "threads": threads}
    given |= {"render_mode": render_mode, "controller": controller, "drawn": drawn}
    return SimulationVectorEnv(scenario, chosen, num_envs, **given)


def make(
    what: str | os.PathLike[str] | Scenario,
    *,
    task: Task | None = None,
    privileged: bool = False,
    dtype: str = "float32",
    render_mode: str | None = None,
    **parameters: Any,
) -> SimulationEnv:
    """One environment; as `make_vec`."""
    return SimulationEnv(*_chosen(what, task, parameters), privileged=privileged, dtype=dtype, render_mode=render_mode)


def make_parallel(
    what: str | os.PathLike[str] | Scenario,
    *,
    task: Task | None = None,
    dtype: str = "float32",
    render_mode: str | None = None,
    **parameters: Any,
) -> SimulationParallelEnv:
    """The robots of one world as PettingZoo's agents; as `make`, of a scenario with several robots.

    `make_parallel_vec` makes many such worlds.

    ::

        env = make_parallel("amorsim/Crossing-v0")
        seen, infos = env.reset(seed=1)
        while env.agents:
            actions = {agent: env.action_space(agent).sample() for agent in env.agents}
            seen, rewards, terminations, truncations, infos = env.step(actions)

    Raises
    ------
    AmorsimError
        If PettingZoo is not installed, or a robot has no sensor that the task observes.
    """
    if importlib.util.find_spec("pettingzoo") is None:
        raise AmorsimError('agents of one world need the extra "learn": python -m pip install "amorsim[learn]"')
    from amorsim.learning.parallel import SimulationParallelEnv

    return SimulationParallelEnv(*_chosen(what, task, parameters), dtype=dtype, render_mode=render_mode)


def make_parallel_vec(
    what: str | os.PathLike[str] | Scenario,
    num_worlds: int = 1,
    *,
    task: Task | None = None,
    dtype: str = "float32",
    threads: int = 1,
    **parameters: Any,
) -> SimulationParallelVectorEnv:
    """Many worlds of several robots, all in one simulation; as `make_parallel`, with an axis for the worlds.

    ::

        worlds = make_parallel_vec("amorsim/Crossing-v0", 100)
        seen, infos = worlds.reset(seed=1)          # seen["r0"] is (100, 186)
        seen, rewards, terminations, truncations, infos = worlds.step(actions)
    """
    return SimulationParallelVectorEnv(*_chosen(what, task, parameters), num_worlds, dtype=dtype, threads=threads)


def load_environment(name: str) -> Scenario:
    """The scenario of an environment by its name, such as ``"amorsim/Dock-v0"``, to be changed and given to `make_vec`.

    Raises
    ------
    ValueError
        If there is none of that name.
    """
    known = TASKS | _OF_MANY
    if name not in known:
        raise ValueError(no_such("environment", name, list(known)))
    return load(_SCENARIOS / known[name])


def _chosen(
    what: str | os.PathLike[str] | Scenario, task: Task | None, parameters: dict[str, Any]
) -> tuple[Scenario, Task]:
    if isinstance(what, Scenario):
        scenario = what
    elif str(what).startswith("amorsim/"):
        scenario = load_environment(str(what))
    else:
        scenario = load(what)
    chosen = scenario.task if task is None else task
    if chosen is None:
        raise ValueError(f"{what}: expected a scenario with [task], or a task beside it")
    fields = [field.name for field in attrs.fields(type(chosen))]
    for name in parameters:
        if name not in fields:
            raise TypeError(no_such("parameter", name, fields))
    return scenario, attrs.evolve(chosen, **parameters)
