"""``amorsim generate``: make a random world."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amorsim.cli.console import compile_once
from amorsim.cli.scenarios.convert import write_world

__all__ = ["command"]


def command(
    kind: Annotated[
        str,
        typer.Argument(metavar="KIND", help="A world generator: office, maze, cave ... `amorsim plugins` lists them."),
    ],
    target: Annotated[
        Path, typer.Option("-o", "--out", metavar="FILE", help="The file to write; its ending gives the format.")
    ],
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed; the same one gives the same cells.")] = 0,
    size: Annotated[
        tuple[float, float] | None, typer.Option(metavar="WIDTH HEIGHT", help="Size [m], in place of the generator's.")
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="A parameter of the generator, as in corridor=1.5; may be given again. `amorsim plugins show KIND` "
            "lists them.",
        ),
    ] = None,
    replica: Annotated[
        int | None,
        typer.Option(metavar="N", min=0, help='The world of a replica, where a scenario says per = "replica".'),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace files that are there.")] = False,
) -> None:
    """Make a random world and write it as a map, in any format that can be written.

    The file is read back, and what its format loses is reported, as by convert.
    """
    settings = [f"size=[{size[0]!r}, {size[1]!r}]", *(changes or ())] if size else list(changes or ())
    if replica is not None:
        settings.append('per="replica"')
    from amorsim.scenario.reading.read import read_generated_alone
    from amorsim.worlds.drawn import map_of

    def look() -> None:
        read_generated_alone(kind, seed, settings, is_made=False)

    compile_once(look)
    world = read_generated_alone(kind, seed, settings)
    assert world is not None  # or there would be faults
    write_world(map_of(world, replica or 0), target, force=force)
