"""The journal of an edited scenario: its steps on disk, which survive a killed server.

A line of JSON each: first the texts before the first step, then what happened. It lies in the user's state folder and
never next to the scenario. A step is written as soon as it is made; a line that a kill cut off is left out.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import attrs

from amorsim.core.errors import AmorsimError, RunError
from amorsim.core.files.atomic_files import write_text
from amorsim.ui.editor.history import History, Patch, Step

__all__ = ["Journal", "JournalError", "Kept", "mark_of", "state_folder"]

FORMAT = 1


class JournalError(AmorsimError):
    """Steps that cannot be kept on disk."""


def state_folder() -> Path:
    """The folder of the user's state: ``AMORSIM_STATE``, or the system's place for it."""
    if own := os.environ.get("AMORSIM_STATE"):
        return Path(own)
    if base := os.environ.get("XDG_STATE_HOME") or os.environ.get("LOCALAPPDATA"):
        return Path(base) / "amorsim"
    home = Path("~").expanduser()
    if sys.platform == "darwin":
        return home / "Library" / "Application Support" / "amorsim"
    return home / ".local" / "state" / "amorsim"


def mark_of(text: str | None) -> str:
    """A digest of a text; empty for a file that does not exist."""
    return "" if text is None else hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


@attrs.define(kw_only=True)
class Kept:
    """The content of a journal: the present texts, the steps, and marks of the texts that were saved last."""

    texts: dict[str, str]
    history: History = attrs.field(factory=History)
    saved: dict[str, str] = attrs.field(factory=dict)  # by the text's name, as `mark_of` gives it

    @property
    def base(self) -> dict[str, str]:
        """The texts before the first step."""
        texts = dict(self.texts)
        for step in reversed(self.history.done):
            _apply(texts, step, back=True)
        return texts


class Journal:
    """The journal of a key, locked by this process.

    Raises
    ------
    JournalError
        If another process has it, or it cannot be written.
    """

    def __init__(self, folder: Path, key: str) -> None:
        name = f"{Path(key).stem or 'untitled'}-{hashlib.sha256(key.encode()).hexdigest()[:16]}"
        self.file = folder / "edit" / f"{name}.jsonl"
        self._lock: IO[bytes] | None = None
        self._stream: IO[str] | None = None
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._lock = self.file.with_suffix(".lock").open("ab")
        except OSError as error:
            raise JournalError(f"{self.file}: cannot be written ({error.strerror}); steps are not kept") from None
        with contextlib.suppress(ImportError):  # not on Windows
            import fcntl

            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                self.close()
                raise JournalError("another Editor has this scenario open; the steps made here are not kept") from None

    def close(self) -> None:
        """Release it, so that another process can open it."""
        for stream in (self._stream, self._lock):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()
        self._stream = self._lock = None

    def read(self) -> Kept | None:
        """The journal's content; None if it is empty or cannot be read."""
        try:
            first, *lines = self.file.read_text(encoding="utf-8").split("\n")
            head = json.loads(first)
            if head["format"] != FORMAT:
                return None
            kept = Kept(texts=dict(head["texts"]), saved=dict(head["saved"]))
        except (OSError, ValueError, KeyError, TypeError):
            return None
        for line in lines:
            try:
                _happened(kept, json.loads(line))
            except (ValueError, KeyError, TypeError, AttributeError):  # cut off by a kill: the end
                break
        return kept

    def rewrite(self, kept: Kept) -> None:
        """Replace all of it; raises `JournalError` if it cannot be written."""
        history = kept.history
        lines: list[Any] = [{"format": FORMAT, "texts": kept.base, "saved": kept.saved}]
        lines += [_said(step) for step in (*history.done, *reversed(history.undone))]
        lines += [{"undo": len(history.undone)}] if history.undone else []
        try:
            if self._stream is not None:
                self._stream.close()
            write_text(self.file, "".join(json.dumps(line) + "\n" for line in lines))
            self._stream = self.file.open("a", encoding="utf-8")
        except (OSError, RunError) as error:
            self._stream = None
            raise JournalError(f"{self.file}: cannot be written; steps are not kept: {error}") from None

    def forget(self) -> None:
        """Delete it."""
        with contextlib.suppress(OSError):
            self.file.unlink()

    def step(self, step: Step) -> None:
        """Note a step."""
        self._write(_said(step))

    def undo(self) -> None:
        """Note that the last step was undone."""
        self._write({"undo": 1})

    def redo(self) -> None:
        """Note that a step was redone."""
        self._write({"redo": 1})

    def saved(self, marks: Mapping[str, str]) -> None:
        """Note that the files were saved with texts of these marks."""
        self._write({"saved": dict(marks)})

    def _write(self, line: Mapping[str, Any]) -> None:
        if self._stream is not None:
            try:
                self._stream.write(json.dumps(line) + "\n")
                self._stream.flush()
            except OSError:  # a disk that is full shall not stop the work
                self._stream = None


def _said(step: Step) -> dict[str, Any]:
    return {"step": step.label, "patches": {name: list(patch) for name, patch in step.patches.items()}}


def _happened(kept: Kept, line: Mapping[str, Any]) -> None:
    """Replay a line."""
    if "step" in line:
        step = Step(line["step"], {name: Patch(*patch) for name, patch in line["patches"].items()})
        _apply(kept.texts, step)
        kept.history.add(step)
    for _ in range(line.get("undo", 0)):
        if (back := kept.history.back()) is not None:
            _apply(kept.texts, back, back=True)
    for _ in range(line.get("redo", 0)):
        if (forward := kept.history.forward()) is not None:
            _apply(kept.texts, forward)
    if "saved" in line:
        kept.saved = dict(line["saved"])


def _apply(texts: dict[str, str], step: Step, *, back: bool = False) -> None:
    for name, patch in step.patches.items():
        texts[name] = patch.apply(texts.get(name, ""), back=back)
