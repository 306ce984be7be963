"""Settings of the command line, ``robots.rover.controller.speed=0.2``, put into a document."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import Fault
from amorsim.scenario.angles import parse_float
from amorsim.scenario.faults import Book, Source, shown
from amorsim.scenario.names_in_lists import index_of

__all__ = ["Override", "apply_overrides", "parse_overrides"]


@attrs.frozen(kw_only=True)
class Override:
    """A value for a path in the document, and the text that says so."""

    path: tuple[str, ...]
    value: Any
    text: str

    @property
    def file(self) -> str:
        """What faults name in the place of a file."""
        return f"--set {self.text}"

    @property
    def chooses_model(self) -> bool:
        """Whether it says of which model a robot or a sensor is, so that it counts before models are merged in."""
        is_of_sensor = len(self.path) == 5 and self.path[2] == "sensors"
        return self.path[0] == "robots" and self.path[-1] == "model" and (len(self.path) == 3 or is_of_sensor)


def parse_overrides(texts: Iterable[str], book: Book) -> list[Override]:
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
            found.append(Override(path=path, value=_value(value.strip()), text=text))
    return found


_EXPECTED = "expected PATH=VALUE, as in simulation.dt=0.05 or robots.0.controller.speed=0.2"


def _value(text: str) -> Any:
    try:
        document = tomllib.loads(f"value = {text}", parse_float=parse_float)
    except (ValueError, RecursionError):
        return text
    # A line break in the text would begin a second key.
    return document["value"] if list(document) == ["value"] else text


def apply_overrides(document: dict[str, Any], overrides: Iterable[Override], book: Book) -> None:
    """Put each value at its path, making tables on the way; robots and such are found by index or by name."""
    for override in overrides:
        problem, path = _apply(document, override)
        if problem:
            book.add(Fault(file=override.file, path=".".join(path), message=problem))
        else:
            # Relative paths of the command line start where it was typed.
            book.set_source(path, Source(file=override.file, folder=Path.cwd()))


def _apply(document: dict[str, Any], override: Override) -> tuple[str, tuple[str, ...]]:
    """What is wrong with an override, or nothing, and the path of what it made, indices in the place of names.

    That is the path of its value, or of the first table on the way that was not there.
    """
    place: Any = document
    done: list[str] = []
    made: tuple[str, ...] = ()
    for part in override.path[:-1]:
        if isinstance(place, list):
            index = index_of(place, part)
            if isinstance(index, str):
                return index, (*done, part)
            place = place[index]
            done.append(str(index))
        elif isinstance(place, dict):
            done.append(part)
            if part not in place and not made:
                made = tuple(done)
            place = place.setdefault(part, {})
        else:
            return f"there is nothing under {'.'.join(done)}: it is {shown(place)}", (*done, part)
    last = override.path[-1]
    if isinstance(place, list):
        index = index_of(place, last)
        if isinstance(index, str):
            return index, (*done, last)
        place[index] = override.value
        return "", (*done, str(index))
    if not isinstance(place, dict):
        return f"there is nothing under {'.'.join(done)}: it is {shown(place)}", (*done, last)
    if last == "use" and place.get("use") != override.value:
        # Another component: the fields of the one before are not its own.
        place.clear()
    place[last] = override.value
    return "", made or (*done, last)
