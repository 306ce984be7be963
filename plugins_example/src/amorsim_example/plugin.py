"""The plugin: the module that the entry point in pyproject.toml names, with the hook that registers all there is.

A component may be named in place of being imported, as here; then it is imported when a scenario first asks for it,
and a plugin that nobody uses costs nothing.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import amorsim as am

if TYPE_CHECKING:
    from amorsim.plugins.registry import Registry

__all__ = ["amorsim_register"]

_HERE = Path(__file__).parent


@am.hookimpl
def amorsim_register(registry: Registry) -> None:
    """Register the components, the robot and the scenario."""
    registry.drive("example-tricycle", "amorsim_example.tricycle:Tricycle")
    registry.sensor("beacon", "amorsim_example.beacon:Beacon")
    registry.noise("drift", "amorsim_example.drift:Drift")
    registry.map_loader("maze", "amorsim_example.maze:Maze")
    registry.estimator("compass_odometry", "amorsim_example.compass_odometry:CompassOdometry")
    registry.scenario_loader("course", "amorsim_example.course:Course")
    registry.world_generator("posts", "amorsim_example.posts:Posts")
    registry.controller("bounce", "amorsim_example.bounce:Bounce")
    registry.planner("flood", "amorsim_example.flood:Flood")
    registry.motion("shuttle", "amorsim_example.shuttle:Shuttle")
    registry.recorder("tally", "amorsim_example.tally:Tally")
    registry.metric("detour", "amorsim_example.detour:Detour")
    registry.task("roam", "amorsim_example.roam:Roam")
    registry.robot("example-tricycle", _HERE / "robots" / "tricycle.toml")
    registry.scenario("example-maze", _HERE / "scenarios" / "maze.toml")
