"""The commands sweep, compare and report, as a user types them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.cli.progress import study_progress
from amorsim.sweeps import executors
from amorsim.sweeps.sweep import Progress
from tests.cli.conftest import Command
from tests.sweeps.studies import TRACK, study_file, tables


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return study_file(tmp_path / "study.toml", tables(tmp_path / "s", replicas=4))


def test_a_study_is_run_and_goes_on(amorsim: Command, file: Path, tmp_path: Path) -> None:
    result = amorsim("sweep", file, "--out", "out")
    assert result.status == 0, result.err
    assert "2 points x 1 seed x 4 replicas" in result.out
    assert "8 rows: out/table." in result.out
    assert "final_error [m]" in result.out
    assert am.read_study(tmp_path / "out").is_complete
    assert amorsim("sweep", file, "--out", "out", "--quiet").out == ""
    assert amorsim("sweep", file, "--quiet").status == 0
    assert (tmp_path / "amorsim-runs" / "study" / "study.json").exists()


def test_points_that_fail_are_reported(amorsim: Command, tmp_path: Path) -> None:
    path = study_file(tmp_path / "study.toml", tables(tmp_path / "s", axes={TRACK: [1.0, -1.0, 1.1]}))
    result = amorsim("sweep", path, "--out", "out")
    assert result.status == 1
    assert "point 1 failed: " in result.err


def test_means_say_how_many_replicas_they_are_of(amorsim: Command, tmp_path: Path) -> None:
    given = tables(tmp_path / "s", replicas=5, axes=None)
    simulation = am.Simulation(am.load(tmp_path / "s" / "small.toml"), replicas=5)
    simulation.run()
    x = np.sort(simulation.true_pose[:, 0])
    given["metrics"] = {
        "arrival": {"use": "arrival_time", "goal": [float(0.5 * (x[1] + x[2])) + 5.0, 1.0], "tolerance": 5.0}
    }
    result = amorsim("sweep", study_file(tmp_path / "study.toml", given), "--out", "out")
    assert result.status == 0, result.err
    assert "(3 of 5)" in result.out
    assert "(3 of 5)" in am.report(tmp_path / "out").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--keep", "some"), "--keep: expected none, all, or numbers of points as 0,7,12, got 'some'"),
        (("--jobs", "0"), "jobs: expected a number of processes >= 1"),
        (("--out", "n" * 300), "n: cannot make this folder for the study (File name too long)"),
    ],
)
def test_mistakes_are_reported(amorsim: Command, file: Path, arguments: tuple[str, ...], words: str) -> None:
    result = amorsim("sweep", file, *arguments)
    assert result.status == 2
    assert words in result.err
    assert "Traceback" not in result.err


def test_a_study_that_is_not_there_is_reported(amorsim: Command) -> None:
    result = amorsim("sweep", "none.toml")
    assert result.status == 2
    assert "none.toml" in result.err


@pytest.mark.long
def test_an_axis_is_compared_and_reported(amorsim: Command, file: Path, tmp_path: Path) -> None:
    amorsim("sweep", file, "--out", "out", "--quiet")
    result = amorsim("compare", "out", "--axis", TRACK, "--metric", "length", "--out", "c")
    assert result.status == 0, result.err
    assert "gain of pairing" in result.out
    assert "length: " in result.out
    assert (tmp_path / "c" / "comparison.png").exists()
    assert json.loads((tmp_path / "c" / "comparison.json").read_text())["labels"] == ["1.0", "1.05"]
    assert amorsim("report", "c").out == "c/report.html\n"
    assert amorsim("report", "out", "--out", "r.html").out == "r.html\n"
    again = amorsim("compare", "out", "--axis", TRACK, "--out", "c")
    assert again.status == 2
    assert "holds files already" in again.err


def test_scenarios_are_simulated_and_compared(amorsim: Command, file: Path, tmp_path: Path) -> None:
    small = tmp_path / "s" / "small.toml"
    (tmp_path / "s" / "other.toml").write_text(small.read_text().replace("scale = 1.0", "scale = 1.1"))
    result = amorsim("compare", "s/small.toml", "s/other.toml", "--replicas", 8, "--duration", 1.0, "--out", "c")
    assert result.status == 0, result.err
    assert "other - small" in result.out
    assert len(am.read_study(tmp_path / "c" / "small")["point"]) == 8
    assert amorsim("compare", "s/small.toml").status == 2
    wrong = amorsim("compare", "s/small.toml", "s/other.toml", "--seeds", "a", "--out", "d")
    assert "--seeds: expected whole numbers" in wrong.err


OF_FOUR = ("--replicas", 2, "--seeds", "1,2", "--duration", 0.5)


@pytest.fixture
def pair(file: Path, tmp_path: Path) -> tuple[str, str]:
    """Two scenarios, relative to the present folder."""
    small = tmp_path / "s" / "small.toml"
    (tmp_path / "s" / "other.toml").write_text(small.read_text().replace("scale = 1.0", "scale = 1.1"))
    return "s/small.toml", "s/other.toml"


ESTIMATORS = """
[robots.estimators]
wheels = { use = "dead_reckoning" }
filter = { use = "ekf", wheel_variance = 1e-4 }
"""


def test_the_estimators_of_one_scenario_are_compared(amorsim: Command, pair: tuple[str, str], tmp_path: Path) -> None:
    for name in pair:
        path = tmp_path / name
        path.write_text(path.read_text().replace("\n[robots.errors", f"{ESTIMATORS}\n[robots.errors"))
    two = ("--estimator", "wheels", "--estimator", "filter")
    result = amorsim("compare", pair[0], *OF_FOUR, *two, "--out", "c")
    assert result.status == 0, result.err
    assert "filter - wheels  position_error " in result.out
    about = json.loads((tmp_path / "c" / "comparison.json").read_text())
    assert about["origin"]["command"].endswith("--metric position_error --estimator wheels --estimator filter")
    # The study that this left is compared in the same way.
    again = amorsim("compare", "c/small", "--out", "d")
    assert again.out.partition("\n\nd/")[0] in result.out
    result = amorsim("compare", *pair, *OF_FOUR, "--metric", "nis", "--out", "e")
    assert result.err.startswith(
        "nis: none of the estimators has what this metric needs: dead_reckoning, wheels, filter"
    )
    wrong = amorsim("compare", *pair, *OF_FOUR, "--estimator", "fliter", "--out", "f")
    assert wrong.err.startswith("no estimator 'fliter' that all scenarios have; known: dead_reckoning, wheels, filter.")


@pytest.mark.long
def test_a_metric_is_taken_of_the_estimators_that_have_what_it_needs(amorsim: Command) -> None:
    result = amorsim("compare", "landmarks", "landmarks", *OF_FOUR, "--metric", "nis", "--out", "c")
    assert "nis of ekf: landmarks-1 and landmarks-2 are identical in all 4 pairs; their scenarios do not" in result.out
    assert "nis of wheels" not in result.out


def test_of_several_robots_one_is_named(amorsim: Command) -> None:
    result = amorsim("compare", "convoy", "convoy", "--out", "c")
    assert result.status == 2
    assert "convoy-1: there are several robots; name one with --robot: " in result.err
    assert "no robot 'nobody'; known: " in amorsim("compare", "convoy", "--robot", "nobody", "--out", "c").err


class Interrupted:
    """Computes chunks; Ctrl-C is pressed during the one of a number."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.done, self.last = 0, -1
        self._run = executors.run_chunk
        monkeypatch.setattr(executors, "run_chunk", self)

    def __call__(self, *arguments: Any) -> Any:
        if self.done == self.last:
            raise KeyboardInterrupt
        self.done += 1
        return self._run(*arguments)


@pytest.mark.long
@pytest.mark.parametrize("after", [1, 3])
def test_a_comparison_goes_on_after_ctrl_c(
    amorsim: Command, pair: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, after: int
) -> None:
    assert amorsim("compare", *pair, *OF_FOUR, "--out", "whole").status == 0
    chunks = Interrupted(monkeypatch)
    chunks.last = after
    result = amorsim("compare", *pair, *OF_FOUR, "--out", "c")
    assert result.status == 130
    assert result.err == "interrupted; what is done is in c. The same command goes on\n"
    chunks.last = -1
    result = amorsim("compare", *pair, *OF_FOUR, "--out", "c")
    assert result.status == 0, result.err
    assert chunks.done == 4
    command = (
        "amorsim compare s/small.toml s/other.toml --replicas 2 --seeds 1,2 --duration 0.5 --metric position_error"
    )
    assert json.loads((tmp_path / "c" / "comparison.json").read_text())["origin"]["command"] == command
    for name in ("comparison.json", "comparison.csv"):
        assert (tmp_path / "c" / name).read_text() == (tmp_path / "whole" / name).read_text()


@pytest.mark.long
def test_without_a_named_folder_the_one_that_was_begun_is_found(
    amorsim: Command, pair: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    chunks = Interrupted(monkeypatch)
    runs = tmp_path / "amorsim-runs"
    chunks.last = 2
    assert amorsim("compare", *pair, *OF_FOUR).status == 130
    chunks.last = -1
    assert amorsim("compare", *pair, *OF_FOUR, "--metric", "path_length").status == 0
    assert (runs / "comparison-002" / "comparison.json").exists()
    assert not (runs / "comparison-001" / "comparison.json").exists()
    chunks.done = 0
    assert amorsim("compare", *pair, *OF_FOUR).status == 0
    assert chunks.done == 2
    assert (runs / "comparison-001" / "comparison.json").exists()
    assert amorsim("compare", *pair, *OF_FOUR).status == 0
    assert (runs / "comparison-003" / "comparison.json").exists()


@pytest.mark.long
def test_a_folder_of_another_comparison_is_refused(amorsim: Command, pair: tuple[str, str], tmp_path: Path) -> None:
    assert amorsim("compare", *pair, *OF_FOUR, "--out", "c").status == 0
    result = amorsim("compare", *pair, *OF_FOUR[:-1], 0.6, "--out", "c")
    assert result.status == 2
    assert (
        "c: the comparison that was begun here differs in: duration; take back the change, or name another"
        in result.err
    )
    path = tmp_path / pair[1]
    path.write_text(path.read_text().replace("scale = 1.1", "scale = 1.2"))
    result = amorsim("compare", *pair, *OF_FOUR, "--out", "c")
    assert result.status == 2
    assert "c: the comparison that was begun here differs in: scenario of other;" in result.err
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "a").touch()
    assert "full: the folder holds files already" in amorsim("compare", *pair, *OF_FOUR, "--out", "full").err


def test_progress_without_a_terminal_is_whole_words(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.setattr("amorsim.cli.progress._EVERY", -1.0)
    with study_progress() as show:
        assert show is not None
        show(Progress(done=0, total=2, failed=0, left=None))
        show(Progress(done=1, total=2, failed=1, left=30.0))
    assert capsys.readouterr().out.splitlines() == ["0 of 2 done", "1 of 2 done, about 30 s left, 1 failed"]
