"""A submission's use of the machine: memory and processes, as the system counts them in /proc."""

from __future__ import annotations

import contextlib
import stat
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

__all__ = ["Watch"]

_MOST_THREADS = 512
_INTERVAL = 0.05  # [s]
_COUNTED = ("RssAnon:", "RssShmem:", "VmSwap:")


class Watch:
    """Watches a process and its children, and reports once if they use too much; without /proc it sees nothing.

    The limits of a process (``setrlimit``) hold for each alone: two may take twice as much.

    Parameters
    ----------
    pid
        The first process.
    memory
        The most memory of all [bytes].
    report
        Called from a thread, with a sentence.
    """

    def __init__(self, pid: int, memory: int, report: Callable[[str], None]) -> None:
        self._pid = pid
        self._memory = memory
        self._report = report
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="amorsim-usage", daemon=True)

    def start(self) -> None:
        """Begin to look."""
        self._thread.start()

    def end(self) -> None:
        """Look no more."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def _run(self) -> None:
        while not self._ended.wait(_INTERVAL):
            if problem := self._problem():
                self._report(problem)
                return

    def _problem(self) -> str:
        threads, memory = 0, 0
        open_files: dict[tuple[int, int], int] = {}
        for process in _family(self._pid):
            here = _status(process)
            threads += here.get("Threads:", 0)
            memory += 1024 * sum(here.get(each, 0) for each in _COUNTED)
            try:
                open_files |= _unnamed_files(process)
            except PermissionError:
                if process.name != str(self._pid):  # bubblewrap, which hides its own
                    return "it hides which files it has opened"
            if threads > _MOST_THREADS:
                return f"it started more than {_MOST_THREADS} processes and threads"
            if memory + sum(open_files.values()) > self._memory:
                return f"it needed more memory than {self._memory:.3g} bytes in all"
        return ""


def _family(pid: int) -> Iterator[Path]:
    """The folders in /proc of a process and all that it started."""
    waiting = [pid]
    while waiting:
        process = Path("/proc") / str(waiting.pop())
        yield process
        try:
            for thread in (process / "task").iterdir():
                waiting += map(int, (thread / "children").read_text().split())
        except OSError:  # it has ended
            continue


def _status(process: Path) -> dict[str, int]:
    """Numbers of a process: kB of memory, threads."""
    try:
        lines = (process / "status").read_text(errors="replace").splitlines()
    except OSError:
        return {}
    words = [line.split() for line in lines]
    return {each[0]: int(each[1]) for each in words if len(each) > 1 and each[0] in (*_COUNTED, "Threads:")}


def _unnamed_files(process: Path) -> dict[tuple[int, int], int]:
    """The sizes of open files without a name, which may lie in memory (``memfd_create``), by device and number."""
    found = {}
    try:
        opened = list((process / "fd").iterdir())
    except (FileNotFoundError, ProcessLookupError):  # it has ended
        return {}
    for each in opened:
        with contextlib.suppress(OSError):  # it has been closed
            about = each.stat()
            if stat.S_ISREG(about.st_mode) and about.st_nlink == 0:
                found[about.st_dev, about.st_ino] = about.st_blocks * 512
    return found
