"""Exceptions, one class for each kind of failure, all under `AmorsimError`.

A message states what failed, what was given, what was expected and what to do.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from typing import Any

import attrs

__all__ = [
    "AmorsimError",
    "AnalysisError",
    "ComponentError",
    "ContactError",
    "ControllerError",
    "DocumentError",
    "Fault",
    "GraphError",
    "MapError",
    "PluginError",
    "RunError",
    "ScenarioError",
    "ShapeError",
    "SnapshotError",
    "StudyError",
    "did_you_mean",
]

_SHOWN = 100  # faults in a message


class AmorsimError(Exception):
    """The base of all exceptions that amorsim raises on purpose."""

    def __reduce__(self) -> tuple[Any, ...]:
        # Python would call the class with the message alone, which not all take.
        return _again, (type(self), self.args, vars(self))


def _again(cls: type[AmorsimError], args: tuple[Any, ...], state: dict[str, Any]) -> AmorsimError:
    """An error as it was, in another process."""
    error = cls.__new__(cls, *args)
    vars(error).update(state)
    return error


class MapError(AmorsimError):
    """A map that cannot be read, or a query that a map cannot answer."""


class GraphError(AmorsimError):
    """A graph of poses that cannot be read, or whose edges do not determine its poses."""


class PluginError(AmorsimError):
    """A plugin, or a name that no plugin registered."""


class ComponentError(AmorsimError):
    """A component that breaks its contract."""


class PlanError(AmorsimError):
    """A start, goal or map that a planner cannot take."""


class ShapeError(AmorsimError, ValueError):
    """A shape that no body can have."""


class ContactError(AmorsimError):
    """A step whose contacts cannot be found, because a body moves too far in it."""


class ControllerError(AmorsimError):
    """A user's controller that cannot be loaded, raised, or returned what is not a command; of `robot`, if known."""

    def __init__(self, message: str, robot: str = "") -> None:
        self.robot = robot
        super().__init__(message)


class DocumentError(AmorsimError):
    """A path that leads nowhere in a document, or a change that its file cannot hold.

    `path` is where, empty if no path is at fault; `problem` is what is wrong there.
    """

    def __init__(self, problem: str, path: str = "") -> None:
        self.path = path
        self.problem = problem
        super().__init__(f"{path}: {problem}" if path else problem)


class SnapshotError(AmorsimError):
    """A state that cannot be copied or restored."""


class RunError(AmorsimError):
    """A run's folder that cannot be written or read."""


class StudyError(AmorsimError):
    """A study's file or folder that cannot be used, or a study that cannot go on; what was done stays."""


class AnalysisError(AmorsimError):
    """A trajectory, a run or a study that cannot be analysed as asked."""


@attrs.frozen(kw_only=True)
class Fault:
    """One fault in a scenario: its place, what was found, and what was expected.

    `path` is its place in the document. `named` is the same for messages, with names of robots, obstacles and zones
    instead of their numbers, if they have names. `line` is the line in the file from 1, if known; `value` is what was
    found.
    """

    file: str
    path: str
    message: str
    named: str = ""
    line: int | None = None
    value: Any = attrs.field(default=None, eq=False, repr=False)

    def __str__(self) -> str:
        file = f"{self.file}:{self.line}" if self.file and self.line else self.file
        where = ": ".join(part for part in (file, self.named or self.path) if part)
        return f"{where}: {self.message}" if where else self.message

    @property
    def remedy(self) -> str:
        """What was expected, in the words of the message; empty if the message has no such words."""
        if found := re.search(r"[Dd](id you mean .*\?)", self.message):
            return f"D{found[1]}"
        if found := re.search(r"expected (?:(?!, got ).)*", self.message):
            return found[0]
        _, mark, last = re.sub(r" \(column \d+\)$", "", self.message).rpartition("; ")
        if mark:
            return last.removesuffix(".")
        found = re.search(r": (write .*)", self.message)
        return found[1] if found else ""


class ScenarioError(AmorsimError):
    """A scenario with faults; carries all of them, and the warnings of its map if that was read.

    Its message shows the first hundred.
    """

    def __init__(self, faults: Iterable[Fault], warnings: Iterable[str] = ()) -> None:
        self.faults = tuple(faults)
        self.warnings = tuple(warnings)
        lines = [str(fault) for fault in self.faults[:_SHOWN]]
        if len(self.faults) > _SHOWN:
            lines.append(f"and {len(self.faults) - _SHOWN} more faults")
        super().__init__("\n".join(lines))


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """A question after the known name nearest to `name`, with a leading space; empty if none is near."""
    if not isinstance(name, str):
        return ""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    return f" Did you mean {near[0]!r}?" if near else ""
