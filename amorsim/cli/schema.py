"""``amorsim schema``: the JSON Schema of a kind of file, for editors."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from amorsim.core.files.atomic_files import write_text

__all__ = ["command"]


def command(
    kind: Annotated[str, typer.Argument(metavar="[scenario|study|rubric]", help="The kind of file.")] = "scenario",
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Write it to this file, in place of one that is there.")
    ] = None,
) -> None:
    """Print the JSON Schema of a kind of file, with the components of all installed plugins.

    With a first line `#:schema scenario.schema.json` in a file, editors that know TOML complete its keys and underline
    mistakes; `amorsim new` writes both. Write it again after a plugin was installed.
    """
    from amorsim.schemas import make_schema

    text = json.dumps(make_schema(kind), indent=1)
    if out is None:
        typer.echo(text)
    else:
        write_text(out, text + "\n")
