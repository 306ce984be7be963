"""The scenarios that were edited last, in the user's state folder."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

from amorsim.core.files.atomic_files import write_text
from amorsim.core.files.json_files import parse_json
from amorsim.core.files.reading import read_bytes

__all__ = ["recent_files", "remember"]

MOST = 20
_FILE = "recent.json"


def recent_files(state: Path) -> list[str]:
    """Paths of the files, the newest first, without those that no longer exist."""
    try:
        found = parse_json(read_bytes(state / _FILE))
    except (OSError, ValueError):
        return []
    names = [name for name in found if isinstance(name, str)] if isinstance(found, list) else []
    with contextlib.suppress(OSError):
        names = [name for name in names if Path(name).is_file()]
    return names[:MOST]


def remember(state: Path, path: Path) -> None:
    """Put a file first in the list; does nothing if the list cannot be written."""
    name = str(path.absolute())
    names = [name, *(other for other in recent_files(state) if other != name)][:MOST]
    with contextlib.suppress(OSError):
        state.mkdir(parents=True, exist_ok=True)
        write_text(state / _FILE, json.dumps(names, indent=1) + "\n")
