"""``amorsim new``: a scenario, a controller and a map to start from."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import say
from amorsim.core.errors import RunError
from amorsim.core.whole_files import write_text

__all__ = ["command"]

_FILES = ("scenario.toml", "controller.py", "rooms.wld")


def command(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="The folder to make; it may exist, but nothing in it is replaced.")
    ],
) -> None:
    """Make a folder with a scenario, a controller of ten lines and a map, which run as they are."""
    template = resources.files("amorsim.cli") / "template"
    there = [name for name in _FILES if (folder / name).exists()]
    if there:
        raise RunError(f"{folder}: {', '.join(there)} would be replaced; name another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{folder}: cannot make this folder ({error.strerror or error})") from None
    for name in _FILES:
        write_text(folder / name, (template / name).read_text(encoding="utf-8"))
    say(f"made {', '.join(_FILES)} in {folder}; now: amorsim run {folder / 'scenario.toml'}")
