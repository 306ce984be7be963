"""What a user may name as a scenario: a file, a bundled name, or a map alone; and the simulation of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from amorsim.core.errors import AmorsimError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from amorsim.scenario.spec import Scenario
    from amorsim.simulation.simulation import Simulation

__all__ = ["look_up", "make_simulation", "read_scenario"]


def look_up(name: str) -> None:
    """Raise what `read_scenario` would if there is nothing of that name; quickly, for nothing is compiled for it."""
    from amorsim.plugins.manager import default_registry
    from amorsim.scenario.maps import find_loader
    from amorsim.scenario.read import find_document

    if _is_map(name):
        find_loader(Path(name), None, default_registry())
    else:
        find_document(name, default_registry())


def _is_map(name: str) -> bool:
    if not name.strip():
        raise AmorsimError("expected the name of a scenario or of a map, got nothing")
    return Path(name).suffix.lower() not in ("", ".toml")


def read_scenario(name: str, *, resolution: float | None = None, changes: Sequence[str] = ()) -> Scenario:
    """The scenario that a user means by `name`."""
    from amorsim.scenario.read import load, scenario_for_map

    if _is_map(name):
        options: dict[str, Any] = {} if resolution is None else {"resolution": resolution}
        return scenario_for_map(Path(name), overrides=tuple(changes), **options)
    if resolution is not None:
        raise AmorsimError(
            "--resolution is for a map alone; a scenario says it in [world] (or --set world.resolution=)"
        )
    return load(name, overrides=tuple(changes))


def make_simulation(scenario: Scenario, replicas: int | Sequence[int] = 1, threads: int = 1) -> tuple[Simulation, str]:
    """The simulation of a scenario, and a remark for the user, or nothing."""
    from amorsim.scenario.worlds import is_free_at
    from amorsim.simulation.simulation import Simulation

    simulation = Simulation(scenario, replicas=replicas, threads=threads)
    world, first = scenario.map, scenario.robots[0]
    if scenario.source is not None or world.start is None or first.pose is None:
        return simulation, ""
    if is_free_at(world, first, world.start):
        return simulation, ""
    (x, y, _), pose = world.start, first.pose
    return simulation, (
        f"the map's start ({x:.3f}, {y:.3f}) m leaves the robot no room; it starts at ({pose.x:.3f}, {pose.y:.3f}) m"
    )
