"""``amorsim check``: every fault of a scenario at once."""

from __future__ import annotations

from typing import Annotated

import typer

from amorsim.cli.console import complain, say

__all__ = ["command"]


def command(
    scenario: Annotated[
        str,
        typer.Argument(metavar="SCENARIO", help="A scenario file (.toml), the name of a bundled one, or a map alone."),
    ],
    resolved: Annotated[
        bool, typer.Option("--resolved", help="Print the scenario with its models and all defaults filled in.")
    ] = False,
    resolution: Annotated[
        float | None,
        typer.Option(metavar="METRES", help="For a map alone: the side of a cell (of a picture: of a pixel)."),
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a value first, as `amorsim run` does."),
    ] = None,
) -> None:
    """Report all that is wrong with a scenario: file, key, value, and what would be right.

    The exit status is 0 if it would run, else 2.
    """
    from amorsim.core.errors import AmorsimError, ScenarioError
    from amorsim.runs.asked import make_simulation, read_scenario
    from amorsim.runs.session import steps_of
    from amorsim.simulation.advice import advice

    try:
        read = read_scenario(scenario, resolution=resolution, changes=changes or [])
        simulation, remark = make_simulation(read)
        steps_of(simulation, read.duration)
    except AmorsimError as error:
        faults = error.faults if isinstance(error, ScenarioError) else (error,)
        for fault in faults:
            complain(str(fault))
        complain(f"{len(faults)} fault{'s' if len(faults) > 1 else ''} found")
        raise typer.Exit(2) from None
    found = (*read.map.warnings, *([remark] if remark else ()))
    for line in (*(f"{read.map.name}: {warning}" for warning in found), *advice(read)):
        complain(f"warning: {line}")
    if resolved:
        from amorsim.scenario.write import document_of, document_text

        say(document_text(document_of(simulation.scenario)).rstrip())
    else:
        width, height = read.map.size
        how_many = "1 robot" if len(read.robots) == 1 else f"{len(read.robots)} robots"
        robots = ", ".join(robot.name for robot in read.robots[:8]) + (" ..." if len(read.robots) > 8 else "")
        say(f"{scenario}: no faults; {width:.2f} m x {height:.2f} m, {how_many} ({robots})")
