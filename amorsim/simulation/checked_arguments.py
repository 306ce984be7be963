"""Checks of a simulation's arguments: its scenario's size, replicas and seed."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np

from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError
from amorsim.core.execution.memory import too_large
from amorsim.core.parameters import check_value, describe
from amorsim.scenario.needs import least_bytes
from amorsim.scenario.spec import Obstacle, Robot, Scenario

__all__ = ["MAX_REPLICA", "MOST_STEPS", "checked_seed", "numbers_in_words", "replica_numbers"]

MOST_STEPS = 2**32 - 1  # a tick is a 32-bit word of the draws' counter
MAX_REPLICA = 2**32 - 2  # a 32-bit word of the draws' counter; one number is reserved for studies


def checked_seed(seed: Any) -> int:
    """A seed as a Python int; a `ParameterError` if it is none."""
    seed = _plain(seed)
    check_value(describe(Scenario)["seed"], seed)
    return int(seed)


def replica_numbers(scenario: Scenario, replicas: int | Sequence[int]) -> tuple[int, ...]:
    """The numbers of the replicas, given them or how many there are.

    Raises
    ------
    AmorsimError
        If these are not such numbers, or the arrays of so many replicas would not fit into memory; none is made.
    """
    replicas = _plain(replicas)
    try:
        count = replicas if isinstance(replicas, int) else len(replicas)
    except TypeError:
        raise _no_replicas(replicas) from None
    if isinstance(replicas, int) and not 0 < count <= MAX_REPLICA + 1:
        raise _no_replicas(replicas)
    _check_memory(scenario, count)
    return _replica_numbers(replicas)


def numbers_in_words(numbers: Sequence[int]) -> str:
    """All the numbers if they are few, otherwise how many there are, the least and the greatest."""
    return (
        ", ".join(map(str, numbers)) if len(numbers) < 9 else f"{len(numbers)}, from {min(numbers)} to {max(numbers)}"
    )


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
