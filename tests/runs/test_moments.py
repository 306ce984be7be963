"""Single moments of text files are found by halving, and hold what the whole file says."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.runs import moments
from amorsim.runs.moments import TimedLines

HEADER = "time,stamp,robot,true_0,measured_0"


def write(path: Path, steps: int = 200, robots: int = 3, tail: str = "") -> Path:
    """A sensor of three robots; that of ``r2`` has a reading in every tenth step."""
    lines = [HEADER]
    for step in range(steps):
        for robot in range(robots):
            if robot < 2 or step % 10 == 0:
                lines.append(f"{step * 0.1:.6f},{step * 0.1:.6f},r{robot},{step + robot / 10},{'9' * (step % 40 + 1)}")
    path.write_text("\n".join(lines) + "\n" + tail)
    return path


Open = Callable[..., TimedLines]


@pytest.fixture
def opened() -> Iterator[Open]:
    """Opens files, and closes them at the end."""
    files = []

    def open_one(path: Path, problems: list[str] | None = None) -> TimedLines:
        found = [] if problems is None else problems
        files.append(TimedLines(path, "sensors/laser", damaged=lambda error: found.append(str(error))))
        return files[-1]

    yield open_one
    for file in files:
        file.close()


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that a small file has many, and lines lie across their edges."""
    monkeypatch.setattr(moments, "BLOCK", 61)


def test_every_moment_is_found_in_any_order(opened: Open, tmp_path: Path) -> None:
    lines = opened(write(tmp_path / "laser.csv"))
    assert lines.last_time == pytest.approx(19.9)
    order = [*range(200), *np.random.default_rng(1).permutation(200).tolist()]
    for step in order:
        found = lines.at(step * 0.1, 0.05)
        assert [cells[2] for cells in found] == [b"r0", b"r1", b"r2"][: 3 if step % 10 == 0 else 2]
        assert [lines.numbers(cells, [3])[0] for cells in found[:2]] == [step, step + 0.1]
    assert lines.at(20.0, 0.05) == lines.at(-1.0, 0.05) == []


def test_the_last_reading_is_that_which_the_robot_holds(opened: Open, tmp_path: Path) -> None:
    lines = opened(write(tmp_path / "laser.csv"))
    for step in (0, 3, 10, 11, 99, 100, 199, 1000):
        cells = lines.last(step * 0.1 + 0.05, lambda cells: cells[2] == b"r2")
        assert cells is not None
        assert lines.numbers(cells, [3]) == [min(step, 190) // 10 * 10 + 0.2]
    assert lines.last(-0.05, lambda _: True) is None
    assert lines.last(5.0, lambda cells: cells[2] == b"r7") is None


def test_a_line_that_was_broken_off_is_left_out(opened: Open, tmp_path: Path) -> None:
    problems: list[str] = []
    lines = opened(write(tmp_path / "laser.csv", steps=5, tail="0.500000,0.5000"), problems)
    assert lines.last_time == pytest.approx(0.4)
    assert lines.at(0.5, 0.05) == []
    assert problems == []


@pytest.mark.parametrize("text", ["", "0.1"])
def test_a_file_without_lines_has_no_time(opened: Open, tmp_path: Path, text: str) -> None:
    path = tmp_path / "laser.csv"
    path.write_text(f"{HEADER}\n{text}")
    lines = opened(path)
    assert lines.last_time is None
    assert lines.at(0.0, 0.05) == []
    assert lines.last(1.0, lambda _: True) is None


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("x,3.0,r0,1,2", "line 92, time: expected a finite number, got 'x'"),
        ("nan,3.0,r0,1,2", "line 92, time: expected a finite number, got 'nan'"),
        ("3.0,3.0,r0,1", "line 92, is damaged: expected 5 cells, got 4"),
        ("\x00\x01", "line 92, is damaged: expected 5 cells, got 1"),
    ],
)
def test_a_damaged_line_is_named_once_and_the_others_are_read(
    opened: Open, tmp_path: Path, line: str, problem: str
) -> None:
    path = write(tmp_path / "laser.csv")
    text = path.read_text().splitlines()
    text[91] = line
    path.write_text("\n".join(text) + "\n")
    problems: list[str] = []
    lines = opened(path, problems)
    for _ in range(2):
        for step in range(200):
            assert 1 <= len(lines.at(step * 0.1, 0.05)) <= 3
    assert problems == [f"{path}, {problem}"]


def test_a_damaged_number_is_missing_and_named_once(opened: Open, tmp_path: Path) -> None:
    path = write(tmp_path / "laser.csv")
    path.write_text(path.read_text().replace("\n1.000000,1.000000,r0,10.0,", "\n1.000000,1.000000,r0,ten,"))
    problems: list[str] = []
    lines = opened(path, problems)
    for _ in range(2):
        assert np.isnan(lines.numbers(lines.at(1.0, 0.05)[0], [3])).all()
    assert problems == [f"{path}, at 1.000000 s, true_0: expected a number, got 'ten'"]


@pytest.mark.parametrize("text", ["", "time,robot\n", "time,time,robot\n"])
def test_a_file_with_another_header_is_refused(opened: Open, tmp_path: Path, text: str) -> None:
    (tmp_path / "laser.csv").write_text(text)
    with pytest.raises(am.RunError, match=r"laser.csv, line 1: is damaged"):
        opened(tmp_path / "laser.csv")


def test_a_line_longer_than_a_block_is_read(opened: Open, tmp_path: Path) -> None:
    path = tmp_path / "laser.csv"
    columns = ",".join(f"{kind}_{i}" for kind in ("true", "measured") for i in range(50))
    rows = [f"{step},{step},r0," + ",".join(["1.5"] * 100) for step in range(40)]
    path.write_text("\n".join([f"time,stamp,robot,{columns}", *rows]) + "\n")
    lines = opened(path)
    assert lines.last_time == 39.0
    for step in (0, 39, 20, 7):
        assert [cells[0] for cells in lines.at(step, 0.5)] == [str(step).encode()]
        cells = lines.last(step + 0.5, lambda _: True)
        assert cells is not None
        assert cells[0] == str(step).encode()
