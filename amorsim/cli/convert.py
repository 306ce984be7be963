"""``amorsim convert``: write a map in another format."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amorsim.cli.console import compile_once, complain, say
from amorsim.cli.options import Changes, Resolution
from amorsim.core.errors import AmorsimError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from amorsim.core.lost_cells import Lost
    from amorsim.core.map import Map
    from amorsim.scenario.maps import MapFile

__all__ = ["command", "write_world"]


def command(
    source: Annotated[
        str,
        typer.Argument(metavar="IN", help="A map of any format, or a scenario (.toml, or a bundled one) for its map."),
    ],
    target: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="The file to write; its ending tells the format. A .yaml has a .pgm beside it; a .toml is a scenario.",
        ),
    ],
    use: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="OUT's format, where its ending tells another: mobilesim for a .map."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace files that are there.")] = False,
    resolution: Resolution = None,
    changes: Changes = None,
) -> None:
    """Write a map in another format, read it back, and say in numbers what is lost.

    Options of IN's loader are set as those of a world: --set world.threshold=0.5. A .toml is a scenario on IN's map:
    with the robots that IN has, or else with a Pioneer that wanders.
    """
    from amorsim.runs.asked import look_up, read_world

    compile_once(lambda: look_up(source, resolution=resolution, changes=changes or ()))
    if target.suffix.lower() == ".toml":
        _write_scenario(source, target, resolution=resolution, changes=changes or [], force=force)
        return
    world = read_world(source, resolution=resolution, changes=changes or [])
    for warning in world.warnings:
        complain(f"{world.name}: {warning}")
    write_world(world, target, force=force, use=use)


def _write_scenario(
    source: str, target: Path, *, resolution: float | None, changes: Sequence[str], force: bool
) -> None:
    """Write a scenario on the map of a file, read it back, and say what it holds and what was lost."""
    from amorsim.core.lost_cells import lost_cells
    from amorsim.runs.asked import read_scenario, scenario_document

    before = read_scenario(source, resolution=resolution, changes=changes)
    for warning in (*before.remarks, *before.map.warnings):
        complain(f"{before.map.name}: {warning}")
    document = scenario_document(source, target, before, resolution=resolution, changes=changes)
    again = document.scenario()
    if target.exists() and not force:
        raise AmorsimError(f"{target.name} is there already; --force replaces it")
    document.save()
    rows, columns = again.map.shape
    bodies = f"{_counted(len(again.robots), 'robot')}, {_counted(len(again.obstacles), 'obstacle')}"
    lost = _in_words(lost_cells(before.map, again.map))
    say(f"{target}: {columns} x {rows} cells of {again.map.resolution:g} m, {bodies}; {lost}")


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def write_world(world: Map, target: Path, *, force: bool, use: str | None = None) -> None:
    """Write a map into a file, and say how it is read and what was lost. Raises `MapError` as `write_map` does."""
    from amorsim.scenario.maps import write_map

    again, lost = write_map(world, target, force=force, use=use)
    for warning in again.warnings:
        complain(f"{target.name}: {warning}")
    rows, columns = again.shape
    say(f"{target}: {columns} x {rows} cells of {again.resolution:g} m; {_in_words(lost)}")
    options = _options(again)
    if options:
        say(f"the file does not say it: read it with {', '.join(options)}")


def _in_words(lost: Lost) -> str:
    """What was lost, in words."""
    unchanged = "no cell differs" if lost.farthest else "the cells are the same"
    parts = [f"{lost.cells} of {lost.of} cells differ" if lost.cells else unchanged]
    if lost.farthest is None:
        parts.append("which are too many to say how far they are off")
    elif lost.farthest:
        parts.append(f"walls are off by {lost.farthest:.3g} m at the most")
    if lost.unknown:
        parts.append(f"{lost.unknown} unknown cells are no longer known as such")
    if lost.has_start:
        parts.append("the robot's start is lost")
    return "read back, " + ", ".join(parts)


def _options(world: Map) -> list[str]:
    """The options, as in a scenario's [world], without which a file is read otherwise."""
    from amorsim.core.errors import MapError
    from amorsim.core.same_cells import have_same_cells
    from amorsim.scenario.fields import write_fields
    from amorsim.scenario.maps import load_map
    from amorsim.scenario.write import table_text

    file: MapFile = world.source
    try:
        if have_same_cells(load_map(file.path), world):
            return []
    except MapError:
        pass
    given, usual = write_fields(file.loader), write_fields(type(file.loader)())
    return table_text({name: value for name, value in given.items() if usual.get(name) != value}).splitlines()
