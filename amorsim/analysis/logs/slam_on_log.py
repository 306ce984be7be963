"""A recorded log becomes a path, a map and a graph: an estimator runs on it, without the simulator."""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from amorsim.algorithms.pose_graph import PoseGraph, write_g2o
from amorsim.analysis.logs.recordings import RECORDING, read_log
from amorsim.analysis.logs.robot_of_log import robot_of
from amorsim.analysis.logs.run_log import LogEntry
from amorsim.analysis.logs.slam_replay import SlamReplay
from amorsim.analysis.logs.wheels_at_scans import with_wheels_at_scans
from amorsim.analysis.trajectory import Trajectory, write_tum
from amorsim.array_types import Array
from amorsim.contracts import Estimator
from amorsim.core.arguments import check_kind, checked, path_of
from amorsim.core.errors import AnalysisError
from amorsim.core.execution.progress import progress_shown
from amorsim.core.maps.estimated_map import estimated_map
from amorsim.core.maps.map import Map
from amorsim.core.poses import compose, relative
from amorsim.core.unknown_names import no_such
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.estimators.map_area import log_odds_evidence
from amorsim.kernels.kinematics.poses import directions
from amorsim.kernels.mapping.nodes import add_nodes
from amorsim.kernels.mapping.occupancy import probabilities_of_log_odds
from amorsim.kernels.mapping.scan_cells import Area, window_for
from amorsim.scenario.pose import Pose
from amorsim.scenario.spec import MountedSensor, Robot
from amorsim.sensors.encoder import Encoder
from amorsim.simulation.estimator_runner import EstimatorRunner

__all__ = ["SlamResult", "slam"]


_OUTLIERS = 1e-3  # share of the scans' ends at each side that need not lie on the map: beams through windows
_MARGIN = 0.5  # [m] around what lies on the map
_MOST_CELLS = 50_000_000


@attrs.frozen(kw_only=True, eq=False)
class SlamResult:
    """The result of an estimator on a log: the robot's pose at each scan, and what it saw.

    Attributes
    ----------
    path
        As the estimator knew it at the end of the log: with a graph, after its last loop.
    online
        As it knew it when each scan arrived.
    odometry
        By the wheels alone.
    scans
        Ranges `(n, k)` [m], inf for no return.
    laser
        The sensor that took them.
    graph
        Of the estimator, if it has one. Information counts as it did in the graph's last solution.
    loops
        How many edges of the graph closed a loop.
    is_whole
        Whether the log was read to its end; False after Ctrl-C.
    """

    path: Trajectory
    online: Trajectory
    odometry: Trajectory
    scans: Array
    laser: MountedSensor
    graph: PoseGraph | None
    loops: int
    is_whole: bool

    @checked
    def map(self, resolution: float = 0.05) -> Map:
        """The map that all scans draw from where the path has them: occupied, free and unknown cells.

        Raises
        ------
        AnalysisError
            If it would have too many cells.
        """
        if not (math.isfinite(resolution) and resolution > 0.0):
            raise AnalysisError(f"resolution: expected a number of metres > 0, got {resolution!r}")
        mount = self.laser.mount
        place = np.array([float(mount.x), float(mount.y), float(mount.heading)])
        sensor: Any = self.laser.sensor
        bearings = np.ascontiguousarray(sensor.bearings())[:1]
        cos_b, sin_b = np.empty_like(bearings), np.empty_like(bearings)
        directions(bearings, cos_b, sin_b)
        reach = float(np.max(sensor.range_max))
        low, high = self._bounds(bearings, place)
        rows, cols = (max(1, math.ceil(length / resolution)) for length in (high - low)[::-1].tolist())
        if rows * cols > _MOST_CELLS:
            raise AnalysisError(
                f"a map of {(high - low)[0]:.0f} x {(high - low)[1]:.0f} m has too many cells of {resolution:g} m; "
                "take larger ones"
            )
        area, origin = Area(rows, cols, resolution), np.floor(low / resolution) * resolution
        log_odds = np.full((1, rows * cols), np.nan, dtype=np.float32)
        window, at = window_for(area, reach), np.empty(3)
        poses, rules = self.path.poses, log_odds_evidence()
        add_nodes(
            area, origin, poses, self.scans, place, cos_b[0], sin_b[0], reach, rules, window, at, log_odds[0]
        )  # fmt: skip
        probability = np.empty((1, rows * cols))
        probabilities_of_log_odds(log_odds, probability)
        beliefs = {
            "occupancy": probability.reshape(rows, cols),
            "occupancy_origin": origin,
            "occupancy_resolution": np.array(resolution),
        }
        return estimated_map(beliefs, name="map")

    def _bounds(self, bearings: Array, mount: Array) -> tuple[Array, Array]:
        """The lower left and the upper right corner [m] of what was seen, and of the path."""
        poses = compose(self.path.poses, np.broadcast_to(mount, self.path.poses.shape))
        angles = poses[:, 2:] + bearings
        is_end = np.isfinite(self.scans)
        ends = [
            (poses[:, place, None] + np.where(is_end, self.scans, 0.0) * turn(angles))[is_end]
            for place, turn in enumerate((np.cos, np.sin))
        ]
        path = self.path.poses[:, :2]
        low, high = path.min(axis=0), path.max(axis=0)
        if is_end.any():
            low = np.minimum(low, [np.quantile(one, _OUTLIERS) for one in ends])
            high = np.maximum(high, [np.quantile(one, 1.0 - _OUTLIERS) for one in ends])
        return np.asarray(low - _MARGIN), np.asarray(high + _MARGIN)

    def save(self, folder: str | os.PathLike[str], resolution: float = 0.05) -> list[Path]:
        """Write ``path.tum``, ``online.tum``, ``odometry.tum``, ``map.yaml`` and ``graph.g2o``; returns the files.

        Times are the log's own. The folder is made if it is not there.

        Raises
        ------
        AmorsimError
            If a file cannot be written.
        """
        from amorsim.scenario.files.maps import save_map

        folder = path_of(folder, "folder", "the folder for the files")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise AnalysisError(f"{folder}: cannot be made: {error.strerror}") from None
        made = []
        for name in ("path", "online", "odometry"):
            made.append(folder / f"{name}.tum")
            write_tum(getattr(self, name), made[-1], within=folder)
        made.append(folder / "map.yaml")
        save_map(self.map(resolution), made[-1])
        if self.graph is not None:
            made.append(folder / "graph.g2o")
            write_g2o(self.graph, made[-1])
        return made


@checked
def slam(
    log: str | os.PathLike[str],
    robot: Robot | None = None,
    estimator: str | Estimator = "graph_slam",
    *,
    topics: Mapping[str, str] | None = None,
    command: str | None = None,
    replica: int | None = None,
    damaged: Callable[[str], None] | None = None,
    progress: bool = True,
    out: str | os.PathLike[str] | None = None,
    resolution: float = 0.05,
) -> SlamResult:
    """Run an estimator on a log, and keep the path, the scans and the graph.

    Readings of a recording count when they were measured, not when they arrived, and between two readings wheels turn
    evenly. Ctrl-C ends it early, and keeps what was found until then.

    Parameters
    ----------
    log, topics, command, replica, damaged
        As `read_log` takes them.
    robot
        That made the log: with its nominal drive and sensors, an encoder and a laser among them. Without a pose it
        starts at the origin. If not given, `robot_of` the log.
    estimator
        The name of one of the robot's, or any other.
    progress
        Whether a bar shows how far it is.
    out
        Folder, new or empty, for the files that `SlamResult.save` writes and all moments of the log, in the form of a
        run's folder without truth: ``amorsim replay OUT`` plays them.
    resolution
        Side of a cell of the map in that folder [m].

    Raises
    ------
    AmorsimError
        If the log cannot be read, the robot has no such estimator or sensors, or the log has no scan; or if the folder
        holds something or cannot be written.
    """
    path = path_of(log, "log", RECORDING)
    robot = robot_of(path, topics) if robot is None else _placed(robot)
    mapper = EstimatorRunner(robot, estimator)
    laser, encoder = _sensors(robot, estimator)
    wheels = EstimatorRunner(robot, DeadReckoning(encoder=encoder))
    given = {"topics": topics, "command": command, "replica": replica, "damaged": damaged, "as_measured": True}
    received = list(read_log(path, robot, **given))  # type: ignore[arg-type]  # as their names have them
    counts: Any = robot.sensors[encoder].sensor
    entries = with_wheels_at_scans(received, laser, encoder, counts)
    kept = _Kept()
    is_whole = False
    with contextlib.ExitStack() as on_error:
        replay = None
        if out is not None and entries:
            replay = on_error.enter_context(SlamReplay(out, path.name, entries[-1].time - entries[0].time))
        with contextlib.suppress(KeyboardInterrupt):
            for entry in _shown(entries, progress=progress):
                if replay is not None:
                    replay.write_until(entry.time - entries[0].time)
                estimate, reckoned = mapper.update(*entry), wheels.update(*entry)
                if replay is not None:
                    replay.keep(mapper.frame())
                if laser in entry.readings:
                    kept.add(entry, laser, estimate.pose, reckoned.pose, mapper.beliefs)
            is_whole = True
        if not kept.times:
            raise AnalysisError(
                f"{path}: no scan of the sensor {laser!r}" + ("" if is_whole else " until it was interrupted")
            )
        graph, loops = _graph(mapper.beliefs)
        result = SlamResult(
            path=kept.trajectory(kept.final(), f"path by {path.name}"),
            online=kept.trajectory(kept.poses, f"path by {path.name}, as known at each scan"),
            odometry=kept.trajectory(kept.wheels, f"path by {path.name}, by the wheels alone"),
            scans=np.array(kept.scans),
            laser=robot.sensors[laser],
            graph=graph,
            loops=loops,
            is_whole=is_whole,
        )
        if replay is not None:
            result.save(replay.folder, resolution)
            replay.finish(mapper.robot, is_whole=is_whole)
    return result


class _Kept:
    """The data kept of each scan."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self.poses: list[Array] = []
        self.wheels: list[Array] = []
        self.scans: list[Array] = []
        self._nodes: list[int] = []  # of a graph: its newest node, and where that was thought to be
        self._node_poses: list[Array] = []
        self._graph: Array | None = None  # (n, 3), the nodes as they are now

    def add(self, entry: LogEntry, laser: str, pose: Array, reckoned: Array, beliefs: Mapping[str, Any]) -> None:
        """Keep a scan, and where the robot was thought to be."""
        self.times.append(entry.time)
        self.poses.append(pose)
        self.wheels.append(reckoned)
        self.scans.append(np.array(entry.readings[laser], dtype=np.float64))
        if "graph_poses" in beliefs:
            self._graph = np.asarray(beliefs["graph_poses"])
            self._nodes.append(int(np.isfinite(self._graph[:, 0]).sum()) - 1)
            self._node_poses.append(self._graph[self._nodes[-1]].copy())

    def final(self) -> Sequence[Array]:
        """The poses as known at the end: each scan moves with the node that it was taken from."""
        if self._graph is None:
            return self.poses
        moved = relative(np.array(self._node_poses), np.array(self.poses))
        return list(compose(np.ascontiguousarray(self._graph[self._nodes]), moved))

    def trajectory(self, poses: Sequence[Array], name: str) -> Trajectory:
        """These poses, at the scans' times."""
        return Trajectory(time=np.array(self.times), poses=np.array(poses), name=name)


def _placed(robot: Robot) -> Robot:
    """The robot, with a pose."""
    check_kind(robot, Robot, "robot", "a Robot, as am.load_robot('pioneer2dx-lms200')")
    return attrs.evolve(robot, pose=Pose()) if robot.pose is None else robot


def _sensors(robot: Robot, estimator: str | Estimator) -> tuple[str, str]:
    """The names of the laser and the encoder that an estimator reads, or else of the robot's first ones."""
    found = robot.estimators[estimator] if isinstance(estimator, str) else estimator
    laser: str | None = getattr(found, "laser", None)
    encoder: str | None = getattr(found, "encoder", None)
    for name, mounted in robot.sensors.items():
        sensor = mounted.sensor
        if laser is None and sensor.bearings() is not None and hasattr(sensor, "range_max") and sensor.unit == "m":
            laser = name
        if encoder is None and isinstance(sensor, Encoder):
            encoder = name
    for what, one in (("a laser", laser), ("an encoder", encoder)):
        if one is None:
            raise AnalysisError(f"robot {robot.name!r}: expected {what} among its sensors: {', '.join(robot.sensors)}")
        if one not in robot.sensors:
            raise AnalysisError(no_such("sensor", one, robot.sensors, whose=f"robot {robot.name!r}"))
    return str(laser), str(encoder)


def _shown(entries: Sequence[LogEntry], *, progress: bool) -> Iterator[LogEntry]:
    """The entries, while a bar shows how far they are."""
    with progress_shown(progress, "mapping", float) as show:
        for number, entry in enumerate(entries, start=1):
            yield entry
            if show is not None:
                show(number / len(entries))


def _graph(beliefs: Mapping[str, Any]) -> tuple[PoseGraph | None, int]:
    """The graph that an estimator believes in, if it has one with edges, and its loops."""
    if "graph_edges" not in beliefs:
        return None, 0
    poses, edges = np.asarray(beliefs["graph_poses"]), np.asarray(beliefs["graph_edges"])
    there = edges[:, 0] >= 0
    if not there.any():
        return None, 0
    measured, information = (np.asarray(beliefs[f"graph_{name}"]) for name in ("measurements", "information"))
    graph = PoseGraph.of(poses[np.isfinite(poses[:, 0])], edges[there], measured[there], information[there])
    return graph, int(beliefs["graph_loops"])
