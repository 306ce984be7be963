"""The view of a document in a window: the drawing, the things, and the faults. No program of a user is run."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

import attrs

from amorsim.core.error_text import error_in_words
from amorsim.core.errors import Fault
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document
from amorsim.scenario.reading.partial import Partial
from amorsim.ui.editor.inspectors.fault_component import component_of
from amorsim.ui.editor.inspectors.things import Thing, things_of
from amorsim.ui.faults.shown_faults import FaultLine, fault_lines
from amorsim.ui.scene.still import StillBuilder
from amorsim.ui.scene.wire import Still

__all__ = ["CODE_LIMIT", "FaultAt", "Looked", "Seen", "look", "placed"]

CODE_LIMIT = 5.0  # [s] that a user's program may take to be loaded and made


class FaultAt(FaultLine):
    """A fault, the path of the value that it is about, with numbers in place of names, and the component it is in."""

    at: str
    component: tuple[str, str] | None  # kind and name


@attrs.frozen(kw_only=True)
class Looked:
    """The view of a document in a window, as plain values."""

    faults: list[FaultAt]
    things: list[Thing]
    still: Still | None

    @classmethod
    def failed(cls, name: str, problem: str) -> Looked:
        """The view of a document that cannot be read: one fault."""
        fault = Fault(file=name, path="", message=f"cannot be read: {problem}")
        lines: list[FaultAt] = [{**line, "at": "", "component": None} for line in fault_lines([fault])]
        return cls(faults=lines, things=[], still=None)


@attrs.frozen(kw_only=True)
class Seen:
    """What a window shows, and the scenario that it was made from: None if nothing could be read."""

    looked: Looked
    partial: Partial | None = None
    builder: StillBuilder | None = None


def look(document: Document, text: str, name: str, folder: Path, registry: Registry) -> Seen:
    """Read a document.

    Parameters
    ----------
    document
        As `Work.view` gives it.
    text
        The text that it stands for.
    name
        What the file is called.
    folder
        Where the files lie that are not saved; no fault names it.
    """
    try:
        partial = document.partial()
        builder = StillBuilder(partial, name)
        looked = Looked(
            faults=placed(partial.faults, document, text, name, folder, registry),
            things=things_of(document, partial, registry),
            still=builder.still,
        )
        return Seen(looked=looked, partial=partial, builder=builder)
    except Exception as error:  # what a plugin may raise
        sys.stderr.write("".join(traceback.format_exception(error)))
        return Seen(looked=Looked.failed(name, error_in_words(error)))


def placed(
    faults: Sequence[Fault], document: Document, text: str, name: str, folder: Path, registry: Registry
) -> list[FaultAt]:
    """Faults in the words of the user's own files, with their lines in the text and what they are about."""
    worded = [_worded(fault, document, name, folder) for fault in faults]
    lines = fault_lines(worded, {name: text})
    return [
        {**line, "at": fault.path, "component": component_of(document, fault.path, registry)}
        for line, fault in zip(lines, worded, strict=True)
    ]


def _worded(fault: Fault, document: Document, name: str, folder: Path) -> Fault:
    for place in sorted({path.parent for path in folder.rglob("*.*")}) if folder.is_dir() else ():
        fault = attrs.evolve(fault, message=fault.message.replace(f"{place}/", ""))
    return attrs.evolve(fault, file=name) if fault.file == str(document.path) else fault
