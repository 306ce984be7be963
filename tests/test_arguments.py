"""Whatever is given to a public function in place of what it takes is refused in words, by the argument's name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim import analysis
from tests.building import robot, scenario

ANYTHING: dict[str, Any] = {
    "None": None,
    "whole": 7,
    "real": 1.5,
    "nan": float("nan"),
    "inf": float("inf"),
    "true": True,
    "list": ["xyz"],
    "empty list": [],
    "dict": {"a": 1},
    "text": "xyz",
    "empty text": "",
    "text with a null": "x\0z",
    "bytes": b"xyz",
    "no numbers": np.array([]),
    "numbers": np.zeros(4),
    "nans": np.full((3, 3), np.nan),
    "object": object(),
    "class": int,
    "complex": 1j,
}
PATHS = {key for key in ANYTHING if key != "text"}
TEXTS = {key for key in ANYTHING if "text" not in key}
NO_NONE = set(ANYTHING) - {"None"}
ALL = set(ANYTHING)
WHOLE = set(ANYTHING) - {"whole"}
REAL = set(ANYTHING) - {"whole", "real"}

Call = Callable[[Any], object]


def trajectory() -> analysis.Trajectory:
    return analysis.Trajectory(time=np.arange(3.0), poses=np.arange(9.0).reshape(3, 3), name="t")


@pytest.fixture(scope="module")
def simulation() -> am.Simulation:
    return am.Simulation(scenario(robot()))


METHODS: dict[str, tuple[Callable[[am.Simulation, Any], object], set[str]]] = {
    "duration": (lambda sim, x: sim.run(x), REAL - {"None"}),
    "steps_of": (lambda sim, x: sim.steps_of(x), REAL),
    "keep": (lambda sim, x: sim.run(0.2, keep=x), NO_NONE - {"empty list", "no numbers"}),
    "name": (lambda sim, x: sim.robot(x), ALL),
    "obstacle": (lambda sim, x: sim.obstacle(x), ALL),
    "replica": (lambda sim, x: sim.robot("rover", x), NO_NONE),
    "map_of": (lambda sim, x: sim.map_of(x), NO_NONE),
    "digest": (lambda sim, x: sim.digest(x), NO_NONE),
    "pose": (lambda sim, x: sim.set_pose("rover", x), ALL),
    "path": (lambda sim, x: sim.set("rover", x, 1.0), ALL),
    "to": (lambda sim, x: sim.hand_over("rover", x), ALL),
    "snapshot": (lambda sim, x: sim.restore(x), ALL),
    "resolution": (lambda sim, x: sim.occupancy(x), REAL),
    "samples": (lambda sim, x: am.keep_stages(sim, samples=x), WHOLE),
    "record": (lambda sim, x: am.record(sim, x), PATHS - {"None"}),
    "size": (lambda sim, x: am.draw(sim, size=x), ALL),
    "title": (lambda sim, x: am.draw(sim, title=x), TEXTS),
    "kept": (lambda sim, x: am.draw(sim, x), NO_NONE),
}

FUNCTIONS: dict[str, tuple[Call, set[str]]] = {
    "load": (am.load, ALL),
    "overrides": (lambda x: am.load("demo", x), ALL - {"empty list", "no numbers", "empty text"}),
    "load_map": (am.load_map, ALL),
    "open_document": (am.open_document, ALL),
    "document.get": (lambda x: am.open_document("demo").get(x), ALL),
    "document.set": (lambda x: am.open_document("demo").set(x, 1.0), ALL - {"list", "text", "text with a null"}),
    "document.save": (lambda x: am.open_document("demo").save(x), PATHS - {"None"}),
    "save_map": (lambda x: am.save_map(x, "x.wld"), ALL),
    "save_map path": (lambda x: am.save_map(scenario(robot()).map, x), ALL),
    "save_robot": (lambda x: am.save_robot(x, "x.toml"), ALL),
    "save_robot path": (lambda x: am.save_robot(robot(), x), PATHS),
    "check_code": (am.check_code, ALL),
    "Simulation": (am.Simulation, ALL),
    "seed": (lambda x: am.Simulation(scenario(robot()), seed=x), WHOLE - {"None"}),
    "replicas": (lambda x: am.Simulation(scenario(robot()), replicas=x), ALL - {"whole", "bytes", "true"}),
    "run": (am.run, ALL),
    "reproduce": (am.reproduce, ALL),
    "run_page": (am.run_page, ALL),
    "keep_stages": (am.keep_stages, ALL),
    "record": (am.record, ALL),
    "draw": (am.draw, ALL),
    "estimated_map": (am.estimated_map, ALL),
    "report": (am.report, ALL),
    "read_study": (am.read_study, ALL),
    "sweep": (am.sweep, ALL),
    "compare": (lambda x: analysis.compare(x, x), ALL),
    "labels": (lambda x: analysis.compare("none", labels=x), ALL),
    "export_run": (lambda x: analysis.export_run(x, "tum"), ALL),
    "measure": (lambda x: analysis.measure(x, am.metrics.PathLength()), ALL),
    "metric": (lambda x: analysis.measure("none", x), ALL),
    "run_trajectories": (analysis.run_trajectories, ALL),
    "run_nees": (analysis.run_nees, ALL),
    "run_nis": (analysis.run_nis, ALL),
    "read_tum": (analysis.read_tum, ALL),
    "read_kitti": (analysis.read_kitti, ALL),
    "read_csv": (analysis.read_csv, ALL),
    "write_tum": (lambda x: analysis.write_tum(x, "x.tum"), ALL),
    "write_csv": (lambda x: analysis.write_csv(trajectory(), x), PATHS),
    "reference": (lambda x: analysis.ape(x, trajectory()), ALL),
    "estimate": (lambda x: analysis.ape(trajectory(), x), ALL),
    "most_apart": (lambda x: analysis.ape(trajectory(), trajectory(), most_apart=x), REAL - {"None"}),
    "align": (lambda x: analysis.ape(trajectory(), trajectory(), align=x), ALL),
    "delta": (lambda x: analysis.rpe(trajectory(), trajectory(), delta=x), REAL),
    "unit": (lambda x: analysis.rpe(trajectory(), trajectory(), unit=x), ALL),
    "relations": (lambda x: analysis.relation_errors(trajectory(), x), ALL),
    "samples": (analysis.mean_interval, ALL - {"numbers", "empty list", "no numbers"}),
    "confidence": (lambda x: analysis.mean_interval([1.0, 2.0, 4.0], confidence=x), ALL),
    "estimators": (lambda x: analysis.compare("none", estimators=x), ALL),
    "paired_effect": (analysis.paired_effect, ALL - {"numbers"}),
    "p_values": (analysis.holm, ALL - {"numbers", "empty list", "no numbers"}),
    "ensemble": (analysis.ensemble, ALL - {"nans"}),
    "errors": (lambda x: analysis.nees(x, np.eye(3)[None]), ALL - {"nans"}),
    "covariances": (lambda x: analysis.nis(np.zeros((1, 3)), x), ALL - {"nans"}),
    "values": (lambda x: analysis.verdict(x, 3), TEXTS & {"list", "dict", "bytes", "object", "class", "complex"}),
    "degrees": (lambda x: analysis.verdict(np.ones(20), x), WHOLE),
    "probability": (lambda x: analysis.map_scores(x, np.zeros((3, 3), int), 0.1), ALL - {"nans"}),
    "truth": (lambda x: analysis.map_scores(np.zeros((3, 3)), x, 0.1), ALL - {"nans"}),
    "points": (lambda x: analysis.umeyama(x, np.zeros((3, 2))), ALL),
    "distances": (lambda x: analysis.distances_to_walls(x, np.zeros((1, 4))), ALL),
    "compose": (lambda x: am.compose(x, np.zeros((3, 3))), ALL - {"nans"}),
    "displacements": (lambda x: am.compose(np.zeros((3, 3)), x), ALL - {"nans"}),
    "logarithm": (am.logarithm, ALL - {"nans"}),
    "wrap_angle": (am.wrap_angle, {"None", "list", "dict", "text", "bytes", "object", "class", "complex"}),
    "Robot.errors": (lambda x: robot(errors=x), ALL - {"dict"}),
    "runner": (lambda x: am.EstimatorRunner(x, "dead_reckoning"), ALL),
    "estimator": (lambda x: am.EstimatorRunner(robot(), x), ALL),
    "runner's dt": (lambda x: am.EstimatorRunner(robot(), "dead_reckoning", dt=x), REAL),
    "runner's seed": (lambda x: am.EstimatorRunner(robot(), "dead_reckoning", seed=x), WHOLE - {"None"}),
    "runner's replica": (lambda x: am.EstimatorRunner(robot(), "dead_reckoning", replica=x), WHOLE),
    "time": (lambda x: runner().update(x, {}), REAL),
    "readings": (lambda x: runner().update(0.0, x), ALL),
    "reading": (lambda x: runner().update(0.0, {"encoder": x}), ALL),
    "command": (lambda x: runner().update(0.0, {}, x), NO_NONE),
    "ages": (lambda x: runner().update(0.0, {}, ages=x), NO_NONE),
}


def runner() -> am.EstimatorRunner:
    return am.EstimatorRunner(robot(), "dead_reckoning")


def refused(call: Call, given: str) -> str:
    """What is said of a value; or how it was taken."""
    try:
        call(ANYTHING[given])
    except am.AmorsimError:
        return ""
    except Exception as error:
        if type(error) is ValueError and "expected" in str(error):
            return ""
        return f"{given}: {type(error).__name__}: {error}"
    return f"{given}: was taken"


@pytest.mark.parametrize("what", FUNCTIONS)
def test_what_a_function_does_not_take_is_refused_in_words(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    call, wrong = FUNCTIONS[what]
    assert [words for given in sorted(wrong) if (words := refused(call, given))] == []
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("what", METHODS)
def test_what_a_simulation_does_not_take_is_refused_in_words(
    what: str, simulation: am.Simulation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    call, wrong = METHODS[what]
    assert [words for given in sorted(wrong) if (words := refused(lambda x: call(simulation, x), given))] == []
    assert not list(tmp_path.iterdir())


def test_numbers_of_numpy_are_numbers() -> None:
    made = am.Simulation(scenario(robot()), seed=np.int64(3), replicas=np.int32(2), threads=np.int64(1))
    made.run(np.float64(0.2))
    assert (made.seed, made.replicas, made.tick) == (3, (0, 1), 2)
    made.set_pose("rover", np.array([1.0, 1.0, 0.0]), replica=np.int64(1))
    assert am.EstimatorRunner(robot(), "dead_reckoning", dt=np.float32(0.5), seed=np.int64(1)).update(0.0, {})


def test_lists_of_numbers_are_taken_for_arrays() -> None:
    assert analysis.mean_interval([1, 2, 4]) == analysis.mean_interval(np.array([1.0, 2.0, 4.0]))
    assert analysis.nees([[1, 0]], [[[1, 0], [0, 1]]]).tolist() == [1.0]
    assert am.compose([[1, 0, 0]], [[0, 2, 0]]).tolist() == [[1.0, 2.0, 0.0]]
    assert am.wrap_angle([4.0]).tolist() == am.wrap_angle(np.array([4.0])).tolist()
