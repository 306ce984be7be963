"""Pictures for scripts and notebooks: a map, a scenario, or a simulation with the ways that its robots went."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from PIL import Image

from amorsim.array_types import AnyArray, Array
from amorsim.core.arguments import checked
from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError
from amorsim.core.maps.map import Map
from amorsim.render.picture import checked_size, draw_map, draw_run
from amorsim.runs.traces import paths_of, things_of
from amorsim.scenario.spec import Scenario
from amorsim.simulation.checked_arguments import numbers_in_words
from amorsim.simulation.simulation import Simulation

__all__ = ["draw"]

_POSES = ("true_pose", "estimated_pose")


@checked
def draw(
    what: Map | Scenario | Simulation,
    kept: Mapping[str, AnyArray] | None = None,
    *,
    replica: int | None = None,
    size: int = 1000,
    title: str = "",
) -> Image.Image:
    """Draw a map, a scenario at its start, or a simulation as it is now; a notebook shows the picture.

    ::

        simulation = am.Simulation(am.load("demo"))
        kept = simulation.run(60, keep=("true_pose", "estimated_pose"))
        am.draw(simulation, kept).save("drift.png")

    Parameters
    ----------
    kept
        What `Simulation.run` returned: from ``true_pose`` the true paths are drawn, solid, and from ``estimated_pose``
        the estimated ones, dashed. Without it, the robots where they are.
    replica
        Number of the replica to draw; without it, the first.
    size
        Longer side of the picture [px], 240 at least and 8192 at most.
    title
        Stands above the picture.

    Returns
    -------
    PIL.Image.Image
        An RGB picture.

    Raises
    ------
    AmorsimError
        If there is no such replica, the poses kept are not of this simulation, or `what` cannot be drawn.
    ScenarioError
        If the scenario cannot be simulated.
    """
    size = checked_size(size)
    if isinstance(what, Map):
        return draw_map(what, size=size, title=title)
    simulation = Simulation(what) if isinstance(what, Scenario) else what
    if not isinstance(simulation, Simulation):
        raise AmorsimError(f"draw: expected a Map, a Scenario or a Simulation, got {in_words(what)}")
    index = _index_of(simulation, replica)
    if kept is not None and not kept.keys() & set(_POSES):
        raise AmorsimError(f"draw: kept: expected {' or '.join(_POSES)} in it, got {', '.join(kept) or 'nothing'}")
    true, estimated = (_ways(simulation, index, kept or {}, name) for name in _POSES)
    number = simulation.replicas[index]
    return draw_run(
        simulation.map_of(number),
        paths_of(simulation, number, true, estimated),
        zones=[zone.outline for zone in simulation.scenario.zones],
        patches=simulation.scenario.floor.patches,
        things=things_of(simulation, number),
        size=size,
        title=title,
    )


def _index_of(simulation: Simulation, replica: int | None) -> int:
    if replica is None:
        return 0
    if replica not in simulation.replicas:
        raise AmorsimError(f"draw: no replica {replica!r}; known replicas: {numbers_in_words(simulation.replicas)}")
    return simulation.replicas.index(replica)


def _ways(simulation: Simulation, index: int, kept: Mapping[str, AnyArray], name: str) -> Array:
    """The places `(T, M, 2)` [m] along the true or the estimated paths of a replica's robots."""
    robots = len(simulation.names)
    rows = robots * len(simulation.replicas)
    poses = kept.get(name, np.empty((0, rows, 3)))
    if np.ndim(poses) != 3 or np.shape(poses)[1:] != (rows, 3):
        raise AmorsimError(
            f"draw: kept[{name!r}]: expected poses (T, {rows}, 3), as this simulation's run() returns, got the shape "
            f"{np.shape(poses)}"
        )
    return np.asarray(poses, dtype=np.float64)[:, index * robots : (index + 1) * robots, :2]
