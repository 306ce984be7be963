"""The functions of the reading process; see `amorsim.ui.editor.reader`. Each request is a function of `_Functions`."""

from __future__ import annotations

import os
import pickle
import sys
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.core.error_text import error_in_words
from amorsim.core.errors import AmorsimError
from amorsim.core.maps.footprint_room import wall_gaps
from amorsim.core.shapes import Shape
from amorsim.plugins.manager import default_registry
from amorsim.scenario.documents.document import Document
from amorsim.scenario.programs.code_check import check_code
from amorsim.scenario.reading.partial import Partial
from amorsim.ui.editor.cards import card_of
from amorsim.ui.editor.looking import CODE_LIMIT, Seen, look, placed
from amorsim.ui.editor.storage.exported_files import picture_of, save_model, write_world
from amorsim.ui.forms.manuals import manual_of

__all__ = ["main"]

_POINT = 1e-6  # [m], the radius of a point, whose clearance is asked for
_FARTHEST = 1000.0  # [m] that walls are looked for


def main() -> None:
    """Answer requests from standard input until its end."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a plugin prints is not an answer
    functions = _Functions()
    _say(answers, (True, None))
    while True:
        try:
            name, arguments = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        _say(answers, functions.answer(name, arguments))


def _say(pipe: Any, answer: tuple[bool, Any]) -> None:
    pickle.dump(answer, pipe)
    pipe.flush()


class _Functions:
    """The functions that can be called, and what was read last, to which pictures and models belong."""

    def __init__(self) -> None:
        self._registry = default_registry()
        self._seen: Seen | None = None

    def answer(self, name: str, arguments: Mapping[str, Any]) -> tuple[bool, Any]:
        """Whether a function succeeded, and its result or the words of its error."""
        try:
            return True, getattr(self, name)(**arguments)
        except AmorsimError as error:
            return False, str(error)
        except Exception as error:  # what a plugin may raise
            sys.stderr.write("".join(traceback.format_exception(error)))
            return False, f"this failed: {error_in_words(error)}"

    def look(self, text: str, path: Path, shown: str, name: str, folder: Path) -> Any:
        """The view of a document."""
        self._seen = look(Document(text, path, registry=self._registry), shown, name, folder, self._registry)
        return self._seen.looked

    def picture(self, name: str) -> bytes:
        """The PNG of a map of the scenario that was read last."""
        builder = None if self._seen is None else self._seen.builder
        try:
            if builder is None:
                raise LookupError
            return builder.picture(name)
        except LookupError:
            raise AmorsimError(f"there is no picture {name!r}") from None

    def check_code(self, text: str, path: Path, shown: str, name: str, folder: Path) -> Any:
        """The faults of the programs that a scenario without other faults names; they run in other processes."""
        document = Document(text, path, registry=self._registry)
        if document.faults():
            return []
        faults = check_code(document.scenario(), time_limit=CODE_LIMIT)
        return placed(faults, document, shown, name, folder, self._registry)

    def write_world(self, target: Path, is_trial: bool, force: bool) -> Any:
        """Write the world that was read last in another format, or try what would be lost."""
        partial = self._partial()
        return write_world(partial.map, target, is_trial=is_trial, force=force, registry=self._registry)

    def picture_of_world(self, kind: str, title: str) -> str:
        """The world that was seen last, as a picture."""
        return picture_of(self._partial().map, kind, title, self._registry)

    def save_model(self, thing: str, sensor: str, target: Path, parent: str) -> str:
        """Write a robot that was seen last, or one of its sensors, into a file."""
        seen = self._seen
        found = next((one for one in seen.looked.things if one["path"] == thing), None) if seen else None
        if found is None:
            raise AmorsimError("there is no such thing")
        return save_model(self._partial(), found, sensor, target, parent, self._registry)

    def clearance(self, x: float, y: float) -> float:
        """How far the nearest wall of the world that was seen last is from a point [m]; 0 in a wall."""
        world = self._partial().map
        if world is None:
            raise AmorsimError("the world cannot be read; mend its faults first")
        gaps, _ = wall_gaps(world, [Shape.circle(_POINT)], np.array([[x, y, 0.0]]), cap=_FARTHEST)
        return max(0.0, float(gaps[0]) + _POINT)

    def card(self, kind: str, name: str, folder: Path) -> Any:
        """The card of something in a gallery."""
        return card_of(kind, name, folder, self._registry)

    def manual(self, kind: str, name: str) -> Any:
        """The manual of a component."""
        return manual_of(kind, name, self._registry)

    def square(self, text: str, path: Path, robot: str, **_: Any) -> Any:
        """The effect of a robot's errors on a square."""
        from amorsim.ui.editor.experiments import square_paths

        return square_paths(Document(text, path, registry=self._registry).scenario(), robot)

    def noise(self, text: str, path: Path, robot: str, sensor: str, **_: Any) -> Any:
        """How a sensor's readings scatter."""
        from amorsim.ui.editor.experiments import noise_bars

        return noise_bars(Document(text, path, registry=self._registry).scenario(), robot, sensor)

    def starts(self, text: str, path: Path, **_: Any) -> Any:
        """Where a run would let those start that are placed at random, by name."""
        from amorsim.ui.editor.experiments import starts_by_name

        return starts_by_name(Document(text, path, registry=self._registry).partial())

    def _partial(self) -> Partial:
        if self._seen is None or self._seen.partial is None:
            raise AmorsimError("it cannot be read; mend its faults first")
        return self._seen.partial
