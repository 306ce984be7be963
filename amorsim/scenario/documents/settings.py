"""Settings of the command line, as texts ``robots.rover.controller.speed=0.2``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import attrs

from amorsim.core.arguments import texts
from amorsim.core.errors import Fault, ScenarioError
from amorsim.core.parameters import ParameterError
from amorsim.scenario.reading.faults import FaultCollector
from amorsim.scenario.toml.literals import parse_value

__all__ = ["Setting", "parse_settings", "setting_texts"]

_EXPECTED = "expected PATH=VALUE, as in simulation.dt=0.05 or robots.0.controller.speed=0.2"


@attrs.frozen(kw_only=True)
class Setting:
    """A value for a path in a document, and the text that sets it."""

    path: tuple[str, ...]
    value: Any
    text: str

    @property
    def file(self) -> str:
        """The name for faults in place of a file's."""
        return f"--set {self.text}"

    @property
    def chooses_model(self) -> bool:
        """Whether it names the model of a robot or sensor, to whose content all other settings then apply."""
        is_of_sensor = len(self.path) == 5 and self.path[2] == "sensors"
        return self.path[0] == "robots" and self.path[-1] == "model" and (len(self.path) == 3 or is_of_sensor)


def setting_texts(overrides: Iterable[str]) -> tuple[str, ...]:
    """The texts of settings that a caller gave.

    Raises
    ------
    ScenarioError
        If they are not a list of texts.
    """
    try:
        return texts(overrides, "overrides", "settings")
    except ParameterError as error:
        raise ScenarioError([Fault(file="", path=error.name, message=error.problem)]) from None


def parse_settings(overrides: Iterable[str], book: FaultCollector) -> list[Setting]:
    """The settings in texts ``PATH=VALUE``; the value is TOML, or else a plain text."""
    found = []
    for text in setting_texts(overrides):
        name, equals, value = text.partition("=")
        path = tuple(part.strip() for part in name.split("."))
        if not equals or not all(path):
            book.add(Fault(file=f"--set {text}", path="", message=_EXPECTED))
        else:
            found.append(Setting(path=path, value=_value(value.strip()), text=text))
    return found


def _value(text: str) -> Any:
    try:
        return parse_value(text)
    except (ValueError, RecursionError):
        return text
