"""A submission in another process: it is sent what a controller or an estimator is given, and answers.

That process has no simulation in it, so there is no truth that its code could find. Both sides speak lines of JSON, and
what comes back is data: it is never executed, its length is limited, and it is refused unless it has the expected form.
"""

from __future__ import annotations

import base64
import json
import os
import select
import time
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Array
from amorsim.contracts import Beliefs, Context, Draws, Estimate, Estimator, Measurement, RobotModel, State
from amorsim.controllers.user import RobotClock, RobotEstimate, RobotReading, Twist, WheelSpeeds
from amorsim.core.error_text import in_words
from amorsim.core.errors import ControllerError, StudyError
from amorsim.grading.fence import Fence
from amorsim.grading.handed_in import HandedIn
from amorsim.grading.process import SubmissionProcess
from amorsim.grading.questions import Answers, answers_from
from amorsim.kernels.cache_folder import cache_folder

__all__ = ["Remote", "SubmittedEstimator"]


_LONGEST = 1 << 20  # [bytes] of an answer
_LARGEST = 1 << 26  # [bytes] of the beliefs of an estimator
_KINDS = tuple(np.dtype(kind).str for kind in (np.float64, np.int64, np.bool_))  # of numbers in beliefs
_START = 60.0  # [s] to load the file in


class Remote:
    """A submission in a process of its own; used as a context. As a controller, it is called like a user's function.

    Parameters
    ----------
    handed_in
        Its files.
    name
        The name of the function or class in its file.
    role
        ``"controller"`` or ``"estimator"``.
    time_limit
        How long it may think in all [s].
    memory_limit
        How much memory its processes may have in all [bytes].
    fence
        The fence to run it in; without one it can do what the user can.

    Raises
    ------
    ControllerError
        From a call, if the submission raises, hangs, ends its process, or answers with something else.
    StudyError
        On entering, if the fence or Python in it does not come up.
    """

    def __init__(
        self,
        handed_in: HandedIn,
        name: str,
        role: str,
        *,
        time_limit: float,
        memory_limit: int,
        fence: Fence | None,
    ) -> None:
        self._handed_in = handed_in
        self._first = {"path": handed_in.name, "name": name, "role": role, "memory": memory_limit}
        self._time_limit = time_limit
        self._memory_limit = memory_limit
        self._fence = fence
        self._limit = self._left = _START
        self._rest = b""
        self.answers: Answers = {}
        """Its answers to the questions of the rubric."""

    def __enter__(self) -> Remote:
        self._process = SubmissionProcess(self._fence, self._memory_limit)
        try:
            self._begin()
            self._load()
        except BaseException:
            self._process.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._process.close()

    def _begin(self) -> None:
        """Wait until Python runs, before anything of the submission does."""
        try:
            self._answer("starting it")
        except ControllerError as error:
            raise StudyError(f"a submission's process cannot be started: {error}") from None
        self._process.watch()

    def _load(self) -> None:
        """Send the files, and wait until they are loaded: importing is not thinking, and has a time of its own."""
        files = self._handed_in.files
        kernels = None if self._fence is None else cache_folder()
        self._say(
            {
                **self._first,
                "files": {name: len(data) for name, data in files.items()},
                "kernels": None if kernels is None else str(kernels),
            },
            "loading it",
            b"".join(files.values()),
        )
        _, answers = self._answer("loading it")
        self.answers = answers_from(answers)
        self._limit = self._left = self._time_limit

    def __call__(self, readings: Mapping[str, RobotReading], estimate: RobotEstimate, clock: RobotClock) -> Any:
        """The submission's command."""
        when = f"at {clock.time:.1f} s"
        self._say(
            {
                "readings": _said(readings),
                "estimate": [estimate.pose.tolist(), estimate.covariance.tolist()],
                "clock": [clock.tick, clock.time, clock.dt],
            },
            when,
        )
        kind, value = self._answer(when)
        try:
            if kind == "twist":
                return Twist(*value)
            if kind == "wheels":
                return WheelSpeeds(*value)
        except TypeError:
            raise ControllerError(f"it answered {in_words(value)}, which is not a command") from None
        return value

    def begin(self, pose: Array) -> None:
        """Send an estimator the start pose `(3,)`, as the robot knows it."""
        self._say({"start": pose.tolist()}, "at the start")
        self._answer("at the start")

    def estimate(self, readings: Mapping[str, RobotReading], command: Array, elapsed: float) -> tuple[Array, Array]:
        """The submission's estimate: a pose `(3,)` and a covariance `(3, 3)`."""
        self._say({"readings": _said(readings), "command": command.tolist(), "elapsed": elapsed}, "in a step")
        _, value = self._answer("in a step")
        try:
            pose, covariance = (np.array(part, dtype=np.float64) for part in value)
        except (TypeError, ValueError, OverflowError):
            pose = covariance = np.empty(0)
        if (
            pose.shape != (3,)
            or covariance.shape != (3, 3)
            or not all(np.isfinite(x).all() for x in (pose, covariance))
        ):
            raise ControllerError(
                f"it answered {in_words(value)}; expected a pose (x, y, heading) of finite numbers, or that and a "
                "covariance (3, 3)"
            )
        return pose, covariance

    def beliefs(self) -> dict[str, AnyArray]:
        """The submission's beliefs, by name; whatever it sends, they are arrays of numbers."""
        self._say({"beliefs": True}, "when its beliefs were asked for")
        _, value = self._answer("when its beliefs were asked for", _LARGEST)
        found = {}
        try:
            for name, (kind, shape, data) in value.items():
                if kind not in _KINDS:
                    raise ValueError
                found[name] = np.frombuffer(base64.b64decode(data), kind).reshape(shape).copy()
        except (AttributeError, TypeError, ValueError):
            raise ControllerError(f"it answered {in_words(value)}; expected arrays by name") from None
        return found

    def _say(self, message: Mapping[str, Any], when: str, more: bytes = b"") -> None:
        """Send a line, and bytes after it; a submission that does not read must not hold up the grading."""
        if self._rest or _is_ready(self._process.answers):
            self._refuse_answers()
        pipe = self._process.requests
        rest = memoryview(json.dumps(message).encode() + b"\n" + more)
        while rest:
            begun = time.monotonic()
            _, ready, _ = select.select([], [pipe], [], max(0.0, self._left))
            self._left -= time.monotonic() - begun
            if not ready:
                raise self._too_slow(when)
            try:
                rest = rest[os.write(pipe, rest) :]
            except BlockingIOError:
                continue
            except OSError:
                raise self._ended("before it was asked") from None

    def _refuse_answers(self) -> None:
        """Raise if an answer came before its question."""
        if self._rest or os.read(self._process.answers, 1):
            raise ControllerError("it answered before it was asked")
        raise self._ended("before it was asked")

    def _answer(self, when: str, longest: int = _LONGEST) -> tuple[str, Any]:
        pipe = self._process.answers
        while b"\n" not in self._rest:
            begun = time.monotonic()
            is_there = _is_ready(pipe, max(0.0, self._left))
            self._left -= time.monotonic() - begun
            if not is_there:
                raise self._too_slow(when)
            more = os.read(pipe, 1 << 16)
            if not more:
                raise self._ended(when)
            self._rest += more
            if len(self._rest) > longest:
                raise ControllerError(f"it answered with more than a command ({when})")
        line, _, self._rest = self._rest.partition(b"\n")
        try:
            answer = json.loads(line)
        except (ValueError, RecursionError):
            answer = None
        if not isinstance(answer, list) or len(answer) != 2:
            raise ControllerError(f"it answered {line[:60]!r}, which is not a command ({when})")
        kind, value = answer
        if kind == "error":
            raise ControllerError(f"{value} ({when})")
        return str(kind), value

    def _too_slow(self, when: str) -> ControllerError:
        return ControllerError(f"it took longer than {self._limit:g} s in all ({when})")

    def _ended(self, when: str) -> ControllerError:
        how = self._process.how_it_ended()
        if self._process.problem:
            return ControllerError(f"{self._process.problem} ({when})")
        return ControllerError(f"its process ended{how} ({when}); it may have left Python, or needed too much memory")


def _is_ready(pipe: int, wait: float = 0.0) -> bool:
    """Whether something can be read from a pipe, or it has ended."""
    return bool(select.select([pipe], [], [], wait)[0])


@attrs.frozen(kw_only=True)
class SubmittedEstimator(Estimator):
    """Asks a submission for the estimate of one robot."""

    remote: Remote = attrs.field()

    def start(self, context: Context) -> State:
        """Send the pose at the start."""
        self.remote.begin(context.pose[0])
        return {}

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """Its answer to this step's readings."""
        read = {
            name: RobotReading(each.measured[0], int(each.stamp[0, 0]), float(each.age[0, 0]), bool(each.fresh[0, 0]))
            for name, each in readings.items()
        }
        pose, covariance = self.remote.estimate(read, command[0], float(elapsed[0, 0]))
        return Estimate(pose[None], covariance[None])

    def beliefs(self, state: State) -> Beliefs:
        """Its beliefs other than the pose, asked for now."""
        return {name: array[None] for name, array in self.remote.beliefs().items()}


def _said(readings: Mapping[str, RobotReading]) -> dict[str, Any]:
    return {
        name: [reading.measured.tolist(), reading.stamp, reading.age, bool(reading.fresh)]
        for name, reading in readings.items()
    }
