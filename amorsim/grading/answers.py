"""The answers of a submission, which is loaded and then asked line by line."""

from __future__ import annotations

import base64
import inspect
import json
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.controllers.user import PoseVector, RobotClock, RobotEstimate, RobotReading, Twist, WheelSpeeds
from amorsim.core.error_text import error_in_words
from amorsim.core.errors import AmorsimError, ControllerError
from amorsim.grading.questions import ANSWERS
from amorsim.scenario.programs.controller_files import load_controller

__all__ = ["answer_all"]

Say = Callable[[str, Any], None]


def answer_all(path: Path, name: str, role: str, requests: Iterable[bytes], say: Say) -> None:
    """Load a submission, and answer each line that is sent."""
    try:
        answer, answers = _loaded(path, name, role)
    except AmorsimError as error:
        say("error", str(error))
        sys.exit(1)
    except BaseException as error:
        say("error", error_in_words(error))
        sys.exit(1)
    say("ready", answers)
    for line in requests:
        try:
            say(*answer(json.loads(line)))
        except MemoryError:
            say("error", "MemoryError: it needed more memory than it may have")
        except Exception as error:
            say("error", error_in_words(error))


Answer = Callable[[Mapping[str, Any]], tuple[str, Any]]


def _loaded(path: Path, name: str, role: str) -> tuple[Answer, dict[str, Any]]:
    """The function that answers a line, and the answers to the rubric's questions."""
    if role == "controller":
        found: Any = load_controller(path, name, {})
        command: Any = getattr(found(), "command", None) if inspect.isclass(found) else found
        return lambda message: _as_message(command(*_arguments(message))), _answers(found)
    made = load_controller(path, name, {"start": None})
    if not callable(getattr(made, "update", None)):
        raise ControllerError(
            f"{name!r} in {path.name}: expected a class with update(self, readings, command, elapsed)"
        )
    own: list[Any] = []

    def estimate(message: Mapping[str, Any]) -> tuple[str, Any]:
        if "beliefs" in message:
            return "beliefs", _beliefs(own[0])
        if "start" in message:
            own[:] = [made(start=np.array(message["start"]).view(PoseVector))]
            return "ready", None
        readings = _readings(message)
        return "estimate", _estimated(own[0].update(readings, np.array(message["command"]), message["elapsed"]))

    return estimate, _answers(made)


def _answers(found: Any) -> dict[str, Any]:
    """The answers in the file of a function or class, by the numbers of the questions."""
    written = getattr(sys.modules.get(getattr(found, "__module__", None) or ""), ANSWERS, None)
    return {str(number): _plain(value) for number, value in written.items()} if isinstance(written, Mapping) else {}


def _estimated(answer: Any) -> list[Any]:
    """A pose and a covariance as lists; a submission may return the pose alone."""
    if isinstance(answer, tuple) and len(answer) == 2:
        pose, covariance = answer
    else:
        pose, covariance = answer, np.zeros((3, 3))
    return [np.asarray(pose, dtype=np.float64).tolist(), np.asarray(covariance, dtype=np.float64).tolist()]


def _beliefs(own: Any) -> dict[str, Any]:
    """The beliefs of a submission by name: types, shapes, and bytes in base64."""
    if not hasattr(own, "beliefs"):
        return {}
    arrays = {str(name): np.asarray(values) for name, values in dict(own.beliefs()).items()}
    sent = {name: a if a.dtype in (np.bool_, np.int64) else a.astype(np.float64) for name, a in arrays.items()}
    return {
        name: [array.dtype.str, array.shape, base64.b64encode(array.tobytes()).decode()] for name, array in sent.items()
    }


def _readings(message: Mapping[str, Any]) -> dict[str, RobotReading]:
    return {
        name: RobotReading(np.array(measured, dtype=np.float64), stamp, age, fresh)
        for name, (measured, stamp, age, fresh) in message["readings"].items()
    }


def _arguments(message: Mapping[str, Any]) -> tuple[dict[str, RobotReading], RobotEstimate, RobotClock]:
    pose, covariance = (np.array(part, dtype=np.float64) for part in message["estimate"])
    return _readings(message), RobotEstimate(pose.view(PoseVector), covariance), RobotClock(*message["clock"])


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
    """A number of NumPy as Python's; anything else as text, which the simulation refuses by name."""
    if isinstance(value, np.generic):
        value = value.item()
    return value if value is None or isinstance(value, (bool, int, float)) else str(value)[:200]
