"""A submission in another process: it is sent what a controller or an estimator gets, and answers.

That process has no simulation in it, so there is no truth that its code could find. Both sides speak lines of JSON.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import time
import uuid
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Estimate, Estimator, Measurement, RobotModel, State
from amorsim.controllers.user import RobotClock, RobotEstimate, RobotReading, Twist, WheelSpeeds
from amorsim.core.errors import ControllerError
from amorsim.core.processes import end_with_children, python_command
from amorsim.grading.fence import Fence
from amorsim.grading.guard import MARK, end_strays

__all__ = ["Remote", "SubmittedEstimator"]

Array = npt.NDArray[np.float64]

_LONGEST = 1 << 20  # [bytes] of an answer
_START = 60.0  # [s] to load the file in


class Remote:
    """A submission in a process of its own; used as a context. As a controller, it is called like a user's function.

    Parameters
    ----------
    path, name
        The file, and the name of the function or class in it.
    role
        ``"controller"`` or ``"estimator"``.
    time_limit
        How long it may think in all [s].
    memory_limit
        How much memory its process may have [bytes].
    hidden
        Files and folders that it must not read, where the system can see to that (`Fence`).

    Raises
    ------
    ControllerError
        From a call, if the submission raises, hangs, ends its process, or answers with something else.
    """

    def __init__(
        self,
        path: Path,
        name: str,
        role: str,
        *,
        time_limit: float,
        memory_limit: int,
        hidden: Collection[Path] = (),
    ) -> None:
        self._left = time_limit
        self._limit = time_limit
        code = "from amorsim.grading.child import main; main()"
        self._mark = uuid.uuid4().hex
        self._fence = Fence(path, hidden)
        self._process = subprocess.Popen(
            python_command(code),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            cwd=self._fence.folder,
            env={**os.environ, **self._fence.settings, MARK: self._mark},
        )
        assert self._process.stdin is not None
        os.set_blocking(self._process.stdin.fileno(), False)
        self._rest = b""
        fence = self._fence.said()
        self._say({"path": str(path), "name": name, "role": role, "memory": memory_limit, "fence": fence})

    def __enter__(self) -> Remote:
        # Importing is not thinking: the time for it is not the submission's.
        left, self._left = self._left, _START
        try:
            self._answer("loading it")
        except BaseException:
            self.close()
            raise
        self._left = left
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the process, and all that it has started."""
        end_with_children(self._process)
        end_strays(self._mark)
        self._fence.close()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                try:
                    pipe.close()
                except OSError:  # what could not be sent
                    continue

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
            raise ControllerError(f"it answered {value!r}, which is no command") from None
        return value

    def begin(self, pose: Array) -> None:
        """Send an estimator the pose `(3,)` at which the robot starts, as the robot knows it."""
        self._say({"start": pose.tolist()}, "at the start")
        self._answer("at the start")

    def estimate(self, readings: Mapping[str, RobotReading], command: Array, elapsed: float) -> tuple[Array, Array]:
        """The submission's estimate: a pose `(3,)` and a covariance `(3, 3)`."""
        self._say({"readings": _said(readings), "command": command.tolist(), "elapsed": elapsed}, "in a step")
        _, value = self._answer("in a step")
        try:
            pose, covariance = (np.array(part, dtype=np.float64) for part in value)
        except (TypeError, ValueError):
            pose = covariance = np.empty(0)
        if pose.shape != (3,) or covariance.shape != (3, 3) or not np.isfinite(pose).all():
            raise ControllerError(
                f"it answered {str(value)[:80]}; expected a pose (x, y, heading) of finite numbers, or that and a "
                "covariance (3, 3)"
            )
        return pose, covariance

    def _say(self, message: Mapping[str, Any], when: str = "loading it") -> None:
        """Send a line; a submission that does not read must not hold up the grading."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        if self._rest or select.select([self._process.stdout.fileno()], [], [], 0.0)[0]:
            self._refuse_answers()
        pipe = self._process.stdin.fileno()
        rest = json.dumps(message).encode() + b"\n"
        while rest:
            begun = time.monotonic()
            _, ready, _ = select.select([], [pipe], [], max(0.0, self._left))
            self._left -= time.monotonic() - begun
            if not ready:
                raise ControllerError(f"it took longer than {self._limit:g} s in all ({when})")
            try:
                rest = rest[os.write(pipe, rest) :]
            except BlockingIOError:
                continue
            except OSError:
                raise self._ended("before it was asked") from None

    def _refuse_answers(self) -> None:
        """Raise if there is an answer to a question that was not asked yet; the end of the process is none."""
        assert self._process.stdout is not None
        if self._rest or os.read(self._process.stdout.fileno(), 1):
            raise ControllerError("it answered before it was asked")
        raise self._ended("before it was asked")

    def _answer(self, when: str) -> tuple[str, Any]:
        assert self._process.stdout is not None
        pipe = self._process.stdout.fileno()
        while b"\n" not in self._rest:
            begun = time.monotonic()
            there, _, _ = select.select([pipe], [], [], max(0.0, self._left))
            self._left -= time.monotonic() - begun
            if not there:
                raise ControllerError(f"it took longer than {self._limit:g} s in all ({when})")
            more = os.read(pipe, 1 << 16)
            if not more:
                raise self._ended(when)
            self._rest += more
            if len(self._rest) > _LONGEST:
                raise ControllerError(f"it answered with more than a command ({when})")
        line, _, self._rest = self._rest.partition(b"\n")
        try:
            kind, value = json.loads(line)
        except (ValueError, TypeError, RecursionError):
            raise ControllerError(f"it answered {line[:60]!r}, which is no command ({when})") from None
        if kind == "error":
            raise ControllerError(f"{value} ({when})")
        return str(kind), value

    def _ended(self, when: str) -> ControllerError:
        try:
            status = self._process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            status = None
        how = f" by signal {-status}" if status is not None and status < 0 else ""
        return ControllerError(f"its process ended{how} ({when}); it may have left Python, or needed too much memory")


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


def _said(readings: Mapping[str, RobotReading]) -> dict[str, Any]:
    return {
        name: [reading.measured.tolist(), reading.stamp, reading.age, bool(reading.fresh)]
        for name, reading in readings.items()
    }
