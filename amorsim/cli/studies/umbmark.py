"""``amorsim umbmark``: the bidirectional square, and the drive corrected by it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from amorsim.cli.console import say
from amorsim.cli.options import Changes, RobotName, Seed, Studied
from amorsim.cli.studies.study import check_out, claim_folder, draw, read_study, table
from amorsim.core.files.atomic_files import write_text

if TYPE_CHECKING:
    from amorsim.scenario.spec import Scenario
    from amorsim.studies.umbmark import Umbmark

__all__ = ["command"]

MODEL = "corrected.toml"
SCENARIO = "corrected-scenario.toml"
# What of a robot's table a model holds; the rest is about its place, its task and its true values.
_OF_MODEL = ("shape", "on_collision", "ground", "drive", "sensors", "estimators")


def command(
    scenario: Studied,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for the results. [default: amorsim-runs/<name>-umbmark-<number>]"),
    ] = None,
    robot: RobotName = None,
    side: Annotated[float, typer.Option(metavar="METRES", help="Side of the square.")] = 4.0,
    speed: Annotated[float, typer.Option(metavar="M/S", help="Speed of the robot, at most 0.2 m/s.")] = 0.2,
    runs: Annotated[int, typer.Option(metavar="N", help="Squares in each direction, at least two.")] = 5,
    in_its_world: Annotated[
        bool, typer.Option("--in-its-world", help="Drive on the scenario's map, from the robot's start.")
    ] = False,
    seed: Seed = None,
    changes: Changes = None,
) -> None:
    """Measure the systematic errors of a differential drive by squares in both directions, and correct them.

    This is UMBmark (Borenstein and Feng 1996). The robot drives by its odometry. From the true end of each square less
    the estimated one follow how unequal its wheels are (Ed) and how wrong its track is (Eb).
    """
    from amorsim.studies.umbmark import umbmark

    check_out(out)
    read = read_study(scenario, changes, seed)
    found = umbmark(read, robot=robot, side=side, speed=speed, runs=runs, in_its_world=in_its_world)
    say(_report(found))
    folder = claim_folder(out, read, "umbmark")
    _write(read, found, folder)
    path = folder / "umbmark.png"
    has_plot = draw(path, lambda plots: plots.plot_umbmark(found, path))
    name = found.robot
    say(
        f"\nthe corrected {name}: {folder / MODEL}, a model for any scenario (model = {str(folder / MODEL)!r})\n"
        f"the same robot in this scenario, its true drive as before: amorsim run {folder / SCENARIO}"
        + (
            f"\nend points: {folder / 'ends.csv'}, picture: {path}"
            if has_plot
            else f"\nend points: {folder / 'ends.csv'}"
        )
    )


def _report(found: Umbmark) -> str:
    runs = len(found.clockwise)
    parts = [
        f"{found.robot}: {runs} squares of {found.side:g} m each way at {found.speed:g} m/s; absolute less odometric "
        "end [m]"
    ]
    rows = []
    for number, (cw, ccw) in enumerate(zip(found.clockwise.tolist(), found.anticlockwise.tolist(), strict=True), 1):
        rows.append([str(number), *(f"{value:+.4f}" for value in (*cw, *ccw))])
    centres = (*found.clockwise.mean(axis=0).tolist(), *found.anticlockwise.mean(axis=0).tolist())
    rows.append(["centre", *(f"{value:+.4f}" for value in centres)])
    parts.append(table(["run", "cw x", "cw y", "ccw x", "ccw y"], rows))

    published, exact = found.published, found.exact
    rows = [
        [f"Borenstein and Feng, {label}", f"{f.alpha:+.6f}", f"{f.beta:+.6f}", f"{f.ed:.5f}", f"{f.eb:.5f}"]
        for label, f in (("x", published.x), ("y", published.y), ("mean", published.mean))
    ]
    rows.append(["exact least squares", "", "", f"{exact.ed.value:.5f}", f"{exact.eb.value:.5f}"])
    rows.append(["  95 % interval, from", "", "", f"{exact.ed.low:.5f}", f"{exact.eb.low:.5f}"])
    rows.append(["  to", "", "", f"{exact.ed.high:.5f}", f"{exact.eb.high:.5f}"])
    parts.append("\n" + table(["", "alpha [rad]", "beta [rad]", "Ed", "Eb"], rows))
    if exact.scatter == 0.0:
        parts.append("all runs are alike: nothing about this robot is random, and so the intervals have no width")

    rows = [
        [label, *(f"{value:.6f}" for value in geometry), f"{1000.0 * error:.2f}"]
        for label, geometry, error in (
            ("nominal", found.nominal, found.error_before),
            ("corrected, Borenstein and Feng", found.corrected_published, found.error_after_published),
            ("corrected, exact", found.corrected, found.error_after),
        )
    ]
    parts.append("\n" + table(["", "left radius [m]", "right radius [m]", "track [m]", "E_max,syst [mm]"], rows))
    return "\n".join(parts)


def _write(read: Scenario, found: Umbmark, folder: Path) -> None:
    from amorsim.scenario.files.write import table_text, with_copies
    from amorsim.studies.umbmark import corrected_scenario

    lines = ["parameters,direction,run,x,y"]
    for parameters, pair in (("nominal", (found.clockwise, found.anticlockwise)), ("corrected", found.after)):
        for direction, ends in zip(("clockwise", "anticlockwise"), pair, strict=True):
            lines += [f"{parameters},{direction},{i},{x:.6f},{y:.6f}" for i, (x, y) in enumerate(ends.tolist(), 1)]
    write_text(folder / "ends.csv", "\n".join(lines) + "\n")

    document = with_copies(corrected_scenario(read, found.robot, found.corrected), folder)
    for robot in document["robots"]:
        if robot["name"] == found.robot:
            model = {key: robot.pop(key) for key in _OF_MODEL if key in robot}
            robot.pop("resolved_from", None)
            rest = dict(robot)
            robot.clear()
            robot.update(name=rest.pop("name"), model=MODEL, **rest)
            write_text(folder / MODEL, _model_text(model, found))
    write_text(folder / SCENARIO, table_text(document))


def _model_text(model: dict[str, Any], found: Umbmark) -> str:
    """The model as a file of its own: the keys under a robot of a scenario, one level higher."""
    from amorsim.scenario.files.models import FORMAT
    from amorsim.scenario.files.write import table_text

    text = re.sub(r"^\[robots\.", "[", table_text({"robots": [model]}), flags=re.MULTILINE)
    exact = found.exact
    return (
        f"# {found.robot}, its drive corrected by UMBmark (amorsim umbmark):\n"
        f"# Ed = {exact.ed.value:.7f}, 95 % interval +- {exact.ed.half_width:.2g}\n"
        f"# Eb = {exact.eb.value:.7f}, 95 % interval +- {exact.eb.half_width:.2g}\n\n"
        f"format = {FORMAT}\n" + text.replace("[[robots]]\n", "", 1).lstrip("\n")
    )
