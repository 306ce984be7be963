"""The commands sweep, compare and report, as a user types them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import amorsim as am
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


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--keep", "some"), "--keep: expected none, all, or numbers of points as 0,7,12, got 'some'"),
        (("--jobs", "0"), "jobs: expected a number of processes >= 1"),
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
