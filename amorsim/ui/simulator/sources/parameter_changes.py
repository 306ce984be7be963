"""The parameters that were set while a simulation ran; a reset keeps them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from amorsim.ui.simulator.sources.inputs import Input

__all__ = ["Changes"]


class Changes:
    """Values by robot and path, each the last one that was set."""

    def __init__(self) -> None:
        self._values: dict[tuple[str, str], Any] = {}

    @classmethod
    def of(cls, inputs: Iterable[Input]) -> Changes:
        """The changes that some inputs made."""
        changes = cls()
        for one in inputs:
            changes.note(one)
        return changes

    def note(self, new: Input) -> None:
        """Keep what an input sets, in place of earlier values inside it: a chain or an error has all its numbers."""
        if new.do != "set":
            return
        within = f"{new.path}."
        self._values = {
            (robot, path): value
            for (robot, path), value in self._values.items()
            if robot != new.robot or not (path == new.path or path.startswith(within))
        }
        self._values[new.robot, new.path] = new.value

    def forget(self, robot: str, path: str) -> None:
        """Take a parameter for unchanged: it was set to the scenario's value."""
        self._values.pop((robot, path), None)

    def inputs(self) -> list[Input]:
        """The inputs that set the same at the start of another simulation."""
        return [Input(tick=0, do="set", robot=robot, path=path, value=v) for (robot, path), v in self._values.items()]

    @property
    def values(self) -> dict[tuple[str, str], Any]:
        """The values by robot and path."""
        return dict(self._values)
