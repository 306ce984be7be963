"""Other Python processes: starting them, and ending them together with the one that started them."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

__all__ = ["end_with_children", "end_with_parent", "python_command"]

_LOOK = 0.5  # [s] between two looks at whether the parent lives
_watched: set[int] = set()


def python_command(code: str, path: Sequence[str] | None = None) -> list[str]:
    """The command that runs `code` in another process with the same import paths, or with `path`.

    ``python -m`` would look into the present folder first, where a user's ``random.py`` may lie.
    """
    script = f"import json, sys; sys.path[:] = json.loads(sys.argv[1]); {code}"
    return [sys.executable, "-P", "-c", script, json.dumps(sys.path if path is None else list(path))]


def end_with_children(process: subprocess.Popen[bytes]) -> None:
    """End a process that was started with ``start_new_session=True``, and all processes that it has started."""
    if hasattr(os, "killpg"):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    elif os.name == "nt":
        subprocess.run(["taskkill", "/F", "/T", "/PID", str(process.pid)], capture_output=True, check=False)
    with contextlib.suppress(OSError):
        process.kill()
    process.wait()


def end_with_parent(parent: int) -> None:
    """End this process once its parent has ended, however that happened; `parent` is the parent's number.

    Only for processes that read nothing from their parent: the others see that it has ended. Calling it again does
    nothing.
    """
    if parent in _watched or os.name == "nt":  # where the number of an ended parent stays
        return
    _watched.add(parent)
    threading.Thread(target=_watch, args=(parent,), name="amorsim-parent", daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_LOOK)
    os._exit(1)
