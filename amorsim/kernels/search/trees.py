"""Trees of places that grow by random samples: RRT, RRT-Connect and RRT*.

S. M. LaValle and J. J. Kuffner, "Randomized kinodynamic planning", IJRR 20, 2001; J. J. Kuffner and S. M. LaValle,
"RRT-Connect: an efficient approach to single-query path planning", ICRA 2000; S. Karaman and E. Frazzoli,
"Sampling-based algorithms for optimal motion planning", IJRR 30, 2011; J. D. Gammell and others, "Informed RRT*",
IROS 2014.

Places are in cells, from the map's lower left corner. Draws are a function of a seed and the number of the sample, so
a search with a larger budget begins as one with a smaller.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.random.philox import philox
from amorsim.kernels.search.any_angle import is_open_line

__all__ = ["Ground", "Tree", "connect", "draw", "grow", "improve", "is_free", "new_tree"]

Ints32 = NDArray[np.int32]

_WORD = np.uint64(0xFFFFFFFF)
_SHIFT = np.uint64(32)
_UNIT = 2.0**-32


class Ground(NamedTuple):
    """Where samples fall, and how they are used."""

    free: NDArray[np.uint8]  # cells, as in `amorsim.kernels.search.frontier`
    width: int
    seed: int
    goal_x: float
    goal_y: float
    bias: float  # share of samples that are the goal
    step: float  # [cells] that a tree grows towards a sample at most


class Tree(NamedTuple):
    """A tree with room for n places; place 0 is its root."""

    x: Array
    y: Array
    parent: Ints32
    cost: Array  # [cells] from the root
    child: Ints32  # the first place reached from each, -1 for none
    sibling: Ints32  # the next place with the same parent, -1 for none
    used: Ints  # (3,) places in use, samples drawn, the place that the goal is reached from or -1


def new_tree(x: float, y: float, room: int) -> Tree:
    """A tree that is its root only."""
    tree = Tree(
        x=np.empty(room + 1),
        y=np.empty(room + 1),
        parent=np.full(room + 1, -1, np.int32),
        cost=np.zeros(room + 1),
        child=np.full(room + 1, -1, np.int32),
        sibling=np.full(room + 1, -1, np.int32),
        used=np.array([1, 0, -1]),
    )
    tree.x[0], tree.y[0] = x, y
    return tree


@part
def is_free(free: NDArray[np.uint8], width: int, x: float, y: float) -> bool:
    """Whether a place is in a free cell of the map."""
    col, row = math.floor(x), math.floor(y)
    rows = free.shape[0] // width - 2
    if col < 0 or row < 0 or col >= width - 2 or row >= rows:
        return False
    return bool(free[(row + 1) * width + col + 1] != 0)


@part
def draw(seed: int, number: int, stream: int) -> tuple[float, float, float]:
    """Three numbers in (0, 1) for a sample."""
    key = np.uint64(seed)
    w0, w1, w2, _ = philox(
        np.uint64(number) & _WORD,
        np.uint64(number) >> _SHIFT,
        np.uint64(stream),
        np.uint64(0x9A7),
        key & _WORD,
        key >> _SHIFT,
    )
    return (
        (np.float64(np.int64(w0)) + 0.5) * _UNIT,
        (np.float64(np.int64(w1)) + 0.5) * _UNIT,
        (np.float64(np.int64(w2)) + 0.5) * _UNIT,
    )


@part
def _sample(ground: Ground, number: int) -> tuple[float, float]:
    """The place of a sample: anywhere on the map, or the goal."""
    u, v, w = draw(ground.seed, number, 0)
    if w < ground.bias:
        return ground.goal_x, ground.goal_y
    rows = ground.free.shape[0] // ground.width - 2
    return u * (ground.width - 2), v * rows


@part
def _nearest(tree: Tree, x: float, y: float) -> int:
    """The place of the tree nearest to (x, y) [cells]; of several, the first."""
    best = math.inf
    found = 0
    for i in range(tree.used[0]):
        dx = tree.x[i] - x
        dy = tree.y[i] - y
        square = dx * dx + dy * dy
        if square < best:
            best = square
            found = i
    return found


@part
def _towards(tree: Tree, near: int, x: float, y: float, step: float) -> tuple[float, float]:
    """The place [cells] one `step` from place `near` towards (x, y), or (x, y) if that is nearer."""
    dx = x - tree.x[near]
    dy = y - tree.y[near]
    away = math.sqrt(dx * dx + dy * dy)
    if away <= step:
        return x, y
    return tree.x[near] + dx / away * step, tree.y[near] + dy / away * step


@part
def _is_open(ground: Ground, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether a robot may go straight from (x0, y0) to (x1, y1) [cells]."""
    return is_open_line(ground.free, ground.width, x0, y0, x1, y1)


@part
def _add(tree: Tree, x: float, y: float, parent: int, cost: float) -> int:
    """Add a place (x, y) [cells] that is reached from another for a `cost` [cells] in all; returns its number."""
    at = tree.used[0]
    tree.used[0] = at + 1
    tree.x[at], tree.y[at] = x, y
    tree.cost[at] = cost
    tree.parent[at] = parent
    tree.child[at] = -1
    tree.sibling[at] = tree.child[parent]
    tree.child[parent] = at
    return int(at)


@part
def _extend(tree: Tree, ground: Ground, x: float, y: float) -> int:
    """Grow by one step towards a place; returns the new one, or -1 if a wall is in the way or nothing is new."""
    near = _nearest(tree, x, y)
    nx, ny = _towards(tree, near, x, y, ground.step)
    dx, dy = nx - tree.x[near], ny - tree.y[near]
    away = math.sqrt(dx * dx + dy * dy)
    if away == 0.0 or not is_free(ground.free, ground.width, nx, ny):
        return -1
    if not _is_open(ground, tree.x[near], tree.y[near], nx, ny):
        return -1
    return _add(tree, nx, ny, near, tree.cost[near] + away)


@kernel
def grow(tree: Tree, ground: Ground, most: int) -> bool:
    """Draw samples for an RRT until it sees the goal within a step, or `most` are drawn; whether it does."""
    for _ in range(most):
        x, y = _sample(ground, tree.used[1])
        tree.used[1] += 1
        new = _extend(tree, ground, x, y)
        if new < 0:
            continue
        dx, dy = ground.goal_x - tree.x[new], ground.goal_y - tree.y[new]
        if dx * dx + dy * dy <= ground.step * ground.step and _is_open(
            ground, tree.x[new], tree.y[new], ground.goal_x, ground.goal_y
        ):
            tree.used[2] = new
            return True
    return False


@kernel
def connect(tree: Tree, other: Tree, ground: Ground, most: int) -> bool:
    """Draw samples for two trees in turn until they meet or `most` are drawn; returns whether they met.

    The places at which they met are written to ``used[2]`` of each. `most` is even but for the last call.
    """
    for _ in range(most):
        number = tree.used[1]
        x, y = _sample(ground, number)
        tree.used[1] += 1
        # Each in turn grows towards a sample, and the other then as far towards what is new as it can.
        first, second = (tree, other) if number % 2 == 0 else (other, tree)
        new = _extend(first, ground, x, y)
        if new < 0:
            continue
        x, y = first.x[new], first.y[new]
        while second.used[0] < second.x.shape[0]:
            came = _extend(second, ground, x, y)
            if came < 0:
                break
            if second.x[came] == x and second.y[came] == y:
                first.used[2] = new
                second.used[2] = came
                return True
    return False


@part
def _cut(tree: Tree, place: int) -> None:
    """Take a place from among the children of its parent."""
    parent = tree.parent[place]
    if tree.child[parent] == place:
        tree.child[parent] = tree.sibling[place]
        return
    at = tree.child[parent]
    while tree.sibling[at] != place:
        at = tree.sibling[at]
    tree.sibling[at] = tree.sibling[place]


@part
def _lower(tree: Tree, place: int, by: float) -> None:
    """Lower the cost of a place and of all that is reached from it."""
    at = place
    while True:
        tree.cost[at] -= by
        if tree.child[at] >= 0:
            at = tree.child[at]
            continue
        while at != place and tree.sibling[at] < 0:
            at = tree.parent[at]
        if at == place:
            return
        at = tree.sibling[at]


@part
def _informed(ground: Ground, number: int, x: float, y: float, best: float) -> tuple[float, float]:
    """A sample through which a path may be shorter than `best`: in an ellipse around start and goal."""
    u, v, w = draw(ground.seed, number, 0)
    if w < ground.bias:
        return ground.goal_x, ground.goal_y
    dx, dy = ground.goal_x - x, ground.goal_y - y
    apart = math.sqrt(dx * dx + dy * dy)
    long = 0.5 * best
    short = 0.5 * math.sqrt(max(best * best - apart * apart, 0.0))
    away = math.sqrt(u)
    along, across = away * math.cos(2.0 * math.pi * v) * long, away * math.sin(2.0 * math.pi * v) * short
    c, s = (dx / apart, dy / apart) if apart > 0.0 else (1.0, 0.0)
    return x + 0.5 * dx + c * along - s * across, y + 0.5 * dy + s * along + c * across


@part
def _best_end(tree: Tree, ground: Ground, ends: Ints32, count: int) -> float:
    """The cost of the best path to the goal by a place that sees it, which is noted."""
    best = math.inf
    for i in range(count):
        place = ends[i]
        dx, dy = ground.goal_x - tree.x[place], ground.goal_y - tree.y[place]
        cost = tree.cost[place] + math.sqrt(dx * dx + dy * dy)
        if cost < best:
            best = cost
            tree.used[2] = place
    return best


@kernel
def improve(
    tree: Tree, ground: Ground, is_informed: bool, reach: float, near: Ints32, ends: Ints32, state: Array, most: int
) -> None:
    """Draw `most` samples for an RRT*.

    Parameters
    ----------
    reach
        Places within ``reach * sqrt(log(n) / n)`` [cells] of a new one are tried as its parent and its children; no
        farther than a step.
    near
        (n,) to work in.
    ends
        (n,) the places that see the goal within a step; ``state[1]`` says how many.
    state
        (2,) the cost of the best path, and how many ends there are; changed.
    """
    for _ in range(most):
        number = tree.used[1]
        if is_informed and state[0] < math.inf:
            x, y = _informed(ground, number, tree.x[0], tree.y[0], state[0])
        else:
            x, y = _sample(ground, number)
        tree.used[1] += 1
        close = _nearest(tree, x, y)
        x, y = _towards(tree, close, x, y, ground.step)
        away = math.sqrt((x - tree.x[close]) ** 2 + (y - tree.y[close]) ** 2)
        if away == 0.0 or not is_free(ground.free, ground.width, x, y):
            continue
        n = tree.used[0] + 1
        radius = min(reach * math.sqrt(math.log(n) / n), ground.step)
        # The neighbours, and of those that see the new place the one that it is reached from best.
        count = 0
        parent = -1
        least = math.inf
        for i in range(tree.used[0]):
            dx, dy = tree.x[i] - x, tree.y[i] - y
            square = dx * dx + dy * dy
            if square <= radius * radius or i == close:
                cost = tree.cost[i] + math.sqrt(square)
                if cost < least and _is_open(ground, tree.x[i], tree.y[i], x, y):
                    parent = i
                    least = cost
                near[count] = i
                count += 1
        if parent < 0:
            continue
        new = _add(tree, x, y, parent, least)
        for k in range(count):
            i = near[k]
            cost = least + math.sqrt((tree.x[i] - x) ** 2 + (tree.y[i] - y) ** 2)
            if cost < tree.cost[i] and _is_open(ground, x, y, tree.x[i], tree.y[i]):
                _cut(tree, i)
                tree.parent[i] = new
                tree.sibling[i] = tree.child[new]
                tree.child[new] = i
                _lower(tree, i, tree.cost[i] - cost)
        dx, dy = ground.goal_x - x, ground.goal_y - y
        if dx * dx + dy * dy <= ground.step * ground.step and _is_open(ground, x, y, ground.goal_x, ground.goal_y):
            ends[int(state[1])] = new
            state[1] += 1.0
        state[0] = _best_end(tree, ground, ends, int(state[1]))
