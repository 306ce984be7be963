"""The users' programs of a scenario: loaded for a simulation, or left out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import attrs

from amorsim.core.errors import ControllerError, Fault, ScenarioError
from amorsim.core.parameters import ParameterError, describe
from amorsim.core.user_code import UserCode
from amorsim.plugins.checks import check_class
from amorsim.plugins.registry import KINDS
from amorsim.scenario.programs.program_text import Program
from amorsim.scenario.reading.faults import FaultCollector, Node, Source
from amorsim.scenario.reading.fields import read_component
from amorsim.scenario.reading.lines import with_lines
from amorsim.scenario.spec import Robot, Scenario

__all__ = ["loaded", "loaded_component", "loaded_robot", "made_of", "programs_of", "without_programs"]


def programs_of(scenario: Scenario) -> Iterator[tuple[UserCode, Program]]:
    """The components whose programs have not been loaded, each once."""
    found: dict[int, UserCode] = {}

    def note(code: UserCode) -> UserCode:
        found[id(code)] = code
        return code

    _with_components(scenario, _Replacing(note))
    yield from ((code, code.function) for code in found.values())


def loaded(scenario: Scenario) -> Scenario:
    """The scenario with users' functions and classes in place of their names; their files are run for that.

    Raises
    ------
    ScenarioError
        With a fault for each that cannot be loaded, or does not take its options.
    """
    loading = _Loading()
    found = _with_components(scenario, loading.replacing)
    loading.raise_if_any(scenario.map.warnings)
    return found


def loaded_robot(robot: Robot) -> Robot:
    """The same for one robot."""
    loading = _Loading()
    found = _with_robot(robot, loading.replacing)
    loading.raise_if_any()
    return found


def loaded_component(component: Any) -> Any:
    """The same for one component."""
    loading = _Loading()
    found = loading.replacing.of(component)
    loading.raise_if_any()
    return found


def without_programs(scenario: Scenario) -> Scenario:
    """The scenario with functions that do nothing in place of users' programs."""
    return _with_components(scenario, _Replacing(lambda code: attrs.evolve(code, function=code.idle())))


class _Loading:
    """Loads components, and collects what is wrong with them."""

    def __init__(self) -> None:
        self._faults: list[Fault] = []
        self.replacing = _Replacing(self._load)

    def _load(self, code: UserCode) -> Any:
        try:
            return made_of(code)
        except ScenarioError as error:
            self._faults += error.faults
        except ControllerError as error:
            self._faults.append(code.function.fault(str(error)))
        return code

    def raise_if_any(self, warnings: tuple[str, ...] = ()) -> None:
        """Raise `ScenarioError` if anything is wrong."""
        faults = [*self._faults, *self.replacing.faults]
        if faults:
            raise ScenarioError(with_lines(dict.fromkeys(faults)), warnings)


class _Replacing:
    """Replaces each component whose program has not been loaded, also within others."""

    def __init__(self, instead: Callable[[UserCode], Any]) -> None:
        self._instead = instead
        self._known: dict[int, tuple[Any, Any]] = {}  # with the component itself, so that no other gets its id
        self.faults: list[Fault] = []

    def of(self, component: Any) -> Any:
        """The component, or what comes in its place; bodies that share one share that too."""
        if id(component) not in self._known:
            self._known[id(component)] = component, self._other(component)
        return self._known[id(component)][1]

    def _other(self, component: Any) -> Any:
        if isinstance(component, UserCode):
            return self._instead(component) if isinstance(component.function, Program) else component
        if not attrs.has(type(component)):
            return component
        changed, place = {}, None
        for name, parameter in describe(type(component)).items():
            own = getattr(component, name) if parameter.component else None
            if (other := self.of(own)) is not own:
                changed[name], place = other, own
        try:
            return attrs.evolve(component, **changed) if changed else component
        except ParameterError as error:
            assert isinstance(place, UserCode)
            self.faults.append(place.function.fault(str(error)))
            return component


def _with_components(scenario: Scenario, replacing: _Replacing) -> Scenario:
    robots = [_with_robot(robot, replacing) for robot in scenario.robots]
    obstacles = [_evolved(one, motion=replacing.of(one.motion)) for one in scenario.obstacles]
    also = [replacing.of(recorder) for recorder in scenario.recording.also]
    is_same = (
        all(map(_is, robots, scenario.robots))
        and all(map(_is, obstacles, scenario.obstacles))
        and all(map(_is, also, scenario.recording.also))
    )
    if is_same:
        return scenario
    recording = attrs.evolve(scenario.recording, also=also)
    return attrs.evolve(scenario, robots=robots, obstacles=obstacles, recording=recording)


def _with_robot(robot: Robot, replacing: _Replacing) -> Robot:
    estimators = {name: replacing.of(estimator) for name, estimator in robot.estimators.items()}
    if all(estimators[name] is own for name, own in robot.estimators.items()):
        estimators = robot.estimators
    found: Robot = _evolved(robot, controller=replacing.of(robot.controller), estimators=estimators)
    return found


def _evolved(body: Any, **fields: Any) -> Any:
    """The body itself where the fields are the same objects."""
    return body if all(getattr(body, name) is value for name, value in fields.items()) else attrs.evolve(body, **fields)


def _is(one: Any, other: Any) -> bool:
    return one is other


def made_of(code: UserCode) -> Any:
    """The component that a user's code is, or its function or plain class in one that runs it: the file is run.

    Raises
    ------
    ControllerError
        If it cannot be loaded, breaks its contract, or does not take its options.
    ScenarioError
        With a fault for each of the fields of a component that has a wrong value.
    """
    program: Program = code.function
    found = program.load(dict(code.options))
    contract = KINDS[code.kind]
    if not (isinstance(found, type) and issubclass(found, contract)):
        return attrs.evolve(code, function=found)
    if problems := check_class(code.kind, contract, found):
        raise ControllerError(f"{program.path}: {program.name}: {'; '.join(problems)}")
    return _component(found, program, dict(code.options))


def _component(cls: type, program: Program, options: dict[str, Any]) -> Any:
    """An instance of a component with the options of a table as its fields."""
    place = program.place or Fault(file="", path="use", message="")
    book = FaultCollector(Source(file=place.file, folder=program.folder))
    path = tuple(place.path.split(".")[:-1])
    made = read_component(cls, Node(options, path, book))
    if not book.faults:
        return made
    named = place.named.rpartition(".")[0]
    raise ScenarioError(
        attrs.evolve(fault, named=".".join([named, *fault.path.split(".")[len(path) :]]) if named else "")
        for fault in book.faults
    )
