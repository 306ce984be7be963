"""``amorsim calibrate``: the errors of a gyro, a compass or a range sensor."""

from __future__ import annotations

import enum
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amorsim.cli.console import say
from amorsim.cli.options import Changes, RobotName, Seed, Studied
from amorsim.cli.studies.study import check_out, claim_folder, read_study, table
from amorsim.core.errors import AmorsimError
from amorsim.core.files.atomic_files import write_text
from amorsim.render.words import with_interval

if TYPE_CHECKING:
    from amorsim.algorithms.intervals import Interval
    from amorsim.scenario.spec import Scenario

__all__ = ["What", "command"]

# One quantity: its name, its unit, its interval.
Row = tuple[str, str, "Interval"]


class What(enum.StrEnum):
    """The kinds of sensor that can be calibrated."""

    gyro = "gyro"
    compass = "compass"
    range = "range"


def command(
    scenario: Studied,
    what: Annotated[
        What,
        typer.Option(
            help="gyro: bias and scale, on a turn table; compass: deviation A to E, turning in place; range: bias and "
            "standard deviation, before a wall."
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for the results. [default: amorsim-runs/<name>-<what>-<number>]"),
    ] = None,
    robot: RobotName = None,
    sensor: Annotated[
        str | None, typer.Option(metavar="NAME", help="Which sensor. [default: the first of that kind]")
    ] = None,
    element: Annotated[
        int | None,
        typer.Option(metavar="N", help="For range: which beam or transducer. [default: the one that looks ahead]"),
    ] = None,
    runs: Annotated[int, typer.Option(metavar="N", help="How many times the experiment is run, at least twice.")] = 10,
    seed: Seed = None,
    changes: Changes = None,
) -> None:
    """Find the errors of a gyro, a compass or a range sensor on a test bench, with their 95 % intervals."""
    check_out(out)
    if element is not None and what is not What.range:
        raise AmorsimError("--element is for --what range: a gyro and a compass have one value")
    read = read_study(scenario, changes, seed)
    title, rows = _measure(read, what, robot, sensor, element, runs)
    cells = [[name, unit, *with_interval(*found[:3])] for name, unit, found in rows]
    say(f"{title}; {runs} runs")
    say(table(["", "unit", "value", "95 % from", "to"], cells))
    folder = claim_folder(out, read, what.value)
    lines = ["quantity,unit,value,low,high"]
    lines += [f"{name},{unit},{v.value:.9g},{v.low:.9g},{v.high:.9g}" for name, unit, v in rows]
    path = folder / "calibration.csv"
    write_text(path, "\n".join(lines) + "\n")
    say(f"\nresults: {path}")


def _degrees(found: Interval) -> Interval:
    return type(found)(*map(math.degrees, found[:3]))


def _measure(
    read: Scenario, what: What, robot: str | None, sensor: str | None, element: int | None, runs: int
) -> tuple[str, list[Row]]:
    from amorsim.studies.calibration import calibrate_compass, calibrate_gyro, calibrate_range

    if what is What.gyro:
        name, found = calibrate_gyro(read, robot=robot, sensor=sensor, runs=runs)
        rows: list[Row] = [("bias", "deg/s", _degrees(found["bias"])), ("scale", "", found["scale"])]
        return f"{name}: measured = scale * true + bias, on a turn table", rows
    if what is What.compass:
        name, found = calibrate_compass(read, robot=robot, sensor=sensor, runs=runs)
        rows = [(key, "deg", _degrees(value)) for key, value in found.items()]
        return f"{name}: deviation a + b sin h + c cos h + d sin 2h + e cos 2h, turning in place", rows
    name, number, distances = calibrate_range(read, robot=robot, sensor=sensor, element=element, runs=runs)
    rows = []
    for at in distances:
        rows += [(f"bias at {at.distance:.3f} m", "m", at.bias), (f"sigma at {at.distance:.3f} m", "m", at.sigma)]
    lost = 1.0 - min(at.returned for at in distances)
    remark = f"; up to {100.0 * lost:.1f} % of the readings had no return" if lost > 0.0 else ""
    return f"{name}, element {number}, squarely before a wall{remark}", rows
