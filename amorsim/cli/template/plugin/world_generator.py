"""A world generator: a hall with posts."""

from __future__ import annotations

import attrs
import numpy as np

import amorsim as am

__all__ = ["Hall"]

_CELL = 0.1  # [m]


@attrs.frozen(kw_only=True)
class Hall(am.WorldGenerator):
    """A square hall with posts at random places; its middle is kept free for the robot.

    Parameters
    ----------
    side
        Of the hall [m].
    posts
        How many posts.
    """

    side: float = am.parameter(10.0, unit="m", ge=2, le=100, help="of the hall")
    posts: int = am.parameter(20, ge=0, le=10_000, help="how many posts")

    def generate(self, draws: am.Draws) -> am.Map:
        """The hall."""
        count = round(self.side / _CELL)
        cells = np.zeros((count, count), dtype=np.uint8)
        rows, columns = np.floor(draws.uniform(2 * self.posts).reshape(2, -1) * count).astype(np.int64)
        cells[rows, columns] = 1
        middle = count // 2
        cells[middle - 5 : middle + 5, middle - 5 : middle + 5] = 0
        cells[[0, -1], :] = cells[:, [0, -1]] = 1
        return am.Map.from_array(cells, resolution=_CELL, start=(self.side / 2, self.side / 2, 0.0))
