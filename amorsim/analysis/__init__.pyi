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
from amorsim.analysis.logs.recordings import read_bag, read_log, read_mcap
from amorsim.analysis.logs.robot_of_log import robot_of
from amorsim.analysis.logs.run_log import LogEntry
from amorsim.analysis.logs.slam_on_log import SlamResult, slam
from amorsim.analysis.measuring import measure
from amorsim.analysis.pose_errors import PoseErrors, Statistics, ape, relation_errors, rpe
from amorsim.analysis.relations import clock_offset, read_relations
from amorsim.analysis.run_files import RunFiles
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
    "robot_of",
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
