"""The folder of a run: claimed before the run, removed if the run never begins; and its ``run.json``."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import platform
import sys
from collections.abc import Collection, Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

from amorsim.core.arguments import path_of
from amorsim.core.errors import RunError
from amorsim.core.files.atomic_files import create_text, write_text
from amorsim.core.files.temporary_folders import HIDDEN, own_name, remove_left
from amorsim.plugins.manager import default_registry
from amorsim.runs.machine import processor

__all__ = [
    "RUNS",
    "RunFolder",
    "check_free",
    "circumstances",
    "fingerprints",
    "last_time",
    "new_folder",
    "next_folder",
    "tables_of",
]

FORMAT = 1
RUNS = "amorsim-runs"  # where folders go that nobody named
ABOUT = "run.json"
_TABLES = ("poses", "velocities", "commands", "events", "obstacles", "parts")
_PLACES = ("sensors", "estimates", "beliefs")  # folders of further tables
_MADE_LATER = ("export", "plots")  # folders of files that are made of the run's tables
_LONGEST_LINE = 1 << 20  # bytes
_ROOM_BESIDES = 16384  # bytes: a folder, and files in whole blocks


def new_folder(name: str, base: Path | None = None) -> Path:
    """The first free folder ``amorsim-runs/<name>-<number>`` under `base`, else under the present folder, made.

    Made at once, so that of two runs that begin together each gets its own.

    Raises
    ------
    RunError
        If it cannot be made.
    """
    parent = (base or Path.cwd()) / RUNS
    number = 1
    while True:
        path = parent / f"{name}-{number:03d}"
        try:
            parent.mkdir(parents=True, exist_ok=True)
            path.mkdir()
        except FileExistsError:
            if not parent.is_dir():
                raise RunError(f"{parent}: is in the way of the folder for runs; name one with --out") from None
            number += 1
        except OSError as error:
            raise RunError(f"{path}: cannot make this folder for the run ({error.strerror or error})") from None
        else:
            return path


def next_folder(path: str | os.PathLike[str]) -> Path:
    """`path` with the first number from 2 on that names a new folder, as in ``run-2``."""
    first = Path(path)
    number = 2
    while (found := first.with_name(f"{first.name}-{number}")).exists():
        number += 1
    return found


def check_free(path: Path | None) -> None:
    """Raise an error for a folder that is not empty, before anything is computed for it; None is always free.

    Temporary files of processes that write there do not count; those that a killed one left are removed.

    Raises
    ------
    RunError
        If there are files in it, it is a file itself, or its content cannot be listed.
    """
    try:
        if path is None or not path.exists():
            return
    except OSError as error:  # a name that is too long
        raise RunError(f"{path}: cannot make this folder for the run ({error.strerror or error})") from None
    if not path.is_dir():
        raise RunError(f"{path}: is a file; name a folder, new or empty")
    try:
        remove_left(path)
        there = next((each.name for each in path.iterdir() if not each.name.startswith(HIDDEN)), "")
    except OSError as error:
        raise RunError(f"{path}: cannot make this folder for the run ({error.strerror or error})") from None
    if there:  # named, for it may be one that a listing leaves out
        raise _taken(path, there)


def _taken(path: Path, there: str) -> RunError:
    return RunError(
        f"{path}: the folder holds files already, such as {there}; name another one, or one that is not there"
    )


def _text(about: Mapping[str, Any]) -> str:
    return json.dumps(about, indent=2) + "\n"


class RunFolder:
    """A folder that belongs to one run: `path` exists and has a new, complete ``run.json``.

    Parameters
    ----------
    path
        The folder, which must be empty or not be there; without it, a new one is made after `name`.
    name
        See `path`.
    about
        First content of ``run.json``.

    Raises
    ------
    RunError
        If it holds something, or cannot be made or written.
    """

    def __init__(self, path: str | os.PathLike[str] | None, name: str, about: Mapping[str, Any]) -> None:
        self._made: list[Path] = []  # by us, the innermost first
        if path is None:
            self.path = new_folder(name)
            self._made = [self.path, self.path.parent]
        else:
            self.path = path_of(path, "folder")
            self._make()
        self._room: Path | None = None  # reserves space until a run ends: on a full disk, the last run.json takes it
        try:
            self._claim(about)
        except RunError:
            self._remove_folders()
            raise

    def _make(self) -> None:
        check_free(self.path)
        missing = [self.path]
        while not missing[-1].exists() and missing[-1].parent != missing[-1]:
            missing.append(missing[-1].parent)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            self._made = missing[:-1]
        except OSError as error:
            raise self._failure(error) from None

    def _claim(self, about: Mapping[str, Any]) -> None:
        try:
            create_text(self.path / ABOUT, _text(about))
        except FileExistsError:  # of two that begin together, the other one made it
            raise _taken(self.path, ABOUT) from None

    def _failure(self, error: OSError) -> RunError:
        return RunError(f"{self.path}: cannot make this folder for the run ({error.strerror or error})")

    def give_back(self) -> None:
        """Remove what was made, for a run that did not begin; all files in it are this run's."""
        for file in sorted(self.path.rglob("*"), reverse=True):
            with contextlib.suppress(OSError):
                file.rmdir() if file.is_dir() else file.unlink()
        self._remove_folders()

    def _remove_folders(self) -> None:
        for folder in self._made:
            with contextlib.suppress(OSError):  # another run's files are in it
                folder.rmdir()

    def write_about(self, about: Mapping[str, Any]) -> None:
        """Write ``run.json`` so that it is complete at any moment.

        Raises
        ------
        RunError
            If it cannot be written.
        """
        write_text(self.path / ABOUT, _text(about))

    def set_room_aside(self, size: int) -> None:
        """Reserve `size` bytes of the disk for `write_end`, plus the overhead of a file.

        Raises
        ------
        RunError
            If there is no room.
        """
        self._room = self.path / own_name("room")
        try:
            self._room.write_bytes(bytes(size + _ROOM_BESIDES))
        except OSError as error:
            raise RunError(f"{self.path}: there is no room for the run's files ({error.strerror or error})") from None

    def write_end(self, about: Mapping[str, Any]) -> None:
        """Like `write_about`, but also on a full disk, because space was reserved."""
        if self._room is not None:
            with contextlib.suppress(OSError):
                self._room.unlink()
        self.write_about(about)


def tables_of(folder: Path, inputs: Collection[str]) -> list[Path]:
    """The text files of results in a run's folder, those of recorders of plugins too.

    Parameters
    ----------
    inputs
        The names of the files that are copies of what the run was given, such as a track: ``inputs`` in ``run.json``.
    """
    found = ((path, path.relative_to(folder)) for path in folder.rglob("*.csv") if path.is_file())
    return sorted(path for path, name in found if name.parts[0] not in _MADE_LATER and name.as_posix() not in inputs)


def _own_tables(folder: Path) -> list[Path]:
    """The tables that amorsim itself writes during a run."""
    own = (folder / f"{name}.csv" for name in _TABLES)
    more = (path for place in _PLACES for path in (folder / place).glob("*.csv"))
    return sorted(path for path in (*own, *more) if path.is_file())


def last_time(folder: Path) -> float:
    """The time [s] up to which all of a run's own tables have lines; tables of occasional things do not count.

    0 if one has none. A slow sensor's table ends before the others, even if it is complete.
    """
    times = []
    for path in _own_tables(folder):
        if path.name in ("events.csv", "obstacles.csv") or path.parent.name == "beliefs":
            continue
        try:
            with path.open("rb") as file:
                header = file.readline().rstrip(b"\n").split(b",")
                start = file.tell()
                file.seek(max(start, file.seek(0, os.SEEK_END) - _LONGEST_LINE))
                last = file.read().rpartition(b"\n")[0].rpartition(b"\n")[2]
            times.append(float(last.split(b",")[header.index(b"time")]))
        except (OSError, ValueError, IndexError):  # no line
            times.append(0.0)
    return min(times, default=0.0)


_version = functools.cache(metadata.version)  # which reads a file each time


def circumstances() -> dict[str, Any]:
    """Versions and machine, on which the last bits of results may depend."""
    packages = ("numpy", "numba", "attrs", "shapely", "pillow")
    return {
        "amorsim": _version("amorsim"),
        "python": sys.version.split()[0],
        "packages": {name: _version(name) for name in packages},
        "plugins": {plugin.name: plugin.version for plugin in default_registry().plugins},
        # The kernels are compiled for this processor: two of one kind give the same bits.
        "processor": processor(),
        "system": platform.system(),
    }


def fingerprints(folder: Path, names: list[str]) -> dict[str, str]:
    """A digest of each of the named files in a folder; without those that are not there, or no regular files."""
    found = {}
    for name in names:
        with contextlib.suppress(OSError):
            if (folder / name).is_file():  # a pipe would be read for ever
                with (folder / name).open("rb") as file:
                    found[name] = hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()
    return found
