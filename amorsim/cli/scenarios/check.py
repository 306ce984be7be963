"""``amorsim check``: every fault of a scenario at once."""

from __future__ import annotations

from typing import Annotated

import typer

from amorsim.cli.console import complain, say
from amorsim.cli.options import Changes, Resolution

__all__ = ["command"]


def command(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO",
            help="A scenario file (.toml), the name of a bundled one, a map alone, or a robot's model (.toml).",
        ),
    ],
    resolved: Annotated[
        bool, typer.Option("--resolved", help="Print the scenario with its models and all defaults filled in.")
    ] = False,
    schedule: Annotated[bool, typer.Option("--schedule", help="Print the calls that make a step, in order.")] = False,
    resolution: Resolution = None,
    changes: Changes = None,
    time_limit: Annotated[
        float,
        typer.Option(metavar="SECONDS", help="How long each component in a file of yours may take to be loaded."),
    ] = 10.0,
) -> None:
    """Report all faults of a scenario or a robot's model: file, key, value, and what would be right.

    Components in files of your own are loaded in another process, which is ended after the time limit. The exit
    status is 0 if the scenario would run, else 2.
    """
    from amorsim.core.error_text import explain
    from amorsim.core.errors import AmorsimError, Fault, ScenarioError
    from amorsim.core.parameters import ParameterError
    from amorsim.runs.scenario_argument import make_simulation, read_scenario
    from amorsim.runs.session import steps_of
    from amorsim.scenario.programs.code_check import check_code, check_time_limit
    from amorsim.scenario.programs.programs import without_programs
    from amorsim.scenario.reading.read import is_model, scenario_for_model
    from amorsim.simulation.lint import advice
    from amorsim.simulation.sources import source_lines

    try:
        check_time_limit(time_limit)
    except ParameterError as error:
        raise AmorsimError(f"--time-limit: {error.problem}") from None
    read = None
    of_code: tuple[Fault, ...] = ()
    try:
        of_model = is_model(scenario)
        if of_model:
            read = scenario_for_model(scenario, changes or [])
        else:
            read = read_scenario(scenario, resolution=resolution, changes=changes or [])
        of_code = check_code(read, time_limit=time_limit)
        simulation, remark = make_simulation(without_programs(read))
        steps_of(simulation, read.duration)
        if of_code:
            raise ScenarioError(())
    except AmorsimError as error:
        faults = (*of_code, *(error.faults if isinstance(error, ScenarioError) else (error,)))
        warnings = error.warnings if isinstance(error, ScenarioError) else ()
        if read is not None:
            warnings = tuple(f"{read.map.name}: {warning}" for warning in (*read.remarks, *read.map.warnings))
        for warning in warnings:
            complain(f"warning: {warning}")
        for fault in faults:
            complain(explain(fault) if isinstance(fault, AmorsimError) else str(fault))
        complain(f"{len(faults)} fault{'s' if len(faults) > 1 else ''} found")
        raise typer.Exit(2) from None
    found = (*read.remarks, *read.map.warnings, *([remark] if remark else ()))
    for line in (*(f"{read.map.name}: {warning}" for warning in found), *(() if of_model else advice(read))):
        complain(f"warning: {line}")
    if resolved:
        from amorsim.scenario.files.write import resolved_table, table_text

        say(table_text(resolved_table(simulation.scenario), with_remarks=True).rstrip())
    elif schedule:
        say(str(simulation.schedule))
    elif of_model:
        robot = simulation.scenario.robots[0]
        sensors = ", ".join(robot.sensors) or "no sensors"
        say(f"{scenario}: no faults; a robot, {type(robot.drive).__name__}, with {sensors}")
    else:
        width, height = read.map.size
        how_many = "1 robot" if len(read.robots) == 1 else f"{len(read.robots)} robots"
        robots = ", ".join(robot.name for robot in read.robots[:8]) + (" ..." if len(read.robots) > 8 else "")
        say(f"{scenario}: no faults; {width:.2f} m x {height:.2f} m, {how_many} ({robots})")
        for line in source_lines(read):
            say(line)
