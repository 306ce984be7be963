"""Interprets a document: its tables are read and checked, and their faults listed."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import attrs

from amorsim.core.errors import Fault
from amorsim.core.parameters import ParameterError
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.origins import KINDS, kind_of, lifted
from amorsim.scenario.files.model_files import check_model, read_model
from amorsim.scenario.files.models import merge_models
from amorsim.scenario.reading.contents import book_of, read_values
from amorsim.scenario.reading.faults import FaultCollector
from amorsim.scenario.reading.lines import with_lines
from amorsim.scenario.reading.worlds import Maps
from amorsim.scenario.spec import Scenario
from amorsim.scenario.toml.layout import copied_tables
from amorsim.scenario.toml.parse import Written

__all__ = ["Meaning", "read_meaning"]


class Meaning(NamedTuple):
    """The result of reading a document."""

    book: FaultCollector
    maps: Maps
    merged: dict[str, Any]  # its tables, with those of the models
    values: dict[str, Any]  # what a scenario is made with; nothing of a model or a device
    scenario: Scenario | None  # none if there are faults
    faults: tuple[Fault, ...]


def read_meaning(written: Written, path: Path, registry: Registry, *, shares_alike: bool) -> Meaning:
    """All values that a file has at a path, read and checked.

    With `shares_alike`, of robots that differ in name and pose alone one is read; they share their components then.
    """
    book = book_of(written, path)
    book.shares_alike = shares_alike
    maps = Maps(registry)
    tables = copied_tables(lifted(written.values))
    kind = kind_of(written.values)
    values: dict[str, Any] = {}
    if kind == "scenario":
        values = read_values(tables, book, registry, maps, True, False)
    else:
        check_model(written.values, kind, book)
        source = book.source(())
        at = tuple(map(str, KINDS[kind]))
        book.set_source(at, attrs.evolve(source, depth=len(at)))
        merge_models(tables, book, registry)
        read_model(tables["robots"][0], kind, book, registry)
    scenario = None
    if not book.count and kind == "scenario":
        try:
            scenario = Scenario(**values, source=path)
        except ParameterError as error:
            book.fault((error.name,), error.problem)
    faults = with_lines(book.faults, {str(path): written})
    return Meaning(book, maps, tables, values, scenario, tuple(faults))
