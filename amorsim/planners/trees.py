"""RRT, RRT-Connect and RRT*: trees that grow by random samples."""

from __future__ import annotations

import math

import attrs
import numpy as np

from amorsim.algorithms.cells import Cells
from amorsim.array_types import Array, Ints32
from amorsim.core.parameters import parameter
from amorsim.kernels.search.any_angle import is_open_line
from amorsim.kernels.search.trees import Ground, Tree, connect, grow, improve, new_tree
from amorsim.planners.sampling import Grown, SamplingPlanner

__all__ = ["Rrt", "RrtConnect", "RrtStar"]


_AT_A_TIME = 500  # samples, so that Ctrl-C is noticed; an even number
_STEPS = 20  # to cross the map, by the default


@attrs.frozen(kw_only=True)
class _TreePlanner(SamplingPlanner):
    """A planner that grows trees."""

    step: float | None = parameter(
        None, unit="m", gt=0, help="longest line of a tree; without it a twentieth of the map's longer side"
    )
    bias: float = parameter(0.05, ge=0, lt=1, help="share of the samples that are the goal")

    def ground(self, cells: Cells, goal: Array) -> Ground:
        """Where samples fall."""
        step = max(cells.rows, cells.cols) / _STEPS if self.step is None else self.step / cells.side
        return Ground(cells.free, cells.width, self.seed, float(goal[0]), float(goal[1]), self.bias, step)


@attrs.frozen(kw_only=True)
class Rrt(_TreePlanner):
    """A path by a rapidly exploring random tree (RRT): the first that it finds, which is not short.

    The tree grows from the start, by a step at a time, towards random places. After S. M. LaValle and J. J. Kuffner,
    "Randomized kinodynamic planning", IJRR 20, 2001.
    """

    def grow(self, cells: Cells, start: Array, goal: Array) -> Grown:
        """Grow a tree from the start until it sees the goal."""
        ground = self.ground(cells, goal)
        tree = new_tree(float(start[0]), float(start[1]), self.budget)
        is_found = False
        while not is_found and tree.used[1] < self.budget:
            is_found = grow(tree, ground, min(_AT_A_TIME, self.budget - int(tree.used[1])))
        path = np.concatenate((_from_root(tree, int(tree.used[2])), goal[None])) if is_found else None
        return Grown(path, _places(tree), _links(tree))


@attrs.frozen(kw_only=True)
class RrtConnect(_TreePlanner):
    """A path by two random trees, from start and goal, which grow towards each other (RRT-Connect).

    Usually much quicker than `Rrt`, and its paths are not shorter. After J. J. Kuffner and S. M. LaValle, "RRT-Connect:
    an efficient approach to single-query path planning", ICRA 2000.
    """

    bias: float = parameter(0.0, ge=0, lt=1, help="share of the samples that are the goal")

    def grow(self, cells: Cells, start: Array, goal: Array) -> Grown:
        """Grow a tree from each end until they meet."""
        ground = self.ground(cells, goal)
        # A sample adds one place to a tree, and to the other as many as there are steps to the new one.
        room = self.budget + 100_000
        trees = tuple(new_tree(float(x), float(y), room) for x, y in (start, goal))
        is_found = False
        while not is_found and trees[0].used[1] < self.budget:
            is_found = connect(trees[0], trees[1], ground, min(_AT_A_TIME, self.budget - int(trees[0].used[1])))
        path = None
        if is_found:
            first, second = (_from_root(tree, int(tree.used[2])) for tree in trees)
            path = np.concatenate((first, second[::-1][1:]))
        places, links = (np.concatenate([part(tree) for tree in trees]) for part in (_places, _links))
        return Grown(path, places, links)


@attrs.frozen(kw_only=True)
class RrtStar(_TreePlanner):
    """A short path by a random tree that rearranges itself around every new place (RRT*).

    It draws all samples of its budget. With each the best path gets shorter or stays, and approaches the shortest.

    After S. Karaman and E. Frazzoli, "Sampling-based algorithms for optimal motion planning", IJRR 30, 2011, and J. D.
    Gammell and others, "Informed RRT*", IROS 2014.
    """

    budget: int = parameter(10_000, ge=0, help="samples, all of which are drawn")
    informed: bool = parameter(True, help="whether samples are drawn only from where a shorter path may come")

    def grow(self, cells: Cells, start: Array, goal: Array) -> Grown:
        """Grow a tree from the start with all samples."""
        ground = self.ground(cells, goal)
        tree = new_tree(float(start[0]), float(start[1]), self.budget)
        near, ends = np.empty((2, self.budget + 1), np.int32)
        state = np.array([math.inf, 0.0])
        # Karaman and Frazzoli, theorem 38: with more than this radius the best path tends to the shortest.
        reach = 1.1 * 2.0 * math.sqrt(1.5) * math.sqrt(np.count_nonzero(cells.free) / math.pi)
        if math.dist(start, goal) <= ground.step:
            _see_at_once(tree, ground, cells, ends, state)
        while tree.used[1] < self.budget:
            most = min(_AT_A_TIME, self.budget - int(tree.used[1]))
            improve(tree, ground, self.informed, reach, near, ends, state, most)
        path = np.concatenate((_from_root(tree, int(tree.used[2])), goal[None])) if tree.used[2] >= 0 else None
        return Grown(path, _places(tree), _links(tree))


def _see_at_once(tree: Tree, ground: Ground, cells: Cells, ends: Ints32, state: Array) -> None:
    """Note that the root sees the goal, if it does."""
    line = (float(tree.x[0]), float(tree.y[0]), ground.goal_x, ground.goal_y)
    if is_open_line(cells.free, cells.width, *line):
        ends[0] = 0
        state[:] = math.dist(line[:2], line[2:]), 1.0
        tree.used[2] = 0


def _from_root(tree: Tree, place: int) -> Array:
    """The places (M, 2) from a tree's root to one of its places."""
    numbers = [place]
    while tree.parent[numbers[-1]] >= 0:
        numbers.append(int(tree.parent[numbers[-1]]))
    return np.stack((tree.x[numbers[::-1]], tree.y[numbers[::-1]]), axis=1)


def _places(tree: Tree) -> Array:
    count = tree.used[0]
    return np.stack((tree.x[:count], tree.y[:count]), axis=1)


def _links(tree: Tree) -> Array:
    """The lines (E, 4) from each place's parent to it."""
    places = _places(tree)
    return np.concatenate((places[tree.parent[1 : len(places)]], places[1:]), axis=1)
