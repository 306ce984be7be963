"""What a submission can reach, on Linux with Landlock: Python, its own files, and a folder that is thrown away.

It can read neither the rubric with the held-out seeds nor other submissions, change no file, signal no process but
those that it started, and open no connection. What the system does not offer is left out: this is no sandbox.
"""

from __future__ import annotations

import ctypes
import functools
import os
import shutil
import sys
import tempfile
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

from amorsim.kernels.cache_folder import cache_folder

__all__ = ["Fence", "fence_in", "is_offered"]

# Of landlock(7): system calls, flags, and the rights of files that the first version knows.
_CREATE, _ADD, _RESTRICT = 444, 445, 446
_VERSION, _BENEATH = 1, 1
_EXECUTE, _WRITE, _READ, _LIST = 1 << 0, 1 << 1, 1 << 2, 1 << 3
_TRUNCATE, _TRUNCATE_SINCE = 1 << 14, 3
_ALL = (1 << 13) - 1
_OF_FILES = _EXECUTE | _WRITE | _READ | _TRUNCATE
_TCP, _TCP_SINCE = 0b11, 4  # to bind and to connect
_SCOPES, _SCOPES_SINCE = 0b11, 6  # abstract sockets, signals
_NO_NEW_RIGHTS = 38  # of prctl(2)
_MEMORY = Path("/dev/shm")  # where a thousand links are made in no time
_SYSTEM = ("/usr", "/bin", "/lib", "/lib64", "/etc", "/opt", "/nix/store", "/proc", "/sys")


class _Ruleset(ctypes.Structure):
    _fields_ = (("files", ctypes.c_uint64), ("net", ctypes.c_uint64), ("scoped", ctypes.c_uint64))


class _Beneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("allowed", ctypes.c_uint64), ("folder", ctypes.c_int32))


@functools.cache
def is_offered() -> int:
    """The version of Landlock that the system has; 0 without it."""
    if sys.platform != "linux":
        return 0
    return max(0, int(_call(_CREATE, None, 0, _VERSION)))


class Fence:
    """The surroundings of one submission: a folder of its own, removed by `close`, and what else it may read.

    Where Landlock is not offered, a submission starts in its file's folder and reads what its user may.

    Parameters
    ----------
    path
        The submission's file; the files beside it are readable too.
    hidden
        Files and folders that it must not read.

    Attributes
    ----------
    folder
        Where it starts.
    settings
        Environment variables for its process.
    """

    def __init__(self, path: Path, hidden: Collection[Path] = ()) -> None:
        self.folder = path.parent
        self.settings: dict[str, str] = {}
        self._own: list[Path] = []  # what it may write into
        self._hidden = [each.resolve() for each in hidden]
        if not is_offered():
            return
        self.folder, rest = _new_folder(), _new_folder()
        self._own = [self.folder, rest]
        beside = sorted(path.parent.resolve().iterdir())
        self._beside = [each for each in beside if not self._shows_hidden(each)]
        for each in self._beside:
            (self.folder / each.name).symlink_to(each)
        self.settings = {"TMPDIR": str(rest)}
        if (compiled := cache_folder()) is not None:
            # numba wants to write beside what it reads; what it writes is thrown away.
            kernels = _new_folder(_MEMORY if os.access(_MEMORY, os.W_OK) else None)
            self._own.append(kernels)
            _mirror(compiled, kernels / "amorsim" / compiled.name)
            self.settings["NUMBA_CACHE_DIR"] = str(kernels)
            self._beside.append(compiled)
        self._listed = [path.parent.resolve()]

    def said(self) -> dict[str, list[str]]:
        """What `fence_in` takes, as plain values; nothing where it can do nothing."""
        if not self._own:
            return {}
        package = Path(__file__).resolve().parents[1]
        prefixes = (sys.prefix, sys.base_prefix, sys.exec_prefix, *sys.path)
        python = {Path(each).resolve() for each in (*prefixes, *_SYSTEM) if each and Path(each).exists()}
        readable = [package, *(each for each in sorted(python) if not self._shows_hidden(each)), *self._beside]
        return {
            "readable": [str(each) for each in readable],
            "listed": [str(each) for each in self._listed],
            "writable": [str(each) for each in self._own],
        }

    def close(self) -> None:
        """Remove its folders."""
        for each in self._own:
            shutil.rmtree(each, ignore_errors=True)

    def _shows_hidden(self, path: Path) -> bool:
        """Whether what is hidden lies at or beneath a path."""
        at = path.resolve()
        return any(each == at or at in each.parents for each in self._hidden)


def _new_folder(parent: Path | None = None) -> Path:
    return Path(tempfile.mkdtemp(prefix="amorsim-graded-", dir=parent))


def _mirror(folder: Path, made: Path) -> None:
    """Make a folder with links to the files of another one, and the same for all folders in it."""
    made.mkdir(parents=True)
    for each in os.scandir(folder):
        if each.is_dir():
            _mirror(folder / each.name, made / each.name)
        else:
            os.symlink(each.path, f"{made}/{each.name}")  # noqa: PTH211 - there are a thousand


def fence_in(readable: Iterable[str] = (), listed: Iterable[str] = (), writable: Iterable[str] = ()) -> None:
    """Keep this process, and all that it starts, from everything else, for ever; nothing where that is not offered.

    Parameters
    ----------
    readable
        Files and folders that can be read, and executed.
    listed
        Folders whose names can be read.
    writable
        Folders in which anything can be done.
    """
    version, allowed = is_offered(), list(writable)
    if not version or not allowed:
        return
    handled = _ALL | (_TRUNCATE if version >= _TRUNCATE_SINCE else 0)
    rules = _Ruleset(handled, _TCP if version >= _TCP_SINCE else 0, _SCOPES if version >= _SCOPES_SINCE else 0)
    size = 8 if version < _TCP_SINCE else 16 if version < _SCOPES_SINCE else 24
    ruleset = int(_call(_CREATE, ctypes.byref(rules), size, 0))
    if ruleset < 0:
        return
    for path, rights in _rights(readable, listed, allowed):
        try:
            place = os.open(path, os.O_PATH | os.O_CLOEXEC)
        except OSError:  # it has gone
            continue
        rights &= handled if Path(path).is_dir() else handled & _OF_FILES
        _call(_ADD, ruleset, _BENEATH, ctypes.byref(_Beneath(rights, place)), 0)
        os.close(place)
    ctypes.CDLL(None).prctl(_NO_NEW_RIGHTS, 1, 0, 0, 0)
    _call(_RESTRICT, ruleset, 0)
    os.close(ruleset)


def _rights(readable: Iterable[str], listed: Iterable[str], writable: Iterable[str]) -> Iterator[tuple[str, int]]:
    for path in readable:
        yield path, _READ | _LIST | _EXECUTE
    for path in listed:
        yield path, _LIST
    for path in writable:
        yield path, _ALL | _TRUNCATE
    yield "/dev", _READ | _WRITE | _LIST


def _call(*arguments: object) -> int:
    return int(ctypes.CDLL(None, use_errno=True).syscall(*arguments))
