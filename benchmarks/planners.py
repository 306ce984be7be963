"""Planners beside plain C++, `pathfinding`, networkx and scipy, on one map of the MovingAI benchmarks.

All sides of a setting get the same problems, and their lengths are compared before a ratio counts. Times are of one
plan, with all that a call from Python costs; graphs and maps are made beforehand.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import math
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import amorsim as am
from benchmarks.contest import Clock
from benchmarks.results import Ratio, Row, ratio_of

__all__ = ["measure"]

SECTION = "planners"
MAP = Path(__file__).resolve().parents[2] / "shared" / "maps" / "movingai" / "den000d.map"
_SIDE = 1.0  # [m] of a cell
_ROOT = math.sqrt(2.0)

Bytes = npt.NDArray[np.uint8]
Cell = tuple[int, int]  # row, col
Problem = tuple[Cell, Cell]
Solve = Callable[[Problem], float]
"""The length of the shortest path [cells], for a problem."""


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """The rows: A* beside other programs, jump point search beside A*, the field beside scipy, and all planners."""
    world, name = _world(quick)
    free = world.to_array() == 0
    problems = _problems(free, 4 if quick else 12)
    rows = _race(f"A*, {name}", _searchers(world, free, say), problems, rounds, clock, say)
    ours = {"amorsim": _of(am.planners.JumpPoint(), world), "amorsim's A*": _of(am.planners.AStar(), world)}
    rows += _race(f"jump point search, {name}", ours, problems, rounds, clock, say)
    rows += _race(f"distances of all cells, {name}", _fields(world, free, say), problems[:3], rounds, clock, say)
    return rows + _all_planners(rounds, quick, clock, say)


def _world(quick: bool) -> tuple[am.Map, str]:
    if MAP.is_file() and not quick:
        return am.load_map(MAP, resolution=_SIDE), "den000d"
    side = 100 if quick else 500
    size = (0.05 * side, 0.05 * side)
    cells = am.worlds.cave(1, size=size).to_array(resolution=0.05)
    return am.Map.from_array(cells, resolution=_SIDE), f"a cave of {cells.shape[0]} x {cells.shape[1]} cells"


def _problems(free: npt.NDArray[np.bool_], count: int) -> list[Problem]:
    """Pairs of free cells that are joined, spread over the map."""
    random = np.random.default_rng(1)
    places = np.argwhere(free)
    world = am.Map.from_array(~free, resolution=_SIDE)
    planner = am.planners.JumpPoint()
    found: list[Problem] = []
    while len(found) < count:
        start, goal = (tuple(places[random.integers(len(places))].tolist()) for _ in range(2))
        if start != goal and planner.plan(world, _middle(start), _middle(goal)).status == "found":
            found.append((start, goal))
    return found


def _middle(cell: Cell) -> tuple[float, float]:
    return ((cell[1] + 0.5) * _SIDE, (cell[0] + 0.5) * _SIDE)


def _of(planner: am.Planner, world: am.Map) -> Solve:
    return lambda problem: planner.plan(world, *map(_middle, problem)).length / _SIDE


def _race(
    setting: str,
    sides: dict[str, Solve],
    problems: Sequence[Problem],
    rounds: int,
    clock: Clock,
    say: Callable[[str], None],
) -> list[Row]:
    """All sides in turn, several rounds; the first is amorsim's."""
    say(f"planners: {setting}")
    lengths = {side: [solve(problem) for problem in problems] for side, solve in sides.items()}
    times: dict[str, list[float]] = {side: [] for side in sides}
    for _ in range(rounds):
        for side, solve in sides.items():
            began = clock()
            for problem in problems:
                solve(problem)
            times[side].append((clock() - began) / len(problems))
    ours, *_ = sides
    rows = []
    for side in sides:
        off = max(abs(a - b) for a, b in zip(lengths[side], lengths[ours], strict=True))
        why_not = "" if off <= 1e-6 else f"a length differs by {off:.3g} cells"
        ratio = None
        if side != ours:
            spread = ratio_of(times[ours], times[side], less_is_better=True)
            ratio = Ratio(spread=spread, counts=not why_not, why_not=why_not)
        note = "" if side != ours else f"{len(problems)} problems, mean length {np.mean(lengths[ours]):.0f} cells"
        rows.append(
            Row(
                section=SECTION,
                setting=setting,
                side=side,
                unit="s a plan",
                rounds=tuple(times[side]),
                ratio=ratio,
                note=note,
            )
        )
    return rows


def _searchers(world: am.Map, free: npt.NDArray[np.bool_], say: Callable[[str], None]) -> dict[str, Solve]:
    """A* of amorsim and of others, as far as they are installed."""
    sides: dict[str, Solve] = {"amorsim": _of(am.planners.AStar(), world)}
    for name, make in (("plain C++", _plain), ("pathfinding", _pathfinding), ("networkx", _networkx)):
        try:
            sides[_versioned(name)] = make(free)
        except (ImportError, OSError, subprocess.CalledProcessError) as error:
            say(f"planners: without {name}: {error}")
    return sides


def _versioned(name: str) -> str:
    try:
        return f"{name} {importlib.metadata.version(name)}"
    except importlib.metadata.PackageNotFoundError:
        return name


_SOURCE = r"""
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <queue>
#include <utility>
#include <vector>
// Plain A*: a binary heap, arrays, the octile distance; no corner is cut. Cells have a border of blocked ones.
extern "C" double plan(const uint8_t *free_, int width, int count, int start, int goal) {
    const double root = std::sqrt(2.0);
    std::vector<double> cost(count, 1e300);
    std::vector<int> parent(count, -1);
    std::vector<uint8_t> closed(count, 0);
    auto guess = [&](int cell) {
        int up = std::abs(cell / width - goal / width), across = std::abs(cell % width - goal % width);
        int near = up < across ? up : across, far = up < across ? across : up;
        return far - near + root * near;
    };
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;
    cost[start] = 0.0;
    open.push({guess(start), start});
    const int steps[8] = {1, -1, width, -width, width + 1, width - 1, -width + 1, -width - 1};
    while (!open.empty()) {
        int cell = open.top().second;
        open.pop();
        if (closed[cell]) continue;
        closed[cell] = 1;
        if (cell == goal) return cost[cell];
        for (int k = 0; k < 8; k++) {
            int other = cell + steps[k];
            if (!free_[other] || closed[other]) continue;
            if (k >= 4) {
                int across = (k % 2 == 0) ? 1 : -1, up = steps[k] - across;
                if (!free_[cell + across] || !free_[cell + up]) continue;
            }
            double longer = cost[cell] + (k >= 4 ? root : 1.0);
            if (longer < cost[other]) {
                cost[other] = longer;
                parent[other] = cell;
                open.push({longer + guess(other), other});
            }
        }
    }
    return -1.0;
}
"""


def _plain(free: npt.NDArray[np.bool_]) -> Solve:
    """A* in C++, compiled now."""
    compiler = shutil.which("g++")
    if compiler is None:
        raise OSError("there is no g++")
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder) / "plan.cpp", Path(folder) / "plan.so"
        source.write_text(_SOURCE)
        subprocess.run([compiler, "-O2", "-shared", "-fPIC", "-o", str(library), str(source)], check=True)
        plan = ctypes.CDLL(str(library)).plan
    plan.restype = ctypes.c_double
    plan.argtypes = [ctypes.c_void_p, *[ctypes.c_int] * 4]
    cells = np.ascontiguousarray(np.pad(free, 1)).view(np.uint8)
    width = cells.shape[1]

    def solve(problem: Problem) -> float:
        start, goal = ((row + 1) * width + col + 1 for row, col in problem)
        return float(plan(cells.ctypes.data, width, cells.size, start, goal))

    return solve


def _pathfinding(free: npt.NDArray[np.bool_]) -> Solve:
    from pathfinding.core.diagonal_movement import DiagonalMovement
    from pathfinding.core.grid import Grid
    from pathfinding.finder.a_star import AStarFinder

    grid: Any = Grid(matrix=free.astype(int).tolist())

    def solve(problem: Problem) -> float:
        grid.cleanup()
        (start_row, start_col), (row, col) = problem
        finder = AStarFinder(diagonal_movement=DiagonalMovement.only_when_no_obstacle)
        path, _ = finder.find_path(grid.node(start_col, start_row), grid.node(col, row), grid)
        steps = np.abs(np.diff([(node.x, node.y) for node in path], axis=0)).sum(axis=1)
        return float(np.where(steps == 2, _ROOT, steps).sum())

    return solve


def _networkx(free: npt.NDArray[np.bool_]) -> Solve:
    import networkx

    graph = networkx.Graph()
    graph.add_weighted_edges_from(_edges(free))

    def guess(one: Cell, other: Cell) -> float:
        up, across = abs(one[0] - other[0]), abs(one[1] - other[1])
        return max(up, across) + (_ROOT - 1.0) * min(up, across)

    return lambda problem: float(networkx.astar_path_length(graph, *problem, heuristic=guess))


def _edges(free: npt.NDArray[np.bool_]) -> list[tuple[Cell, Cell, float]]:
    """The steps between free cells, each once, none of which cuts a corner."""
    padded = np.pad(free, 1)
    edges: list[tuple[Cell, Cell, float]] = []
    for row, col in np.argwhere(free).tolist():
        for up, across in ((0, 1), (1, 0), (1, 1), (1, -1)):
            if (
                padded[row + 1 + up, col + 1 + across]
                and padded[row + 1 + up, col + 1]
                and padded[row + 1, col + 1 + across]
            ):
                edges.append(((row, col), (row + up, col + across), math.hypot(up, across)))
    return edges


def _fields(world: am.Map, free: npt.NDArray[np.bool_], say: Callable[[str], None]) -> dict[str, Solve]:
    """The sum of the distances of all cells to the goal."""
    planner = am.planners.Wavefront()

    def ours(problem: Problem) -> float:
        to_go = planner.field(world, _middle(problem[1])).to_go
        return float(to_go[problem[0]]) / _SIDE

    sides: dict[str, Solve] = {"amorsim": ours}
    try:
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import dijkstra
    except ImportError as error:
        say(f"planners: without scipy: {error}")
        return sides
    numbers = np.full(free.shape, -1)
    numbers[free] = np.arange(np.count_nonzero(free))
    ends = np.array([(numbers[one], numbers[other], length) for one, other, length in _edges(free)])
    count = int(np.count_nonzero(free))
    graph = csr_array((ends[:, 2], (ends[:, 0].astype(int), ends[:, 1].astype(int))), shape=(count, count))
    both = csr_array(graph + graph.T)

    def theirs(problem: Problem) -> float:
        distances = dijkstra(both, directed=True, indices=int(numbers[problem[1]]))
        return float(distances[numbers[problem[0]]])

    return sides | {_versioned("scipy"): theirs}


def _all_planners(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """One plan across an office by each planner, with a footprint of 0.25 m; of cars, with a radius of 0.5 m."""
    say("planners: all, in an office")
    world = am.worlds.office(0)
    disc = am.Shape.circle(0.25)
    planners: dict[str, am.Planner] = {
        "dijkstra": am.planners.Dijkstra(),
        "a_star": am.planners.AStar(),
        "jump_point": am.planners.JumpPoint(),
        "wavefront": am.planners.Wavefront(),
        "theta_star": am.planners.ThetaStar(),
        "theta_star, lazy": am.planners.ThetaStar(lazy=True),
        "d_star_lite": am.planners.DStarLite(),
        "voronoi": am.planners.Voronoi(),
        "potential_field": am.planners.PotentialField(),
        "rrt": am.planners.Rrt(),
        "rrt_connect": am.planners.RrtConnect(),
        "rrt_star": am.planners.RrtStar(),
        "prm": am.planners.Prm(),
        "dubins": am.planners.Dubins(radius=0.5),
        "reeds_shepp": am.planners.ReedsShepp(radius=0.5),
        "hybrid_a_star": am.planners.HybridAStar(radius=0.5),
    }
    rows = []
    for name, planner in planners.items():
        plan = planner.plan(world, (2.0, 2.0, 1.57), (20.0, 10.0, 1.57), footprint=disc)
        times = []
        for _ in range(1 if quick else rounds):
            began = clock()
            planner.plan(world, (2.0, 2.0, 1.57), (20.0, 10.0, 1.57), footprint=disc)
            times.append(clock() - began)
        note = f"{plan.status}, {plan.length:.2f} m, {plan.expanded} expanded" if plan.poses.size else plan.status
        rows.append(
            Row(section=SECTION, setting="across an office", side=name, unit="s a plan", rounds=tuple(times), note=note)
        )
    return rows
