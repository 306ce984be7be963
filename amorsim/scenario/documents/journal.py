"""The changes of a document, which can be taken back one by one and made again."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from amorsim.scenario.toml.editing import Editor, Splice

__all__ = ["Journal"]

Change = list[Splice]


class Journal:
    """What was changed by an editor, step by step."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._done: list[Change] = []
        self._undone: list[Change] = []

    @contextlib.contextmanager
    def changing(self) -> Iterator[None]:
        """What changes within it is one step of `undo`, if anything does; if it raises, nothing has changed."""
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
        """Take the last step back, to the byte; false if there is none."""
        if not self._done:
            return False
        change = self._done.pop()
        for splice in reversed(change):
            self._editor.apply(splice, back=True)
        self._undone.append(change)
        return True

    def redo(self) -> bool:
        """Make the step again that was taken back last; false if there is none."""
        if not self._undone:
            return False
        change = self._undone.pop()
        for splice in change:
            self._editor.apply(splice)
        self._done.append(change)
        return True
