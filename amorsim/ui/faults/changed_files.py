"""Watching files for changes."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from pathlib import Path

from amorsim.core.errors import DocumentError, ScenarioError
from amorsim.core.files.reading import read_bytes
from amorsim.scenario.documents.document import open_document

__all__ = ["Stamps", "change_of", "stamps_of", "stamps_of_scenario"]

Stamp = tuple[int, int, int, bytes] | None
Stamps = dict[Path, Stamp]

BETWEEN_LOOKS = 0.25  # [s]
_SMALL = 64 * 1024  # [bytes] up to which the content is compared too: a clock may be too coarse for two quick changes


def stamps_of(files: Iterable[Path]) -> Stamps:
    """A mark of each file, which differs after a change; None for a file that does not exist."""
    return {file: _stamp(file) for file in files}


def stamps_of_scenario(name: str) -> Stamps:
    """The same of a scenario's file and of those that it names."""
    try:
        return stamps_of(open_document(name).files())
    except (DocumentError, ScenarioError):  # the latter for another program's file
        return stamps_of([Path(name).absolute()])


async def change_of(stamps: Stamps) -> Stamps:
    """The marks of the files, once one has changed and none is being written any more.

    A file counts as written once it has looked the same twice.
    """
    before = stamps
    while True:
        await asyncio.sleep(BETWEEN_LOOKS)
        now = await asyncio.to_thread(stamps_of, stamps)
        if now != stamps and now == before:
            return now
        before = now


def _stamp(file: Path) -> Stamp:
    try:
        about = file.stat()
        content = read_bytes(file) if about.st_size <= _SMALL else b""
    except (OSError, ValueError):
        return None
    return about.st_mtime_ns, about.st_size, about.st_ino, content
