"""Faults as a window shows them, and which errors a user can mend in the scenario's files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypedDict

from amorsim.core.error_text import explain
from amorsim.core.errors import AmorsimError, Fault, RunError, ScenarioError
from amorsim.core.files.reading import read_text
from amorsim.scenario.reading.faults import shown

__all__ = ["FaultLine", "FaultsError", "fault_lines", "lines_of"]

_LONGEST = 200  # letters of a line of a file


class FaultLine(TypedDict):
    """A fault: its place, the value there, and what is wrong with it."""

    file: str
    line: int | None
    said: str  # the line as it stands in the file
    path: str  # of the key, with the names of robots
    value: str
    message: str
    remedy: str


class FaultsError(AmorsimError):
    """A scenario that cannot be simulated before its files are mended; carries the faults as a window shows them."""

    def __init__(self, text: str, faults: Iterable[FaultLine]) -> None:
        self.faults = list(faults)
        super().__init__(text)


def lines_of(error: AmorsimError) -> list[FaultLine]:
    """The faults of a scenario's files that an error lists; none if it is about something else.

    An error of the base class is of an option; `RunError` is of the folder that a run is written into.
    """
    if isinstance(error, ScenarioError):
        return fault_lines(error.faults)
    if type(error) is AmorsimError or isinstance(error, RunError):
        return []
    return fault_lines([Fault(file="", path="", message=explain(error))])


def fault_lines(faults: Iterable[Fault], texts: Mapping[str, str] | None = None) -> list[FaultLine]:
    """Faults as a window shows them, each with the line of its file; `texts` are of files that are not saved."""
    files: dict[str, Sequence[str]] = {name: text.split("\n") for name, text in (texts or {}).items()}
    found: list[FaultLine] = []
    for fault in faults:
        said = ""
        if fault.line is not None:
            if fault.file not in files:
                files[fault.file] = _lines(fault.file)
            lines = files[fault.file]
            said = lines[fault.line - 1].strip() if 0 < fault.line <= len(lines) else ""
        found.append(
            {
                "file": fault.file,
                "line": fault.line,
                "said": said if len(said) <= _LONGEST else f"{said[: _LONGEST - 1]}…",
                "path": fault.named or fault.path,
                "value": "" if fault.value is None else shown(fault.value),
                "message": fault.message,
                "remedy": fault.remedy,
            }
        )
    return found


def _lines(file: str) -> Sequence[str]:
    try:
        return read_text(Path(file), encoding="utf-8-sig").split("\n")
    except (OSError, ValueError):
        return ()
