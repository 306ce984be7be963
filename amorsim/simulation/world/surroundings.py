"""What there is in the world beside cells and footprints: marks, lamps, and how bodies look."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Lights
from amorsim.scenario.spec import Floor, Landmark, Light, Obstacle, Robot
from amorsim.simulation.world.floor import FloorPlan

__all__ = ["Surroundings"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


@attrs.frozen(kw_only=True, eq=False)
class Surroundings:
    """The same in all replicas; things are the bodies of a replica, in their order, and after them the landmarks.

    A part of a robot is a thing of its own, as high as its robot and of its colour.

    Attributes
    ----------
    landmarks, radius
        Places `(L, 2)` [m] of the landmarks in the world, and their radii `(L,)` [m].
    ids
        What is written on the landmarks `(L,)`, and on the bodies that carry a mark `(C,)`, one after the other.
    carriers
        `(C,)` which bodies of a replica carry a mark.
    lights
        The lamps.
    floor
        What is marked on the floor, and where it drops.
    colours, heights
        Of each thing: its colour or none, and how high it is [m].
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
        """Those of a scenario; `bodies` in the order that they have in a replica, `owners` those of its parts."""
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
