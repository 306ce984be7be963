"""Reading the ``run.json`` of a run's folder, and checking the type of every key that amorsim writes."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from amorsim.core.errors import RunError
from amorsim.core.numbers import is_number
from amorsim.core.parameters import ParameterError, check_value, describe
from amorsim.runs.folder import ABOUT, FORMAT
from amorsim.runs.tables import check_file
from amorsim.scenario.faults import shown
from amorsim.scenario.read import load
from amorsim.scenario.spec import Scenario
from amorsim.simulation.simulation import MAX_REPLICA, MOST_STEPS

__all__ = ["read_about", "scenario_of"]

_FAR = 1e300  # larger numbers are taken for mistakes

LARGEST = 1 << 28  # [bytes]: room for the digests of three million replicas

Check = Callable[[Any], bool]


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_whole(value: Any) -> bool:
    return type(value) is int and 0 <= value <= MOST_STEPS


def _is_real(value: Any) -> bool:
    return type(value) in (int, float)


def _table_of(check: Check) -> Check:
    return lambda value: isinstance(value, dict) and all(map(check, value.values()))


def _is_seed(value: Any) -> bool:
    try:
        check_value(describe(Scenario)["seed"], value)
    except ParameterError:
        return False
    return True


def _are_replicas(value: Any) -> bool:
    return (
        isinstance(value, list)
        and bool(value)
        and all(type(number) is int and 0 <= number <= MAX_REPLICA for number in value)
        and len(set(value)) == len(value)
    )


def _are_inputs(value: Any) -> bool:
    """Whether these are fingerprints of files in the folder, and of none elsewhere."""
    if not _table_of(_is_text)(value):
        return False
    paths = [PurePosixPath(name) for name in value]
    return not any(path.is_absolute() or ".." in path.parts or "\0" in str(path) for path in paths)


_NEEDED: dict[str, tuple[Check, str]] = {
    "status": (_is_text, "a text"),
    "seed": (_is_seed, "a whole number"),
    "replicas": (_are_replicas, "a list of different whole numbers >= 0"),
    "dt": (lambda value: is_number(value, below=_FAR) and value > 0, "a number [s] > 0"),
    "steps": (_is_whole, f"a whole number >= 0 and <= {MOST_STEPS}"),
}
_OTHERS: dict[str, tuple[Check, str]] = {
    "format": (lambda value: type(value) is int and value == FORMAT, f"{FORMAT}, the format that this amorsim reads,"),
    "duration": (lambda value: is_number(value, below=_FAR), "a number [s]"),
    "inputs": (_are_inputs, "a table of fingerprints, by the names of files in the folder"),
    "changes_before": (_is_whole, f"a whole number >= 0 and <= {MOST_STEPS}"),
    "amorsim": (_is_text, "a text"),
    "python": (_is_text, "a text"),
    "processor": (_is_text, "a text"),
    "system": (_is_text, "a text"),
    "packages": (_table_of(_is_text), "a table of texts"),
    "plugins": (_table_of(lambda value: value is None or _is_text(value)), "a table of texts"),
    "steps_done": (_is_whole, f"a whole number >= 0 and <= {MOST_STEPS}"),
    "worlds": (_table_of(_is_text), "a table of texts, by replica"),
    "digests": (_table_of(_is_text), "a table of texts, by replica"),
    "distance": (_table_of(_is_real), "a table of numbers [m], by robot"),
    "final_error": (_table_of(_is_real), "a table of numbers [m], by robot"),
    "collisions": (_table_of(_is_whole), "a table of whole numbers, by robot"),
    "seconds": (lambda value: is_number(value, below=_FAR), "a number [s]"),
}


RUN_FOLDER = "the folder of a run"


def read_about(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """The content of a folder's ``run.json``; keys that amorsim does not know are kept as they are.

    Raises
    ------
    RunError
        If it is not the folder of a run, or the file is damaged; the message names the key.
    """
    path = Path(folder) / ABOUT
    if not os.path.lexists(path):
        raise RunError(f"{folder}: expected the folder of a run, with a {ABOUT} in it")
    check_file(path, LARGEST)
    try:
        about = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RunError(f"{path}: cannot be read ({error})") from None
    except RecursionError:
        raise RunError(f"{path}: is damaged: its tables and lists are nested too deeply") from None
    if not isinstance(about, dict):
        raise RunError(f"{path}: is damaged: expected a table, got {shown(about)}")
    form = about.get("format", FORMAT)
    if _is_whole(form) and form != FORMAT:
        raise RunError(
            f"{path}: is in format {form}, of another version of amorsim ({about.get('amorsim', 'not known')}); this "
            f"one reads format {FORMAT}"
        )
    for key, (check, what) in (_NEEDED | _OTHERS).items():
        if (key in about or key in _NEEDED) and not check(about.get(key)):
            raise RunError(f"{path}: is damaged: expected {what} under {key!r}, got {shown(about.get(key))}")
    return about


def scenario_of(folder: str | os.PathLike[str], about: Mapping[str, Any]) -> Scenario:
    """The scenario of a run, from the files in its folder; `about` is the content of its ``run.json``.

    Raises
    ------
    RunError
        If one of its files is no regular file.
    ScenarioError
        If it cannot be read.
    """
    for name in {"scenario.toml", *about.get("inputs", ())}:
        if os.path.lexists(path := Path(folder) / name):
            check_file(path)
    return load(Path(folder) / "scenario.toml")
