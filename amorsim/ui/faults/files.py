"""Whether files have changed, by looking at them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from amorsim.core.reading import read_bytes

__all__ = ["Stamp", "stamps_of"]

Stamp = tuple[int, int, int, bytes] | None

_SMALL = 256 * 1024  # [bytes] up to which the content is compared too: a clock may be too coarse for two quick changes


def stamps_of(files: Iterable[Path]) -> dict[Path, Stamp]:
    """What each file looks like at present, other than before if it has changed; None where there is none."""
    return {file: _stamp(file) for file in files}


def _stamp(file: Path) -> Stamp:
    try:
        about = file.stat()
        content = read_bytes(file) if about.st_size <= _SMALL else b""
    except (OSError, ValueError):
        return None
    return about.st_mtime_ns, about.st_size, about.st_ino, content
