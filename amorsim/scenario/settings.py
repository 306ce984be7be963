"""Settings of the command line, as texts ``robots.rover.controller.speed=0.2``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import attrs

from amorsim.core.errors import Fault
from amorsim.scenario.faults import Book
from amorsim.scenario.toml_values import parse_value

__all__ = ["Setting", "parse_settings"]

_EXPECTED = "expected PATH=VALUE, as in simulation.dt=0.05 or robots.0.controller.speed=0.2"


@attrs.frozen(kw_only=True)
class Setting:
    """A value for a path in a document, and the text that says so."""

    path: tuple[str, ...]
    value: Any
    text: str

    @property
    def file(self) -> str:
        """What faults name in the place of a file."""
        return f"--set {self.text}"

    @property
    def chooses_model(self) -> bool:
        """Whether it says of which model a robot or a sensor is, so that all others are about what that says."""
        is_of_sensor = len(self.path) == 5 and self.path[2] == "sensors"
        return self.path[0] == "robots" and self.path[-1] == "model" and (len(self.path) == 3 or is_of_sensor)


def parse_settings(texts: Iterable[str], book: Book) -> list[Setting]:
    """What ``PATH=VALUE`` texts say: a value is one of TOML, or else a plain text."""
    if isinstance(texts, str):
        problem = f"expected a list of settings, as [{texts!r}], got a text"
        book.add(Fault(file="", path="overrides", message=problem))
        return []
    found = []
    for text in texts:
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
