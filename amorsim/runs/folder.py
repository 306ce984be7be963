"""The folder of a run: claimed before, given back if the run never began, and its ``run.json``."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import platform
import sys
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

from amorsim.core.errors import RunError
from amorsim.plugins.manager import default_registry

__all__ = ["RunFolder", "check_free", "circumstances", "fingerprints", "new_folder", "next_folder"]

FORMAT = 1
ABOUT = "run.json"


def new_folder(name: str, base: Path | None = None) -> Path:
    """The first free folder ``amorsim-runs/<name>-<number>`` under `base`, else under the present folder, made.

    Made at once, so that of two runs that begin together each gets its own.

    Raises
    ------
    RunError
        If it cannot be made.
    """
    parent = (base or Path.cwd()) / "amorsim-runs"
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
    """`path` with the first number from 2 on that gives a folder which is not there, as in ``run-2``."""
    first = Path(path)
    number = 2
    while (found := first.with_name(f"{first.name}-{number}")).exists():
        number += 1
    return found


def check_free(path: Path | None) -> None:
    """Complain of a folder that holds something, before anything is computed for it; None is any.

    Raises
    ------
    RunError
        If there are files in it, it is a file itself, or what is in it cannot be told.
    """
    if path is None or not path.exists():
        return
    if not path.is_dir():
        raise RunError(f"{path}: is a file; name a folder, new or empty")
    try:
        holds_something = any(path.iterdir())
    except OSError as error:
        raise RunError(f"{path}: cannot make this folder for the run ({error.strerror or error})") from None
    if holds_something:
        raise RunError(f"{path}: the folder holds files already; name another one, or one that is not there")


class RunFolder:
    """A folder that belongs to one run from now on: `path` exists and holds nothing but a new ``run.json``.

    Parameters
    ----------
    path
        The folder, which must be empty or not be there; without it, a new one is made after `name`.

    Raises
    ------
    RunError
        If it holds something, or cannot be made or written.
    """

    def __init__(self, path: str | os.PathLike[str] | None, name: str = "run") -> None:
        self._made: list[Path] = []  # by us, the innermost first
        if path is None:
            self.path = new_folder(name)
            self._made = [self.path, self.path.parent]
        else:
            self.path = Path(path)
            self._make()
        try:
            # Only one of two that begin together makes this file.
            (self.path / ABOUT).open("x").close()
        except OSError as error:
            self._remove_folders()
            raise self._failure(error) from None

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

    def _failure(self, error: OSError) -> RunError:
        return RunError(f"{self.path}: cannot make this folder for the run ({error.strerror or error})")

    def give_back(self) -> None:
        """Remove what was made: for a run that did not begin. Only files of this run can be in it."""
        for file in sorted(self.path.rglob("*"), reverse=True):
            with contextlib.suppress(OSError):
                file.rmdir() if file.is_dir() else file.unlink()
        self._remove_folders()

    def _remove_folders(self) -> None:
        for folder in self._made:
            with contextlib.suppress(OSError):  # another run's files are in it
                folder.rmdir()

    def write_about(self, about: Mapping[str, Any]) -> None:
        """Write ``run.json``: beside, and then moved over, so that it is whole at any moment.

        Raises
        ------
        RunError
            If it cannot be written.
        """
        path = self.path / ABOUT
        beside = path.with_suffix(".json.part")
        try:
            beside.write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")
            beside.replace(path)
        except OSError as error:
            raise RunError(f"{path}: cannot be written ({error.strerror or error})") from None


_version = functools.cache(metadata.version)  # which reads a file each time


def circumstances() -> dict[str, Any]:
    """Versions and machine, on which the last bits of results may hang."""
    from llvmlite import binding

    packages = ("numpy", "numba", "attrs", "shapely", "pillow")
    return {
        "amorsim": _version("amorsim"),
        "python": sys.version.split()[0],
        "packages": {name: _version(name) for name in packages},
        "plugins": {plugin.name: plugin.version for plugin in default_registry().plugins},
        # For which kind the kernels are compiled: two of one kind give the same bits.
        "processor": f"{platform.machine()} {binding.get_host_cpu_name()}",
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
