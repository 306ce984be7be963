"""``amorsim run``: simulate a scenario, or a map alone."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amorsim.cli.console import complain, say

if TYPE_CHECKING:
    from amorsim.scenario.spec import Scenario
    from amorsim.simulation.run import RunSummary

__all__ = ["command"]

Progress = Callable[[float], None]


def command(
    scenario: Annotated[
        str,
        typer.Argument(
            help="A scenario file (.toml), the name of a bundled scenario (such as demo), or a map alone (such as "
            "lab.wld or plan.bmp), in which a Pioneer 2DX then wanders."
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the run's files, new or empty. [default: amorsim-runs/<name>-<number>]"),
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of all random draws, in place of the scenario's.")] = None,
    duration: Annotated[
        float | None, typer.Option(help="Simulated time in seconds, in place of the scenario's.")
    ] = None,
    replicas: Annotated[
        int | None, typer.Option(help="How many replicas to simulate, each with its own draws.")
    ] = None,
    replica: Annotated[
        list[int] | None, typer.Option(help="The number of one replica to simulate; may be given again.")
    ] = None,
    resolution: Annotated[
        float | None, typer.Option(help="For a map alone: the side of a cell (of a pixel) in metres.")
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Change a value of the scenario, as in robots.0.errors.drive.track.scale=1.02; may be given again.",
        ),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Simulate a scenario and write what happened into a folder.

    The folder holds the scenario with its map, text files of all that was true, measured and estimated, and a
    picture of the paths.
    """
    from amorsim.cli.scenarios import read_scenario
    from amorsim.core.errors import AmorsimError
    from amorsim.simulation.run import new_folder
    from amorsim.simulation.run import run as run_scenario
    from amorsim.simulation.simulation import Simulation

    if replicas is not None and replica:
        raise AmorsimError("--replicas and --replica exclude each other: the first counts them, the second names them")
    if duration is not None and not 0.0 < duration < float("inf"):
        raise AmorsimError(f"--duration: expected a number of seconds > 0, got {duration}")
    read = read_scenario(scenario, resolution=resolution, changes=changes or [])
    if not quiet:
        for warning in read.map.warnings:
            complain(f"{read.map.name}: {warning}")
    numbers = list(replica) if replica else (1 if replicas is None else replicas)
    with _announce_compiling(quiet):
        simulation = Simulation(read, seed=seed, replicas=numbers)
    name = read.source.stem if read.source else Path(scenario).stem
    folder = out or new_folder(name)
    with _bar(quiet) as progress:
        summary = run_scenario(read, folder, duration=duration, progress=progress, simulation=simulation)
    if not quiet:
        _report(read, summary)
    if not summary.is_complete:
        raise typer.Exit(130)


@contextlib.contextmanager
def _announce_compiling(quiet: bool) -> Iterator[None]:
    from amorsim.kernels.compile import is_cold

    if is_cold() and not quiet:
        say("compiling the kernels, once after installing (some ten seconds) ...")
    yield


@contextlib.contextmanager
def _bar(quiet: bool) -> Iterator[Progress | None]:
    if quiet:
        yield None
    elif sys.stdout.isatty():
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        columns = (TextColumn("simulating"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
        with Progress(*columns, transient=True) as bar:
            task = bar.add_task("simulating", total=1.0)
            yield lambda share: bar.update(task, completed=share)
    else:
        yield _PlainProgress()


class _PlainProgress:
    """Lines in place of a bar, one every quarter, where there is no terminal."""

    def __init__(self) -> None:
        self._next = 0.25

    def __call__(self, share: float) -> None:
        if share >= self._next:
            say(f"{int(self._next * 100)} % simulated")
            self._next = (share // 0.25 + 1) * 0.25


def _report(scenario: Scenario, summary: RunSummary) -> None:
    time = summary.steps * scenario.dt
    if not summary.is_complete:
        say(f"interrupted after {time:g} s of simulated time; the files are whole up to there")
    names = list(summary.distance)
    for name in names[:5]:
        count = summary.collisions[name]
        hits = "no collision" if count == 0 else "1 collision" if count == 1 else f"{count} collisions"
        say(
            f"{name}: drove {summary.distance[name]:.2f} m in {time:g} s, {hits}; "
            f"at the end the estimate is off by {summary.final_error[name]:.3f} m"
        )
    if len(names) > 5:
        say(f"... and {len(names) - 5} robots more")
    picture = summary.folder / "picture.png"
    say(f"results: {summary.folder}" + (f", picture: {picture}" if picture.exists() else ""))
