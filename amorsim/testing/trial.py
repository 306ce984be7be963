"""The trials of all kinds of component: the same rows together, alone, twice, and from a copy of their state."""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from typing import Any, Generic, TypeVar

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Ints
from amorsim.contracts import State
from amorsim.core.rows import stack
from amorsim.simulation.state.snapshot import copy_state
from amorsim.testing.failure import Who
from amorsim.testing.rig import ROWS, STEPS, Rig, Session

__all__ = ["Given", "Record", "Trial", "try_rows"]

C = TypeVar("C")
Outputs = dict[str, AnyArray]

_EVERY = np.arange(ROWS, dtype=np.int64)


class Given:
    """Arrays that a component was given or gave, with copies, to see whether it lets them be."""

    def __init__(self, who: Who, check: str, what: str) -> None:
        self._who, self._check, self._what = who, check, what
        self._kept: list[tuple[str, AnyArray, AnyArray]] = []

    def add(self, name: str, array: AnyArray | None) -> None:
        """Remember an array, to see later whether it was changed."""
        if array is not None and array.dtype != object:
            self._kept.append((name, array, array.copy()))

    def check(self) -> None:
        """Fail if any of them was changed."""
        for name, array, copy in self._kept:
            if array.tobytes() != copy.tobytes():
                self._who.fail(self._check, f"{name}: expected {self._what}, found it changed")


class Trial(abc.ABC, Generic[C]):
    """How a component of some kind is called in a step."""

    widths: Sequence[int] = ()  # numbers of values: as many rows are tried
    size = 0  # of a sample, for the context

    def __init__(self, who: Who, rig: Rig) -> None:
        self.who = who
        self.rig = rig

    is_robot = True  # an obstacle is not a robot; its motion's context has none

    def begin(self, component: C, session: Session) -> Outputs:
        """Arrays carried from step to step in addition to the state (a drive's joints), row first."""
        return {}

    @abc.abstractmethod
    def step(
        self, component: C, session: Session, state: State, carried: Outputs, given: Given
    ) -> Mapping[str, AnyArray]:
        """Call the component, add its inputs to `given`, check the shapes of its results; arrays by name."""

    def array(self, found: Any, shape: tuple[int, ...], name: str) -> AnyArray:
        """The array that a method returned, if it is one of float64 and of this shape."""
        require = self.who.require
        require(isinstance(found, np.ndarray), "shapes", name, f"an array {shape}", type(found).__name__)
        require(found.shape == shape, "shapes", name, f"the shape {shape}", found.shape)
        require(found.dtype == np.float64, "shapes", name, "float64", found.dtype)
        return np.asarray(found)


@attrs.frozen
class Record:
    """The result of a run: outputs, and states after each step."""

    outputs: list[Outputs]
    states: list[Outputs]


class _Run:
    """A component over some rows, step by step, watched."""

    def __init__(self, trial: Trial[Any], components: Sequence[Any], rows: Ints) -> None:
        self.trial, self.who = trial, trial.who
        self.component = stack([components[row % ROWS] for row in rows])
        self.session = Session(trial.rig, rows)
        self.kept = {field.name: getattr(self.component, field.name) for field in _init_fields(self.component)}
        self.given = Given(self.who, "inputs", "an array that it was given to be left alone")
        self.results = Given(self.who, "kept", "a result to stay as it was returned, for all that hold it")
        context = self.session.context(trial.size)
        self.given.add("context.pose", context.pose)
        self.session.go_to(0)
        if not trial.is_robot:
            context = attrs.evolve(context, robot=None)  # type: ignore[arg-type]
        with self.who.calling("start"):
            started = self.component.start(context)
        self.state: State = self._started(started, len(rows))
        self.layout = {name: (array.shape, array.dtype) for name, array in self.state.items()}
        self.carried = trial.begin(self.component, self.session)

    def _started(self, state: Any, rows: int) -> State:
        require = self.who.require
        require(isinstance(state, dict), "start", "start()", "a dict of arrays", type(state).__name__)
        for name, array in state.items():
            require(isinstance(name, str), "start", "a key of the state", "a text", repr(name))
            what = f"state[{name!r}]"
            require(isinstance(array, np.ndarray), "start", what, "an array", type(array).__name__)
            require(array.shape[:1] == (rows,), "start", what, f"{rows} rows as first axis", f"the shape {array.shape}")
        return dict(state)

    def steps(self, first: int, last: int) -> Record:
        record = Record([], [])
        for t in range(first, last):
            self.session.go_to(t)
            outputs = dict(self.trial.step(self.component, self.session, self.state, self.carried, self.given))
            self._check_state()
            self.given.check()
            record.outputs.append({name: array.copy() for name, array in outputs.items()})
            record.states.append(_plain(self.state))
            for name, array in outputs.items():
                self.results.add(f"{name} of an earlier step", array)
        self.results.check()
        self._check_parameters()
        return record

    def _check_parameters(self) -> None:
        kept = [name for name, value in self.kept.items() if getattr(self.component, name) is not value]
        kept += sorted(set(getattr(self.component, "__dict__", {})) - set(self.kept))
        if kept:
            self.who.fail("parameters", f"expected its state to be in `state`, found it kept on itself, in {kept}")

    def _check_state(self) -> None:
        now = {
            name: (array.shape, array.dtype) if isinstance(array, np.ndarray) else type(array).__name__
            for name, array in self.state.items()
        }
        for name in {**self.layout, **now}:
            self.who.require(
                now.get(name) == self.layout.get(name),
                "state",
                f"state[{name!r}] after a step",
                self.layout.get(name, "no such key, as at the start"),
                now.get(name, "none"),
            )

    def saved(self) -> tuple[Outputs, Outputs]:
        return copy_state("the component", self.state), {name: array.copy() for name, array in self.carried.items()}

    def put_back(self, saved: tuple[Outputs, Outputs]) -> None:
        self.state.update(copy_state("the component", saved[0]))
        self.carried.update({name: array.copy() for name, array in saved[1].items()})


def _init_fields(component: Any) -> list[attrs.Attribute[Any]]:
    return [field for field in attrs.fields(type(component)) if hasattr(component, field.name)]


def _plain(state: State) -> Outputs:
    return {name: array.copy() for name, array in state.items() if array.dtype != object}


def try_rows(trial: Trial[Any], components: Sequence[Any]) -> Record:
    """Try what holds for all kinds on 64 components; returns the results as 64 rows."""
    who = trial.who
    whole = _Run(trial, components, _EVERY).steps(0, STEPS)

    _compare(who, "determinism", "a second run", whole, _Run(trial, components, _EVERY).steps(0, STEPS))

    half = STEPS // 2
    run = _Run(trial, components, _EVERY)
    run.steps(0, half)
    saved = run.saved()
    run.steps(half, STEPS)
    run.put_back(saved)
    later = Record(whole.outputs[half:], whole.states[half:])
    _compare(who, "snapshot", "going on from a copy of the state", later, run.steps(half, STEPS))

    for row in range(ROWS):
        rows = np.array([row], dtype=np.int64)
        _compare(who, "rows", f"row {row} alone", _rows(whole, rows), _Run(trial, components, rows).steps(0, STEPS))
    for width in sorted(set(trial.widths)):
        rows = np.arange(width, dtype=np.int64)
        found = _Run(trial, components, rows).steps(0, 2)
        expected = _rows(Record(whole.outputs[:2], whole.states[:2]), rows % ROWS)
        _compare(who, "width", f"{width} rows, as many as there are values", expected, found)
    return whole


def _rows(record: Record, rows: Ints) -> Record:
    def taken(steps: list[Outputs]) -> list[Outputs]:
        return [{name: array[rows] for name, array in step.items()} for step in steps]

    return Record(taken(record.outputs), taken(record.states))


def _compare(who: Who, check: str, what: str, expected: Record, found: Record) -> None:
    for kind, before, after in (("", expected.outputs, found.outputs), ("state ", expected.states, found.states)):
        for step, (wanted, got) in enumerate(zip(before, after, strict=True)):
            for name, array in wanted.items():
                other = got.get(name)
                if other is None or array.shape != other.shape or array.tobytes() != other.tobytes():
                    difference = _difference(step, array, other)
                    who.fail(check, f"{what}: expected the same bits in {kind}{name}, {difference}")


def _difference(step: int, wanted: AnyArray, got: AnyArray | None) -> str:
    if got is None or got.shape != wanted.shape:
        return f"found {None if got is None else got.shape} at step {step}"
    bits = np.flatnonzero([a.tobytes() != b.tobytes() for a, b in zip(wanted.ravel(), got.ravel(), strict=True)])
    place = np.unravel_index(int(bits[0]), wanted.shape)
    return (
        f"found {got[place]!r} where {wanted[place]!r} should be (step {step}, index {tuple(int(i) for i in place)}, "
        f"{len(bits)} of {wanted.size} values differ)"
    )
