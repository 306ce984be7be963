"""The floor of a scenario, for sensors that look down."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import FloorPoints
from amorsim.core.shapes import Shape, pack
from amorsim.kernels.sensing import floor_layers as floors
from amorsim.scenario.floor import Floor
from amorsim.scenario.pose import Pose

__all__ = ["FloorPlan"]


class _Layer:
    """Shapes that lie on the floor, one on top of another."""

    def __init__(self, things: Sequence[tuple[Shape, Pose]], values: Sequence[float], bare: float) -> None:
        self._bodies = pack([shape for shape, _ in things])
        self._poses = np.array([(pose.x, pose.y, pose.heading) for _, pose in things]).reshape(-1, 3)
        self._values = np.array([*values, bare])  # the last has the index -1

    def at(self, places: Array) -> Array:
        """The value `(Q,)` of the topmost shape at places `(Q, 2)`, or of the bare floor."""
        if len(self._values) == 1:
            return np.full(len(places), self._values[0])
        which = np.empty(len(places), dtype=np.int64)
        floors.topmost(self._bodies, self._poses, places, which)
        found: Array = self._values[which]
        return found


class FloorPlan:
    """A floor, the same in all replicas, as arrays for kernels."""

    def __init__(self, floor: Floor) -> None:
        marks = [(mark.footprint, mark.pose if mark.shape is not None else Pose()) for mark in floor.markings]
        self._markings = _Layer(marks, [mark.reflectance for mark in floor.markings], floor.reflectance)
        self._drops = _Layer([(drop.shape, drop.pose) for drop in floor.drops], [d.depth for d in floor.drops], 0.0)

    def at(self, places: Array) -> FloorPoints:
        """Properties of the floor at places `(N, k, 2)` [m] in the world."""
        points = np.ascontiguousarray(places, dtype=np.float64).reshape(-1, 2)
        depth = self._drops.at(points)
        reflectance = np.where(depth > 0.0, 0.0, self._markings.at(points))
        return FloorPoints(reflectance.reshape(places.shape[:2]), depth.reshape(places.shape[:2]))
