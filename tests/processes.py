"""Processes that tests look for."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["command_line_of", "is_running"]


def is_running(pid: int) -> bool:
    """Whether a process is there and has not ended; on a system without /proc, whether it is there."""
    try:
        os.kill(pid, 0)
        stat = Path(f"/proc/{pid}/stat")
        return not Path("/proc").is_dir() or stat.read_text().rpartition(")")[2].split()[0] not in ("Z", "X")
    except (FileNotFoundError, ProcessLookupError):  # it ended, perhaps between opening the file and reading it
        return False


def command_line_of(pid: int) -> bytes:
    """The command line of a process, with zeros between its words; empty for one that has ended."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except (FileNotFoundError, ProcessLookupError):
        return b""
