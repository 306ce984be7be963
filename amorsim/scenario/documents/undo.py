"""The changes of a document, to be undone and redone one by one."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from amorsim.scenario.toml.editing import Editor, Splice

__all__ = ["Journal"]

Change = list[Splice]


class Journal:
    """The steps of an editor's work."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._done: list[Change] = []
        self._undone: list[Change] = []

    @contextlib.contextmanager
    def changing(self) -> Iterator[None]:
        """A block whose changes are one step of `undo`, if there are any; if it raises, nothing has changed."""
        log = self._editor.log = []
        before = self._editor.statements.copy()
        try:
            yield
        except BaseException:
            for splice in reversed(log):
                self._editor.apply(splice, back=True)
            raise
        if log and self._editor.statements != before:
            self._done.append(log)
            self._undone.clear()

    def undo(self) -> bool:
        """Undo the last step, to the byte; false if there is none."""
        if not self._done:
            return False
        change = self._done.pop()
        for splice in reversed(change):
            self._editor.apply(splice, back=True)
        self._undone.append(change)
        return True

    def redo(self) -> bool:
        """Redo the step that was undone last; false if there is none."""
        if not self._undone:
            return False
        change = self._undone.pop()
        for splice in change:
            self._editor.apply(splice)
        self._done.append(change)
        return True
