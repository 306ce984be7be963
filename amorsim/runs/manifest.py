"""Reading the ``run.json`` of a run's folder, and checking the type of every key that amorsim writes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from amorsim.core.errors import RunError
from amorsim.core.files.json_files import Check, check_keys, is_figure, is_real, is_text, is_whole, read_table, table_of
from amorsim.core.parameters import ParameterError, check_value, describe
from amorsim.runs.folder import ABOUT, FORMAT
from amorsim.runs.tables import check_file
from amorsim.scenario.reading.read import load
from amorsim.scenario.spec import Scenario
from amorsim.simulation.simulation import MAX_REPLICA, MOST_STEPS

__all__ = ["read_about", "scenario_of"]

_LONGEST = 10.0 * MOST_STEPS  # [s]: of the longest step
LARGEST = 1 << 28  # [bytes]: room for the digests of three million replicas


def _is_count(value: Any) -> bool:
    return is_whole(value, MOST_STEPS)


def _is_of(field: str) -> Check:
    """A check for values that a field of scenarios takes."""

    def check(value: Any) -> bool:
        try:
            check_value(describe(Scenario)[field], value)
        except ParameterError:
            return False
        return True

    return check


def _are_replicas(value: Any) -> bool:
    return (
        isinstance(value, list)
        and bool(value)
        and all(type(number) is int and 0 <= number <= MAX_REPLICA for number in value)
        and len(set(value)) == len(value)
    )


def _are_inputs(value: Any) -> bool:
    """Whether these are fingerprints of files in the folder, none of them elsewhere."""
    if not table_of(is_text)(value):
        return False
    paths = [PurePosixPath(name) for name in value]
    return not any(path.is_absolute() or ".." in path.parts or "\0" in str(path) for path in paths)


_NEEDED: dict[str, tuple[Check, str]] = {
    "status": (is_text, "a text"),
    "seed": (_is_of("seed"), "a whole number"),
    "replicas": (_are_replicas, "a list of different whole numbers >= 0"),
    "dt": (_is_of("dt"), "a number [s] >= 1e-06 and <= 10"),
    "steps": (_is_count, f"a whole number >= 0 and <= {MOST_STEPS}"),
}
_OTHERS: dict[str, tuple[Check, str]] = {
    "format": (lambda value: type(value) is int and value == FORMAT, f"{FORMAT}, the format that this amorsim reads,"),
    "duration": (lambda value: is_real(value) and abs(value) <= _LONGEST, f"a number [s], at most {_LONGEST:g}"),
    "log": (is_text, "a text"),
    "inputs": (_are_inputs, "a table of fingerprints, by the names of files in the folder"),
    "changes_before": (_is_count, f"a whole number >= 0 and <= {MOST_STEPS}"),
    "amorsim": (is_text, "a text"),
    "python": (is_text, "a text"),
    "processor": (is_text, "a text"),
    "system": (is_text, "a text"),
    "packages": (table_of(is_text), "a table of texts"),
    "plugins": (table_of(lambda value: value is None or is_text(value)), "a table of texts"),
    "steps_done": (_is_count, f"a whole number >= 0 and <= {MOST_STEPS}"),
    "worlds": (table_of(is_text), "a table of texts, by replica"),
    "digests": (table_of(is_text), "a table of texts, by replica"),
    "distance": (table_of(is_figure), "a table of numbers [m], by robot"),
    "final_error": (table_of(is_figure), "a table of numbers [m], by robot"),
    "collisions": (table_of(_is_count), "a table of whole numbers, by robot"),
    "seconds": (is_real, "a number [s]"),
}


RUN_FOLDER = "the folder of a run"


def read_about(folder: str | os.PathLike[str], *, needs_truth: bool = True) -> dict[str, Any]:
    """The content of a folder's ``run.json``, with keys that amorsim does not know kept as they are.

    Parameters
    ----------
    needs_truth
        Whether the folder that `amorsim slam` made of a log is refused: its files have nan where truth would be.

    Raises
    ------
    RunError
        If it is not the folder of a run, or the file is damaged; the message names the key.
    """
    path = Path(folder) / ABOUT
    if not os.path.lexists(path):
        raise RunError(f"{folder}: expected the folder of a run, with a {ABOUT} in it")
    try:
        about = read_table(path, RunError, LARGEST)
    except FileNotFoundError:
        raise RunError(f"{path}: cannot be read (it is a link that leads nowhere)") from None
    form = about.get("format", FORMAT)
    if is_whole(form) and form != FORMAT:
        version = about["amorsim"] if is_text(about.get("amorsim")) else "not known"
        raise RunError(
            f"{path}: is in format {form}, of another version of amorsim ({version}); this one reads format {FORMAT}"
        )
    check_keys(path, about, _NEEDED, _OTHERS, RunError)
    if needs_truth and "log" in about:
        raise RunError(
            f"{folder}: was made of the log {about['log']} by amorsim slam, so it has no true poses and cannot be "
            f"simulated again; amorsim replay {folder} shows it, and path.tum in it is the path"
        )
    return about


def scenario_of(folder: str | os.PathLike[str], about: Mapping[str, Any]) -> Scenario:
    """The scenario of a run, from the files in its folder; `about` is the content of its ``run.json``.

    Raises
    ------
    RunError
        If one of its files is not a regular file.
    ScenarioError
        If it cannot be read.
    """
    for name in {"scenario.toml", *about.get("inputs", ())}:
        if os.path.lexists(path := Path(folder) / name):
            check_file(path)
    return load(Path(folder) / "scenario.toml")
