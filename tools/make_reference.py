"""Writes docs/reference/components.md: every built-in component, from its class.

Run it after a change of a component's fields or docstring; a test says when that was forgotten::

    python tools/make_reference.py
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

import amorsim as am
from amorsim.analysis.reference import reference_page
from amorsim.controllers.avoider import Avoider
from amorsim.plugins.manager import make_registry
from amorsim.plugins.registry import KINDS, Entry, Registry

__all__ = ["PAGE", "page"]

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = DOCS / "reference" / "components.md"

_HEAD = """\
# Components

<!-- Written by tools/make_reference.py from the classes themselves; a change made here is lost. -->

What comes with amorsim. `amorsim plugins` lists these and those of installed plugins, and `amorsim plugins show NAME`
prints the same as stands here.

In a file, a component is a table: `use = "NAME"`, and its fields. The tables below spell fields as files do: angles in
degrees, in keys that end in `_deg`. In Python the same field has no `_deg` and is in radians. "The sensor's unit" is
that of the sensor whose chain an element stands in (in the `ground` chain: metres); where that is an angle, a file
spells it `_deg` too, as in `std_deg` on a compass.
"""

# Heading of each kind, and where its name stands in a scenario.
_KINDS = {
    "drive": ("Drives", "In `[robots.drive]`."),
    "sensor": (
        "Sensors",
        "In `[robots.sensors.NAME]`; `mount`, `rate`, `latency` and `noise` stand beside the fields.",
    ),
    "noise": ("Noise", "In the lists `noise` of a sensor and `ground` of a robot."),
    "map_loader": ("Map loaders", "In `[world]` and `[robots.knowledge]`, beside `map`; in Python in `am.load_map`."),
    "scenario_loader": (
        "Scenario loaders",
        "They read other programs' files as scenarios. Their fields are options of the command line and of `am.load`, "
        "as in `--set loader.crop_bitmaps=true`.",
    ),
    "world_generator": (
        "World generators",
        'In `map = { generate = "NAME", ... }` of `[world]`; in `amorsim generate`; in Python in `am.worlds`.',
    ),
    "motion": ("Motions", "In `motion` of an obstacle."),
    "estimator": ("Estimators", "In `[robots.estimators.NAME]`."),
    "controller": ("Controllers", "In `controller` of a robot."),
    "planner": ("Planners", "In Python: `am.planners`. A scenario does not choose one."),
    "metric": (
        "Metrics",
        "In `[metrics]` of a study, as `NAME = { use = ..., ... }`; `robot` stands beside the fields where there are "
        "several. In Python: `am.metrics`.",
    ),
    "task": ("Tasks", "In `[task]`. [Train a policy](../how-to/train-a-policy.md) is the guide."),
    "recorder": ("Recorders", "What writes the files of a run; a scenario does not choose one."),
}


_FEW = 4  # scenarios that are named of those that use a component

# Pages in docs/explanation: of a whole kind, and of single components.
_EXPLAINED = {"drive": "drives.md", "sensor": "sensors.md", "planner": "planners.md", "motion": "motions.md"}
_EXPLAINED_ALONE = {
    "ekf": "ekf.md",
    "ukf": "ukf.md",
    "monte_carlo": "monte-carlo.md",
    "scan_matching": "scan-matching.md",
    "graph_slam": "graph-slam.md",
    "grid_mapping": "grid-mapping.md",
    "grid_slam": "grid-slam.md",
}


def _inside(value: Any) -> Iterator[Any]:
    """All components and other values with fields within a value, at any depth."""
    if attrs.has(type(value)):
        yield value
        for field in attrs.fields(type(value)):
            yield from _inside(getattr(value, field.name))
    elif isinstance(value, Mapping):
        for each in value.values():
            yield from _inside(each)
    elif isinstance(value, (list, tuple)):
        for each in value:
            yield from _inside(each)


def _scenarios_by_class(registry: Registry) -> dict[type, list[str]]:
    """Which bundled scenarios use each class of component."""
    found: dict[type, list[str]] = defaultdict(list)
    for entry in registry.entries("scenario"):
        scenario = am.load(entry.name)
        for kind in dict.fromkeys(type(value) for value in _inside([scenario.robots, scenario.obstacles])):
            found[kind].append(entry.name)
    return found


def _explanation(cls: type, entry: Entry) -> str:
    """The page in docs/explanation on a component, from there; empty if there is none."""
    if entry.kind == "noise":
        return f"errors/{entry.name.replace('_', '-')}.md"
    if entry.kind == "controller":
        return "avoidance.md" if issubclass(cls, Avoider) else ""
    if entry.kind == "estimator":
        return _EXPLAINED_ALONE.get(entry.name, "")
    return _EXPLAINED.get(entry.kind, "")


def _picture(entry: Entry) -> str:
    """The name of a component's picture in docs/pictures; empty if there is none."""
    name = {"noise": "error", "world_generator": "world"}.get(entry.kind, "")
    file = f"{name}-{entry.name.replace('_', '-')}.png"
    return file if name and (DOCS / "pictures" / file).exists() else ""


def _related(cls: type, entry: Entry, scenarios: list[str]) -> str:
    """What else the docs show of a component: picture, explanation, scenarios."""
    lines = []
    if picture := _picture(entry):
        lines += [f"![{entry.name}](../pictures/{picture})", ""]
    if explanation := _explanation(cls, entry):
        title = (DOCS / "explanation" / explanation).read_text(encoding="utf-8").split("\n")[0].lstrip("# ")
        lines += [f"Equations and sources: [{title}](../explanation/{explanation}).", ""]
    if scenarios:
        links = ", ".join(f"[`{name}`](scenarios.md#{name})" for name in scenarios[:_FEW])
        lines += [f"Used by the scenarios {links}.", ""]
    return "\n".join(lines)


def page() -> str:
    """The whole page; of the built-in components only, whatever else is installed."""
    registry = make_registry(entry_points=[])
    users = _scenarios_by_class(registry)
    parts = [_HEAD]
    for kind in KINDS:
        entries = registry.entries(kind)
        if not entries:
            continue
        title, where = _KINDS[kind]
        parts.append(f"## {title}\n\n{where}\n")
        for entry in entries:
            cls = registry.get(entry.kind, entry.name)
            parts += [reference_page(registry, entry), _related(cls, entry, users.get(cls, []))]
    return "\n".join(part for part in parts if part)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
