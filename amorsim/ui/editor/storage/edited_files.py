"""The files that are edited with a scenario, as texts: the map of its world, and the programs that it names."""

from __future__ import annotations

import hashlib
from collections.abc import Container, Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.errors import AmorsimError
from amorsim.core.files.atomic_files import write_bytes
from amorsim.core.files.reading import is_there, read_bytes, reason
from amorsim.scenario.programs.local_imports import files_beside
from amorsim.ui.editor.inspectors.walls import EMPTY_WORLD
from amorsim.ui.editor.journal import mark_of
from amorsim.ui.editor.storage.bitmaps import CODEC, SUFFIXES, decode, encode
from amorsim.ui.faults.changed_files import Stamp, stamps_of

__all__ = ["PROGRAM", "FileText", "Files", "FilesError"]

PROGRAM = ".py"


class FilesError(AmorsimError):
    """A file that cannot be edited as a text."""


@attrs.define(kw_only=True)
class FileText:
    """The edited text of a file, and the text on the disk: None if there is none yet.

    `empty` is the file's text before its first change.
    """

    text: str
    saved: str | None
    empty: str = ""
    encoding: str = "utf-8"

    @property
    def first(self) -> str:
        """The text before the first change since it was read or saved."""
        return self.empty if self.saved is None else self.saved

    def data(self, suffix: str) -> bytes:
        """The text as it is written into a file: of a bitmap, the picture."""
        return encode(self.text, suffix) if self.encoding == CODEC else self.text.encode(self.encoding)


def read_file(path: Path, world: Mapping[str, Any]) -> FileText:
    """The text of a file; `world` is the scenario's table of the world, for maps.

    Raises
    ------
    FilesError, WallsError
        If it cannot be read, or is a bitmap that cannot be painted on.
    """
    if not is_there(path):
        empty = "" if path.suffix == PROGRAM else EMPTY_WORLD
        return FileText(text=empty, saved=None, empty=empty)
    try:
        data = read_bytes(path)
    except (OSError, ValueError) as error:
        raise FilesError(f"{path.name}: cannot be read: {reason(error)}") from None
    if path.suffix.lower() in SUFFIXES:
        text, encoding = decode(data, path.name, has_threshold=isinstance(world.get("threshold"), (int, float))), CODEC
    else:
        try:
            text, encoding = data.decode(), "utf-8"
        except UnicodeDecodeError:
            text, encoding = data.decode("latin-1"), "latin-1"
    return FileText(text=text, saved=text, encoding=encoding)


class Files:
    """The texts of files by path, as far as they have been read.

    Attributes
    ----------
    stamps
        When the files were changed last, as they were read or saved.
    """

    def __init__(self) -> None:
        self._held: dict[Path, FileText] = {}
        self.stamps: dict[Path, Stamp] = {}

    def __contains__(self, path: object) -> bool:
        return path in self._held

    def __iter__(self) -> Iterator[Path]:
        return iter(list(self._held))

    def __getitem__(self, path: Path) -> FileText:
        return self._held[path]

    def read(self, path: Path, world: Mapping[str, Any]) -> FileText:
        """The text of a file, read now if that was not done before; raises as `read_file`."""
        if path not in self._held:
            self._held[path] = read_file(path, world)
            self.stamps |= stamps_of([path])  # also of one that is not there: it may come back with its own content
        return self._held[path]

    def begin(self, path: Path, empty: str) -> None:
        """Hold a file that is not there yet."""
        self._held[path] = FileText(text=empty, saved=None, empty=empty)

    def drop(self, path: Path) -> None:
        """Hold a file no more."""
        del self._held[path]
        self.stamps.pop(path, None)

    def clear(self) -> None:
        """Forget all texts."""
        self._held.clear()

    @property
    def texts(self) -> dict[str, str]:
        """All texts by their paths."""
        return {str(path): held.text for path, held in self._held.items()}

    def restore(self, texts: Mapping[str, str]) -> None:
        """Restore the texts of the files, and forget all others."""
        self._held = {path: held for path, held in self._held.items() if str(path) in texts}
        for path, held in self._held.items():
            held.text = texts[str(path)]

    @property
    def differing(self) -> dict[Path, FileText]:
        """The files whose text is not what is on the disk."""
        return {path: held for path, held in self._held.items() if held.text != held.saved}

    @property
    def marks(self) -> dict[str, str]:
        """The marks (`mark_of`) of the files on the disk, as far as they are known."""
        return {str(path): mark_of(held.saved) for path, held in self._held.items()}

    def write(self, path: Path) -> None:
        """Write a file; raises `RunError` if that cannot be done."""
        held = self._held[path]
        write_bytes(path, held.data(path.suffix.lower()))
        held.saved = held.text
        self.stamps |= stamps_of([path])

    def move(self, places: Mapping[Path, Path], *, written: Container[Path]) -> None:
        """Keep the files under their new paths and forget all others; those `written` there count as saved."""
        self._held = {
            new: attrs.evolve(self._held[old], saved=self._held[old].text if old in written else None)
            for old, new in places.items()
            if old in self._held
        }
        self.stamps = stamps_of(path for path, held in self._held.items() if held.saved is not None)

    def place(self, path: Path, folder: Path) -> Path:
        """The path of a copy of a file as edited: in a folder of its own in `folder`, with what a program imports.

        A file that is on the disk as it is edited, with all that it imports, stays where it is.
        """
        differing = self.differing
        beside: dict[str, Path] = {}
        if path.suffix == PROGRAM:
            beside = files_beside(path, self._held[path].data(PROGRAM) if path in self._held else None)
        if not {path, *beside.values()} & set(differing):
            return path
        needed = beside | {path.name: path}
        data_of = {key: self._data(file) for key, file in needed.items()}
        whole = b"\0".join(part for name in sorted(data_of) for part in (name.encode(), data_of[name]))
        own = folder / hashlib.sha256(whole).hexdigest()[:16]
        for name, data in data_of.items():
            if not is_there(own / name):
                (own / name).parent.mkdir(parents=True, exist_ok=True)
                write_bytes(own / name, data)
        return own / path.name

    def _data(self, path: Path) -> bytes:
        return self._held[path].data(path.suffix.lower()) if path in self._held else path.read_bytes()
