"""Scenarios as TOML, made of something else: a map alone, another program's file, or a scenario with settings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.document import Document, open_document
from amorsim.scenario.documents.elsewhere import near
from amorsim.scenario.documents.settings import parse_settings
from amorsim.scenario.files.other_files import map_alone
from amorsim.scenario.files.write import table_text
from amorsim.scenario.reading.faults import FaultCollector
from amorsim.scenario.reading.fields import write_fields
from amorsim.scenario.spec import Scenario

__all__ = ["converted"]


def converted(
    source: str,
    target: Path,
    scenario: Scenario,
    *,
    of_map: Mapping[str, Any] | None,
    changes: Sequence[str],
    registry: Registry,
) -> Document:
    """The document of a scenario, to be saved at `target`; the files that it names stay where they are.

    Parameters
    ----------
    source
        A map alone, another program's file, a scenario's file, or the name of a bundled one.
    scenario
        What was read from it, with the changes: robots whose place the file does not give start where they do in it.
    of_map
        The options of a map alone, None for all others.
    changes
        Settings as of the command line.

    Raises
    ------
    AmorsimError
        If one of the changes is of a scenario loader, whose options a scenario in TOML does not have.
    """
    if any(change.startswith("loader.") for change in changes):
        raise AmorsimError("a scenario in TOML has no loader's options; change the scenario that was written instead")
    if of_map is None:
        document = open_document(source, registry=registry).moved(target)
    else:
        tables = map_alone(Path(source), of_map)
        tables["world"]["map"] = near(Path(tables["world"]["map"]), target.absolute().parent)
        document = Document(table_text(tables), target, registry=registry)
    book = FaultCollector.silent()
    for setting in parse_settings(changes, book):
        document.set(".".join(setting.path), setting.value)
    book.raise_if_any()
    poses = {robot.name: robot.pose for robot in scenario.robots}
    for number, table in enumerate(document.values["robots"]):
        pose = poses.get(table.get("name", "robot"))
        if not {"pose", "start", "count"} & set(table) and pose is not None:
            document.set(f"robots.{number}.pose", write_fields(pose))
    return document
