"""Whatever a plugin's method raises or gives is reported with the plugin's component, and no other error shows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

import amorsim as am
from tests.building import robot, scenario, write_rover
from tests.installed import registered

FAILING: dict[str, Any] = {}  # what a method does in place of its own: raises, or gives a value


def asked(method: str, own: Any) -> Any:
    """What a method gives: its own answer, or what the test wants."""
    wanted = FAILING.get(method, own)
    if isinstance(wanted, BaseException):
        raise wanted
    return wanted


@attrs.frozen(kw_only=True)
class Estimates(am.Estimator):
    def update(self, robot: Any, readings: Any, command: Any, elapsed: Any, state: Any, draws: Any) -> am.Estimate:
        return am.Estimate(np.zeros((len(command), 3)), np.zeros((len(command), 3, 3)))

    def failed(self, state: am.State) -> Any:
        return asked("failed", None)


@attrs.frozen(kw_only=True)
class Senses(am.Sensor):
    unit: ClassVar[str] = "m"

    def size(self, drive: am.Drive) -> Any:
        return asked("size", 1)

    def sense(self, view: am.View, aim: am.Aim, state: am.State, draws: am.Draws) -> Any:
        return np.zeros((1, 1)), {}


@attrs.define(kw_only=True)
class Records(am.Recorder):
    def fresh(self) -> Any:
        return asked("fresh", self)

    def open(self, run: am.RunInfo, frames: Any) -> None:
        asked("open", None)

    def write(self, frames: Any, events: Any) -> None:
        asked("write", None)

    def close(self) -> None:
        asked("close", None)


@attrs.frozen(kw_only=True)
class Measures(am.Metric):
    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"

    def needs(self) -> Any:
        return asked("needs", ())

    def measure(self, episode: am.Episode) -> Any:
        return asked("measure", np.zeros(len(episode.replicas)))


@attrs.frozen(kw_only=True)
class LoadsMaps(am.MapLoader):
    extensions: ClassVar[tuple[str, ...]] = (".failing",)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return bool(asked("sniff", False))

    def load(self, path: Path) -> Any:
        return asked("load", None)


@attrs.frozen(kw_only=True)
class LoadsScenarios(am.ScenarioLoader):
    extensions: ClassVar[tuple[str, ...]] = (".failings",)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        return bool(asked("sniff", True))

    def read(self, path: Path) -> Any:
        return asked("read", None)


class Plugin:
    @staticmethod
    @am.hookimpl
    def amorsim_register(registry: am.Registry) -> None:
        registry.estimator("estimates", Estimates)
        registry.sensor("senses", Senses)
        registry.recorder("records", Records)
        registry.metric("measures", Measures)
        registry.map_loader("maps", LoadsMaps)
        registry.scenario_loader("scenarios", LoadsScenarios)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of its own; the plugin is registered."""
    monkeypatch.chdir(tmp_path)
    with registered(monkeypatch, Plugin):
        yield tmp_path
    FAILING.clear()


def estimate(folder: Path) -> None:
    am.Simulation(scenario(robot(estimators={"own": Estimates()}))).run(0.2)


def sense(folder: Path) -> None:
    am.Simulation(scenario(robot(sensors={"encoder": robot().sensors["encoder"], "own": Senses()})))


def read_sensor(folder: Path) -> None:
    am.load(write_rover(folder, "[robots.sensors.own]", 'use = "senses"'))


def record(folder: Path) -> None:
    made = scenario(robot(), recording=am.Recording(also=(Records(),), picture=False))
    am.run(made, folder / "run", duration=0.2)


def study(folder: Path) -> None:
    write_rover(folder, 'controller = { use = "square" }')
    axes = {"simulation.seed": [1]}
    found = am.sweep(
        {"format": 1, "scenario": "one.toml", "duration": 0.2, "axes": axes, "metrics": {"m": {"use": "measures"}}},
        folder / "study",
    )
    raise am.StudyError(str(found["error"][0]))


def load_map(folder: Path) -> None:
    (folder / "x.failing").write_text("x")
    am.load_map(folder / "x.failing")


def load_scenario(folder: Path) -> None:
    (folder / "x.failings").write_text("x")
    am.load(folder / "x.failings")


BOOM = RuntimeError("boom")


@pytest.mark.parametrize("given", [BOOM, SystemExit(3), None, "text", np.array([1.0])], ids=str)
@pytest.mark.parametrize(
    ("act", "method", "words"),
    [
        (estimate, "failed", "'own'.*failed|'own'.*boom|'own'.*SystemExit"),
        (sense, "size", "sensor 'own'.*size"),
        (read_sensor, "size", "sensors.own.*size"),
        (record, "fresh", r"recorder Records: fresh\(\)"),
        (record, "open", r"recorder Records: open\(\)"),
        (record, "write", r"recorder Records: write\(\)"),
        (record, "close", r"recorder Records: close\(\)"),
        (study, "needs", r"Measures.needs\(\)"),
        (study, "measure", "boom|SystemExit|Measures.measure"),
        (load_map, "load", "LoadsMaps"),
        (load_map, "sniff", "LoadsMaps gave None"),
        (load_scenario, "read", "the scenario loader 'scenarios'"),
        (load_scenario, "sniff", "x.failings"),
    ],
)
def test_what_a_plugin_does_wrong_is_reported_in_words(
    act: Callable[[Path], None], method: str, words: str, given: Any, folder: Path
) -> None:
    takes_any = method in ("open", "write", "close") and not isinstance(given, BaseException)
    if takes_any or (method, type(given)) in (("failed", type(None)), ("measure", np.ndarray)):
        return
    FAILING[method] = given
    with pytest.raises(am.AmorsimError, match=words):
        act(folder)
