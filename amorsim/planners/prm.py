"""PRM: a probabilistic roadmap."""

from __future__ import annotations

import math

import attrs
import numpy as np

from amorsim.algorithms.cells import Cells
from amorsim.array_types import Array
from amorsim.core.parameters import parameter
from amorsim.kernels.search.roadmap import search_roadmap, spread_places
from amorsim.planners.sampling import Grown, SamplingPlanner

__all__ = ["Prm"]


_AT_A_TIME = 50  # places taken up, so that Ctrl-C is noticed
_MOST_LINKS = 200_000


@attrs.frozen(kw_only=True)
class Prm(SamplingPlanner):
    """A path along a probabilistic roadmap (PRM): random free places, joined to those near them.

    It takes the shortest path along the roadmap. If there is none, it draws as many samples again. After L. E. Kavraki
    and others, "Probabilistic roadmaps for path planning in high-dimensional configuration spaces", IEEE Transactions
    on Robotics and Automation 12, 1996. How near places are joined follows S. Karaman and E. Frazzoli, 2011: the more
    there are, the nearer.
    """

    samples: int = parameter(500, ge=1, help="samples drawn before the first look for a path")

    def grow(self, cells: Cells, start: Array, goal: Array) -> Grown:
        """Draw samples until the roadmap has a path."""
        places = np.stack((start, goal))
        drawn, wanted = 0, self.samples
        links, taken = np.empty((0, 4)), places[:0]
        area = np.count_nonzero(cells.free) / math.pi
        while drawn < self.budget:
            last = min(wanted, self.budget)
            more = np.empty((last - drawn, 2))
            more = more[: spread_places(cells.free, cells.width, self.seed, drawn, last, more)]
            places = np.concatenate((places, more))
            drawn, wanted = last, 2 * wanted
            # As for RRT*: with more than this radius the shortest path of the roadmap tends to the shortest.
            reach = 1.1 * 2.0 * math.sqrt(1.5 * area * math.log(len(places)) / len(places))
            path, taken, links = _search(cells, places, reach)
            if path is not None:
                return Grown(path, taken, links)
        return Grown(None, taken, links)


def _search(cells: Cells, places: Array, reach: float) -> tuple[Array | None, Array, Array]:
    """The shortest path from place 0 to place 1, the places taken up, and the lines looked at."""
    count = len(places)
    cost, parent = np.full(count, math.inf), np.full(count, -1, np.int32)
    cost[0] = 0.0
    state, used = np.zeros(count, np.uint8), np.zeros(2, np.int64)
    links = np.empty((min(_MOST_LINKS, 30 * count), 2), np.int32)
    ended = 0
    while ended == 0:
        ended = search_roadmap(cells.free, cells.width, places, reach, cost, parent, state, links, used, _AT_A_TIME)
    ends = links[: used[0]]
    lines = np.concatenate((places[ends[:, 0]], places[ends[:, 1]]), axis=1)
    taken = places[state == 1]
    if ended == 2:
        return None, taken, lines
    numbers = [1]
    while numbers[-1] != 0:
        numbers.append(int(parent[numbers[-1]]))
    return places[numbers[::-1]], taken, lines
