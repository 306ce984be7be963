"""Recording a simulation that `run` steps, or a script that drives by hand."""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Any

import attrs

from amorsim.contracts import Recorder, RunInfo
from amorsim.core.arguments import checked
from amorsim.core.display import in_notebook
from amorsim.core.error_text import in_words
from amorsim.core.errors import RunError
from amorsim.core.files.atomic_files import write_bytes
from amorsim.core.user_code import go_back, present_folder
from amorsim.plugins.manager import default_registry, run_finished, run_started
from amorsim.render.picture import draw_run
from amorsim.runs.estimated_maps import write_estimated_maps
from amorsim.runs.folder import ABOUT, FORMAT, RunFolder, circumstances, fingerprints, last_time
from amorsim.runs.recorder_calls import ask, fresh
from amorsim.runs.traces import Traces, collisions_of
from amorsim.runs.world_digests import fingerprints_of_worlds
from amorsim.scenario.files.write import resolved_table, with_copies, write_table
from amorsim.scenario.spec import Scenario
from amorsim.simulation.handle import finite_numbers
from amorsim.simulation.simulation import MOST_STEPS, Simulation

__all__ = ["RunSession", "RunSummary", "record", "run_name", "steps_of"]

SENSOR_FILES_UP_TO = 32  # replicas; beyond, sensors are written only if asked for


@attrs.frozen(kw_only=True)
class RunSummary:
    """The outcome of a run, and where its files lie."""

    folder: Path
    steps: int
    digests: dict[int, str]  # by replica; empty if the run broke off in the middle of a step
    distance: dict[str, float]  # [m] driven by each robot, in the first replica
    final_error: dict[str, float]  # [m] between true and estimated position at the end
    collisions: dict[str, int]
    seconds: float  # of wall time
    is_complete: bool  # false if it was broken off

    _repr_mimebundle_ = in_notebook


def record(
    simulation: Simulation, folder: str | os.PathLike[str] | None = None, *, duration: float | None = None
) -> RunSession:
    """Record a simulation that you step yourself; it must not have been stepped yet.

    ::

        with am.record(simulation, "by-hand") as session:
            for _ in range(100):
                simulation.robot("rover").drive(forward=0.3)
                simulation.step()
                session.keep()
        print(session.summary.distance)

    The folder is one like that of `run`, and reproduces too: commands given by hand, `Simulation.set` and
    `Simulation.set_pose` are written down and given again.

    Parameters
    ----------
    simulation
        At its start; changes may have been made to it.
    folder
        New or empty; without it, ``amorsim-runs/<scenario>-<number>``.
    duration
        How long it is meant to last [s], for ``run.json`` and ``scenario.toml``; without it, the scenario's.

    Raises
    ------
    RunError
        If the simulation has been stepped, or the folder cannot be made or holds something.
    ScenarioError
        If a file cannot name something in the scenario; nothing is written then.
    """
    return RunSession(simulation, folder, duration=duration)


@checked
class RunSession:
    """A run that is being recorded, made by `record`. As a context manager it closes itself.

    Attributes
    ----------
    folder
        Folder of the files.
    steps
        Number of steps written.
    """

    def __init__(
        self,
        simulation: Simulation,
        folder: str | os.PathLike[str] | None = None,
        *,
        duration: float | None = None,
        wanted_steps: int | None = None,
        is_kept: bool = True,
    ) -> None:
        scenario = simulation.scenario
        if simulation.ticks.any() or simulation._fleet.episodes.any():
            raise RunError("only a simulation in which no step was made can be recorded; make a new one")
        duration = scenario.duration if duration is None else duration
        planned = steps_of(simulation, duration) if wanted_steps is None else int(wanted_steps)
        scenario = attrs.evolve(scenario, seed=simulation.seed, duration=duration)
        resolved_table(scenario, maps_in_files=False)  # complains before there is a folder
        self.steps = 0
        self._is_kept = is_kept  # or else the folder is soon removed, and errors do not mention its content
        self._simulation = simulation
        self._scenario = scenario
        self._summary: RunSummary | None = None
        self._has_lost_lines = False  # whether text files end before the simulation did
        self._process, self._here = os.getpid(), present_folder()
        self._events = 0  # number of the simulation's events that have been written
        self._starts = simulation._starts
        self._started = time.perf_counter()
        self._registry = default_registry()
        # Each run has recorders of its own, because they hold files.
        self._recorders: list[Recorder] = [
            self._registry.get("recorder", "text")(),
            *(fresh(recorder) for recorder in scenario.recording.also),
        ]
        self._about: dict[str, Any] = {
            "format": FORMAT,
            "status": "running",
            "seed": simulation.seed,
            "replicas": list(simulation.replicas),
            "dt": simulation.dt,
            "duration": duration,
            "steps": planned,
            "inputs": {},
            "changes_before": len(simulation.events),
            **fingerprints_of_worlds(simulation),
            **circumstances(),
        }
        self._folder = RunFolder(folder, run_name(scenario), self._about)
        self.folder = self._folder.path
        try:
            self._open()
        except BaseException:
            self.give_up()
            raise

    def _open(self) -> None:
        simulation = self._simulation
        write_table(with_copies(self._scenario, self.folder), self.folder / "scenario.toml")
        files = (path.relative_to(self.folder).as_posix() for path in self.folder.rglob("*") if path.is_file())
        self._about["inputs"] = fingerprints(self.folder, sorted(name for name in files if name != ABOUT))
        self._folder.write_about(self._about)
        self._folder.set_room_aside(_most_bytes(simulation))
        wanted = self._scenario.recording.sensors
        many = len(simulation.replicas) > SENSOR_FILES_UP_TO
        self._with_sensors = wanted == "all" or (wanted == "auto" and not many)
        info = RunInfo(
            folder=self.folder, dt=simulation.dt, replicas=simulation.replicas, with_sensors=self._with_sensors
        )
        for recorder in self._recorders:
            ask(recorder, "open", info, simulation.frames())
            ask(recorder, "write_obstacles", simulation.obstacle_frames())
        self._traces = Traces(simulation)
        run_started(simulation, self._registry)

    def keep(self) -> None:
        """Write down the step that was just made.

        Raises
        ------
        RunError
            If not exactly one step was made since the last, or a file cannot be written.
        """
        simulation = self._simulation
        self._expect_original()
        if self._summary is not None:
            raise RunError(f"{self.folder}: this run has been closed")
        ticks = simulation._fleet.ticks
        # In most runs the first comparison is enough, and comparing arrays takes longer.
        if ticks[0] != self.steps + 1 or (len(ticks) > 1 and (ticks != self.steps + 1).any()):
            raise RunError(
                f"{self.folder}: expected one step after tick {self.steps}, the last that was kept, got tick "
                f"{', '.join(map(str, sorted(set(ticks.tolist()))[:5]))}; call keep() after every step"
            )
        if simulation._starts != self._starts:
            raise RunError(
                f"{self.folder}: the simulation was reset or restored while it was recorded, which no file can say; "
                "record each episode into a folder of its own, of a new simulation"
            )
        events = simulation.events
        frames, obstacles = simulation.frames(), simulation.obstacle_frames()
        for recorder in self._recorders:
            ask(recorder, "write", frames, events[self._events :])
            ask(recorder, "write_obstacles", obstacles)
        self._events = len(events)
        self._traces.keep(frames)
        self.steps += 1

    @property
    def summary(self) -> RunSummary:
        """The summary of the run; available once the session is closed.

        Raises
        ------
        RunError
            If it is still open.
        """
        if self._summary is None:
            raise RunError(f"{self.folder}: this run has not been closed yet")
        return self._summary

    def close(self, status: str = "finished") -> RunSummary:
        """Close the files, draw the picture, and write how the run ended into ``run.json``."""
        if self._summary is not None:
            return self._summary
        self._expect_original()
        go_back(self._here, "a controller or plugin")
        try:
            self._close_recorders()
        except Exception as error:
            try:
                self._end("broken off", str(error))
            except RunError as second:
                error.add_note(str(second))
            self._note_files(error)
            raise
        self._end(status)
        if self._scenario.recording.picture:
            picture = draw_run(
                self._simulation.map_of(self._simulation.replicas[0]),
                self._traces.paths(),
                zones=[zone.outline for zone in self._scenario.zones],
                patches=self._scenario.floor.patches,
                things=self._traces.things(),
                title=self._title(),
            )
            drawn = io.BytesIO()
            picture.save(drawn, "PNG")
            write_bytes(self.folder / "picture.png", drawn.getvalue())
        write_estimated_maps(self._simulation, self.folder)
        run_finished(self._simulation, self._registry)
        return self.summary

    def _expect_original(self) -> None:
        """End this process if it is a copy forked by a user's code: it would write into the same files."""
        if os.getpid() != self._process:
            sys.stderr.write(
                f"{self.folder}: a controller or plugin forked the process of this run; the copy ends here, and writes "
                "nothing. Start other programs with subprocess, and end a copy with os._exit\n"
            )
            sys.stderr.flush()
            os._exit(1)

    def _close_recorders(self) -> None:
        """Close each, also after another failed; the first failure is raised."""
        problem: Exception | None = None
        for place, recorder in enumerate(self._recorders):
            try:
                ask(recorder, "close")
            except Exception as error:
                self._has_lost_lines |= place == 0  # of the text files
                problem = problem or error
        if problem is not None:
            raise problem

    def _end(self, status: str, problem: str = "") -> None:
        """Write how the run ended, and what went wrong with its files."""
        simulation, steps = self._simulation, self.steps
        if self._has_lost_lines:
            steps = min(steps, round(last_time(self.folder) / simulation.dt))
        # After lost lines, or an error in the middle of a step, a second run has nothing to be compared with.
        is_whole = not self._has_lost_lines and not (simulation.ticks != self.steps).any()
        self._summary = self._sum_up(status, steps, is_whole=is_whole)
        outcome = _outcome(self._summary, status) | ({"problem": problem} if problem else {})
        self._folder.write_end(self._about | outcome)

    def _sum_up(self, status: str, steps: int, *, is_whole: bool) -> RunSummary:
        simulation = self._simulation
        names, first = simulation.names, simulation.replicas[0]
        return RunSummary(
            folder=self.folder,
            steps=steps,
            digests={replica: simulation.digest(replica) for replica in simulation.replicas} if is_whole else {},
            distance=dict(zip(names, self._traces.distance.tolist(), strict=True)),
            final_error=dict(zip(names, self._traces.errors().tolist(), strict=True)),
            collisions={name: len(collisions_of(simulation, name, first)) for name in names},
            seconds=time.perf_counter() - self._started,
            is_complete=status == "finished",
        )

    def _title(self) -> str:
        return f"{run_name(self._scenario)} · seed {self._simulation.seed}"

    def __enter__(self) -> RunSession:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
            return
        assert error is not None
        if self.steps == 0:  # nothing but the start: a mistake, rather than a run
            self.give_up()
            return
        try:
            self.close("interrupted" if issubclass(kind, KeyboardInterrupt) else "broken off")
        except RunError as second:
            if str(second) != str(error):  # the first one has the reason
                error.add_note(str(second))
        self._note_files(error)

    def _note_files(self, error: BaseException) -> None:
        """Let an error state once how far the files go."""
        if self._is_kept and self._files_reach() not in getattr(error, "__notes__", ()):
            error.add_note(self._files_reach())

    def _files_reach(self) -> str:
        """The time of the files' last lines, in words."""
        dt = self._simulation.dt
        if self._has_lost_lines and self._summary is not None:
            end = self._summary.steps * dt
            return (
                f"the files in {self.folder} end early, the first of them at {end:g} s, though {self.steps * dt:g} s "
                "were simulated"
            )
        return f"the files up to {self.steps * dt:g} s are in {self.folder}"

    def give_up(self) -> None:
        """Remove the folder again: for a run in which nothing happened."""
        self._expect_original()
        go_back(self._here, "a controller or plugin")
        with contextlib.suppress(Exception):  # the earlier error is the one to report
            self._close_recorders()
        self._folder.give_back()


def run_name(scenario: Scenario) -> str:
    """The name of a scenario in titles and folders: that of its file, or else of its map."""
    return scenario.source.stem if scenario.source else scenario.map.name or "run"


def steps_of(simulation: Simulation, duration: float) -> int:
    """Number of steps of a run of `duration` [s].

    Raises
    ------
    RunError
        If they are more than can be counted.
    """
    numbers = finite_numbers((duration,))
    if numbers is None or not 0.0 < numbers[0] / simulation.dt <= MOST_STEPS:
        raise RunError(
            f"duration: expected a number of seconds > 0 and <= {MOST_STEPS * simulation.dt:g} "
            f"(2^32 - 1 steps of {simulation.dt:g} s), got {in_words(duration)}"
        )
    return simulation.steps_of(numbers[0])


def _most_bytes(simulation: Simulation) -> int:
    """Largest size of ``run.json`` [bytes] at the end: numbers for each robot, and a digest for each replica."""
    names = sum(len(json.dumps(name)) for name in simulation.names)
    return 65536 + 3 * names + 120 * len(simulation.names) + 200 * len(simulation.replicas)


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
