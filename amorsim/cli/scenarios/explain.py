"""``amorsim explain-errors``: the effect of each error of a robot on its odometry."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amorsim.cli.console import say
from amorsim.cli.options import Changes, RobotName, Seed, Studied
from amorsim.cli.studies.study import check_out, claim_folder, draw, read_study, table
from amorsim.core.files.atomic_files import write_text
from amorsim.render.words import percent, significant

if TYPE_CHECKING:
    from amorsim.scenario.spec import Scenario
    from amorsim.studies.attribution import Attribution

__all__ = ["command"]


def command(
    scenario: Studied,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for the results. [default: amorsim-runs/<name>-errors-<number>]"),
    ] = None,
    robot: RobotName = None,
    sensor: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Explain the readings of this sensor, in place of odometry."),
    ] = None,
    replicas: Annotated[int, typer.Option(metavar="N", help="How often what is random is drawn.")] = 20,
    seed: Seed = None,
    changes: Changes = None,
) -> None:
    """Show the effect of each error on odometry, or on a sensor's readings: each alone, and all together.

    For odometry, the errors are the entries of the robot's errors and the elements of its ground and of its encoder's
    noise. For a sensor, they are the entries of the robot's errors that concern it and the elements of its noise. Each
    error draws the same numbers alone and together with the others, so the shares add up.
    """
    from amorsim.studies.attribution import attribute_errors

    check_out(out)
    read = read_study(scenario, changes, seed)
    if sensor is not None:
        _explain_readings(read, sensor, robot, replicas, out)
        return
    found = attribute_errors(read, robot=robot, replicas=replicas)
    say(_report(found, replicas))
    folder = claim_folder(out, read, "errors")
    lines = ["error,replica,ahead,left"]
    for case in (*found.cases, found.together):
        lines += [f"{case.name},{i},{x:.6f},{y:.6f}" for i, (x, y) in enumerate(case.errors.tolist())]
    write_text(folder / "final-errors.csv", "\n".join(lines) + "\n")
    path = folder / "errors.png"
    has_plot = draw(path, lambda plots: plots.plot_attribution(found, path))
    say(f"\nfinal errors: {folder / 'final-errors.csv'}" + (f", picture: {path}" if has_plot else ""))


def _explain_readings(scenario: Scenario, sensor: str, robot: str | None, replicas: int, out: Path | None) -> None:
    from amorsim.studies.reading_attribution import attribute_readings

    found = attribute_readings(scenario, sensor, robot=robot, replicas=replicas)
    # What a user reads of angles is in degrees.
    scale = math.degrees(1.0) if found.unit.startswith("rad") else 1.0
    unit = found.unit.replace("rad", "deg")
    cases = (*found.cases, found.together)
    rows = [[case.name, significant(scale * case.error), percent(case.share), percent(case.changed)] for case in cases]
    rows.insert(-1, ["interaction", "", percent(found.interaction), ""])
    say(f"{found.robot}, {sensor}: error of a value, root mean square over all readings of {replicas} replicas")
    lines = table(["error", f"alone [{unit}]", "share", "returns lost or made up"], rows).splitlines()
    say("\n".join(line.rstrip() for line in lines))
    folder = claim_folder(out, scenario, "errors")
    lines = ["time," + ",".join(case.name for case in cases)]
    for i, time in enumerate(found.time.tolist()):
        lines.append(f"{time:.6f}," + ",".join(f"{case.by_step[i]:.6g}" for case in cases))
    write_text(folder / "reading-errors.csv", "\n".join(lines) + "\n")
    path = folder / "errors.png"
    has_plot = draw(path, lambda plots: plots.plot_readings(found, path))
    say(f"\nerrors by step: {folder / 'reading-errors.csv'}" + (f", picture: {path}" if has_plot else ""))


def _report(found: Attribution, replicas: int) -> str:
    rows = [[case.name, significant(case.error), percent(case.share)] for case in found.cases]
    rows.append(["interaction", "", percent(found.interaction)])
    rows.append([found.together.name, significant(found.together.error), "100.0 %"])
    lines = [
        f"{found.robot}: final error of dead reckoning, root mean square over {replicas} replicas",
        table(["error", "alone [m]", "share"], rows),
    ]
    if found.left_out:
        lines.append(f"no part in odometry: {', '.join(found.left_out)}; --sensor NAME explains a sensor's readings")
    return "\n".join(lines)
