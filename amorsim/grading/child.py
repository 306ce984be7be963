"""The first lines of a submission's process: its files and limits, before anything of it runs."""

from __future__ import annotations

import contextlib
import json
import os
import select
import shutil
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

__all__ = ["main"]

_LARGEST_FILE = 10**8  # bytes
_MOST_OPEN = 256


def main() -> None:
    """Receive the submission, and answer until nothing more is sent."""
    requests = os.fdopen(os.dup(0), "rb")
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # What a submission prints is not an answer, and it has no keyboard.
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)
    os.close(nowhere)

    def say(kind: str, value: Any) -> None:
        answers.write(json.dumps([kind, value]) + "\n")
        answers.flush()

    say("started", None)
    _end_with_the_grader(requests.fileno())
    first = json.loads(requests.readline())
    home = Path.cwd()
    _receive(requests, first["files"], home)
    if first["kernels"] is not None:
        _link_kernels(Path(first["kernels"]), Path(os.environ["NUMBA_CACHE_DIR"]))
    from amorsim.grading.answers import answer_all

    _limit(first["memory"])
    answer_all(home / first["path"], first["name"], first["role"], requests, say)


def _receive(requests: BinaryIO, files: Mapping[str, int], folder: Path) -> None:
    """Write the files whose names and sizes came first, and whose contents follow."""
    for name, size in files.items():
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(requests.read(size))


def _link_kernels(compiled: Path, made: Path) -> None:
    """Make a folder of links to compiled kernels: numba loads only from where it can write."""
    target = made / "amorsim" / compiled.name
    shutil.copytree(compiled, target, copy_function=os.symlink)


def _end_with_the_grader(pipe: int) -> None:
    """End this process when the grader has ended, whatever the submission does then."""
    if not hasattr(select, "poll"):  # on Windows
        return

    def watch() -> None:
        closing = select.poll()
        closing.register(pipe, 0)  # for its end alone, which comes also where something is still to be read
        closing.poll()
        os._exit(1)

    threading.Thread(target=watch, name="amorsim-grader-gone", daemon=True).start()


def _limit(memory: int) -> None:
    with contextlib.suppress(ImportError, ValueError, OSError):  # not on Windows
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (_LARGEST_FILE, _LARGEST_FILE))
        resource.setrlimit(resource.RLIMIT_NOFILE, (_MOST_OPEN, _MOST_OPEN))
