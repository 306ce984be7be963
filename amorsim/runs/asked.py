"""What a user may name as a scenario: a file, a bundled name, or a map alone; and the simulation of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from amorsim.core.errors import AmorsimError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from amorsim.scenario.spec import Scenario
    from amorsim.simulation.simulation import Simulation

__all__ = ["make_simulation", "read_scenario"]


def read_scenario(name: str, *, resolution: float | None = None, changes: Sequence[str] = ()) -> Scenario:
    """The scenario that a user means by `name`."""
    from amorsim.scenario.read import load, scenario_for_map

    if not name.strip():
        raise AmorsimError("expected the name of a scenario or of a map, got nothing")
    path = Path(name)
    is_map = path.suffix.lower() not in ("", ".toml")
    if is_map:
        options: dict[str, Any] = {} if resolution is None else {"resolution": resolution}
        return scenario_for_map(path, overrides=tuple(changes), **options)
    if resolution is not None:
        raise AmorsimError(
            "--resolution is for a map alone; a scenario says it in [world] (or --set world.resolution=)"
        )
    return load(name, overrides=tuple(changes))


def make_simulation(scenario: Scenario, replicas: int | Sequence[int] = 1, threads: int = 1) -> tuple[Simulation, str]:
    """The simulation of a scenario, and a remark for the user, or nothing.

    A map alone whose own start leaves the robot no room is no mistake of the user's: the robot then starts where there
    is most.
    """
    from amorsim.core.errors import Fault, ScenarioError
    from amorsim.scenario.spec import Pose
    from amorsim.simulation.simulation import Simulation

    try:
        return Simulation(scenario, replicas=replicas, threads=threads), ""
    except ScenarioError as error:
        start = scenario.map.start
        first = scenario.robots[0]
        pose = first.pose
        if scenario.source is not None or start is None or pose is None or start != (pose.x, pose.y, pose.heading):
            raise
        x, y = scenario.map.freest_place()
        robots: Any = [attrs.evolve(first, pose=Pose(x=x, y=y))]
        try:
            simulation = Simulation(attrs.evolve(scenario, robots=robots), replicas=replicas, threads=threads)
        except ScenarioError:
            name = f"robots.{first.name}"
            hint = (
                f"nor is there room for it at the freest place, ({x:.3f}, {y:.3f}) m; say where, as in "
                f"--set {name}.pose.x=1.5 --set {name}.pose.y=2, or take a smaller robot"
            )
            raise ScenarioError([*error.faults, Fault(file="", path=f"{name}.pose", message=hint)]) from None
        return simulation, (
            f"the map's start ({start[0]:.3f}, {start[1]:.3f}) m leaves the robot no room; it starts where there is "
            f"most, at ({x:.3f}, {y:.3f}) m"
        )
