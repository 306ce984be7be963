"""The process of a submission: it loads the file, and answers one line for each that it is sent."""

from __future__ import annotations

import contextlib
import inspect
import json
import os
import select
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.controllers.user import PoseVector, RobotClock, RobotEstimate, RobotReading, Twist, WheelSpeeds
from amorsim.core.errors import AmorsimError, ControllerError
from amorsim.core.trouble import error_in_words
from amorsim.grading.fence import fence_in
from amorsim.grading.guard import renounce
from amorsim.scenario.controller_files import load_controller

__all__ = ["main"]

_LARGEST_FILE = 10**8  # bytes


def main() -> None:
    """Answer until nothing more is sent."""
    requests = os.fdopen(os.dup(0), "rb")
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # What a submission prints is no answer, and it has no keyboard.
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)

    def say(kind: str, value: Any) -> None:
        answers.write(json.dumps([kind, value]) + "\n")
        answers.flush()

    _end_with_the_grader(requests.fileno())
    first = json.loads(requests.readline())
    _limit(first["memory"])
    renounce()
    fence_in(**first["fence"])
    try:
        answer = _loaded(Path(first["path"]), first["name"], first["role"])
    except AmorsimError as error:
        say("error", str(error))
        sys.exit(1)
    except BaseException as error:
        say("error", error_in_words(error))
        sys.exit(1)
    say("ready", None)
    for line in requests:
        try:
            say(*answer(json.loads(line)))
        except MemoryError:
            say("error", "MemoryError: it needed more memory than it may have")
        except Exception as error:
            say("error", error_in_words(error))


Answer = Callable[[Mapping[str, Any]], tuple[str, Any]]


def _loaded(path: Path, name: str, role: str) -> Answer:
    """What answers each line."""
    if role == "controller":
        found: Any = load_controller(path, name, {})
        command: Any = getattr(found(), "command", None) if inspect.isclass(found) else found
        return lambda said: _as_message(command(*_arguments(said)))
    made = load_controller(path, name, {"start": None})
    if not callable(getattr(made, "update", None)):
        raise ControllerError(
            f"{name!r} in {path.name}: expected a class with update(self, readings, command, elapsed)"
        )
    own: list[Any] = []

    def estimate(said: Mapping[str, Any]) -> tuple[str, Any]:
        if "start" in said:
            own[:] = [made(start=np.array(said["start"]).view(PoseVector))]
            return "ready", None
        readings = _readings(said)
        return "estimate", _estimated(own[0].update(readings, np.array(said["command"]), said["elapsed"]))

    return estimate


def _estimated(answer: Any) -> list[Any]:
    """A pose and a covariance, as lists; a pose alone has none."""
    if isinstance(answer, tuple) and len(answer) == 2:
        pose, covariance = answer
    else:
        pose, covariance = answer, np.zeros((3, 3))
    return [np.asarray(pose, dtype=np.float64).tolist(), np.asarray(covariance, dtype=np.float64).tolist()]


def _end_with_the_grader(pipe: int) -> None:
    """End this process when the grader is gone, whatever the submission is doing then: nobody else would."""
    if not hasattr(select, "poll"):  # on Windows
        return

    def watch() -> None:
        closing = select.poll()
        closing.register(pipe, 0)  # for its end alone, which comes also where something is still to be read
        closing.poll()
        os._exit(1)

    threading.Thread(target=watch, name="amorsim-grader-gone", daemon=True).start()


def _limit(memory: int) -> None:
    with contextlib.suppress(ImportError, ValueError, OSError):  # not on Windows
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (_LARGEST_FILE, _LARGEST_FILE))


def _readings(said: Mapping[str, Any]) -> dict[str, RobotReading]:
    return {
        name: RobotReading(np.array(measured, dtype=np.float64), stamp, age, fresh)
        for name, (measured, stamp, age, fresh) in said["readings"].items()
    }


def _arguments(said: Mapping[str, Any]) -> tuple[dict[str, RobotReading], RobotEstimate, RobotClock]:
    pose, covariance = (np.array(part, dtype=np.float64) for part in said["estimate"])
    return _readings(said), RobotEstimate(pose.view(PoseVector), covariance), RobotClock(*said["clock"])


def _as_message(answer: Any) -> tuple[str, Any]:
    if isinstance(answer, Twist):
        return "twist", [_plain(part) for part in (answer.forward, answer.turn, answer.left)]
    if isinstance(answer, WheelSpeeds):
        return "wheels", [_plain(part) for part in (answer.left, answer.right)]
    if isinstance(answer, Mapping):
        return "other", {str(name): _plain(part) for name, part in answer.items()}
    if isinstance(answer, (list, tuple, np.ndarray)):
        return "other", [_plain(part) for part in answer]
    return "other", _plain(answer)


def _plain(value: Any) -> Any:
    """A number of NumPy as Python's; what is no number as text, which the simulation refuses by name."""
    if isinstance(value, np.generic):
        value = value.item()
    return value if value is None or isinstance(value, (bool, int, float)) else str(value)[:200]
