"""A recorded run as a film, GIF or MP4: the one that `run` makes, from the run's files; nothing is simulated."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from amorsim.array_types import Array
from amorsim.core.errors import RunError
from amorsim.core.unknown_names import no_such
from amorsim.runs.manifest import read_about
from amorsim.runs.video_writer import Reel, shown_bodies
from amorsim.scenario.spec import Obstacle, Robot
from amorsim.ui.simulator.sources.recorded import RecordedFiles
from amorsim.ui.simulator.sources.recorded_scene import RecordedScene

__all__ = ["film_recorded"]


def film_recorded(
    folder: Path,
    path: Path,
    *,
    replica: int | None = None,
    size: int = 480,
    rate: float = 10.0,
    speed: float | None = None,
    kind: str = "gif",
    noted: Callable[[str], None] | None = None,
) -> None:
    """Make the film of a recorded run, of one replica, up to where its files end.

    Where a line is damaged, a body is drawn where it was last.

    Parameters
    ----------
    folder
        Of the run.
    path
        Of the film.
    replica
        Its number; without it, the first.
    size, rate, speed, kind
        As of `Reel`, whose errors it raises.
    noted
        Called with each problem that is met in the files.

    Raises
    ------
    RunError
        If it is not the folder of a run, has no such replica, or ``run.json``, ``scenario.toml`` or ``poses.csv``
        cannot be read.
    """
    about = read_about(folder, needs_truth=False)
    replicas: list[int] = about["replicas"]
    replica = replicas[0] if replica is None else replica
    if replica not in replicas:
        raise RunError(f"{folder}: {no_such('replica', replica, replicas)}")
    dt = float(about["dt"])
    problems: list[str] = []
    files = RecordedFiles(folder, dt, replicas, problems.append if noted is None else noted)
    try:
        files.replica = replica
        scenes = RecordedScene(folder, about, files)
        scenes.build(replica)
        partial, last = scenes.partial, files.last_tick
        assert partial.map is not None  # or build() had raised
        robots = sorted(partial.robots, key=lambda robot: robot.name)
        obstacles = sorted(partial.obstacles, key=lambda obstacle: obstacle.name)
        bodies: list[Robot | Obstacle] = [*robots, *obstacles]  # in the order in which a simulation has them
        parts = [(robot.name, part) for robot in robots for part in robot.drive.parts]
        shown = shown_bodies(
            [(body.name, body.shape) for body in bodies],
            [(name, part.shape) for name, part in parts],
            partial.robots,
            partial.obstacles,
        )
        reel = Reel(
            partial.map,
            shown,
            partial.floor.patches,
            path=path,
            dt=dt,
            duration=float(about.get("duration", last * dt)),
            size=size,
            rate=rate,
            speed=speed,
            kind=kind,
        )
        names = [*(body.name for body in bodies), *(f"{name}.{part.name}" for name, part in parts)]
        ticks = range(0, last + 1, reel.every)
        which = slice(3, 6) if "log" in about else slice(0, 3)  # estimated where nothing true is known
        for tick, poses in zip(ticks, _poses(files, ticks, names, which, has_parts=bool(parts)), strict=True):
            reel.add(tick * dt, poses)
    finally:
        files.close()
    reel.save()


def _poses(
    files: RecordedFiles, ticks: Iterable[int], names: Sequence[str], which: slice, *, has_parts: bool
) -> Iterator[Array]:
    """Where bodies are at some ticks `(B, 3)` each; nan for a body without a pose until then.

    `which` chooses the robots' true or estimated poses.
    """
    nothing = np.full(3, np.nan)
    last: dict[str, Array] = {}
    for tick in ticks:
        robots = {name: pose[which] for name, pose in files.poses(tick).items()}
        found = robots | files.obstacles(tick) | (files.parts(tick) if has_parts else {})
        last |= {name: pose for name, pose in found.items() if np.isfinite(pose).all()}
        yield np.array([last.get(name, nothing) for name in names])
