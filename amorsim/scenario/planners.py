"""A planner by its name and settings."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from amorsim.contracts import Planner
from amorsim.core.errors import PluginError
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.faults import Book, Node, Source
from amorsim.scenario.fields import read_component
from amorsim.scenario.settings import parse_settings

__all__ = ["read_planner"]


def read_planner(name: str, overrides: Iterable[str] = (), *, registry: Registry | None = None) -> Planner:
    """A planner by the name that it is registered under; `overrides` name its fields, ``cell=0.05``.

    Raises
    ------
    ScenarioError
        With all faults of these words.
    """
    registry = registry or default_registry()
    said: dict[str, object] = {"use": name}
    book = Book(Source(file="", folder=Path()))
    book.document = said
    for setting in parse_settings(overrides, book):
        said[".".join(setting.path)] = setting.value
        book.set_source(setting.path, Source(file=setting.file, folder=Path.cwd(), depth=0))
    planner = None
    try:
        cls = registry.get("planner", name)
    except PluginError as error:
        book.set_source(("use",), Source(file=f"--planner {name}", folder=Path(), depth=0))
        Node(said, (), book).child("use").fault(str(error))
    else:
        planner = read_component(cls, Node(said, (), book), beside=("use",))
    book.raise_if_any()
    assert isinstance(planner, Planner)  # or there would be faults
    return planner
