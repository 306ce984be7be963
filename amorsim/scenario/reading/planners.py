"""A planner by its name and settings."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from amorsim.contracts import Planner
from amorsim.core.errors import PluginError
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.settings import parse_settings
from amorsim.scenario.programs.programs import loaded_component
from amorsim.scenario.programs.user_components import program_in, read_program_in
from amorsim.scenario.reading.faults import FaultCollector, Node, Source
from amorsim.scenario.reading.fields import read_component

__all__ = ["read_planner"]


def read_planner(name: str, overrides: Iterable[str] = (), *, registry: Registry | None = None) -> Planner:
    """A planner by the name that it is registered under, or ``FILE.py:NAME``, which runs that file.

    `overrides` name its fields, ``cell=0.05``.

    Raises
    ------
    ScenarioError
        With all faults of these words.
    """
    registry = registry or default_registry()
    table: dict[str, object] = {"use": name}
    book = FaultCollector(Source(file="", folder=Path()))
    book.document = table
    for setting in parse_settings(overrides, book):
        table[".".join(setting.path)] = setting.value
        book.set_source(setting.path, Source(file=setting.file, folder=Path.cwd(), depth=0))
    planner = None
    book.set_source(("use",), Source(file=f"--planner {name}", folder=Path(), depth=0))
    node = Node(table, (), book)
    if program_in(node):
        planner = read_program_in(node, "planner")
        book.raise_if_any()
        planner = loaded_component(planner)
    else:
        try:
            planner = read_component(registry.get("planner", name), node, beside=("use",))
        except PluginError as error:
            node.child("use").fault(str(error))
    book.raise_if_any()
    assert isinstance(planner, Planner)  # or there would be faults
    return planner
