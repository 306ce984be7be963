"""Components in users' files, as a scenario's tables name them: what stands for them until the file may run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import attrs

from amorsim.array_types import Array
from amorsim.contracts import Frame, Metric, Plan, Planner, Recorder, RunInfo
from amorsim.controllers.user import UserController
from amorsim.core.errors import ControllerError
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.core.user_code import UserCode
from amorsim.estimators.user import UserEstimator
from amorsim.motions.user import UserMotion
from amorsim.scenario.programs.controller_files import is_controller_file, split_reference
from amorsim.scenario.programs.program_text import check_program
from amorsim.scenario.reading.faults import Node
from amorsim.scenario.reading.plain_values import check_values

__all__ = ["USER_CODE", "program_in", "read_program_in"]


@attrs.frozen(kw_only=True)
class UserPlanner(UserCode, Planner):
    """A planner in a file that has not been loaded."""

    kind: ClassVar[str] = "planner"
    plans_headings: ClassVar[bool] = True  # as far as is known

    def plan(
        self, world: Map, start: Sequence[float], goal: Sequence[float], *, footprint: Shape | None = None
    ) -> Plan:
        """No plan."""
        self.function()
        return Plan(status="unreachable", message="the planner's file was not loaded")


@attrs.frozen(kw_only=True)
class UserRecorder(UserCode, Recorder):
    """A recorder in a file that has not been loaded."""

    kind: ClassVar[str] = "recorder"

    def open(self, run: RunInfo, frames: Sequence[Frame]) -> None:
        """Refuse."""
        self.function()

    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        """Refuse."""
        self.function()

    def close(self) -> None:
        """Nothing was opened."""


@attrs.frozen(kw_only=True)
class UserMetric(UserCode, Metric):
    """A metric in a file that has not been loaded."""

    kind: ClassVar[str] = "metric"
    unit: ClassVar[str] = ""
    better: ClassVar[str] = "neither"

    def measure(self, episode: Any) -> Array:
        """Refuse."""
        value: Array = self.function()
        return value


USER_CODE: dict[str, type[UserCode]] = {
    cls.kind: cls for cls in (UserController, UserMotion, UserEstimator, UserPlanner, UserRecorder, UserMetric)
}
"""What stands for a component in a file, by the kinds of which a file may have one."""


def program_in(node: Node) -> str:
    """The ``FILE.py:NAME`` under ``use`` of a table; empty if it names a registered component or nothing."""
    use = node.value.get("use") if node.is_table else None
    return use if isinstance(use, str) and is_controller_file(use) else ""


def read_program_in(node: Node, kind: str, beside: tuple[str, ...] = ()) -> Any:
    """The component in a file that a table names, without running the file; None after faults.

    Keys `beside` are not options.
    """
    skip = ("use", *beside)
    options = {key: value for key, value in node.value.items() if key not in skip}
    if not check_values(node, skip):
        return None
    use = node.child("use")
    try:
        path, name = split_reference(use.value, use.folder)
        program = check_program(path, name, options, kind)
    except ControllerError as error:
        use.fault(str(error))
        return None
    place = use.book.at(use.path, "", use.value)
    program = attrs.evolve(program, place=place, folder=use.folder)
    return USER_CODE[kind](source=f"{path}:{name}", function=program, options=tuple(options.items()))
