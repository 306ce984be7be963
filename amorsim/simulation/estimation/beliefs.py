"""The beliefs of a step: those of the estimators and of the controller, asked for when they are looked up."""

from __future__ import annotations

import re
import types
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Beliefs
from amorsim.contracts.values import BeliefsByName
from amorsim.core.errors import AmorsimError

__all__ = ["BeliefsNow", "Believer", "StepBeliefs", "beliefs_of_step", "beliefs_problem", "chosen"]

_BELIEF = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z][A-Za-z0-9]*)*")  # numbers at the end are indices in files
_NOTHING: Mapping[str, Beliefs] = types.MappingProxyType({})


Believer = Callable[[Iterable[str] | None], Beliefs]
"""Gives the beliefs of a name that are wanted, or all of them."""


def beliefs_of_step(believers: Mapping[str, Believer], moment: Callable[[], int]) -> Mapping[str, Beliefs]:
    """The beliefs of all estimators and controllers that have any, by name; `moment` is the number of the step."""
    return StepBeliefs(believers, moment) if believers else _NOTHING


class StepBeliefs(BeliefsByName):
    """The beliefs of a step, by name: computed when looked up, and kept."""

    def __init__(self, believers: Mapping[str, Believer], moment: Callable[[], int]) -> None:
        self._believers = believers
        self._moment = moment
        self._made = moment()
        self._kept: dict[str, Beliefs] = {}

    def __getitem__(self, name: str) -> Beliefs:
        if name not in self._believers:
            raise KeyError(name)
        if name not in self._kept:
            self._kept[name] = self._ask(name, None)
        return self._kept[name]

    def some(self, name: str, wanted: Iterable[str]) -> Beliefs:
        """The wanted beliefs of an estimator or of the controller; others need not be computed."""
        if name in self._kept:
            found: Beliefs = chosen(self._kept[name], wanted)
            return found
        return self._ask(name, wanted)

    def _ask(self, name: str, wanted: Iterable[str] | None) -> Beliefs:
        if self._moment() != self._made:
            raise AmorsimError(
                f"the beliefs of {name!r} were looked up after their step; look them up in the step, "
                "or take a new frame"
            )
        return self._believers[name](wanted)

    def __contains__(self, name: object) -> bool:
        return name in self._believers  # asks no component

    def __iter__(self) -> Iterator[str]:
        return iter(self._believers)

    def __len__(self) -> int:
        return len(self._believers)


class BeliefsNow(Mapping[str, Beliefs]):
    """The beliefs as they are whenever they are looked up, by name; of some rows, if `rows` are given."""

    def __init__(self, believers: Mapping[str, Believer], rows: npt.NDArray[np.intp] | None = None) -> None:
        self._believers = believers
        self._rows = rows

    def __getitem__(self, name: str) -> Beliefs:
        found = self._believers[name](None)
        return found if self._rows is None else {what: array[self._rows] for what, array in found.items()}

    def __iter__(self) -> Iterator[str]:
        return iter(self._believers)

    def __len__(self) -> int:
        return len(self._believers)

    def take(self, rows: npt.NDArray[np.intp]) -> BeliefsNow:
        """The beliefs of some rows alone."""
        return BeliefsNow(self._believers, rows if self._rows is None else self._rows[rows])


def chosen(found: Any, wanted: Iterable[str] | None) -> Any:
    """Those of a component's beliefs that are wanted and that it has, or all, computed; no beliefs are left as is."""
    if not isinstance(found, Mapping):
        return found
    return dict(found) if wanted is None else {belief: found[belief] for belief in wanted if belief in found}


def beliefs_problem(found: Any, rows: int) -> str:
    """The fault of what a `beliefs` method returned; empty if they are beliefs of `rows` rows."""
    if not isinstance(found, Mapping):
        return f"expected beliefs() to return arrays by name, got a {type(found).__name__}"
    for name, array in found.items():
        if not isinstance(name, str) or not _BELIEF.fullmatch(name):
            return f"expected names of beliefs such as 'gyro_bias', words of letters joined by _, got {name!r}"
        if not isinstance(array, np.ndarray) or array.dtype not in (np.float64, np.int64, np.bool_):
            kind = getattr(array, "dtype", type(array).__name__)
            return f"expected the belief {name!r} to be an array of float64, int64 or bool, got {kind}"
        if array.shape[:1] != (rows,):
            return f"expected the belief {name!r} to have {rows} rows as its first axis, got the shape {array.shape}"
        if np.isinf(array).any():
            return f"expected finite numbers in the belief {name!r}, or nan where there is nothing, got inf"
    return ""
