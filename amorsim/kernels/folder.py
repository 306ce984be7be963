"""The folder that compiled kernels lie in, what they depend on, and whether they are there; told without numba.

A kernel goes stale with its source and that of every kernel file that it imports.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import importlib.metadata
import os
import re
import sys
import tempfile
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path

__all__ = ["cache_folder", "is_cold", "mark_warm", "source_stamp", "sources_of", "stamp_file"]

_HERE = Path(__file__).resolve().parent


# Every mention counts, in a comment too: one too many compiles once more, one too few would run stale code.
_MENTION = re.compile(rb"amorsim\.kernels\.(\w+)")


def sources_of(path: Path) -> tuple[Path, ...]:
    """The file of a kernel and all files of kernels that it reaches through imports, itself first."""
    found = {path.resolve(): None}
    waiting = list(found)
    while waiting:
        text = waiting.pop().read_bytes()
        named = {_HERE / f"{name.decode()}.py" for name in _MENTION.findall(text)}
        if re.search(rb"from\s+amorsim\.kernels\s+import|import\s+amorsim\.kernels\s", text):
            named.update(_HERE.glob("*.py"))  # whole modules by name: which of them is used is not worth finding out
        for callee in sorted(named):
            if callee.exists() and callee not in found:
                found[callee] = None
                waiting.append(callee)
    return tuple(found)


def _version_of_numba() -> str:
    try:
        return importlib.metadata.version("numba")
    except importlib.metadata.PackageNotFoundError:  # installed in a way that says nothing of it
        import numba

        return str(numba.__version__)


def _digest_of(paths: Iterable[Path]) -> str:
    digest = hashlib.blake2b(digest_size=16)
    for path in paths:
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    digest.update(_version_of_numba().encode())
    return digest.hexdigest()


@functools.cache
def source_stamp(path: Path) -> str:
    """Digest of what the compiled code of one file depends on: its sources and numba's version."""
    return _digest_of(sources_of(path))


@functools.cache
def _all_sources_stamp() -> str:
    return _digest_of(sorted(_HERE.rglob("*.py")))


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _candidates() -> Iterator[Path]:
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(given) / "amorsim"
    yield _HERE / "__pycache__"
    with contextlib.suppress(RuntimeError):  # no home folder is known
        base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".cache"
        yield Path(base) / "amorsim" / "kernels"
    # One folder a user: a shared one could hold another user's code.
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    yield Path(tempfile.gettempdir()) / f"amorsim-kernels-{user}"


def _is_private(folder: Path) -> bool:
    """Whether nobody else could have put code there: matters for the world-writable temporary folder only."""
    if not hasattr(os, "getuid"):
        return True
    status = folder.stat()
    return status.st_uid == os.getuid() and not status.st_mode & 0o022


@functools.cache
def cache_folder() -> Path | None:
    """The first folder that can be written of those that may hold compiled kernels, or none, with a warning."""
    for folder in _candidates():
        if _is_writable(folder):
            if folder.parent == Path(tempfile.gettempdir()):
                with contextlib.suppress(OSError):
                    folder.chmod(0o700)
                if not _is_private(folder):
                    continue
            return folder
    warnings.warn(
        "no folder can be written for compiled kernels, so every start compiles them anew (some seconds); "
        "set NUMBA_CACHE_DIR to a folder that can be written",
        RuntimeWarning,
        stacklevel=2,
    )
    return None


def stamp_file() -> Path | None:
    """The file whose presence says that the kernels of the present sources are compiled."""
    folder = cache_folder()
    return (
        None if folder is None else folder / f"warm-{_all_sources_stamp()}-{sys.version_info[0]}{sys.version_info[1]}"
    )


def is_cold() -> bool:
    """Whether no process has yet compiled the present sources and said so, so that a first step will take a while."""
    stamp = stamp_file()
    return stamp is None or not stamp.exists()


def mark_warm() -> None:
    """Leave word that the kernels are compiled; stamps of other sources go."""
    stamp = stamp_file()
    if stamp is not None and not stamp.exists():
        with contextlib.suppress(OSError):
            for stale in stamp.parent.glob("warm-*"):
                stale.unlink(missing_ok=True)
            stamp.touch()
