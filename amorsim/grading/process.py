"""The process of a submission, within a fence or without: its start, its pipes, its limits, and its end."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import tempfile
from pathlib import Path

from amorsim.core.errors import StudyError
from amorsim.core.execution.processes import end_with_children, python_command
from amorsim.grading.fence import HOME, TEMPORARY, Fence
from amorsim.grading.usage import Watch

__all__ = ["SubmissionProcess"]

_CODE = "from amorsim.grading.child import main; main()"


class SubmissionProcess:
    """Runs `amorsim.grading.child` without any open file of this process; in a fence, without anything of it.

    Parameters
    ----------
    fence
        The fence to run it in; None for the rights of this process.
    memory_limit
        The most memory of all its processes [bytes].

    Raises
    ------
    StudyError
        If the fence does not come up.
    """

    def __init__(self, fence: Fence | None, memory_limit: int) -> None:
        self.problem = ""
        """Why it was ended, if it took too much."""
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._first: int | None = None  # what ends the whole namespace of processes with it
        if fence is None:
            self._folder = tempfile.TemporaryDirectory(prefix="amorsim-graded-", ignore_cleanup_errors=True)
            self._popen = _start(python_command(_CODE), {**os.environ, **_SAME}, cwd=self._folder.name)
            first = self._popen.pid
        else:
            first = self._start_fenced(fence)
        assert self._popen.stdin is not None
        assert self._popen.stdout is not None
        self.requests = self._popen.stdin.fileno()
        self.answers = self._popen.stdout.fileno()
        os.set_blocking(self.requests, False)
        self._watch = Watch(first, memory_limit, self._end_for)

    def _start_fenced(self, fence: Fence) -> int:
        """Start it; returns the first process of its namespace."""
        ours, theirs = os.pipe()
        settings = [part for pair in {**_WITHIN, **_SAME}.items() for part in ("--setenv", *pair)]
        command = fence.command(python_command(_CODE, fence.path()), *settings, "--info-fd", str(theirs))
        try:
            self._popen = _start(command, {}, pass_fds=(theirs,))
        finally:
            os.close(theirs)
        with os.fdopen(ours, "rb") as info:
            answer = info.read()
        try:
            first = int(json.loads(answer)["child-pid"])
            self._first = os.pidfd_open(first)
        except (ValueError, KeyError, OSError):
            self._popen.kill()
            self._popen.wait()
            raise StudyError("bubblewrap ended before it started a submission") from None
        return first

    def watch(self) -> None:
        """From now on, end it if it takes too much."""
        self._watch.start()

    def _end_for(self, problem: str) -> None:
        self.problem = problem
        self._kill()

    def _kill(self) -> None:
        if self._first is None:
            with contextlib.suppress(OSError):
                os.killpg(self._popen.pid, signal.SIGKILL)
            return
        # The first process of a namespace takes all others with it; bubblewrap's own death might be ignored.
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._first, signal.SIGKILL)

    def how_it_ended(self) -> str:
        """How the process ended by itself, in words; empty if it still ran or left Python."""
        try:
            status = self._popen.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            return ""
        number = status - 128 if self._first is not None else -status  # as shells and bubblewrap report it
        return f" by signal {number}" if number > 0 else ""

    def close(self) -> None:
        """End the process, and all that it has started."""
        self._watch.end()
        self._kill()
        if self._first is None:
            end_with_children(self._popen)
        else:
            self._popen.wait()  # bubblewrap waits until all are gone
            os.close(self._first)
            self._first = None
        for pipe in (self._popen.stdin, self._popen.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):  # what could not be sent
                    pipe.close()
        if self._folder is not None:
            self._folder.cleanup()


_SAME = {
    "PYTHONHASHSEED": "0",
    # Each thread of a library would take memory, and the limits must not depend on the number of cores.
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
}
"""The settings of every submission, so that a grading can be repeated on other machines."""
_WITHIN = {
    "HOME": HOME,
    "TMPDIR": TEMPORARY,
    "NUMBA_CACHE_DIR": f"{TEMPORARY}/.numba",
    "PATH": "/usr/bin:/bin",
    "LANG": "C.UTF-8",
    "USER": "submission",
}
"""All others within a fence."""


def _start(
    command: list[str], settings: dict[str, str], cwd: str | Path | None = None, pass_fds: tuple[int, ...] = ()
) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env=settings,
        cwd=cwd,
        pass_fds=pass_fds,
    )
