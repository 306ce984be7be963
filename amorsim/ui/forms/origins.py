"""Where the values of a running scenario come from: its file, a robot's model, a device, a default, or the command."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.scenario.documents.document import Document, open_document
from amorsim.scenario.documents.origins import Origin
from amorsim.scenario.reading.fields import NONE
from amorsim.scenario.spec import Robot, Scenario

__all__ = ["Origins"]

UNKNOWN = ("", "")


class Origins:
    """Looks up in a scenario's document where values come from, once for each path."""

    def __init__(self, scenario: Scenario) -> None:
        self._robots = [robot.name for robot in scenario.robots]
        self._known: dict[tuple[str, str], tuple[str, str]] = {}
        self._document: Document | None = None
        if scenario.source is not None:
            try:
                self._document = open_document(scenario.source)
            except AmorsimError:  # it is gone, or another file by now
                self._document = None

    def of(self, robot: Robot, path: str, value: Any) -> tuple[str, str]:
        """Where a scenario's `value` at a path of `Simulation.set` comes from: as a keyword, and in words.

        The word is ``"file"``, ``"model"``, ``"device"``, ``"default"`` or ``"command line"``; both are empty where it
        is not known.
        """
        if self._document is None:
            return UNKNOWN
        key = robot.name, path
        if key not in self._known:
            self._known[key] = self._look(robot, path, value)
        return self._known[key]

    def _look(self, robot: Robot, path: str, value: Any) -> tuple[str, str]:
        assert self._document is not None
        name = robot.name if len(self._robots) > 1 or "." not in robot.name else "0"
        for candidate in _spelt(robot, path):
            try:
                origin = self._document.inherited(f"robots.{name}.{candidate}")
            except AmorsimError:  # no value, or a fleet's table is about many robots
                continue
            if _differ(origin.value, value, is_angle="_deg" in candidate):
                return "command line", "from the command line"
            return origin.source, _in_words(origin)
        return ("default", "a default: no error") if path.startswith("errors.") else UNKNOWN


def _spelt(robot: Robot, path: str) -> Iterator[str]:
    """The paths at which a document may set a value, the most specific first."""
    parts = path.split(".")
    is_error = parts[0] == "errors"
    chain = robot.ground if parts[0] == "ground" else ()
    if parts[0] == "sensors" and len(parts) > 3 and parts[2] == "noise" and parts[1] in robot.sensors:
        chain = robot.sensors[parts[1]].noise
    if chain:  # an element without a name of its own is found by its place
        at = 3 if parts[0] == "sensors" else 1
        names = [element.name for element in chain]
        if parts[at] in names:
            parts[at] = str(names.index(parts[at]))
    whole = ".".join(parts)
    if not is_error:
        yield from (whole, f"{whole}_deg")
        return
    target, part = ".".join(parts[:-1]), parts[-1]
    yield from (f"{target}.{part}", f"{target}_deg.{part}")
    if part == "value":  # which a number alone may stand for
        yield from (target, f"{target}_deg")


def _differ(written: Any, value: Any, *, is_angle: bool) -> bool:
    """Whether a number differs from the document's, so that the command line must have changed it."""
    if written == NONE or isinstance(written, bool) or isinstance(value, bool):
        return False
    if not isinstance(written, (int, float)) or not isinstance(value, (int, float)):
        return False
    return not math.isclose(math.radians(written) if is_angle else written, value, rel_tol=1e-9, abs_tol=1e-15)


def _in_words(origin: Origin) -> str:
    if origin.source == "default" or origin.file is None:
        return "a default"
    line = "" if origin.line is None else f", line {origin.line}"
    what = {"model": "the model ", "device": "the device "}.get(origin.source, "")
    return f"from {what}{origin.file.name}{line}"
