"""Analysis of runs, studies and trajectories: errors of estimates, their consistency, and what may be claimed.

The names are looked up when first used; only what draws needs matplotlib.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from amorsim.algorithms.consistency import Consistency, nees, nis, verdict
    from amorsim.algorithms.effects import holm, paired_effect
    from amorsim.algorithms.ensembles import Ensemble, ensemble
    from amorsim.algorithms.intervals import Interval, mean_interval
    from amorsim.algorithms.map_scores import MapScores, distances_to_walls, map_scores
    from amorsim.algorithms.trajectories import Transform, umeyama
    from amorsim.analysis.comparison import compare
    from amorsim.analysis.consistency import run_nees, run_nis
    from amorsim.analysis.differences import Comparison, Difference
    from amorsim.analysis.export import export_run
    from amorsim.analysis.measuring import measure
    from amorsim.analysis.pose_errors import PoseErrors, Statistics, ape, relation_errors, rpe
    from amorsim.analysis.recordings import read_bag, read_log, read_mcap
    from amorsim.analysis.relations import clock_offset, read_relations
    from amorsim.analysis.run_files import RunFiles
    from amorsim.analysis.run_log import LogEntry
    from amorsim.analysis.slam_on_log import SlamResult, slam
    from amorsim.analysis.trajectory import (
        Trajectory,
        read_csv,
        read_kitti,
        read_tum,
        run_trajectories,
        write_csv,
        write_kitti,
        write_tum,
    )

_MODULES = {
    "amorsim.algorithms.consistency": "Consistency nees nis verdict",
    "amorsim.algorithms.effects": "holm paired_effect",
    "amorsim.algorithms.ensembles": "Ensemble ensemble",
    "amorsim.algorithms.intervals": "Interval mean_interval",
    "amorsim.algorithms.map_scores": "MapScores distances_to_walls map_scores",
    "amorsim.algorithms.trajectories": "Transform umeyama",
    "amorsim.analysis.comparison": "compare",
    "amorsim.analysis.consistency": "run_nees run_nis",
    "amorsim.analysis.differences": "Comparison Difference",
    "amorsim.analysis.export": "export_run",
    "amorsim.analysis.run_files": "RunFiles",
    "amorsim.analysis.measuring": "measure",
    "amorsim.analysis.pose_errors": "PoseErrors Statistics ape relation_errors rpe",
    "amorsim.analysis.recordings": "read_bag read_log read_mcap",
    "amorsim.analysis.relations": "clock_offset read_relations",
    "amorsim.analysis.run_log": "LogEntry",
    "amorsim.analysis.slam_on_log": "SlamResult slam",
    "amorsim.analysis.trajectory": (
        "Trajectory read_csv read_kitti read_tum run_trajectories write_csv write_kitti write_tum"
    ),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names.split()}

__all__ = [
    "Comparison",
    "Consistency",
    "Difference",
    "Ensemble",
    "Interval",
    "LogEntry",
    "MapScores",
    "PoseErrors",
    "RunFiles",
    "SlamResult",
    "Statistics",
    "Trajectory",
    "Transform",
    "ape",
    "clock_offset",
    "compare",
    "distances_to_walls",
    "ensemble",
    "export_run",
    "holm",
    "map_scores",
    "mean_interval",
    "measure",
    "nees",
    "nis",
    "paired_effect",
    "read_bag",
    "read_csv",
    "read_kitti",
    "read_log",
    "read_mcap",
    "read_relations",
    "read_tum",
    "relation_errors",
    "rpe",
    "run_nees",
    "run_nis",
    "run_trajectories",
    "slam",
    "umeyama",
    "verdict",
    "write_csv",
    "write_kitti",
    "write_tum",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'amorsim.analysis' has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
