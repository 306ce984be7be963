"""The tasks that come with amorsim, by their names in Gymnasium."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import gymnasium as gym

from amorsim.core.unknown_names import no_such
from amorsim.learning.contracts import Task
from amorsim.learning.single import SimulationEnv
from amorsim.learning.tasks.point_goal import PointGoal
from amorsim.learning.vector import SimulationVectorEnv
from amorsim.scenario.reading.read import load
from amorsim.scenario.spec import Scenario

__all__ = ["TASKS", "make", "make_vec", "register_all"]

_SCENARIOS = Path(__file__).parent / "scenarios"


@attrs.frozen
class Registered:
    """A task with its scenario."""

    scenario: str
    task: Callable[..., Task]


TASKS = {"amorsim/PointGoal-v0": Registered("point-goal.toml", PointGoal)}
"""By the name that Gymnasium has for it."""


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
    **parameters: Any,
) -> SimulationVectorEnv:
    """A vector environment: of a task by its name, or of a scenario of your own with a task.

    ::

        envs = make_vec("amorsim/PointGoal-v0", 64, distance=(1.0, 3.0))
        envs = make_vec("my-office.toml", 64, task=PointGoal(sensor="sonar"))

    Parameters
    ----------
    what
        The name of a task, or a scenario: its file, its bundled name or the object. It has one robot, whose
        controller the actions replace.
    num_envs, autoreset_mode, privileged, dtype, threads
        As of `SimulationVectorEnv`.
    task
        For a scenario: the task.
    parameters
        Of a task by its name.
    """
    scenario, chosen = _chosen(what, task, parameters)
    given = {"autoreset_mode": autoreset_mode, "privileged": privileged, "dtype": dtype, "threads": threads}
    return SimulationVectorEnv(scenario, chosen, num_envs, **given)


def make(
    what: str | os.PathLike[str] | Scenario,
    *,
    task: Task | None = None,
    privileged: bool = False,
    dtype: str = "float32",
    **parameters: Any,
) -> SimulationEnv:
    """One environment; as `make_vec`."""
    return SimulationEnv(*_chosen(what, task, parameters), privileged=privileged, dtype=dtype)


def _chosen(
    what: str | os.PathLike[str] | Scenario, task: Task | None, parameters: dict[str, Any]
) -> tuple[Scenario, Task]:
    if task is None:
        if what not in TASKS:
            raise ValueError(no_such("task", what, list(TASKS)) + " For a scenario, give a task as well")
        known = TASKS[str(what)]
        return load(_SCENARIOS / known.scenario), known.task(**parameters)
    if parameters:
        raise TypeError(f"{', '.join(parameters)}: a task that is given has its parameters already")
    return (what if isinstance(what, Scenario) else load(what)), task
