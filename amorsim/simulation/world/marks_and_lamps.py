"""The rest of the world, without cells and footprints: marks, lamps, and the colours and heights of bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts import Lights
from amorsim.scenario.spec import Floor, Landmark, Light, Obstacle, Robot
from amorsim.simulation.world.floor import FloorPlan

__all__ = ["Surroundings"]


@attrs.frozen(kw_only=True, eq=False)
class Surroundings:
    """The same in all replicas. Things are the bodies of a replica, in order, then the landmarks.

    A part of a robot is a thing of its own, with its robot's height and colour.

    Attributes
    ----------
    landmarks, radius
        Places `(L, 2)` [m] of the landmarks in the world, and their radii `(L,)` [m].
    ids
        Ids of the landmarks `(L,)`, then of the bodies that carry a mark `(C,)`, in one array.
    carriers
        `(C,)` the bodies of a replica that carry a mark.
    lights
        The lamps.
    floor
        The markings and drops of the floor.
    colours, heights
        Of each thing: its colour or None, and its height [m].
    """

    landmarks: Array
    radius: Array
    ids: Ints
    carriers: Ints
    lights: Lights
    floor: FloorPlan
    colours: tuple[str | None, ...]
    heights: Array

    @classmethod
    def of(
        cls,
        bodies: Sequence[Robot | Obstacle],
        landmarks: Sequence[Landmark] = (),
        lights: Sequence[Light] = (),
        owners: Sequence[int] = (),
        floor: Floor | None = None,
    ) -> Surroundings:
        """The surroundings of a scenario; `bodies` in their order in a replica, `owners` those of its parts."""
        carried = [(i, body.fiducial) for i, body in enumerate(bodies) if body.fiducial]
        things: list[Any] = [*bodies, *(bodies[owner] for owner in owners), *landmarks]
        return cls(
            landmarks=np.array([[mark.x, mark.y] for mark in landmarks], dtype=np.float64).reshape(-1, 2),
            radius=np.array([mark.radius for mark in landmarks], dtype=np.float64),
            ids=np.array([*(mark.id for mark in landmarks), *(id_ for _, id_ in carried)], dtype=np.int64),
            carriers=np.array([i for i, _ in carried], dtype=np.int64),
            lights=Lights(
                places=np.array([[light.x, light.y] for light in lights], dtype=np.float64).reshape(-1, 2),
                intensity=np.array([light.intensity for light in lights], dtype=np.float64),
            ),
            floor=FloorPlan(floor or Floor()),
            colours=tuple(thing.colour for thing in things),
            heights=np.array([thing.height for thing in things], dtype=np.float64),
        )
