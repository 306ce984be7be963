"""A study's file, read and checked; every fault has its place."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.contracts import Metric
from amorsim.core.arguments import path_of
from amorsim.core.errors import DocumentError, ScenarioError, StudyError
from amorsim.core.files.reading import is_file
from amorsim.core.parameters import ParameterError, check_value, describe
from amorsim.core.unknown_names import no_such
from amorsim.plugins.manager import default_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.files.models import check_format, read_file
from amorsim.scenario.programs.user_components import program_in, read_program_in
from amorsim.scenario.reading.contents import book_of
from amorsim.scenario.reading.faults import FaultCollector, Node, Source, shown
from amorsim.scenario.reading.fields import read_component
from amorsim.scenario.spec import Scenario
from amorsim.scenario.toml.literals import as_toml, plain
from amorsim.simulation.simulation import MAX_REPLICA
from amorsim.sweeps.plan import COLUMNS, Axis, Measured, Plan

__all__ = ["STOPS", "read_metric", "read_plan"]

STOPS = ("never", "still", "collision")
_KEYS = ("format", "description", "scenario", "replicas", "seeds", "duration", "stop", "axes", "metrics")
_RANGE = ("from", "to", "count", "step")
_DRAWN = ("normal", "uniform")
_MOST_VALUES = 1_000_000
_MOST_CHUNKS = 100_000_000


def read_plan(study: str | os.PathLike[str] | Mapping[str, Any], *, registry: Registry | None = None) -> Plan:
    """The study in a file, or in tables as of a file; their relative paths start at the present folder.

    Raises
    ------
    StudyError
        With all that is wrong with it, each with its key and line.
    """
    registry = registry or default_registry()
    if isinstance(study, Mapping):
        book, name = FaultCollector(Source(file="", folder=Path.cwd())), "study"
        try:
            tables = plain(study)
        except DocumentError as error:
            raise StudyError(f"study: {error}") from None
    else:
        path = path_of(study, "study", "the path of a study's file, or its tables")
        written = read_file(path)
        if isinstance(written, str):
            raise StudyError(f"{path}: {written}")
        book, name, tables = book_of(written, path), path.stem, written.values
        book = _with_folder(book, path)
    top = Node(tables, (), book)
    try:
        plan = _read(top, name, registry)
        book.raise_if_any()
    except ScenarioError as error:
        raise StudyError(str(error)) from None
    assert plan is not None  # or there would be a fault
    return plan


def _with_folder(book: FaultCollector, path: Path) -> FaultCollector:
    book.set_source((), Source(file=str(path), folder=path.absolute().parent))
    return book


def _read(top: Node, name: str, registry: Registry) -> Plan | None:
    check_format(top.child("format"))
    top.refuse_unknown(_KEYS)
    scenario = top.child("scenario").text("the name of a scenario, or the path of its file") or ""
    if scenario not in registry.names("scenario") or is_file(top.folder / scenario):
        scenario = str(top.folder / scenario)
    replicas = _whole(top.child("replicas"), 1, MAX_REPLICA + 1, "a number of replicas > 0", 1)
    seeds = _seeds(top.child("seeds"))
    duration = None
    if "duration" in top:
        duration = _number(top.child("duration"))
        if duration is not None and not 0.0 < duration < math.inf:
            top.child("duration").fault(f"expected a number of seconds > 0, got {shown(duration)}")
    stop = top.child("stop").text(f"one of {', '.join(STOPS)}", "never") or ""
    if stop and stop not in STOPS:
        top.child("stop").fault(f"expected one of {', '.join(STOPS)}, got {stop!r}")
    axes = _axes(top.child("axes"))
    metrics = _metrics(top.child("metrics"), registry)
    _check_columns(top, axes, metrics)
    _check_paths(top, axes)
    if top.book.count:
        return None
    plan = Plan(
        name=name,
        scenario=scenario,
        replicas=replicas,
        seeds=seeds,
        axes=tuple(axes),
        metrics=tuple(metrics),
        duration=duration,
        stop=stop,
        tables=top.value,
    )
    if plan.chunks > _MOST_CHUNKS:
        top.child("axes").fault(f"expected {_MOST_CHUNKS} points and seeds at most, got {plan.chunks}")
    return plan


def _whole(node: Node, least: int, most: int, what: str, default: int) -> int:
    if node.value is None:
        return default
    if type(node.value) is not int or not least <= node.value <= most:
        node.fault(f"expected {what}, got {shown(node.value)}")
        return default
    return node.value


def _number(node: Node) -> float | None:
    if type(node.value) not in (int, float):
        node.fault(f"expected a number, got {shown(node.value)}")
        return None
    return float(node.value)


def _seeds(node: Node) -> tuple[int, ...]:
    """The seeds; None, the scenario's own, is written as -1."""
    if node.value is None:
        return (-1,)
    if not node.expect_list("a list of seeds, as in [1, 2]"):
        return (-1,)
    for item in node.items():
        try:
            check_value(describe(Scenario)["seed"], item.value)
        except ParameterError as error:
            item.fault(error.problem)
    if len(set(map(repr, node.value))) < len(node.value) or not node.value:
        node.fault(f"expected one seed at least, and different ones, got {shown(node.value)}")
    return tuple(node.value)


# ---------------------------------------------------------------------------------------------------------------- axes


def _axes(node: Node) -> list[Axis]:
    if node.value is None:
        return []
    if not node.expect_table('a table of paths and their values, as in "robots.rover.controller.speed" = [0.1, 0.2]'):
        return []
    found = []
    for name, child in _flat(node):
        axis = _axis(name, child)
        if axis is not None:
            found.append(axis)
    return found


def _flat(node: Node, before: str = "") -> list[tuple[str, Node]]:
    """The axes in a table, also if their paths have no quotes: ``robots.rover.dt = [...]``."""
    found = []
    for key, child in node.children():
        name = f"{before}{key}"
        if child.is_table and not _is_axis(child.value):
            found += _flat(child, f"{name}.")
        else:
            found.append((name, child))
    return found


def _is_axis(table: Mapping[str, Any]) -> bool:
    return bool({"values", "variants", *_RANGE, *_DRAWN} & set(table)) or not table


def _axis(name: str, node: Node) -> Axis | None:
    if node.is_table and "variants" in node:
        return _variants(name, node)
    values = _values(node)
    if values is None:
        return None
    if not values:
        node.fault("expected one value at least, got none")
        return None
    labels = _labels(values)
    if len(set(map(_identity, labels))) < len(labels):
        node.fault(f"expected different values, got {shown(values)}")
        return None
    settings, files = [], []
    for value in values:
        named: list[str] = []
        settings.append((f"{name}={as_toml(_anchored(value, node.folder, named))}",))
        files.append(tuple(named))
    return Axis(name=name, labels=tuple(labels), settings=tuple(settings), files=tuple(files))


def _values(node: Node) -> list[Any] | None:
    """The values of an axis: a list, a range, or draws from a distribution."""
    if isinstance(node.value, list):
        return node.value
    if not node.expect_table(
        "a list of values, a range as { from = 0.0, to = 1.0, count = 5 }, or { normal = [1.0, 0.02], count = 10 }"
    ):
        return None
    if "values" in node:
        node.refuse_unknown(("values",))
        child = node.child("values")
        return child.value if child.expect_list("a list of values") else None
    drawn = [kind for kind in _DRAWN if kind in node]
    if drawn:
        return _drawn(node, drawn[0])
    return _range(node)


def _range(node: Node) -> list[Any] | None:
    node.refuse_unknown(_RANGE)
    if ("count" in node) == ("step" in node):
        node.fault("expected count or step, one of them")
        return None
    ends = [_number(node.child(key)) for key in ("from", "to")]
    first, last = ends
    if first is None or last is None:
        return None
    if "count" in node:
        count = _whole(node.child("count"), 1, _MOST_VALUES, "a number of values > 0", 1)
        return [float(value) for value in np.linspace(first, last, count)]
    step = _number(node.child("step"))
    if step is None:
        return None
    if step == 0.0 or (last - first) / step < 0.0 or (last - first) / step > _MOST_VALUES:
        node.child("step").fault(f"expected a step that leads from {first:g} to {last:g}, got {shown(step)}")
        return None
    values = [first + i * step for i in range(int((last - first) / step + 1e-9) + 1)]
    wholes = all(type(node.value[key]) is int for key in ("from", "to", "step"))
    return [int(value) for value in values] if wholes else values


def _drawn(node: Node, kind: str) -> list[Any] | None:
    """Values drawn once for the study, from a seed of their own."""
    node.refuse_unknown((kind, "count", "seed"))
    pair = node.child(kind)
    if not isinstance(pair.value, list) or len(pair.value) != 2 or any(type(v) not in (int, float) for v in pair.value):
        what = "a mean and a standard deviation" if kind == "normal" else "a low and a high end"
        pair.fault(f"expected {what}, as in [0.9, 1.1], got {shown(pair.value)}")
        return None
    first, second = map(float, pair.value)
    if second < (0.0 if kind == "normal" else first):
        pair.fault(
            f"expected a {'deviation >= 0' if kind == 'normal' else 'low end <= the high one'}, got {pair.value}"
        )
        return None
    count = _whole(node.child("count"), 1, _MOST_VALUES, "a number of values > 0", 10)
    random = np.random.default_rng(_whole(node.child("seed"), 0, 2**63, "a seed >= 0", 0))
    drawn = random.normal(first, second, count) if kind == "normal" else random.uniform(first, second, count)
    return [float(value) for value in drawn]


def _variants(name: str, node: Node) -> Axis | None:
    """An axis of things that differ in several values at once, by their names."""
    node.refuse_unknown(("variants",))
    table = node.child("variants")
    if not table.expect_table('a table of variants, each a table of paths and values, as { slow = { "..." = 0.1 } }'):
        return None
    labels, settings, files = [], [], []
    for label, variant in table.children():
        if not variant.expect_table("a table of paths and values"):
            continue
        labels.append(label)
        named: list[str] = []
        flat = [(path, child) for path, child in variant.children()]
        settings.append(tuple(f"{path}={as_toml(_anchored(child.value, node.folder, named))}" for path, child in flat))
        files.append(tuple(named))
    if not labels:
        table.fault("expected one variant at least, got none")
        return None
    return Axis(name=name, labels=tuple(labels), settings=tuple(settings), files=tuple(files))


def _labels(values: list[Any]) -> list[Any]:
    """Values as the table shows them: tables by their ``use``, if these differ."""
    if any(isinstance(value, dict) for value in values):
        uses = [value.get("use") if isinstance(value, dict) else value for value in values]
        if all(isinstance(use, str) for use in uses) and len(set(uses)) == len(uses):
            return uses
    return [value if isinstance(value, (bool, int, float, str)) else as_toml(value) for value in values]


def _identity(label: Any) -> str:
    """A key that two labels share if they are the same value: 1 and 1.0 are, 1 and true are not."""
    return repr(int(label) if isinstance(label, float) and label.is_integer() else label)


def _anchored(value: Any, folder: Path, files: list[str]) -> Any:
    """A value with its file names made absolute: beside the study's file, or else in the present folder."""
    if isinstance(value, dict):
        return {key: _anchored(item, folder, files) for key, item in value.items()}
    if isinstance(value, list):
        return [_anchored(item, folder, files) for item in value]
    if not isinstance(value, str) or not value:
        return value
    name, colon, rest = value.partition(".py:")
    for place in (folder, Path.cwd()):  # where a path starts that is set from the command line
        path = place / (f"{name}.py" if colon else value)
        if path.suffix != "" and is_file(path):
            files.append(str(path))
            return f"{path}:{rest}" if colon else str(path)
    return value


# ------------------------------------------------------------------------------------------------------------- metrics


def _metrics(node: Node, registry: Registry) -> list[Measured]:
    what = "a table of metrics, as in final_error = { use = 'position_error' }"
    if node.value is None:
        node.fault(f"missing; expected {what}")
        return []
    if not node.expect_table(what):
        return []
    read = [read_metric(name, child, registry, in_files=True) for name, child in node.children()]
    if not node.value:
        node.fault(f"expected one metric at least, got none; write {what}")
    return [each for each in read if each is not None]


def read_metric(
    name: str, node: Node, registry: Registry, *, beside: tuple[str, ...] = (), in_files: bool = False
) -> Measured | None:
    """The metric in a table: its ``use``, its fields, and ``robot``; a fault and None if there is none.

    Further keys, those of `beside`, are left to the caller. A metric in a file, where the caller loads those that are
    `in_files`, is read without running it.
    """
    names = registry.names("metric")
    known = ", ".join(names)
    if not node.expect_table(f"a table with use = one of: {known}"):
        return None
    use = node.child("use").text(f"the name of a metric: {known}")
    if use is None:
        return None
    if in_files and program_in(node):
        own = read_program_in(node, "metric", ("robot", *beside))
        robot = node.child("robot").text("the name of a robot", "") or ""
        return None if own is None else Measured(name=name, metric=own, robot=robot, source=own.source)
    if use not in names:
        node.child("use").fault(no_such("metric", use, names))
        return None
    robot = node.child("robot").text("the name of a robot", "") or ""
    metric: Metric | None = read_component(registry.get("metric", use), node, beside=("use", "robot", *beside))
    return None if metric is None else Measured(name=name, metric=metric, robot=robot)


def _check_columns(top: Node, axes: list[Axis], metrics: list[Measured]) -> None:
    names = {axis.name for axis in axes}
    for kind, name in [("axes", axis.name) for axis in axes] + [("metrics", each.name) for each in metrics]:
        if name in COLUMNS:
            top.child(kind).child(name).fault(f"the table has a column {name!r} of its own; take another name")
        elif kind == "metrics" and name in names:
            top.child(kind).child(name).fault(f"an axis is called {name!r} too; take another name")


def _check_paths(top: Node, axes: list[Axis]) -> None:
    """Note a fault where two axes, or an axis and a key, set the same: rows would be about what was not simulated."""
    set_by = {"simulation.seed": "seeds", "simulation.duration": "duration"}
    set_by = {path: key for path, key in set_by.items() if key in top}
    for axis in axes:
        paths = {setting.partition("=")[0] for one in axis.settings for setting in one}
        for path in sorted(paths & set(set_by)):
            top.child("axes").fault(f"{axis.name!r} and {set_by[path]!r} both set {path}; keep one of them")
        set_by |= dict.fromkeys(paths, axis.name)
