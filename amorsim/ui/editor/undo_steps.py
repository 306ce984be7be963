"""The steps of a scenario that is being edited, and the journal that keeps them on disk, where it can."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from amorsim.ui.editor.history import History, Step
from amorsim.ui.editor.journal import Journal, JournalError, Kept

__all__ = ["Steps"]


class Steps:
    """The steps that can be undone and redone.

    Parameters
    ----------
    state
        The folder of the journal; None keeps none.

    Attributes
    ----------
    history
        The steps.
    remark
        The message for the user about the journal; empty for none.
    """

    def __init__(self, state: Path | None) -> None:
        self.history = History()
        self.remark = ""
        self._state = state
        self._journal: Journal | None = None
        self._known: set[str] = set()  # the texts that the journal has

    def open(self, key: str) -> Kept | None:
        """Use the journal of a key instead of the present one; returns its content, if any."""
        if self._state is None:
            return None
        self.close()
        try:
            self._journal = Journal(self._state, key)
        except JournalError as error:
            self.remark = str(error)
            return None
        return self._journal.read()

    def close(self) -> None:
        """Release the journal, so that another Editor can have it."""
        if self._journal is not None:
            self._journal.close()
            self._journal = None

    def forget(self) -> None:
        """Empty the journal and release it."""
        if self._journal is not None:
            self._journal.forget()
        self.close()

    def rewrite(self, texts: Mapping[str, str], marks: dict[str, str]) -> None:
        """Start the journal anew, with the present texts and marks of the saved files (see `mark_of`)."""
        if self._journal is None:
            return
        self._known = set(texts)
        try:
            self._journal.rewrite(Kept(texts=dict(texts), history=self.history, saved=marks))
        except JournalError as error:
            self.remark = str(error)
            self.close()

    def add(self, step: Step) -> bool:
        """Add a step; false if the journal must be rewritten because a text that the step changes is missing in it."""
        self.history.add(step)
        if self._journal is None:
            return True
        if not set(step.patches) <= self._known:
            return False
        self._journal.step(step)
        return True

    def back(self) -> Step | None:
        """The step to undo, which can be redone afterwards; None if there is none."""
        step = self.history.back()
        if step is not None and self._journal is not None:
            self._journal.undo()
        return step

    def forward(self) -> Step | None:
        """The step to redo; None if there is none."""
        step = self.history.forward()
        if step is not None and self._journal is not None:
            self._journal.redo()
        return step

    def saved(self, marks: Mapping[str, str]) -> None:
        """Note that files were saved with texts of these marks."""
        if self._journal is not None:
            self._journal.saved(marks)
