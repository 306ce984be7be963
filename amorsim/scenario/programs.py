"""The users' programs of a scenario: loaded for a simulation, or left out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import attrs

from amorsim.core.errors import ControllerError, Fault, ScenarioError
from amorsim.core.user_code import UserCode
from amorsim.scenario.lines import with_lines
from amorsim.scenario.program_text import Program
from amorsim.scenario.spec import Scenario

__all__ = ["loaded", "programs_of", "without_programs"]


def programs_of(scenario: Scenario) -> Iterator[tuple[UserCode, Program]]:
    """The controllers and motions whose programs have not been loaded, each once."""
    bodies: list[Any] = [robot.controller for robot in scenario.robots]
    bodies += [obstacle.motion for obstacle in scenario.obstacles]
    seen: set[int] = set()
    for component in bodies:
        if isinstance(component, UserCode) and isinstance(component.function, Program) and id(component) not in seen:
            seen.add(id(component))
            yield component, component.function


def loaded(scenario: Scenario) -> Scenario:
    """The scenario with the functions and classes of users' programs, whose files are run for that.

    Raises
    ------
    ScenarioError
        With a fault for each that cannot be loaded, or does not take its options.
    """
    faults: list[Fault] = []

    def load(component: UserCode, program: Program) -> Any:
        try:
            return program.load(dict(component.options))
        except ControllerError as error:
            faults.append(program.fault(str(error)))

    found = _with_functions(scenario, load)
    if faults:
        raise ScenarioError(with_lines(dict.fromkeys(faults)), scenario.map.warnings)
    return found


def without_programs(scenario: Scenario) -> Scenario:
    """The scenario with functions in the place of users' programs that do nothing."""
    return _with_functions(scenario, lambda *_: _nothing)


def _nothing(*_: Any, **__: Any) -> None:
    """Stop, or stand."""


def _with_functions(scenario: Scenario, function_of: Callable[[UserCode, Program], Any]) -> Scenario:
    """The scenario with what `function_of` says in the place of each program."""
    made: dict[int, UserCode] = {  # bodies that share a component share what comes in its place
        id(component): attrs.evolve(component, function=function_of(component, program))
        for component, program in programs_of(scenario)
    }
    if not made:
        return scenario

    def changed(body: Any, field: str) -> Any:
        other = made.get(id(getattr(body, field)))
        return body if other is None else attrs.evolve(body, **{field: other})

    return attrs.evolve(
        scenario,
        robots=[changed(robot, "controller") for robot in scenario.robots],
        obstacles=[changed(obstacle, "motion") for obstacle in scenario.obstacles],
    )
