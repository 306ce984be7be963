"""``amorsim convert``: write a map in another format."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amorsim.cli.console import compile_once, complain, say
from amorsim.cli.options import Changes, Resolution

if TYPE_CHECKING:
    from amorsim.core.map import Map

__all__ = ["command", "write_world"]


def command(
    source: Annotated[
        str,
        typer.Argument(metavar="IN", help="A map of any format, or a scenario (.toml, or a bundled one) for its map."),
    ],
    target: Annotated[
        Path,
        typer.Argument(
            metavar="OUT", help="The file to write; its ending tells the format. A .yaml has a .pgm next to it."
        ),
    ],
    force: Annotated[bool, typer.Option("--force", help="Replace files that are there.")] = False,
    resolution: Resolution = None,
    changes: Changes = None,
) -> None:
    """Write a map in another format, read it back, and say in numbers what is lost.

    Options of IN's loader are set as those of a world: --set world.threshold=0.5.
    """
    from amorsim.runs.asked import look_up, read_world

    compile_once(lambda: look_up(source, resolution=resolution, changes=changes or ()))
    world = read_world(source, resolution=resolution, changes=changes or [])
    for warning in world.warnings:
        complain(f"{world.name}: {warning}")
    write_world(world, target, force=force)


def write_world(world: Map, target: Path, *, force: bool) -> None:
    """Write a map into a file, and say how it is read and what was lost. Raises `MapError` as `write_map` does."""
    from amorsim.scenario.map_words import lost_in_words, needed_options
    from amorsim.scenario.maps import write_map
    from amorsim.scenario.write import table_text

    again, lost = write_map(world, target, force=force)
    for warning in again.warnings:
        complain(f"{target.name}: {warning}")
    rows, columns = again.shape
    say(f"{target}: {columns} x {rows} cells of {again.resolution:g} m; {lost_in_words(lost)}")
    options = table_text(needed_options(again)).splitlines()
    if options:
        say(f"the file does not say it: read it with {', '.join(options)}")
