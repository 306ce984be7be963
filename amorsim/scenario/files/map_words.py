"""Messages about what a map loses in a file, and the settings by which a scenario reads that file as it was."""

from __future__ import annotations

from typing import Any

from amorsim.core.errors import MapError
from amorsim.core.maps.lost_cells import Lost
from amorsim.core.maps.map import Map
from amorsim.core.maps.same_cells import have_same_cells
from amorsim.scenario.files.maps import MapFile, load_map
from amorsim.scenario.reading.fields import write_fields

__all__ = ["lost_in_words", "needed_options"]


def lost_in_words(lost: Lost) -> str:
    """The loss, found by reading back: ``"read back, the cells are the same"``."""
    unchanged = "no cell differs" if lost.farthest else "the cells are the same"
    parts = [f"{lost.cells} of {lost.of} cells differ" if lost.cells else unchanged]
    if lost.farthest is None:
        parts.append("which are too many to say how far they are off")
    elif lost.farthest:
        parts.append(f"walls are off by {lost.farthest:.3g} m at most")
    if lost.unknown:
        parts.append(f"{lost.unknown} unknown cells are no longer known as such")
    if lost.has_start:
        parts.append("the robot's start is lost")
    return "read back, " + ", ".join(parts)


def needed_options(world: Map) -> dict[str, Any]:
    """The options of a scenario's [world] without which a map's file is read in another way."""
    file: MapFile = world.source
    try:
        if have_same_cells(load_map(file.path), world):
            return {}
    except MapError:
        pass
    given, usual = write_fields(file.loader), write_fields(type(file.loader)())
    return {name: value for name, value in given.items() if usual.get(name) != value}
