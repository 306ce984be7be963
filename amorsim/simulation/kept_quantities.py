"""Quantities of every step of a simulation, kept as arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from amorsim.array_types import AnyArray, Bools
from amorsim.contracts import Beliefs, Frame
from amorsim.core.arguments import texts
from amorsim.core.errors import AmorsimError
from amorsim.core.execution.memory import too_large
from amorsim.core.unknown_names import no_such

__all__ = ["LAST", "Keeper", "quantity_problem"]

Pick = Callable[[Frame], AnyArray | None]

_OWN = ("true_pose", "estimated_pose", "covariance", "active", "by_hand", "touching")
_OF_FRAME = ("true_twist", "joint_rates", "command", "part_pose")
_OF_READING = ("measured", "true", "stamp", "age", "fresh")
_OF_ESTIMATE = ("pose", "covariance")
LAST = "last."  # begins the names of quantities of the last step alone


class Simulated(Protocol):
    """The interface needed of a simulation; quantities such as ``true_pose`` are its attributes."""

    replicas: tuple[int, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The robots' names."""

    def frames(self) -> list[Frame]:
        """The present step."""


class Keeper:
    """Keeps named quantities of a simulation, a row for each robot of each replica, step by step.

    ==========================  =========================================================================
    ``true_pose``               (S, N, 3) [m, m, rad]; ``estimated_pose`` too, and ``covariance`` (S, N, 3, 3)
    ``true_twist``              (S, N, 3) mean over the step, [m/s, m/s, rad/s]
    ``joint_rates``             (S, N, joints) [rad/s]
    ``command``                 (S, N, channels)
    ``part_pose``               (S, N, parts, 3) true, of each robot's parts such as trailers [m, m, rad]
    ``active``                  (S, N), whether the controller has not ended; ``by_hand``, ``touching`` too
    ``readings.NAME``           (S, N, values) as measured; ``readings.NAME.true``; (S, N, 1) ``.stamp`` [steps],
                                ``.age`` [s], ``.fresh``
    ``estimates.NAME.pose``     (S, N, 3); ``estimates.NAME.covariance`` (S, N, 3, 3)
    ``beliefs.NAME.BELIEF``     (S, N, ...)
    ``last.QUANTITY``           (1, N, ...) any of these, of the last step alone: for large ones, such as maps
    ==========================  =========================================================================

    What a robot does not have, and another has, is nan.

    Parameters
    ----------
    steps
        The most times that `keep` will be called.

    Raises
    ------
    AmorsimError
        If a name is unknown, or the arrays would not fit into memory.
    """

    def __init__(self, simulation: Simulated, names: Iterable[str], steps: int) -> None:
        self._simulation = simulation
        self._count = 0
        self._names = tuple(dict.fromkeys(texts(names, "keep", "names")))
        self._every = [name for name in self._names if not name.startswith(LAST)]
        self._last: dict[str, AnyArray] = {}
        self._picks = {
            name: _pick(simulation, name)
            for name in dict.fromkeys(each.removeprefix(LAST) for each in self._names)
            if name not in _OWN
        }
        first = self._look(self._every)
        each = sum(array.nbytes for array in first.values())
        if problem := too_large(steps, each):
            raise AmorsimError(
                f"keep: {steps} steps of {', '.join(self._names)} in {len(simulation.replicas)} replicas {problem}; "
                "keep less, simulate fewer replicas at once, or run in parts"
            )
        self._arrays = {name: np.empty((steps, *array.shape), array.dtype) for name, array in first.items()}

    def keep(self) -> None:
        """Keep the simulation's present step."""
        for name, array in self._look(self._every).items():
            self._arrays[name][self._count] = array
        self._count += 1

    def keep_last(self, ended: Bools | None = None) -> None:
        """Keep the present step as the last one: of the replicas `ended` `(R,)`, or of all."""
        wanted = [name.removeprefix(LAST) for name in self._names if name.startswith(LAST)]
        for name, array in self._look(wanted).items():
            whole = self._last.setdefault(LAST + name, np.array(array)[None])
            if ended is not None:
                rows = np.repeat(ended, len(self._simulation.names))
                whole[0, rows] = array[rows]

    @property
    def arrays(self) -> dict[str, AnyArray]:
        """The values kept so far, by name: arrays whose first axis is the step."""
        return {name: array[: self._count] for name, array in self._arrays.items()} | self._last

    def _look(self, names: Sequence[str]) -> dict[str, AnyArray]:
        simulation = self._simulation
        beliefs: dict[str, list[str]] = {}  # that are wanted, by whose they are
        for name in names:
            kind, _, rest = name.partition(".")
            if kind == "beliefs":
                whose, _, what = rest.partition(".")
                beliefs.setdefault(whose, []).append(what)
        frames = simulation.frames() if any(name in self._picks for name in names) else []
        if beliefs:
            frames = [frame._replace(beliefs=_some(frame, beliefs)) for frame in frames]
        return {
            name: _whole(simulation, frames, self._picks[name]) if name in self._picks else getattr(simulation, name)
            for name in names
        }


def _whole(simulation: Simulated, frames: Sequence[Frame], pick: Pick) -> AnyArray:
    """A quantity of all rows, from the frames of the groups of robots that are alike."""
    if len(frames) == 1:
        found = pick(frames[0])
        assert found is not None  # `_pick` has looked
        return found
    parts = [pick(frame) for frame in frames]
    there = [part for part in parts if part is not None]
    sizes = tuple(max(sizes) for sizes in zip(*(part.shape[1:] for part in there), strict=True))
    is_whole = len(there) == len(parts) and all(part.shape[1:] == sizes for part in there)
    rows = len(simulation.replicas) * len(simulation.names)
    whole = np.empty((rows, *sizes), there[0].dtype) if is_whole else np.full((rows, *sizes), np.nan)
    replicas = {number: i for i, number in enumerate(simulation.replicas)}
    robots = {name: i for i, name in enumerate(simulation.names)}
    for frame, part in zip(frames, parts, strict=True):
        if part is None:
            continue
        row = [
            replicas[number] * len(robots) + robots[name]
            for number, name in zip(frame.replica.tolist(), frame.names, strict=True)
        ]
        place: tuple[Any, ...] = (row, *(slice(size) for size in part.shape[1:]))
        whole[place] = part
    return whole


def _pick(simulation: Simulated, name: str) -> Pick:
    """A function that returns the quantity of that name from a frame; None where the frame's robots lack it."""
    kind, _, rest = name.partition(".")
    whose, _, what = rest.partition(".")
    if name in _OF_FRAME:
        return lambda frame: getattr(frame, name)
    frames = simulation.frames()
    if kind == "readings" and whose:
        _expect(name, whose, {sensor for frame in frames for sensor in frame.readings}, "sensor")
        _expect(name, what or "measured", _OF_READING, "quantity")
        return lambda frame: _reading(frame, whose, what or "measured")
    if kind == "estimates" and whose:
        _expect(name, whose, {each for frame in frames for each in frame.estimates}, "estimator")
        _expect(name, what, _OF_ESTIMATE, "quantity")
        return lambda frame: getattr(frame.estimates[whose], what) if whose in frame.estimates else None
    if kind == "beliefs" and whose:
        _expect(name, whose, {each for frame in frames for each in frame.beliefs}, "estimator of beliefs")
        if not any(what in _some(frame, {whose: [what]}).get(whose, {}) for frame in frames):
            known = {belief for frame in frames for belief in frame.beliefs.get(whose, {})}
            _expect(name, what, known, "belief")
        return lambda frame: _belief(frame.beliefs, whose, what)
    raise AmorsimError(f"keep: {quantity_problem(name)}")


def quantity_problem(name: str) -> str:
    """What is wrong with the name of a quantity that no robot has; empty if some robot may have it."""
    kind, _, rest = name.removeprefix(LAST).partition(".")
    whose, _, what = rest.partition(".")
    dotted = {"readings": _OF_READING, "estimates": _OF_ESTIMATE, "beliefs": (what,)}
    if name.removeprefix(LAST) in (*_OWN, *_OF_FRAME):
        return ""
    if whose and kind in dotted and (what or "measured") in dotted[kind]:
        return ""
    known = {*_OWN, *_OF_FRAME, "readings.NAME", "estimates.NAME.pose", "beliefs.NAME.BELIEF"}
    return no_such("quantity", name, sorted(known))


def _expect(name: str, part: str, known: Iterable[str], what: str) -> None:
    known = sorted(known)
    if part not in known:
        raise AmorsimError(f"keep: {name!r}: {no_such(what, part, known)}")


def _reading(frame: Frame, sensor: str, what: str) -> AnyArray | None:
    if sensor not in frame.readings:
        return None
    true, reading = frame.readings[sensor]
    return true if what == "true" else getattr(reading, what)


def _some(frame: Frame, wanted: Mapping[str, list[str]]) -> dict[str, Beliefs]:
    """The wanted beliefs that exist, by their owner's name; others need not be computed."""
    return {whose: frame.some_beliefs(whose, names) for whose, names in wanted.items() if whose in frame.beliefs}


def _belief(beliefs: Mapping[str, Mapping[str, AnyArray]], estimator: str, what: str) -> AnyArray | None:
    return beliefs[estimator].get(what) if estimator in beliefs else None
