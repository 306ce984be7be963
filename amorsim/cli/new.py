"""``amorsim new``: a scenario, a controller and a map to start from."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import say
from amorsim.core.atomic_files import write_text
from amorsim.core.errors import RunError
from amorsim.core.reading import is_file

__all__ = ["command"]

SCENARIO = "scenario.toml"
_FILES = (SCENARIO, "controller.py", "rooms.wld")


def command(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="The folder to make; it may exist, but nothing in it is replaced.")
    ],
    source: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="SCENARIO",
            help="Begin with this scenario: a file (.toml, another program's, or a map), or the name of a bundled one. "
            "It names its files by relative paths.",
        ),
    ] = None,
    copy: Annotated[
        bool, typer.Option("--copy", help="With --from: copy the files that the scenario names into the folder too.")
    ] = False,
) -> None:
    """Make a folder with a scenario, a controller of ten lines and a map, which run as they are."""
    if copy and source is None:
        raise RunError("--copy is for a scenario that is given with --from")
    wanted = _FILES if source is None else (SCENARIO,)
    there = [name for name in wanted if is_file(folder / name)]
    if there:
        raise RunError(f"{folder}: {', '.join(there)} would be replaced; name another folder")
    document = None
    if source is not None:
        from amorsim.scenario.documents.document import open_document

        document = open_document(source)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{folder}: cannot make this folder ({error.strerror or error})") from None
    if document is not None:
        before = set(folder.iterdir())
        document.save(folder / SCENARIO, copy=copy)
        made = ", ".join(sorted(path.name for path in folder.iterdir() if path not in before))
    else:
        template = resources.files("amorsim.cli") / "template"
        for name in _FILES:
            write_text(folder / name, (template / name).read_text(encoding="utf-8"))
        made = ", ".join(_FILES)
    say(f"made {made} in {folder}; now: amorsim run {folder / SCENARIO}")
