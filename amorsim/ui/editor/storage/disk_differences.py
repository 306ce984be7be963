"""How the files on the disk differ from what is edited, in words."""

from __future__ import annotations

import difflib
from pathlib import Path

from amorsim.core.errors import AmorsimError
from amorsim.ui.editor.storage.bitmaps import CODEC, pixels_apart
from amorsim.ui.editor.storage.edited_files import read_file
from amorsim.ui.editor.work import Work

__all__ = ["differing_lines"]


def differing_lines(work: Work) -> list[str]:
    """A patch from the files to what is edited; for a bitmap, the pixels that differ."""
    found: list[str] = []
    for name, text in work.texts.items():
        path = Path(name) if name else work.path
        names = f"{path.name}, the file", f"{path.name}, here"
        if name and work.files[path].encoding == CODEC:
            lines = _of_bitmap(path, text, work)
            found += [f"--- {names[0]}", f"+++ {names[1]}", *lines] if lines else []
            continue
        try:
            old = path.read_text(encoding="utf-8", errors="replace")
        except OSError:
            old = ""
        found += difflib.unified_diff(old.splitlines(), text.splitlines(), *names, lineterm="")
    return found


def _of_bitmap(path: Path, text: str, work: Work) -> list[str]:
    try:
        return pixels_apart(read_file(path, work.world.table or {}).text, text)
    except AmorsimError as error:
        return [f"-{error}"]
