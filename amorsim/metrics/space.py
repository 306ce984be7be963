"""How near the robot came to walls, and how much floor it passed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Episode, Metric, parameter
from amorsim.core.maps.footprint_room import wall_gaps

__all__ = ["Clearance", "Coverage"]


_MOST_CELLS = 4_000_000  # of the floor, in a replica


@attrs.frozen(kw_only=True)
class Clearance(Metric):
    """Least gap between the robot, or a part of it as a trailer, and the walls, at any step; 0 if it touched one."""

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "higher"

    gap_max: float = parameter(2.0, unit="m", gt=0, help="larger gaps count as this one, which saves time")

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose", "part_pose")

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        parts = episode.kept["part_pose"]
        bodies = [(episode.shape, episode.kept["true_pose"])]
        bodies += [(part.shape, parts[:, :, place]) for place, part in enumerate(episode.parts)]
        least = np.full(len(episode.replicas), self.gap_max)
        for row in range(len(least)):
            world = episode.map_of(row)
            for shape, poses in bodies:
                gaps, _ = wall_gaps(world, [shape] * len(poses), poses[:, row], self.gap_max)
                least[row] = min(least[row], gaps.min())
        return np.asarray(np.maximum(least, 0.0))


@attrs.frozen(kw_only=True)
class Coverage(Metric):
    """Floor that the robot passed: the area of the cells whose middle was within `radius` of its base point."""

    unit: ClassVar[str] = "m^2"
    better: ClassVar[str] = "higher"

    radius: float = parameter(0.25, unit="m", gt=0, help="how far from its base point it covers the floor")
    cell: float = parameter(0.1, unit="m", gt=0, help="side of the cells that are counted")

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose",)

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        reach = int(np.ceil(self.radius / self.cell)) + 1
        steps = np.arange(-reach, reach + 1)
        near = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        points = episode.kept["true_pose"][..., :2]
        area = np.empty(points.shape[1])
        for row in range(points.shape[1]):
            place = points[:, row]
            cells = np.floor(place / self.cell).astype(np.int64)
            seen: set[tuple[int, int]] = set()
            for first in range(0, len(place), max(1, _MOST_CELLS // len(near))):
                part = slice(first, first + max(1, _MOST_CELLS // len(near)))
                around = cells[part, None, :] + near
                apart = (around + 0.5) * self.cell - place[part, None, :]
                inside = apart[..., 0] ** 2 + apart[..., 1] ** 2 <= self.radius**2
                seen.update(map(tuple, np.unique(around[inside], axis=0).tolist()))
            area[row] = len(seen) * self.cell**2
        return area
