"""What a window is shown of a document: what can be drawn, the things, and the faults. Nothing of a user's runs."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import Fault
from amorsim.core.trouble import error_in_words
from amorsim.scenario.document import Document
from amorsim.ui.editor.things import Thing, things_of
from amorsim.ui.faults.lines import FaultLine, fault_lines
from amorsim.ui.scene.still import StillBuilder

__all__ = ["Looked", "look"]


class FaultAt(FaultLine):
    """A fault, and the path of what it is about, with numbers in the places of names."""

    at: str


@attrs.frozen(kw_only=True)
class Looked:
    """What came of looking at a document."""

    faults: list[FaultAt]
    things: list[Thing]
    builder: StillBuilder | None

    @classmethod
    def failed(cls, name: str, problem: str) -> Looked:
        """Of a document that cannot be looked at."""
        fault = Fault(file=name, path="", message=f"cannot be read: {problem}")
        return cls(faults=[{**line, "at": ""} for line in fault_lines([fault])], things=[], builder=None)


def look(document: Document, text: str, values: Mapping[str, Any], name: str, folder: Path) -> Looked:
    """Read a document.

    Parameters
    ----------
    document
        As `Work.view` gives it.
    text, values
        The text that it stands for, and what that says.
    name
        What the file is called.
    folder
        Where the maps lie that are not saved; no fault names it.
    """
    try:
        partial = document.partial()
        faults = [_said(fault, document, name, folder) for fault in partial.faults]
        lines = fault_lines(faults, {name: text})
        return Looked(
            faults=[{**line, "at": fault.path} for line, fault in zip(lines, faults, strict=True)],
            things=things_of(values, partial, faults),
            builder=StillBuilder(partial, name),
        )
    except Exception as error:  # what a plugin may raise; it must not end the session
        sys.stderr.write("".join(traceback.format_exception(error)))
        return Looked.failed(name, error_in_words(error))


def _said(fault: Fault, document: Document, name: str, folder: Path) -> Fault:
    """A fault in the words of the user's own files."""
    for place in sorted({path.parent for path in folder.rglob("*.*")}) if folder.is_dir() else ():
        fault = attrs.evolve(fault, message=fault.message.replace(f"{place}/", ""))
    return attrs.evolve(fault, file=name) if fault.file == str(document.path) else fault
