"""Pose graphs: amorsim's solver against gtsam's Gauss-Newton, each from its own start to its own end."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from amorsim.algorithms.pose_graph import PoseGraph, chi2_of, optimize, read_g2o, write_g2o
from benchmarks.contest import Clock
from benchmarks.results import Ratio, Row, ratio_of

__all__ = ["made_graph", "measure"]

SECTION = "graphs"
INTEL = Path(__file__).resolve().parents[2] / "shared" / "maps" / "g2o" / "intel.g2o"
"""The graph of the Intel Research Lab, of 1,728 poses, next to the repository where somebody has put it there."""
_ROUNDS, _POSES = 12, 144  # of the graph that is made where there is no other


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """Solutions a second of each side, in turn."""
    graph = read_g2o(INTEL) if INTEL.is_file() and not quick else made_graph()
    name = "intel" if INTEL.is_file() and not quick else "rounds of a square"
    setting = f"{name}, {len(graph.poses)} poses, {len(graph.edges)} edges"
    ends: dict[str, float] = {}

    def ours() -> None:
        ends["amorsim"] = optimize(graph).chi2

    sides = {"amorsim": ours}
    if importlib.util.find_spec("gtsam") is not None:
        sides["gtsam"] = _gtsam(graph, ends)
    rates: dict[str, list[float]] = {side: [] for side in sides}
    for solve in sides.values():
        solve()
    for number in range(rounds):
        say(f"graphs: {setting}, round {number + 1}")
        for side, solve in sides.items():
            began = clock()
            solve()
            rates[side].append(1.0 / (clock() - began))
    return [
        Row(
            section=SECTION,
            setting=setting,
            side=side,
            unit="solutions/s",
            rounds=tuple(found),
            ratio=None if side == "amorsim" else Ratio(spread=ratio_of(rates["amorsim"], found), counts=True),
            note=f"chi2 {ends[side]:.6f}"
            + (", from a linear start" if side == "amorsim" else ", from the graph's poses"),
        )
        for side, found in rates.items()
    ]


def made_graph() -> PoseGraph:
    """Rounds of a square whose odometry drifts, with an edge from each pose to the one a round before."""
    rng = np.random.default_rng(1)
    step = 4.0 * 10.0 / _POSES
    turns = np.where(np.arange(1, _ROUNDS * _POSES) % (_POSES // 4) == 0, np.pi / 2.0, 0.0)
    true = np.zeros((_ROUNDS * _POSES, 3))
    for k, turn in enumerate(turns):
        x, y, heading = true[k]
        true[k + 1] = x + step * np.cos(heading), y + step * np.sin(heading), heading + turn
    first = np.arange(len(true) - 1)
    edges = np.concatenate((np.stack((first, first + 1), axis=1), np.stack((first[:-_POSES], first[_POSES:]), axis=1)))
    c, s = np.cos(true[edges[:, 0], 2]), np.sin(true[edges[:, 0], 2])
    off = true[edges[:, 1]] - true[edges[:, 0]]
    measured = np.stack((c * off[:, 0] + s * off[:, 1], c * off[:, 1] - s * off[:, 0], off[:, 2]), axis=1)
    measured += rng.normal(size=measured.shape) * (0.01, 0.01, 0.002)
    information = np.tile(np.diag((1e4, 1e4, 2.5e5)), (len(edges), 1, 1))
    poses = true + rng.normal(size=true.shape) * (0.1, 0.1, 0.02)
    poses[0] = true[0]
    graph = PoseGraph(
        ids=np.arange(len(poses)), poses=poses, edges=edges, measurements=measured, information=information
    )
    assert chi2_of(graph) > chi2_of(graph, true)
    return graph


def _gtsam(graph: PoseGraph, ends: dict[str, float]) -> Callable[[], None]:
    gtsam: Any = importlib.import_module("gtsam")
    with TemporaryDirectory() as folder:
        write_g2o(graph, Path(folder) / "graph.g2o")
        factors, start = gtsam.readG2o(str(Path(folder) / "graph.g2o"), False)
    noise = gtsam.noiseModel.Diagonal.Variances(np.array([1e-6, 1e-6, 1e-8]))
    factors.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(*graph.poses[0]), noise))

    def solve() -> None:
        found = gtsam.GaussNewtonOptimizer(factors, start, gtsam.GaussNewtonParams()).optimize()
        ends["gtsam"] = 2.0 * factors.error(found)

    return solve
