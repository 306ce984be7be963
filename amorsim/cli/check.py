"""``amorsim check``: every fault of a scenario at once."""

from __future__ import annotations

from typing import Annotated

import typer

from amorsim.cli.console import complain, say

__all__ = ["command"]


def command(
    scenario: Annotated[str, typer.Argument(help="A scenario file, the name of a bundled one, or a map alone.")],
    resolved: Annotated[
        bool, typer.Option("--resolved", help="Print the scenario with its models and all defaults filled in.")
    ] = False,
    resolution: Annotated[
        float | None, typer.Option(help="For a map alone: the side of a cell (of a pixel) in metres.")
    ] = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a value first, as `run` does.")
    ] = None,
) -> None:
    """Report all that is wrong with a scenario: file, key, value, and what would be right.

    The exit status is 0 if it would run, else 2.
    """
    from amorsim.cli.scenarios import read_scenario
    from amorsim.core.errors import ScenarioError
    from amorsim.simulation.advice import advice
    from amorsim.simulation.simulation import Simulation

    try:
        read = read_scenario(scenario, resolution=resolution, changes=changes or [])
        Simulation(read)
    except ScenarioError as error:
        for fault in error.faults:
            complain(str(fault))
        count = len(error.faults)
        complain(f"{count} fault{'s' if count > 1 else ''} found")
        raise typer.Exit(2) from None
    for line in (*(f"{read.map.name}: {warning}" for warning in read.map.warnings), *advice(read)):
        complain(f"warning: {line}")
    if resolved:
        from amorsim.scenario.write import document_of, document_text

        say(document_text(document_of(read)).rstrip())
    else:
        width, height = read.map.size
        how_many = "1 robot" if len(read.robots) == 1 else f"{len(read.robots)} robots"
        robots = ", ".join(robot.name for robot in read.robots[:8]) + (" ..." if len(read.robots) > 8 else "")
        say(f"{scenario}: no faults; {width:.2f} m x {height:.2f} m, {how_many} ({robots})")
