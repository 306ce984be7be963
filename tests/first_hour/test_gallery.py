"""The gallery: every file in it can be read, is shown with its picture, and is one of each format."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

import amorsim as am
from amorsim.plugins.manager import make_registry

ROOT = Path(__file__).resolve().parents[2]
WORLDS = sorted(path for path in (ROOT / "docs" / "worlds").iterdir() if path.suffix != ".pgm")
PAGE = ROOT / "docs" / "reference" / "gallery.md"


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_gallery", ROOT / "tools" / "make_gallery.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("path", WORLDS, ids=lambda path: path.name)
def test_a_world_of_the_gallery_is_read_and_shown(path: Path, tool: ModuleType) -> None:
    scenario: am.Scenario = tool.scenario_of(path)
    assert am.Simulation(scenario).names
    page = PAGE.read_text(encoding="utf-8")
    assert f"(../worlds/{path.name})" in page
    assert f"(../pictures/format-{path.stem}.png)" in page
    assert (ROOT / "docs" / "pictures" / f"format-{path.stem}.png").is_file()


def test_each_bundled_scenario_is_on_its_page_with_a_picture_and_its_command() -> None:
    page = (ROOT / "docs" / "reference" / "scenarios.md").read_text(encoding="utf-8")
    sections = {part.split("\n")[0]: part for part in page.split("\n## ")[1:]}
    assert set(sections) == {entry.name for entry in make_registry(entry_points=[]).entries("scenario")}
    for name, section in sections.items():
        assert f"amorsim run {name}" in section
        (picture,) = re.findall(r"\(\.\./(pictures/[^)]+)\)", section)
        assert (ROOT / "docs" / picture).is_file()


def test_there_is_one_of_each_kind(tool: ModuleType) -> None:
    loaders = {type(tool.scenario_of(path).map.source.loader).__name__ for path in WORLDS}
    registry = make_registry(entry_points=())
    assert loaders == {registry.get("map_loader", name).__name__ for name in registry.names("map_loader")}
    page = PAGE.read_text(encoding="utf-8")
    for name in registry.names("world_generator"):
        assert f"(../pictures/world-{name}.png)" in page
