"""The decorators that compile kernels and their parts, and the cache they keep.

Options are set here and nowhere else: no fast mathematics (bits must not depend on how a loop is cut), no
global interpreter lock while a kernel runs (threads of Python run kernels side by side), and a cache that goes
stale with the source of a kernel and of every kernel file it imports. numba's own cache looks only at the file of
the function it compiles, so a change in a callee of another file would leave old machine code in use.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import re
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import caching, config

__all__ = ["compile_seconds", "is_cold", "kernel", "mark_warm", "part", "sources_of"]

F = TypeVar("F", bound=Callable[..., Any])

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


def _digest_of(paths: Iterable[Path]) -> str:
    digest = hashlib.blake2b(digest_size=16)
    for path in paths:
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    digest.update(numba.__version__.encode())
    return digest.hexdigest()


@functools.cache
def _source_stamp(path: Path) -> str:
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
def _cache_folder() -> Path | None:
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


class _KernelLocator(caching._CacheLocator):  # type: ignore[misc, unused-ignore]
    """Tells numba where compiled kernels lie and what they depend on."""

    def __init__(self, py_func: Callable[..., Any], py_file: str) -> None:
        self._line = py_func.__code__.co_firstlineno
        self._file = Path(py_file)

    def get_cache_path(self) -> str:
        return str(_cache_folder())

    def get_source_stamp(self) -> str:
        return _source_stamp(self._file)

    def get_disambiguator(self) -> str:
        return str(self._line)

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> _KernelLocator | None:
        return None if _cache_folder() is None else cls(py_func, py_file)


class _KernelCacheImpl(caching.CompileResultCacheImpl):  # type: ignore[misc, unused-ignore]
    _locator_classes = [_KernelLocator]  # noqa: RUF012 - as numba declares it


class _KernelCache(caching.FunctionCache):  # type: ignore[misc, unused-ignore]
    _impl_class = _KernelCacheImpl


_compiled_seconds = 0.0


def compile_seconds() -> float:
    """Time [s] this process has spent compiling kernels that no cache held."""
    return _compiled_seconds


def _stamp() -> Path | None:
    folder = _cache_folder()
    return (
        None if folder is None else folder / f"warm-{_all_sources_stamp()}-{sys.version_info[0]}{sys.version_info[1]}"
    )


def is_cold() -> bool:
    """Whether no process has yet compiled the present sources and said so, so that a first step will take a while."""
    stamp = _stamp()
    return stamp is None or not stamp.exists()


def mark_warm() -> None:
    """Leave word that the kernels are compiled; stamps of other sources go."""
    stamp = _stamp()
    if stamp is not None and not stamp.exists():
        with contextlib.suppress(OSError):
            for stale in stamp.parent.glob("warm-*"):
                stale.unlink(missing_ok=True)
            stamp.touch()


def kernel(function: F) -> F:
    """Compile `function` when first called, as all kernels are: ``nogil``, cached, IEEE arithmetic as written.

    Division by zero gives `inf` or `nan` as NumPy does. Arguments are numbers and C-contiguous arrays; callers keep
    to one dtype and dimension per argument, so that each kernel compiles once.
    """
    return _compiled(function)


def part(function: F) -> F:
    """Compile `function` as a part of kernels, that makes no array of its own.

    Whoever calls it holds the arrays, so references to them are not counted. Counting them takes longer than the work
    of a small function: cones were told in half the time without.
    """
    return _compiled(function, _nrt=False)


def _compiled(function: F, **options: Any) -> F:
    dispatcher: Any = numba.njit(nogil=True, error_model="numpy", fastmath=False, **options)(function)
    if not getattr(config, "DISABLE_JIT", False) and _cache_folder() is not None:
        cache: Any = _KernelCache
        dispatcher._cache = cache(function)
        compile_ = dispatcher._compile_for_args

        @functools.wraps(compile_)
        def timed(*args: Any, **kwargs: Any) -> Any:
            global _compiled_seconds
            started = time.perf_counter()
            try:
                return compile_(*args, **kwargs)
            finally:
                _compiled_seconds += time.perf_counter() - started

        with contextlib.suppress(AttributeError):
            dispatcher._compile_for_args = timed
    return cast(F, dispatcher)
