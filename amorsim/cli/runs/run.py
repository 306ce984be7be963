"""``amorsim run``: simulate a scenario, or a map alone."""

from __future__ import annotations

import contextlib
import functools
import math
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amorsim.cli.console import compile_once, compile_planners_once, complain, say
from amorsim.cli.films import Force, Gif, GifRate, GifSize, GifSpeed, Mp4, Wanted, in_options
from amorsim.cli.options import Changes, Duration, Played, Resolution, Seed
from amorsim.core.execution.progress import progress_shown

if TYPE_CHECKING:
    from amorsim.runs.film import Film
    from amorsim.runs.session import RunSummary
    from amorsim.simulation.simulation import Simulation

__all__ = ["command"]

Progress = Callable[[float], None]


def command(
    scenario: Played,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Folder for the run's files, new or empty. [default: amorsim-runs/<name>-<number>]"
        ),
    ] = None,
    seed: Seed = None,
    duration: Duration = None,
    replicas: Annotated[
        int | None, typer.Option(metavar="N", help="How many replicas to simulate; each draws its own noise.")
    ] = None,
    threads: Annotated[
        int, typer.Option(metavar="N", help="How many threads share the work; pays from some hundreds of robots up.")
    ] = 1,
    replica: Annotated[
        list[int] | None,
        typer.Option(metavar="N", help="The number of one replica to simulate; may be given again."),
    ] = None,
    resolution: Resolution = None,
    changes: Changes = None,
    gif: Gif = None,
    mp4: Mp4 = None,
    gif_size: GifSize = Wanted.SIZE,
    gif_rate: GifRate = Wanted.RATE,
    gif_speed: GifSpeed = None,
    force: Force = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Simulate a scenario and write what happened into a folder.

    The folder holds the scenario with its map, text files of all that was true, measured and estimated, and a
    picture of the paths. Ctrl-C ends the run; its files are complete up to then.
    """
    from amorsim.controllers.navigate import Navigate
    from amorsim.core.errors import AmorsimError
    from amorsim.runs.folder import check_free
    from amorsim.runs.run import run as run_scenario
    from amorsim.runs.scenario_argument import look_up, make_simulation, read_scenario, with_options
    from amorsim.simulation.sources import source_lines

    if replicas is not None and replica:
        raise AmorsimError("--replicas and --replica exclude each other: the first counts them, the second names them")
    if replicas is not None and replicas < 1:
        raise AmorsimError(f"--replicas: expected a whole number > 0, got {replicas}")
    if quiet:
        warnings.simplefilter("ignore")
    check_free(out)
    wanted = Wanted(gif=gif, mp4=mp4, size=gif_size, rate=gif_rate, speed=gif_speed, force=force)
    wanted.check()
    compile_once(
        lambda: look_up(scenario, resolution=resolution, changes=changes or (), seed=seed, duration=duration), quiet
    )
    read = with_options(read_scenario(scenario, resolution=resolution, changes=changes or []), seed, duration)
    compile_planners_once(
        [robot.controller.planner for robot in read.robots if isinstance(robot.controller, Navigate)], quiet
    )
    numbers = list(replica) if replica else (1 if replicas is None else replicas)
    simulation, remark = make_simulation(read, numbers, threads)
    if not quiet:
        for warning in (*read.remarks, *read.map.warnings, *([remark] if remark else ())):
            complain(f"{read.map.name}: {warning}")
        for line in source_lines(read):
            say(line)
    films = []
    for kind, file in wanted.files.items():
        from amorsim.runs.film import Film

        with in_options():
            films.append(Film(simulation, file, read.duration, **wanted.settings(kind)))
    with _progress(quiet) as progress:
        on_step = functools.partial(_filmed, films, progress) if films else progress
        summary = run_scenario(simulation.scenario, out, progress=on_step, simulation=simulation)
    for film in films:
        film.save()
    if not quiet:
        _report(simulation, summary)
        for film in films:
            say(f"moving picture: {film.path}")
    if not summary.is_complete:
        raise typer.Exit(130)


def _filmed(films: list[Film], progress: Progress | None, share: float) -> None:
    for film in films:
        film.keep()
    if progress is not None:
        progress(share)


@contextlib.contextmanager
def _progress(quiet: bool) -> Iterator[Progress | None]:
    if quiet:
        yield None
    elif sys.stdout.isatty():
        with progress_shown(True, "simulating", float) as show:
            yield show
    else:
        yield _PlainProgress()


class _PlainProgress:
    """Lines in place of a bar, one every quarter, where there is no terminal."""

    def __init__(self) -> None:
        self._said = 0

    def __call__(self, share: float) -> None:
        quarter = int(4.0 * share)
        if self._said < quarter < 4:
            say(f"{25 * quarter} % simulated")
            self._said = quarter


def _all_together(summary: RunSummary, ended: int) -> str:
    """A summary of all robots, if there are too many for a line each."""
    distance, errors = summary.distance.values(), summary.final_error
    worst = max(errors, key=errors.__getitem__)
    rms = math.sqrt(math.fsum(error**2 for error in errors.values()) / len(errors))
    hits = sum(summary.collisions.values())
    who = sum(count > 0 for count in summary.collisions.values())
    stopped = f", which ended {ended} controllers" if ended else ""
    return (
        f"all {len(errors)} robots: drove {math.fsum(distance) / len(errors):.2f} m on the mean; "
        f"{hits or 'no'} collision{'' if hits == 1 else 's'}{f' of {who} robots' if hits > 1 else ''}{stopped}; "
        f"at the end estimates are off by {rms:.3f} m (root mean square), {worst}'s the most, by {errors[worst]:.3f} m"
    )


def _of_all_replicas(simulation: Simulation, names: list[str]) -> Iterator[str]:
    """A line for each of some robots, over all replicas."""
    numbers = simulation.replicas
    apart = (simulation.true_pose - simulation.estimated_pose).reshape(len(numbers), len(simulation.names), 3)
    for name in names:
        off = [math.hypot(x, y) for x, y in apart[:, simulation.names.index(name), :2].tolist()]
        rms = math.sqrt(math.fsum(error**2 for error in off) / len(off))
        worst = max(range(len(off)), key=off.__getitem__)
        hit = [event.replica for event in simulation.events if event.kind == "collision" and event.name == name]
        hits = "1 collision" if len(hit) == 1 else f"{len(hit) or 'no'} collisions"
        where = f" in {len(set(hit))} of them" if hit else ""
        yield (
            f"{name} (all {len(numbers)} replicas): {hits}{where}; at the end estimates are off by {rms:.3f} m (root "
            f"mean square), in replica {numbers[worst]} the most, by {off[worst]:.3f} m"
        )


def _report(simulation: Simulation, summary: RunSummary) -> None:
    time_ = summary.steps * simulation.dt
    if not summary.is_complete:
        say(f"interrupted after {time_:g} s of simulated time; the files are whole up to there")
    numbers = simulation.replicas
    of = f" (replica {numbers[0]} of {len(numbers)})" if len(numbers) > 1 else ""
    names = list(summary.distance)
    ended = {
        event.name: event.time
        for event in simulation.events
        if event.kind == "controller_ended" and event.replica == numbers[0]
    }
    driverless = {robot.name for robot in simulation.scenario.robots if robot.controller is None}
    for name in names[:5]:
        count = summary.collisions[name]
        hits = "no collision" if count == 0 else "1 collision" if count == 1 else f"{count} collisions"
        if name in ended:
            hits += f", which ended its controller at {ended[name]:.1f} s"
        idle = " (it has no controller)" if name in driverless else ""
        say(
            f"{name}{of}: drove {summary.distance[name]:.2f} m in {time_:g} s{idle}, {hits}; "
            f"at the end the estimate is off by {summary.final_error[name]:.3f} m"
        )
    if len(names) > 5:
        say(_all_together(summary, len(ended)))
    if len(numbers) > 1:
        for line in _of_all_replicas(simulation, names[:5]):
            say(line)
    if simulation.scenario.recording.sensors == "auto" and not (summary.folder / "sensors").exists():
        say("sensors are left out, because there are many replicas; --set recording.sensors=all writes them too")
    picture = summary.folder / "picture.png"
    say(f"results: {summary.folder}" + (f", picture: {picture}" if picture.exists() else ""))
