"""The page of map formats: its rows are those of the registry."""

from __future__ import annotations

import re
from pathlib import Path

from amorsim.contracts import MapLoader
from amorsim.plugins.manager import make_registry

PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "map-formats.md").read_text(encoding="utf-8")


def rows(heading: str) -> dict[str, str]:
    """The second column of each row below a heading, by the name in the first."""
    part = PAGE.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    return dict(re.findall(r"^\| `(\w+)` \| ([^|]*) \|", part, re.MULTILINE))


def loaders() -> dict[str, type[MapLoader]]:
    registry = make_registry(entry_points=())
    return {name: registry.get("map_loader", name) for name in registry.names("map_loader")}


def test_every_format_is_there_with_its_endings() -> None:
    expected = {name: list(loader.extensions) for name, loader in loaders().items()}
    assert {name: re.findall(r"`([^`]+)`", endings) for name, endings in rows("Read").items()} == expected


def test_every_format_that_can_be_written_is_there() -> None:
    writers = {name for name, loader in loaders().items() if "save" in vars(loader)}
    assert set(rows("Written")) == writers


def test_every_scenario_loader_is_said() -> None:
    registry = make_registry(entry_points=())
    part = PAGE.partition("\n## Read\n")[2].partition("\n## ")[0]
    said = {line.split("`")[1] for line in part.splitlines() if "as a scenario" in line}
    assert said == set(registry.names("scenario_loader"))
