"""``amorsim slam``: a path and a map from the log of a real robot."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import attrs
import numpy as np
import typer

from amorsim.cli.console import complain, say
from amorsim.cli.studies.study import check_out, table
from amorsim.core.errors import AmorsimError, AnalysisError

if TYPE_CHECKING:
    from amorsim.analysis.logs.slam_on_log import SlamResult
    from amorsim.analysis.pose_errors import PoseErrors
    from amorsim.scenario.spec import Robot

__all__ = ["command"]

_MOST_COMPLAINTS = 5  # about damaged lines
_MADE = ("path.tum", "online.tum", "odometry.tum", "map.yaml", "graph.g2o", "report.html")
_SAME = 0.006  # [s] in which a scan is that of a relation: six digits of a time after 1000 s are rounded by 5 ms


def command(
    log: Annotated[
        Path,
        typer.Argument(
            metavar="LOG",
            help="A log of CARMEN (.log, .clf, .gfs, also with .gz), a rosbag, an MCAP file, or the folder of a run.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Folder for what is found, new or empty. [default: amorsim-runs/<log>-slam-<number>]",
        ),
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(
            metavar="MODEL",
            help="The robot that made the log: a model, or its .toml file. Of a run's folder, the name of one of its "
            "robots. [default: pioneer2dx-lms200 with the log's beams; the run's first]",
        ),
    ] = None,
    estimator: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Which of the robot's estimators runs on the log. [default: its first graph_slam, or one "
            "like that of pioneer2dx-lms200]",
        ),
    ] = None,
    relations: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Known relations between poses, as Kümmerle et al. (2009) publish them."),
    ] = None,
    topic: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SENSOR=TOPIC", help="Of a recording: the topic of a sensor's readings; may be given again."
        ),
    ] = None,
    resolution: Annotated[float, typer.Option(metavar="METRES", help="Side of a cell of the map.")] = 0.05,
) -> None:
    """Run an estimator on a log, and leave the robot's path, a map and a report.

    The folder has path.tum with the log's own times, map.yaml with its picture, graph.g2o if the estimator has a graph,
    and report.html. It is also the folder of a run, without truth: amorsim replay shows it moment by moment. With
    --relations, the errors in them are printed. Ctrl-C ends it early, and keeps what was found until then.
    """
    from amorsim.analysis.logs.slam_on_log import slam
    from amorsim.core.files.atomic_files import write_text
    from amorsim.reports.slam import error_table, slam_page
    from amorsim.runs.folder import new_folder
    from amorsim.scenario.files.maps import load_map

    check_out(out)
    if not resolution > 0.0:
        raise AmorsimError(f"--resolution: expected a number of metres > 0, got {resolution:g}")
    pairs = _topics(topic or [])
    known = _relations(relations)
    used = _robot(log, robot, pairs)
    used, name = _with_graph_slam(used) if estimator is None else (used, estimator)
    damage: list[str] = []
    begun = time.perf_counter()
    folder = new_folder(f"{log.name.partition('.')[0]}-slam") if out is None else out
    try:
        found = slam(log, used, name, topics=pairs or None, damaged=damage.append, out=folder, resolution=resolution)
    except BaseException:
        if out is None:
            for empty in (folder, folder.parent):
                with contextlib.suppress(OSError):
                    empty.rmdir()
        raise
    took = time.perf_counter() - begun
    for line in damage[:_MOST_COMPLAINTS]:
        complain(line)
    if len(damage) > _MOST_COMPLAINTS:
        complain(f"and {len(damage) - _MOST_COMPLAINTS} more damaged lines, which were left out")
    errors = {} if known is None else _errors(found, known)
    facts = [*_facts(found, log, used, name), ("computed in", f"{took:.0f} s")]
    for what, value in facts:
        say(f"{what}: {value}")
    if errors:
        say("\n" + table(*error_table(errors)))
    page = slam_page(found, load_map(folder / "map.yaml"), log.name, facts, errors)
    write_text(folder / "report.html", page.text, within=folder)
    say("\n" + "\n".join(str(path) for path in map(folder.joinpath, _MADE) if path.exists()))
    if not np.ptp(found.odometry.poses, axis=0).any():
        complain("by the log's odometry the robot never moved: the path is by its scans alone")
    say(f"To see it happen: amorsim replay {folder}")
    if not found.is_whole:
        complain(f"interrupted: this is of the log up to {found.path.time[-1]:g} s")
        raise typer.Exit(130)


def _topics(given: list[str]) -> dict[str, str]:
    found = {}
    for each in given:
        sensor, is_pair, topic = each.partition("=")
        if not (sensor and is_pair and topic):
            raise AmorsimError(f"--topic: expected SENSOR=TOPIC, as laser=/scan, got {each!r}")
        found[sensor] = topic
    return found


def _relations(path: Path | None) -> Any:
    """The relations in a file, read before anything is computed; None without a file."""
    if path is None:
        return None
    from amorsim.analysis.relations import read_relations

    return read_relations(path)


def _robot(log: Path, name: str | None, topics: dict[str, str]) -> Robot:
    """The robot that made a log."""
    from amorsim.analysis.logs.robot_of_log import robot_of
    from amorsim.core.files.reading import is_file
    from amorsim.core.unknown_names import no_such
    from amorsim.runs.folder import ABOUT
    from amorsim.runs.manifest import read_about, scenario_of
    from amorsim.scenario.pose import Pose
    from amorsim.scenario.reading.robots import load_robot

    if not is_file(log / ABOUT):
        return robot_of(log, topics) if name is None else load_robot(name, pose=Pose())
    robots = {one.name: one for one in scenario_of(log, read_about(log)).robots}
    if name is not None and name not in robots:
        raise AmorsimError(f"--robot: {no_such('robot', name, robots, whose='the run')}")
    return next(iter(robots.values())) if name is None else robots[name]


def _with_graph_slam(robot: Robot) -> tuple[Robot, str]:
    """The robot and the name of its first estimator that solves a graph; it gets that of the default robot if none."""
    from amorsim.analysis.logs.robot_of_log import default_robot
    from amorsim.estimators import GraphSlam

    for name, one in robot.estimators.items():
        if isinstance(one, GraphSlam):
            return robot, name
    name = "graph_slam"
    return attrs.evolve(robot, estimators={**robot.estimators, name: default_robot().estimators[name]}), name


def _errors(found: SlamResult, known: Any) -> dict[str, PoseErrors]:
    """The errors of each path in known relations, by its name; none, with a complaint, if no scan has their times.

    The relations' clock is put to that of the log.
    """
    from amorsim.analysis.pose_errors import relation_errors
    from amorsim.analysis.relations import clock_offset
    from amorsim.reports.slam import PATHS

    offset = clock_offset(known, found.path.time)
    if offset:
        say(f"the clock of the relations is {offset:.3f} s ahead of the log's: taken off")
    moved = known - [offset, offset, 0.0, 0.0, 0.0]
    try:
        return {name: relation_errors(getattr(found, name), moved, most_apart=_SAME) for name, _ in PATHS}
    except AnalysisError as error:  # what was computed is kept
        complain(f"--relations: {error}")
        return {}


def _facts(found: SlamResult, log: Path, robot: Robot, estimator: str) -> list[tuple[str, object]]:
    from amorsim.algorithms.trajectories import path_lengths

    time_, scans = found.path.time, found.scans
    facts: list[tuple[str, object]] = [
        ("log", log.name),
        ("scans", f"{len(scans)} of {scans.shape[1]} beams, from {time_[0]:g} to {time_[-1]:g} s"),
        ("path", f"{path_lengths(found.path.poses)[-1]:.1f} m"),
        ("estimator", f"{estimator} of {robot.model or robot.name}"),
    ]
    if found.graph is not None:
        nodes, edges = len(found.graph.poses), len(found.graph.edges)
        facts.append(("graph", f"{nodes} nodes, {edges} edges, {found.loops} of which close a loop"))
    return facts
