"""A run: a simulation with its recorders, and the folder it leaves behind."""

from __future__ import annotations

import json
import os
import platform
import sys
import time
from collections.abc import Callable, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Recorder, RunInfo
from amorsim.core.errors import RunError
from amorsim.core.poses import compose
from amorsim.plugins.manager import default_registry, run_finished, run_started
from amorsim.render.picture import RobotPath, draw_run
from amorsim.scenario.spec import Scenario
from amorsim.scenario.write import with_copies, write_document
from amorsim.simulation.simulation import Simulation

__all__ = ["RunSummary", "circumstances", "new_folder", "run"]

Array = npt.NDArray[np.float64]

SENSOR_FILES_UP_TO = 32  # replicas; beyond, sensors are written only if asked for
FORMAT = 1


@attrs.frozen(kw_only=True)
class RunSummary:
    """What happened in a run, and where its files lie."""

    folder: Path
    steps: int
    digests: dict[int, str]
    distance: dict[str, float]  # [m] driven by each robot, in the first replica
    final_error: dict[str, float]  # [m] between true and estimated position at the end
    collisions: dict[str, int]
    seconds: float  # of the clock on the wall
    is_complete: bool  # false if it was broken off


def new_folder(name: str, base: Path | None = None) -> Path:
    """The first free folder ``amorsim-runs/<name>-<number>`` under `base`, else under the present folder."""
    parent = (base or Path.cwd()) / "amorsim-runs"
    number = 1
    while (parent / f"{name}-{number:03d}").exists():
        number += 1
    return parent / f"{name}-{number:03d}"


def run(
    scenario: Scenario,
    folder: str | os.PathLike[str],
    *,
    seed: int | None = None,
    replicas: int | Sequence[int] = 1,
    duration: float | None = None,
    progress: Callable[[float], None] | None = None,
    simulation: Simulation | None = None,
) -> RunSummary:
    """Simulate `scenario` and write its files into `folder`, which must not exist or be empty.

    `progress` is called with the share done, between 0 and 1, ten times a second at most. Ctrl-C ends the run with
    its files whole, and the summary says that it is not complete.

    Raises
    ------
    RunError
        If the folder cannot be made or holds something.
    ScenarioError
        If the scenario cannot be simulated; nothing is written then.
    """
    if simulation is None:
        simulation = Simulation(scenario, seed=seed, replicas=replicas)
    path = Path(folder)
    _make_folder(path)
    duration = scenario.duration if duration is None else duration
    steps = simulation.steps_of(duration)
    about = _about(simulation, duration, steps)
    document = with_copies(attrs.evolve(scenario, seed=simulation.seed, duration=duration), path)
    write_document(document, path / "scenario.toml")
    _write_json(path / "run.json", about)
    wanted = scenario.recording.sensors
    many = len(simulation.replicas) > SENSOR_FILES_UP_TO
    info = RunInfo(
        folder=path,
        dt=simulation.dt,
        replicas=simulation.replicas,
        with_sensors=wanted == "all" or (wanted == "auto" and not many),
    )
    registry = default_registry()
    recorder: Recorder = registry.get("recorder", "text")()
    keeper = _Paths(simulation)
    run_started(simulation, registry)
    started = time.perf_counter()
    done = 0
    status = "broken off"
    try:
        recorder.open(info, simulation.frames())
        reported = 0.0
        known = len(simulation.events)
        for done in range(1, steps + 1):
            simulation.step()
            recorder.write(simulation.frames(), simulation.events[known:])
            known = len(simulation.events)
            keeper.keep()
            if progress is not None and (now := time.perf_counter()) - reported > 0.1:
                progress(done / steps)
                reported = now
        status = "finished"
    except KeyboardInterrupt:
        status = "interrupted"
    finally:
        recorder.close()
        summary = keeper.summary(path, done, time.perf_counter() - started, status == "finished")
        if scenario.recording.picture:
            draw_run(scenario.map, keeper.paths(), title=_title(scenario, simulation)).save(path / "picture.png")
        _write_json(path / "run.json", about | _outcome(summary, status))
        run_finished(simulation, registry)
    return summary


def _make_folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
        if any(path.iterdir()):
            raise RunError(f"{path}: the folder holds files already; name another one, or one that is not there yet")
        probe = path / "run.json"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise RunError(f"{path}: cannot make this folder for the run ({error.strerror or error})") from None


def circumstances() -> dict[str, Any]:
    """Versions and machine, on which the last bits of results may hang."""
    packages = ("numpy", "numba", "attrs", "shapely", "pillow")
    return {
        "amorsim": metadata.version("amorsim"),
        "python": sys.version.split()[0],
        "packages": {name: metadata.version(name) for name in packages},
        "plugins": {plugin.name: plugin.version for plugin in default_registry().plugins},
        "processor": platform.processor() or platform.machine(),
        "system": platform.system(),
    }


def _about(simulation: Simulation, duration: float, steps: int) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "status": "running",
        "seed": simulation.seed,
        "replicas": list(simulation.replicas),
        "dt": simulation.dt,
        "duration": duration,
        "steps": steps,
        **circumstances(),
    }


def _outcome(summary: RunSummary, status: str) -> dict[str, Any]:
    return {
        "status": status,
        "steps_done": summary.steps,
        "digests": {str(replica): digest for replica, digest in summary.digests.items()},
        "distance": summary.distance,
        "final_error": summary.final_error,
        "collisions": summary.collisions,
        "seconds": round(summary.seconds, 3),
    }


def _write_json(path: Path, content: dict[str, Any]) -> None:
    # Written beside and then moved over, so that it is whole at any moment.
    beside = path.with_suffix(".json.part")
    beside.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    beside.replace(path)


def _title(scenario: Scenario, simulation: Simulation) -> str:
    name = scenario.source.stem if scenario.source else scenario.map.name
    return f"{name} · seed {simulation.seed}" if name else f"seed {simulation.seed}"


class _Paths:
    """Keeps the paths of the first replica's robots, for the picture and the summary."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._count = len(simulation.names)
        self._true: list[Array] = []
        self._estimated: list[Array] = []
        self.keep()

    def keep(self) -> None:
        self._true.append(self._simulation.true_pose[: self._count])
        self._estimated.append(self._simulation.estimated_pose[: self._count])

    def _collisions(self, name: str) -> list[tuple[float, float]]:
        first = self._simulation.replicas[0]
        return [
            event.point
            for event in self._simulation.events
            if event.kind == "collision" and event.name == name and event.replica == first and event.point
        ]

    def paths(self) -> list[RobotPath]:
        true, estimated = np.array(self._true), np.array(self._estimated)
        found = []
        for i, name in enumerate(self._simulation.names):
            outline = next(r.shape for r in self._simulation.scenario.robots if r.name == name).outline
            points = np.column_stack((outline, np.zeros(len(outline))))
            placed = compose(np.repeat(true[-1:, i], len(points), axis=0), points)[:, :2]
            found.append(
                RobotPath(
                    name=name,
                    true=true[:, i, :2],
                    estimated=estimated[:, i, :2],
                    outline=placed,
                    collisions=np.array(self._collisions(name)).reshape(-1, 2),
                )
            )
        return found

    def summary(self, folder: Path, steps: int, seconds: float, is_complete: bool) -> RunSummary:
        simulation = self._simulation
        true, estimated = np.array(self._true)[:, :, :2], np.array(self._estimated)[:, :, :2]
        steps_driven = np.linalg.norm(np.diff(true, axis=0), axis=2).sum(axis=0)
        error = np.linalg.norm(true[-1] - estimated[-1], axis=1)
        names = simulation.names
        return RunSummary(
            folder=folder,
            steps=steps,
            digests={replica: simulation.digest(replica) for replica in simulation.replicas},
            distance={name: float(steps_driven[i]) for i, name in enumerate(names)},
            final_error={name: float(error[i]) for i, name in enumerate(names)},
            collisions={name: len(self._collisions(name)) for name in names},
            seconds=seconds,
            is_complete=is_complete,
        )
