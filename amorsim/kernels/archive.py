"""Compiled kernels in one file, for other machines with the same versions and a fitting processor.

The file is a zip of the folder of compiled kernels (`amorsim.kernels.cache_folder`), with a note of what it fits. What
lies in it runs as a part of this program, so an archive is to be trusted like the program itself.

The distribution ``amorsim-kernels`` brings such a file. Where it is installed and fits, its kernels are taken before
any is compiled. They are for a level of processors that most machines have (`LEVEL`).
"""

from __future__ import annotations

import importlib.util
import json
import os
import re
import sys
import tempfile
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numba
from llvmlite import binding

__all__ = ["LEVEL", "ArchiveError", "is_of_level", "misfit", "pack_kernels", "take_installed", "unpack_kernels"]

LEVEL = "x86-64-v3"
"""The processors that the kernels of ``amorsim-kernels`` are for: Intel's since Haswell (2013), AMD's since 2015."""
# What a processor of that level has, by the names of LLVM.
_FEATURES = ("avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sahf", "sse4.2", "xsave")
_INSTALLED = ("amorsim_kernels", "kernels.zip")
_NOTE = "amorsim-kernels.json"
_LONGEST_NOTE = 20_000  # bytes
_KEPT = (".nbi", ".nbc", "")  # numba's files, and marks of what is compiled
_PLAIN = re.compile(r"(?:\w+/)?[\w.-]+")
_TAKEN = "taken-from-amorsim-kernels"
_OTHER = {
    "kernels": "it is of another version of amorsim or numba",
    "python": "it is of another version of Python",
    "system": "it is of another system",
    "processor": "it is of another processor",
    "features": "it is of a processor with other features",
}
_DAMAGED = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError)


class ArchiveError(Exception):
    """A file is not an archive of compiled kernels, is damaged, or cannot be read or written."""


def pack_kernels(folder: Path, file: Path) -> None:
    """Write the kernels that are compiled in a folder into a file.

    Raises
    ------
    ArchiveError
        If the file cannot be written.
    """
    new = file.with_name(f"{file.name}.{os.getpid()}.part")
    try:
        with zipfile.ZipFile(new, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(_NOTE, json.dumps(_note(folder), indent=1))
            for path in sorted(folder.rglob("*")):
                if path.is_file() and path.suffix in _KEPT:
                    archive.write(path, path.relative_to(folder).as_posix())
        new.replace(file)
    except OSError as error:
        raise ArchiveError(f"{file}: cannot be written ({error.strerror or error})") from error
    finally:
        new.unlink(missing_ok=True)


def misfit(folder: Path, file: Path) -> str:
    """Why the kernels of an archive do not fit into a folder here, in words; empty if they do.

    Raises
    ------
    ArchiveError
        If the file is not an archive of kernels.
    """
    note, here = _read_note(file), _note(folder)
    return next((words for key, words in _OTHER.items() if note.get(key) != here[key]), "")


def unpack_kernels(folder: Path, file: Path) -> None:
    """Put the kernels of an archive that fits in place of all that is in a folder.

    Raises
    ------
    ArchiveError
        If the file is not an archive of kernels, is damaged, or its kernels cannot be written.
    """
    try:
        with (
            zipfile.ZipFile(file) as archive,
            tempfile.TemporaryDirectory(
                prefix=f"{folder.name}-", dir=folder.parent, ignore_cleanup_errors=True
            ) as within,
        ):
            names = [name for name in archive.namelist() if name != _NOTE]
            if any(not _PLAIN.fullmatch(name) for name in names):
                raise _no_archive(file, "it holds other files, too")
            new = Path(within) / "new"
            new.mkdir(mode=0o700)
            archive.extractall(new, names)
            # A process that compiles now goes on writing into the old folder, to no harm.
            folder.rename(Path(within) / "old")
            new.rename(folder)
    except _DAMAGED as error:
        raise _no_archive(file, f"it is damaged: {error}") from None
    except OSError as error:
        raise ArchiveError(f"{file}: cannot be unpacked ({error.strerror or error})") from error


def take_installed(folder: Path) -> None:
    """Take the kernels of ``amorsim-kernels`` into a folder, once, if it is installed and fits.

    From then on this process and those that it starts compile for `LEVEL`, unless ``NUMBA_CPU_NAME`` names another
    processor: numba uses what was compiled for the very processor that it is set to.
    """
    package, name = _INSTALLED
    spec = importlib.util.find_spec(package)
    file = Path(next(iter(spec.submodule_search_locations or [""])), name) if spec else Path()
    if not file.is_file():
        return
    before = numba.config.CPU_NAME, numba.config.CPU_FEATURES
    if before == (None, None) and is_of_level():
        _set_processor(LEVEL, "")
    try:
        if not misfit(folder, file):
            if not (folder / _TAKEN).exists():
                unpack_kernels(folder, file)
                (folder / _TAKEN).touch()
            return
    except (ArchiveError, OSError):
        pass  # what is not taken is compiled
    if before == (None, None):
        _set_processor(None, None)


def is_of_level() -> bool:
    """Whether the processor here is of `LEVEL`."""
    features = binding.get_host_cpu_features()
    return all(features.get(name, False) for name in _FEATURES)


def _set_processor(name: str | None, features: str | None) -> None:
    """Set the processor that numba compiles for, here and in processes that are started."""
    for variable, value in (("CPU_NAME", name), ("CPU_FEATURES", features)):
        setattr(numba.config, variable, value)
        if value is None:
            os.environ.pop(f"NUMBA_{variable}", None)
        else:
            os.environ[f"NUMBA_{variable}"] = value


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
            note = json.loads(archive.read(_NOTE)) if info.file_size <= _LONGEST_NOTE else None
    except OSError as error:
        raise ArchiveError(f"{file}: cannot be read ({error.strerror or error})") from error
    except (*_DAMAGED, KeyError, ValueError):
        note = None
    if not isinstance(note, dict):
        raise _no_archive(file, f"it has no {_NOTE} that can be read")
    return note


def _no_archive(file: Path, why: str) -> ArchiveError:
    return ArchiveError(f"{file}: not an archive of compiled kernels, as `amorsim compile --archive` writes: {why}")
