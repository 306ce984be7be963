"""A setting of the command line means what the same value means in the file, written there by hand."""

from __future__ import annotations

import copy
import random
import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.plugins.manager import default_registry
from amorsim.scenario.files.write import table_text
from amorsim.scenario.toml.literals import as_toml

Place = tuple[str | int, ...]


def places(value: Any, at: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Everything in tables but the tables themselves, and where it is."""
    if not isinstance(value, dict):
        yield at, value
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from places(item, (*at, key))


def by_hand(tables: dict[str, Any], resolved: dict[str, Any], at: Place, value: Any) -> None:
    """Write a value into tables; a list that the file does not have is written as a whole."""
    there: Any = tables
    for key in at[:-1]:
        resolved = resolved[key]
        if isinstance(there, dict) and there.get(key, True) is True:
            there[key] = copy.deepcopy(resolved) if isinstance(resolved, list) else {}
        there = there[key]
    there[at[-1]] = value


def changed(value: Any) -> Any:
    """Another value of the kind, as near as that of most fields may be."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    return value * 1.01 if isinstance(value, float) else value


def outcome(path: Path, *settings: str) -> dict[str, Any] | None:
    """The scenario with all defaults; None if it is refused."""
    try:
        return am.load(path, settings).resolved
    except am.ScenarioError:
        return None


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bundled scenarios with their maps, and room for changed ones."""
    bundled = default_registry().file("scenario", "demo").parent
    return Path(shutil.copytree(bundled, tmp_path_factory.mktemp("bundled") / "scenarios"))


def check(path: Path, count: int) -> None:
    """Compare some settings of a scenario with what a file says: values that hold anyway, and others."""
    resolved = am.load(path).resolved
    found = [
        (at, value)
        for at, value in places(resolved)
        # A file has several forms of a shape, and a scenario with all defaults has one.
        if at[0] in ("simulation", "recording", "robots", "obstacles") and not {"resolved_from", "shape"} & set(at)
    ]
    chosen = random.Random(path.stem).sample(found, count)
    for number, (at, value) in enumerate(chosen):
        wanted = changed(value) if number % 2 else value
        tables = tomllib.loads(path.read_text())
        by_hand(tables, resolved, at, wanted)
        other = path.with_name(f"{path.stem}-by-hand.toml")
        other.write_text(table_text(tables))
        setting = f"{'.'.join(map(str, at))}={as_toml(wanted)}"
        assert outcome(path, setting) == outcome(other), setting


@pytest.mark.parametrize("name", ["line", "crossing", "crowd", "yard"])
def test_a_setting_means_what_it_means_in_the_file(name: str, folder: Path) -> None:
    check(folder / f"{name}.toml", 4)


@pytest.mark.long
@pytest.mark.parametrize("name", ["line", "convoy", "crossing", "crowd", "yard", "loop"])
def test_settings_mean_what_they_mean_in_the_file(name: str, folder: Path) -> None:
    check(folder / f"{name}.toml", 40)
