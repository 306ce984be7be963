"""Calls of every public function, class and method with arguments of which one or two are drawn from what is wrong.

What is called is found by walking through ``__all__`` of `amorsim` and of its public submodules, and what an argument
should be is guessed from its annotation and its name.
"""

from __future__ import annotations

import contextlib
import inspect
import types
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

import amorsim as am
from tests import building

__all__ = ["Api", "public_calls"]

# What is called elsewhere, or never ends, or takes the process with it.
LEFT_OUT = {
    "amorsim.view": "serves until it is ended",
    "amorsim.testing.check_component": "runs a component of the caller's own: its errors are the caller's",
    "amorsim.testing.check_recorder": "likewise",
    "amorsim.testing.check_document_loader": "likewise",
    "amorsim.hookimpl": "of pluggy",
    "amorsim.MapLoader.save": "of loaders, which are given a map and a path by `amorsim.save_map`",
    "amorsim.Draws": "made by the engine alone",
    "amorsim.testing.Rig": "part of the checks of components",
    "amorsim.testing.example": "likewise",
    "amorsim.testing.variants": "likewise",
}
# What amorsim calls itself, with what it has made.
INNER = {"plan_on", "search", "ground", "grow", "curves", "spacing", "kernel", "start", "command", "actuate"}
# Numbers that may be large there, and then take long: no larger ones are tried.
LONG = {"duration", "count", "replicas", "steps", "jobs", "threads", "samples", "budget", "size", "iterations", "keep"}

NUMBERS = (0, -1, 7, 2.5, -0.5, 1e-320, 1e-300, 1e-9, 1e9, 1e15, 1e100, 1e300, 2**31, 2**63, 2**64, 10**400, -(10**400))
SMALL = (0, -1, -0.5, 1e-320, 10**400, -(10**400))


class _Odd:
    """An object of a class that nobody expects; it is made of anything, for a function that is given may raise."""

    def __init__(self, *_: Any) -> None:
        pass


def _junk() -> tuple[Any, ...]:
    """What is wrong nearly everywhere; made anew each time, for it may be changed."""
    return (
        *(None, True, float("nan"), float("inf"), -float("inf"), 1j, b"bytes", "", "x", "\0", "n" * 5000, "demo"),
        *(
            [],
            {},
            (),
            set(),
            [1],
            ["x"],
            [None],
            [[1.0, 2.0]],
            [[1.0], [1.0, 2.0]],
            {"a": 1},
            {1: 2},
            _Odd(),
            int,
            _Odd,
        ),
        *(np.array(2.0), np.array([]), np.zeros(3), np.zeros((2, 3)), np.full((3, 3), np.nan), np.full((2, 3), np.inf)),
        *(np.array(["x"]), np.array([None, 1], dtype=object), np.zeros((0, 3)), np.zeros((3, 3), dtype=np.complex128)),
        *(
            np.zeros((2, 2, 2)),
            np.int64(3),
            np.float32(0.5),
            iter([1.0]),
            range(3),
            lambda *_: None,
            am.Shape.circle(0.1),
        ),
        *([1e300, 1e300, 1e300], (1.0, 1.0, 10**400), (1.0, float("nan"), 0.0), np.datetime64("2020-01-01")),
    )


Call = tuple[str, Callable[[], Callable[..., Any]]]


def public_calls() -> Iterator[Call]:
    """The name of everything public that can be called without an instance, and what returns it."""
    modules: list[Any] = [am]
    for module in modules:
        for name in module.__all__:
            thing, label = getattr(module, name), f"{module.__name__}.{name}"
            if isinstance(thing, types.ModuleType):
                modules.append(thing)
            if label in LEFT_OUT or not callable(thing):
                continue
            if not inspect.isclass(thing):
                yield label, lambda thing=thing: thing
                continue
            if issubclass(thing, BaseException):
                continue
            if not inspect.isabstract(thing):
                yield label, lambda thing=thing: thing
            for method in _methods(thing, (classmethod, staticmethod)):
                if not inspect.isabstract(thing) and f"{label}.{method}" not in LEFT_OUT:
                    yield f"{label}.{method}", lambda thing=thing, method=method: getattr(thing, method)


def _methods(kind: type, of: type | tuple[type, ...]) -> Iterator[str]:
    """The names of a class's public methods of some kinds."""
    for name in dir(kind):
        if not name.startswith("_") and name not in INNER and isinstance(inspect.getattr_static(kind, name), of):
            yield name


class Api:
    """Calls of the public functions, classes and methods."""

    said = ""

    def __init__(self, folder: Path) -> None:
        self._folder = folder / "api"
        self._folder.mkdir(exist_ok=True)
        self._scenario = building.scenario(building.robot())
        self._run = self._folder / "run"
        if not self._run.exists():
            am.run(self._scenario, self._run, duration=0.3)
        self._calls = list(public_calls())
        planners = [getattr(am.planners, name) for name in am.planners.__all__]
        instances: list[tuple[str, Callable[[], Any]]] = [
            ("Simulation", lambda: am.Simulation(self._scenario)),
            ("RobotHandle", lambda: am.Simulation(self._scenario).robot("rover")),
            ("Map", lambda: self._scenario.map),
            ("Shape", lambda: am.Shape.rectangle(0.4, 0.3)),
            ("Scenario", lambda: self._scenario),
            ("Trajectory", self._trajectory),
            ("RunFiles", lambda: am.analysis.RunFiles(self._run)),
            ("Registry", am.Registry),
            ("EstimatorRunner", lambda: am.EstimatorRunner(self._scenario.robots[0], am.estimators.DeadReckoning())),
            ("KeptStages", lambda: am.keep_stages(am.Simulation(self._scenario))),
            ("Document", lambda: am.open_document(self._run / "scenario.toml")),
            *((kind.__name__, kind) for kind in planners if not inspect.isabstract(kind)),
        ]
        for name, make in instances:
            for method in _methods(type(make()), types.FunctionType):
                self._calls.append((f"{name}().{method}", lambda make=make, method=method: getattr(make(), method)))

    def attempt(self, rng: Random) -> None:
        """Call something public with a wrong argument or two."""
        label, get = self._calls[rng.randrange(len(self._calls))]
        self.said = label
        call = get()
        try:
            signature = inspect.signature(call)
        except ValueError:  # of a class written in C
            return
        parameters = [
            one for one in signature.parameters.values() if one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)
        ]
        if not parameters:
            return
        given = {one.name: self._good(one) for one in parameters if one.default is one.empty or rng.random() < 0.2}
        for one in rng.sample(parameters, min(len(parameters), rng.choice((1, 1, 1, 2)))):
            given[one.name] = self._bad(one.name, rng)
        self.said = f"{label}({', '.join(f'{name}={_words(value)}' for name, value in given.items())})"
        alone = [one.name for one in parameters if one.kind is one.POSITIONAL_ONLY]
        with contextlib.chdir(self._folder):
            call(*(given.pop(name) for name in alone if name in given), **given)

    def _bad(self, name: str, rng: Random) -> Any:
        if rng.random() < 0.35:
            return rng.choice(SMALL if name in LONG else NUMBERS)
        junk = _junk()
        return junk[rng.randrange(len(junk))]

    def _good(self, parameter: inspect.Parameter) -> Any:
        """What an argument may be, as far as its name and annotation tell."""
        if parameter.name in (named := self._by_name()):
            return named[parameter.name]()
        kind = str(parameter.annotation)
        for words, make in self._by_kind().items():
            if words in kind:
                return make()
        return 1.0 if parameter.default is parameter.empty else parameter.default

    def _trajectory(self) -> am.analysis.Trajectory:
        return am.analysis.Trajectory(time=np.arange(5.0), poses=np.arange(15.0).reshape(5, 3) / 10, name="t")

    def _by_name(self) -> Mapping[str, Callable[[], Any]]:
        return {
            "scenario": lambda: self._scenario,
            "simulation": lambda: am.Simulation(self._scenario),
            "start": lambda: (1.0, 1.0, 0.0),
            "goal": lambda: (2.0, 1.5, 0.0),
            "footprint": lambda: am.Shape.circle(0.1),
            "shape": lambda: am.Shape.circle(0.2),
            "name": lambda: "rover",
            "run": lambda: self._run,
            "folder": lambda: self._run,
            "path": lambda: self._folder / "out.toml",
            "out": lambda: self._folder / "out",
            "duration": lambda: 0.2,
            "replicas": lambda: 1,
            "dt": lambda: 0.1,
            "time": lambda: np.arange(5.0),
            "poses": lambda: np.arange(15.0).reshape(5, 3) / 10,
            "covariance": lambda: np.tile(np.eye(3), (5, 1, 1)),
            "errors": lambda: np.ones((5, 3)),
            "estimated": self._trajectory,
            "true": self._trajectory,
            "metric": am.metrics.PathLength,
            "robot": lambda: "rover",
        }

    def _by_kind(self) -> Mapping[str, Callable[[], Any]]:
        return {
            "Trajectory": self._trajectory,
            "Simulation": lambda: am.Simulation(self._scenario),
            "Scenario": lambda: self._scenario,
            "Map": lambda: self._scenario.map,
            "Shape": lambda: am.Shape.circle(0.2),
            "Robot": lambda: self._scenario.robots[0],
            "Pose": lambda: am.Pose(x=1.0, y=1.0),
            "Path": lambda: self._folder / "out",
            "Array": lambda: np.ones((5, 3)),
            "Sequence": lambda: [1.0, 2.0],
            "str": lambda: "rover",
            "int": lambda: 3,
            "float": lambda: 1.0,
        }


def _words(value: Any) -> str:
    return repr(value)[:60].replace("\n", " ")
