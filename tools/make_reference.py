"""Writes docs/reference/components.md: every built-in component, from its class.

Run it after a change of a component's fields or docstring; a test says when that was forgotten::

    python tools/make_reference.py
"""

from __future__ import annotations

from pathlib import Path

from amorsim.analysis.reference import reference_page
from amorsim.plugins.manager import make_registry
from amorsim.plugins.registry import KINDS

__all__ = ["PAGE", "page"]

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference" / "components.md"

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
    "recorder": ("Recorders", "What writes the files of a run; a scenario does not choose one."),
}


def page() -> str:
    """The whole page; of the built-in components only, whatever else is installed."""
    registry = make_registry(entry_points=[])
    parts = [_HEAD]
    for kind in KINDS:
        entries = registry.entries(kind)
        if not entries:
            continue
        title, where = _KINDS[kind]
        parts.append(f"## {title}\n\n{where}\n")
        parts += [reference_page(registry, entry) for entry in entries]
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
