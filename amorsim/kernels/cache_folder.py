"""The folder that holds compiled kernels: one for each state of their sources.

numba's cache looks only at the file of the function that it loads. A change in a function that this one calls would
leave old machine code in use. So the folder is named after a digest of all kernels' sources, and numba's version.

Within it, compiled code lies as its sources lie in the package, whatever folder that is installed in. So the folder can
be copied to another installation (`amorsim.kernels.archive`).
"""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numba

from amorsim.kernels.archive import take_installed

__all__ = ["KernelLocator", "cache_folder", "is_cold", "mark_warm"]

_SOURCES = Path(__file__).resolve().parent


@functools.cache
def cache_folder() -> Path | None:
    """The first writable folder of those for compiled kernels; None, with a warning, if there is none."""
    for parent in _candidates():
        folder = parent / f"kernels-{_digest()}"
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError:
            continue
        if _is_private(folder):
            _forget_old(parent, folder)
            take_installed(folder)
            return folder
    warnings.warn(
        "no folder can be written for compiled kernels, so every start compiles them again (about a minute); "
        "set NUMBA_CACHE_DIR to a folder that can be written",
        RuntimeWarning,
        stacklevel=2,
    )
    return None


def is_cold() -> bool:
    """Whether the kernels of usual runs are not compiled yet (`mark_warm`)."""
    folder = cache_folder()
    return folder is None or not (folder / "warm").exists()


def mark_warm() -> None:
    """Note that the kernels of the usual runs are compiled."""
    folder = cache_folder()
    if folder is not None:
        (folder / "warm").touch()


class KernelLocator:
    """The folder of compiled kernels, for numba; none for functions that are not amorsim's own.

    numba's documentation calls this a cache locator, named in ``NUMBA_CACHE_LOCATOR_CLASSES``.
    """

    def __init__(self, folder: Path, line: int) -> None:
        self._folder = folder
        self._line = line

    @classmethod
    def from_function(cls, function: Callable[..., Any], file: str) -> KernelLocator | None:
        """The locator of a function that is defined in a file."""
        folder, path = cache_folder(), Path(file).resolve()
        if folder is None or not path.is_relative_to(_SOURCES):
            return None
        return cls(folder / path.parent.relative_to(_SOURCES), function.__code__.co_firstlineno)

    def get_cache_path(self) -> str:
        """The folder for the function's compiled code."""
        return str(self._folder)

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        self._folder.mkdir(parents=True, exist_ok=True)

    def get_source_stamp(self) -> str:
        """A constant, since the folder's own name changes with the sources (`cache_folder`)."""
        return ""

    def get_disambiguator(self) -> str:
        """A text that differs between functions of one name."""
        return str(self._line)


def _candidates() -> Iterator[Path]:
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(given) / "amorsim"
    yield _SOURCES / "__pycache__"
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    yield (Path(base) if base else Path.home() / ".cache") / "amorsim"
    yield Path(tempfile.gettempdir()) / f"amorsim-{os.getuid() if hasattr(os, 'getuid') else 'kernels'}"


def _is_private(folder: Path) -> bool:
    """Whether no other user can put code there, which would run as this user."""
    if not hasattr(os, "getuid"):
        return True
    return all(
        each.stat().st_uid in (0, os.getuid()) and not each.stat().st_mode & 0o002 for each in (folder, folder.parent)
    )


def _forget_old(parent: Path, present: Path) -> None:
    """Remove compiled kernels of other sources that have not changed for a week."""
    for folder in parent.glob("kernels-*"):
        if folder != present and time.time() - folder.stat().st_mtime > 7 * 86400:
            shutil.rmtree(folder, ignore_errors=True)


def _digest() -> str:
    digest = hashlib.blake2b(numba.__version__.encode(), digest_size=8)
    for path in sorted(_SOURCES.rglob("*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()
