"""Other processes of Python: how they are started, and ended together with those that they started."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence

__all__ = ["end_with_children", "python_command"]


def python_command(code: str, path: Sequence[str] | None = None) -> list[str]:
    """The command that runs `code` in another process, which finds modules where this one does, or in `path`.

    ``python -m`` would look into the present folder first, where a user's ``random.py`` may lie.
    """
    script = f"import json, sys; sys.path[:] = json.loads(sys.argv[1]); {code}"
    return [sys.executable, "-P", "-c", script, json.dumps(sys.path if path is None else list(path))]


def end_with_children(process: subprocess.Popen[bytes]) -> None:
    """End a process that was started with ``start_new_session=True``, and all processes that it has started."""
    if os.name == "nt":
        subprocess.run(["taskkill", "/F", "/T", "/PID", str(process.pid)], capture_output=True, check=False)
    else:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    with contextlib.suppress(OSError):
        process.kill()
    process.wait()
