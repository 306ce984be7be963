"""A simulation that is written into a folder as it goes, and into another one where it begins again."""

from __future__ import annotations

import contextlib
from pathlib import Path

from amorsim.core.errors import RunError
from amorsim.runs.folder import next_folder
from amorsim.runs.session import RunSession
from amorsim.simulation.simulation import Simulation

__all__ = ["Writing"]


class Writing:
    """The files that are written of a simulation.

    Parameters
    ----------
    out
        The folder, new or empty, or with a number after it where it is begun again; None to write nothing.
    """

    def __init__(self, out: Path | None) -> None:
        self._out = out
        self._recording: RunSession | None = None
        self._is_again = False

    @property
    def folder(self) -> Path | None:
        """Where it is being written; None where it is not."""
        return None if self._recording is None else self._recording.folder

    def begin(self, simulation: Simulation) -> None:
        """Write a simulation that is at its start."""
        if self._out is None:
            return
        is_taken = self._is_again and self._out.exists()
        self._recording = RunSession(simulation, next_folder(self._out) if is_taken else self._out)

    def keep(self) -> str:
        """Write a step; returns why writing has just ended, if it has."""
        recording = self._recording
        if recording is None:
            return ""
        try:
            recording.keep()
        except RunError as error:
            self._recording = self._out = None
            with contextlib.suppress(RunError):
                recording.close("broken off")
            return str(error)
        return ""

    def end(self, *, is_finished: bool) -> None:
        """End what is being written, with whole files."""
        recording, self._recording = self._recording, None
        if recording is None:
            return
        self._is_again = True
        if recording.steps == 0:
            recording.give_up()
        else:
            recording.close("finished" if is_finished else "interrupted")
