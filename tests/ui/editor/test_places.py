"""Points in the world that components name, a plugin's too."""

from __future__ import annotations

from pathlib import Path

import attrs

from amorsim.contracts import parameter
from amorsim.controllers.dwa import Dwa
from amorsim.controllers.navigate import Navigate
from amorsim.plugins.registry import Registry
from amorsim.sensors.compass import Compass
from amorsim.ui.editor.inspectors.points import places_at


@attrs.frozen(kw_only=True)
class Beacon(Compass):
    x: float = parameter(unit="m", frame="world")
    y: float = parameter(unit="m", frame="world")


@attrs.frozen(kw_only=True)
class Shy(Dwa):
    shunned: tuple[tuple[float, float], ...] = parameter((), unit="m", frame="world")


def test_sensors_and_components_in_components_have_places_too() -> None:
    registry = Registry()
    registry.sensor("beacon", Beacon)
    registry.controller("navigate", Navigate)
    registry.controller("shy", Shy)
    controller = {"use": "navigate", "goals": [[1, 2]], "avoider": {"use": "shy", "shunned": [[3, 4], [5, 6]]}}
    robot = {"name": "r", "sensors": {"eye": {"use": "beacon", "x": 7, "y": 8}}, "controller": controller}
    found = places_at({"robots": [robot]}, "robots.0", registry, Path())
    assert [(place["path"], place["kind"], place["points"]) for place in found] == [
        ("robots.0.controller.goals", "path", [[1, 2]]),
        ("robots.0.controller.avoider.shunned", "path", [[3, 4], [5, 6]]),
        ("robots.0.sensors.eye", "point", [[7, 8]]),
    ]
