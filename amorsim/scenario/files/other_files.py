"""Scenarios in TOML for files in other formats: other programs' scenarios, and maps alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from amorsim.core.errors import MapError
from amorsim.core.files.reading import is_there
from amorsim.plugins.registry import Registry
from amorsim.scenario.files.foreign import find_scenario_loader, read_foreign
from amorsim.scenario.files.maps import find_loader
from amorsim.scenario.files.models import FORMAT
from amorsim.scenario.files.write import table_text

__all__ = ["map_alone", "scenario_of_other"]


def scenario_of_other(file: Path, registry: Registry) -> tuple[str, Path] | None:
    """The text of a scenario for another program's file or for a map, and a file in the same folder that is not there.

    On a map there is a Pioneer 2DX, as for `amorsim.scenario.reading.read.scenario_for_map`. None for all other files,
    also for one that is not there.

    Raises
    ------
    ScenarioError
        With the faults of another program's file.
    """
    if file.suffix.lower() in ("", ".toml"):
        return None
    if (found := find_scenario_loader(file, registry)) is not None:
        read = read_foreign(file, *found)
        return _text(file, read.remarks, read.tables)
    try:
        find_loader(file, None, registry)
    except MapError:
        return None
    tables = map_alone(file, {})
    tables["world"]["map"] = file.name
    return _text(file, (), tables)


def map_alone(path: Path, options: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a scenario with a Pioneer 2DX on a map; `options` are the map loader's."""
    return {
        "format": FORMAT,
        "world": {**options, "map": str(path.absolute())},
        "simulation": {"duration": 60.0},
        "robots": [{"name": "rover", "model": "pioneer2dx", "controller": {"use": "wander"}}],
    }


def _text(file: Path, remarks: Sequence[str], tables: Mapping[str, Any]) -> tuple[str, Path]:
    head = "".join(f"# {line}\n" for line in (f"From {file.name}.", *remarks))
    name, number = file.with_suffix(".toml"), 1
    while is_there(name):
        number += 1
        name = file.with_name(f"{file.stem}_{number}.toml")
    return f"{head}\n{table_text(tables)}", name
