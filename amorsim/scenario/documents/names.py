"""The names of files in a document, and other names for the same files."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from amorsim.scenario.files.data_files import files_of_scenario
from amorsim.scenario.programs.controller_files import tables_of_programs
from amorsim.scenario.spec import Scenario

__all__ = ["name_from", "rename_maps"]

Document = dict[str, Any]


def rename_maps(document: Document, to: Callable[[str], str]) -> None:
    """Give the files of maps in a document, the world's and those that robots know, other names."""
    for table in (document["world"], *(robot.get("knowledge", {}) for robot in document["robots"])):
        if isinstance(table.get("map"), str):  # else it is generated
            table["map"] = to(table["map"])


def name_from(folder: Path, document: Document, scenario: Scenario) -> None:
    """Name the files of a scenario's document from a folder, so that they may be moved together.

    On Windows, files on another drive keep their whole paths.
    """

    def near(name: str) -> str:
        try:
            return Path(os.path.relpath(name, folder)).as_posix()
        except ValueError:
            return name

    rename_maps(document, near)
    for program in tables_of_programs(document):
        file, _, name = program["use"].rpartition(":")
        program["use"] = f"{near(file)}:{name}"
    for table, key in files_of_scenario(scenario, document):
        table[key] = near(table[key])
