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

    from amorsim.core.maps.map import Map

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
            help="The file to write; its ending gives the format. A .yaml has a .pgm with it, a .toml is a scenario.",
        ),
    ],
    use: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="OUT's format if its ending means another one: mobilesim for a .map."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace files that are there.")] = False,
    resolution: Resolution = None,
    changes: Changes = None,
) -> None:
    """Write a map in another format, read it back, and print in numbers what was lost.

    Options of IN's loader are set as those of a world: --set world.threshold=0.5. A .toml is a scenario on IN's map:
    with the robots that IN has, or else with a Pioneer that wanders. A .world of a scenario has its robots, obstacles
    and landmarks too, as far as Stage can hold them.
    """
    from amorsim.runs.scenario_argument import is_map_alone, look_up, read_world

    compile_once(lambda: look_up(source, resolution=resolution, changes=changes or ()))
    if target.suffix.lower() == ".toml":
        _write_scenario(source, target, resolution=resolution, changes=changes or [], force=force)
        return
    if target.suffix.lower() == ".world" and use in (None, "stage") and not is_map_alone(source):
        _write_stage(source, target, resolution=resolution, changes=changes or [], force=force)
        return
    world = read_world(source, resolution=resolution, changes=changes or [])
    for warning in world.warnings:
        complain(f"{world.name}: {warning}")
    write_world(world, target, force=force, use=use)


def _write_scenario(
    source: str, target: Path, *, resolution: float | None, changes: Sequence[str], force: bool
) -> None:
    """Write a scenario on the map of a file, read it back, and print its content and what was lost."""
    from amorsim.core.files.reading import is_file
    from amorsim.core.maps.lost_cells import lost_cells
    from amorsim.runs.scenario_argument import read_scenario, scenario_document
    from amorsim.scenario.files.map_words import lost_in_words

    before = read_scenario(source, resolution=resolution, changes=changes)
    for warning in (*before.remarks, *before.map.warnings):
        complain(f"{before.map.name}: {warning}")
    document = scenario_document(source, target, before, resolution=resolution, changes=changes)
    again = document.scenario()
    if is_file(target) and not force:
        raise AmorsimError(f"{target.name} is there already; --force replaces it")
    document.save()
    rows, columns = again.map.shape
    bodies = f"{_counted(len(again.robots), 'robot')}, {_counted(len(again.obstacles), 'obstacle')}"
    lost = lost_in_words(lost_cells(before.map, again.map))
    say(f"{target}: {columns} x {rows} cells of {again.map.resolution:g} m, {bodies}; {lost}")


def _write_stage(source: str, target: Path, *, resolution: float | None, changes: Sequence[str], force: bool) -> None:
    """Write a scenario as a Stage world, after printing what will be lost, and read it back."""
    import attrs

    from amorsim.core.files.reading import is_file
    from amorsim.core.maps.lost_cells import lost_cells
    from amorsim.foreign.stage.write import stage_models
    from amorsim.runs.scenario_argument import placed, read_scenario
    from amorsim.scenario.files.map_words import lost_in_words
    from amorsim.scenario.files.resolved import resolved_table
    from amorsim.scenario.reading.read import load

    before = read_scenario(source, resolution=resolution, changes=changes)
    for warning in (*before.remarks, *before.map.warnings):
        complain(f"{before.map.name}: {warning}")
    if is_file(target) and not force:
        raise AmorsimError(f"{target.name} is there already; --force replaces it")
    models, lost = stage_models(resolved_table(placed(before)))
    for line in lost:
        complain(f"{target.name}: {line}")
    write_world(before.map, target, force=force, use="stage", more=f"\n{models}")
    again = load(target)
    bodies = f"{_counted(len(again.robots), 'robot')}, {_counted(len(again.obstacles), 'obstacle')}"
    # Robots have places of their own: the map's start is not lost.
    cells = lost_in_words(attrs.evolve(lost_cells(before.map, again.map), has_start=False))
    say(f"{target}: {bodies}, {_counted(len(again.landmarks), 'landmark')}; with these {cells}")


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def write_world(world: Map, target: Path, *, force: bool, use: str | None = None, more: str = "") -> None:
    """Write a map into a file, and print how to read it and what was lost. Raises `MapError` as `write_map` does."""
    from amorsim.scenario.files.map_words import lost_in_words, needed_options
    from amorsim.scenario.files.maps import write_map
    from amorsim.scenario.files.write import table_text

    again, lost = write_map(world, target, force=force, use=use, more=more)
    for warning in again.warnings:
        complain(f"{target.name}: {warning}")
    rows, columns = again.shape
    say(f"{target}: {columns} x {rows} cells of {again.resolution:g} m; {lost_in_words(lost)}")
    options = table_text(needed_options(again)).splitlines()
    if options:
        say(f"the file does not say it: read it with {', '.join(options)}")
