"""Compiled kernels in one file, for other machines that have the same processor and the same versions.

The file is a zip of the folder of compiled kernels (`amorsim.kernels.cache_folder`), with a note of what it fits. What
lies in it runs as a part of this program, so an archive is to be trusted like the program itself.
"""

from __future__ import annotations

import json
import re
import sys
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numba
from llvmlite import binding

from amorsim.core.atomic_files import new_file, replacing
from amorsim.core.errors import AmorsimError
from amorsim.core.json_files import parse_json
from amorsim.kernels.cache_folder import cache_folder

__all__ = ["misfit", "pack_kernels", "unpack_kernels"]

_NOTE = "amorsim-kernels.json"
_LONGEST_NOTE = 20_000  # bytes
_KEPT = (".nbi", ".nbc", "")  # numba's files, and marks of what is compiled
_PLAIN = re.compile(r"(?:\w+/)?[\w.-]+")
_OTHER = {
    "kernels": "it is of another version of amorsim or numba",
    "python": "it is of another version of Python",
    "system": "it is of another system",
    "processor": "it is of another processor",
    "features": "it is of a processor with other features",
}


def pack_kernels(file: Path) -> None:
    """Write the kernels that are compiled on this machine into a file.

    Raises
    ------
    AmorsimError
        If the file cannot be written, or no folder holds compiled kernels.
    """
    folder = _folder()
    with replacing(file, AmorsimError) as new, zipfile.ZipFile(new, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(_NOTE, json.dumps(_note(folder), indent=1))
        for path in sorted(folder.rglob("*")):
            if path.is_file() and path.suffix in _KEPT:
                archive.write(path, path.relative_to(folder).as_posix())


def misfit(file: Path) -> str:
    """Why the kernels of an archive do not fit here, in words; empty if they do.

    Raises
    ------
    AmorsimError
        If the file is not an archive of kernels.
    """
    note, here = _read_note(file), _note(_folder())
    return next((words for key, words in _OTHER.items() if note.get(key) != here[key]), "")


def unpack_kernels(file: Path) -> None:
    """Take the kernels of an archive that fits, in place of all that were compiled on this machine.

    Raises
    ------
    AmorsimError
        If the file is not an archive of kernels, is damaged, or its kernels cannot be written.
    """
    folder = _folder()
    try:
        with zipfile.ZipFile(file) as archive, new_file(folder.name, folder.parent) as new:
            names = [name for name in archive.namelist() if name != _NOTE]
            if any(not _PLAIN.fullmatch(name) for name in names):
                raise _no_archive(file, "it holds other files, too")
            archive.extractall(new, names)
            # A process that compiles now goes on writing into the old folder, to no harm.
            folder.rename(new.with_name("old"))
            new.rename(folder)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise _no_archive(file, f"it is damaged: {error}") from None
    except OSError as error:
        raise AmorsimError(f"{file}: cannot be unpacked ({error.strerror or error})") from error


def _folder() -> Path:
    folder = cache_folder()
    if folder is None:
        raise AmorsimError("no folder can be written for compiled kernels; set NUMBA_CACHE_DIR to one that can")
    return folder


def _note(folder: Path) -> dict[str, str]:
    """Values that must be equal where compiled kernels are used, by the keys of `_OTHER`."""
    features = numba.config.CPU_FEATURES
    return {
        "kernels": folder.name,
        "python": f"{sys.implementation.name} {sys.version_info.major}.{sys.version_info.minor}",
        "system": binding.get_process_triple(),
        "processor": numba.config.CPU_NAME or binding.get_host_cpu_name(),
        "features": binding.get_host_cpu_features().flatten() if features is None else features,
    }


def _read_note(file: Path) -> dict[str, Any]:
    try:
        with zipfile.ZipFile(file) as archive:
            info = archive.getinfo(_NOTE)
            note = parse_json(archive.read(_NOTE)) if info.file_size <= _LONGEST_NOTE else None
    except OSError as error:
        raise AmorsimError(f"{file}: cannot be read ({error.strerror or error})") from error
    except (zipfile.BadZipFile, zlib.error, EOFError, KeyError, ValueError, NotImplementedError, RuntimeError):
        note = None
    if not isinstance(note, dict):
        raise _no_archive(file, f"it has no {_NOTE} that can be read")
    return note


def _no_archive(file: Path, why: str) -> AmorsimError:
    return AmorsimError(f"{file}: not an archive of compiled kernels, as `amorsim compile --archive` writes: {why}")
