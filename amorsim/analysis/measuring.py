"""Metrics of a run, from the files in its folder."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from amorsim.analysis.own_columns import own_channels
from amorsim.analysis.run_files import RunFiles
from amorsim.array_types import AnyArray, Array
from amorsim.contracts import Episode, Metric
from amorsim.core.arguments import check_kind
from amorsim.core.errors import AnalysisError
from amorsim.core.files.json_files import parse_json
from amorsim.core.maps.map import Map
from amorsim.scenario.spec import Robot
from amorsim.simulation.events import Event
from amorsim.simulation.fleet.grouping import channels_of
from amorsim.simulation.kept_quantities import LAST
from amorsim.worlds.drawn import map_of, origin_of

__all__ = ["episode_of", "measure"]


_OF_POSES = ("true_pose", "estimated_pose")


def measure(run: str | os.PathLike[str] | RunFiles, metric: Metric, *, robot: str | None = None) -> Array:
    """A metric's value in each replica of a run `(R,)`, from its files, which are rounded to a micrometre.

    ::

        am.analysis.measure("amorsim-runs/demo-001", am.metrics.PositionError(at="max"))

    Parameters
    ----------
    robot
        Its name; without it, the first's.

    Raises
    ------
    RunError
        If the folder is not a run's, or a file in it is damaged.
    AnalysisError
        If the run's files do not hold what the metric needs.
    """
    check_kind(metric, Metric, "metric", "a metric, as am.metrics.PathLength()")
    files = run if isinstance(run, RunFiles) else RunFiles(run)
    return metric.measure(episode_of(files, metric.needs(), robot=robot))


def episode_of(files: RunFiles, needs: Sequence[str], *, robot: str | None = None) -> Episode:
    """The metrics' view of a run; raises as `measure`."""
    robot = files.robots[0] if robot is None else robot
    poses = files.arrays("poses", robot=robot)
    specified = next(each for each in files.scenario.robots if each.name == robot)
    kept: dict[str, AnyArray] = {}
    for name in needs:
        whole = name.removeprefix(LAST)
        array = np.array(poses[whole] if whole in _OF_POSES else _read(files, whole, specified))
        kept[name] = array[-1:] if name.startswith(LAST) else array
    steps = min([len(poses["time"]), *(len(array) for name, array in kept.items() if not name.startswith(LAST))])
    if not steps:
        raise AnalysisError(
            f"{files.folder}: its tables of {robot!r} hold no moment for {', '.join(needs) or 'a metric'}"
        )
    return Episode(
        robot=robot,
        replicas=list(files.replicas),
        time=np.asarray(poses["time"][:steps], dtype=np.float64),
        kept={name: array[:steps] for name, array in kept.items()},
        events=_events(files, robot),
        map=files.scenario.map,
        shape=specified.shape,
        parts=specified.drive.parts,
        maps=() if origin_of(files.scenario.map) is None else _Worlds(files),
    )


class _Worlds(Sequence[Map]):
    """The maps of a run's replicas, each made when it is looked up: most metrics need none."""

    def __init__(self, files: RunFiles) -> None:
        self._files = files

    def __len__(self) -> int:
        return len(self._files.replicas)

    def __getitem__(self, row: Any) -> Any:
        if isinstance(row, slice):
            return [self[place] for place in range(*row.indices(len(self)))]
        return map_of(self._files.scenario.map, self._files.replicas[row])


def _read(files: RunFiles, name: str, specified: Robot) -> AnyArray:
    robot = specified.name
    kind, _, rest = name.partition(".")
    whose, _, what = rest.partition(".")
    if name == "covariance":
        if not specified.estimators:
            raise AnalysisError(
                f"{files.folder}: robot {robot!r} has no estimator, so there is no 'covariance', which the metric needs"
            )
        first = next(iter(specified.estimators))
        return files.arrays(f"estimates/{first}", robot=robot)["covariance"]
    if kind == "estimates" and what in ("pose", "covariance") and whose in files.estimators:
        return files.arrays(f"estimates/{whose}", robot=robot)[what]
    if kind == "beliefs" and whose in files.believers:
        beliefs = files.arrays(f"beliefs/{whose}", robot=robot)
        if what in beliefs:
            return beliefs[what]
    if name == "true_twist":
        return files.arrays("velocities", robot=robot)["true_twist"]
    if name == "command":
        return _commands(files, specified)
    if name == "part_pose":
        return _part_poses(files, specified)
    raise AnalysisError(f"{files.folder}: the files of this run do not hold {name!r}, which the metric needs")


def _commands(files: RunFiles, robot: Robot) -> Array:
    """A robot's commands `(S, R, channels)`, as a simulation keeps them: its own channels first, then nan."""
    commands = files.arrays("commands", robot=robot.name)["command"]
    given = [key for key in files.table("commands", replica="all") if key not in ("replica", "time", "robot")]
    own = own_channels(files, robot.name, given)
    most = max(len(channels_of(each)) for each in files.scenario.robots)
    found = np.full((*commands.shape[:2], most), np.nan)
    found[..., : len(own)] = commands[..., [given.index(channel) for channel in own]]
    return found


def _part_poses(files: RunFiles, robot: Robot) -> Array:
    """Poses `(S, R, parts, 3)` of a robot's parts; of a run that was killed up to the last step that all have."""
    parts = robot.drive.parts
    if not parts:
        return np.empty((len(files.arrays("poses")["time"]), len(files.replicas), 0, 3))
    found = []
    for replica in files.replicas:
        table = files.table("parts", replica=replica)
        poses = np.stack([table[key] for key in ("x", "y", "heading")], axis=1)
        found.append([poses[table["part"] == f"{robot.name}.{part.name}"] for part in parts])
    steps = min(len(of_part) for of_replica in found for of_part in of_replica)
    return np.array([[of_part[:steps] for of_part in of_replica] for of_replica in found]).transpose(2, 0, 1, 3)


def _events(files: RunFiles, robot: str) -> list[Event]:
    table = files.table("events", robot=robot, replica="all")
    count = len(table["time"])
    replicas = table["replica"].tolist() if "replica" in table else [files.replicas[0]] * count
    found = []
    for i in range(count):
        x, y, speed = (float(table[key][i]) for key in ("x", "y", "speed"))
        found.append(
            Event(
                tick=int(table["tick"][i]),
                time=float(table["time"][i]),
                replica=int(replicas[i]),
                kind=str(table["kind"][i]),
                name=robot,
                other=str(table["other"][i]),
                point=None if math.isnan(x) else (x, y),
                speed=None if math.isnan(speed) else speed,
                path=str(table["path"][i]),
                value=_value(str(table["value"][i])),
            )
        )
    return found


def _value(text: str) -> Any:
    try:
        return parse_json(text) if text else None
    except ValueError:
        return text
