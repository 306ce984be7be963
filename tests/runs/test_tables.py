"""Text files of a run as columns and lines; what is damaged is named by file, line and column."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.runs import tables
from amorsim.runs.tables import last_line, read_columns, read_lines

HEADER = "time,robot,true_x,true_y,true_heading,estimated_x,estimated_y,estimated_heading"
POSES = f"{HEADER}\n0.0,rover,1,2,3,4,5,6\n0.1,rover,1.5,2,3,4,5,6\n0.2,rover,2.5,2,3,4,5,6\n"
EVENTS = (
    "time,robot,kind,other,x,y,speed,path,value,tick\n"
    "0.1,rover,collision,wall,1.0,2.0,0.5,,,0\n"
    '0.1,rover,pose_set,,,,,pose,"[1.0, 2.0, 0.5]",1\n'
)


def test_columns_have_the_type_of_what_they_hold(tmp_path: Path) -> None:
    (tmp_path / "events.csv").write_text(EVENTS)
    events = read_columns(tmp_path / "events.csv", "events")
    assert events["kind"].tolist() == ["collision", "pose_set"]
    assert events["value"].tolist() == ["", "[1.0, 2.0, 0.5]"]
    assert (events["tick"].dtype, events["tick"].tolist()) == (np.int64, [0, 1])
    np.testing.assert_array_equal(events["speed"], [0.5, np.nan])


def test_blocks_of_any_size_give_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "poses.csv").write_text(POSES)
    whole = read_columns(tmp_path / "poses.csv", "poses")
    assert whole["true_x"].tolist() == [1.0, 1.5, 2.5]
    for size in (1, 7, 40, len(POSES) - 1, len(POSES)):
        monkeypatch.setattr(tables, "_BLOCK", size)
        for key, values in read_columns(tmp_path / "poses.csv", "poses").items():
            np.testing.assert_array_equal(values, whole[key])
        assert [line.number for line in read_lines(tmp_path / "poses.csv")] == [2, 3, 4]
        last = last_line(tmp_path / "poses.csv")
        assert last is not None
        assert (last.number, last.real("true_x")) == (4, 2.5)


def test_a_file_that_an_editor_gave_other_line_ends_reads_the_same(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_bytes(b"\xef\xbb\xbf" + POSES.replace("\n", "\r\n").encode())
    assert read_columns(tmp_path / "poses.csv", "poses")["estimated_heading"].tolist() == [6.0] * 3


def test_a_header_alone_is_no_lines(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text(HEADER + "\n")
    assert read_columns(tmp_path / "poses.csv", "poses")["true_x"].shape == (0,)
    assert list(read_lines(tmp_path / "poses.csv")) == []
    assert last_line(tmp_path / "poses.csv") is None


def test_a_plugins_own_file_has_texts_where_there_are_no_numbers(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("a,b\n1,2\n3,four\n")
    found = read_columns(tmp_path / "mine.csv", "mine")
    assert (found["a"].tolist(), found["b"].tolist()) == ([1.0, 3.0], ["2", "four"])


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("0.1,", "nan,", r"poses.csv, line 3, time: expected a finite number.* got 'nan'"),
        ("0.1,", "inf,", r"line 3, time: expected a finite number.* got 'inf'"),
        ("1.5", "1.5m", r"line 3, true_x: expected a number, got '1.5m'"),
        ("1.5", "", r"line 3, true_x: expected a finite number.* got ''"),
        ("1.5", "1e300", r"line 3, true_x: expected a finite number, of at most 1e\+100 in size, got '1e300'"),
        ("1.5,", "", r"line 3: is damaged: expected 8 cells, got 7"),
        ("true_x", "true_xx", r"line 1: is damaged: no column 'true_x'.* Did you mean 'true_xx'\?"),
        ("true_x", "time", r"line 1: is damaged: there are 2 columns 'time'"),
        ("1.5,", '"1.5,', r"line 3: is damaged: expected 8 cells"),
    ],
)
def test_what_is_damaged_is_named(tmp_path: Path, old: str, new: str, problem: str) -> None:
    (tmp_path / "poses.csv").write_text(POSES.replace(old, new, 1))
    with pytest.raises(am.RunError, match=problem):
        read_columns(tmp_path / "poses.csv", "poses")


def test_bytes_that_are_no_text_are_named_by_line(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_bytes(POSES.encode().replace(b"2.5", b"2\xff5"))
    for read in (lambda path: read_columns(path, "poses"), lambda path: list(read_lines(path)), last_line):
        with pytest.raises(am.RunError, match=r"poses.csv, line 4: is damaged: byte 0xff is not UTF-8"):
            read(tmp_path / "poses.csv")


@pytest.mark.parametrize("tick", ["1.0", "-1", "²", "1" * 19])
def test_ticks_are_whole_numbers(tmp_path: Path, tick: str) -> None:
    (tmp_path / "events.csv").write_text(EVENTS.replace(",,,0\n", f",,,{tick}\n"))
    with pytest.raises(am.RunError, match=r"line 2, tick: expected a whole number >= 0"):
        read_columns(tmp_path / "events.csv", "events")
    with pytest.raises(am.RunError, match=r"line 2, tick: expected a whole number >= 0"):
        next(read_lines(tmp_path / "events.csv")).whole("tick")


def test_readings_have_both_channels_of_every_value(tmp_path: Path) -> None:
    (tmp_path / "gyro.csv").write_text("time,stamp,robot,true_0,measured_1\n")
    with pytest.raises(am.RunError, match="no column 'measured_0'"):
        read_columns(tmp_path / "gyro.csv", "sensors/gyro")
    (tmp_path / "gyro.csv").write_text("time,stamp,robot,true_1,measured_1\n")
    with pytest.raises(am.RunError, match="no column 'true_0'"):
        read_columns(tmp_path / "gyro.csv", "sensors/gyro")


def test_what_is_no_regular_file_is_not_read(tmp_path: Path) -> None:
    with pytest.raises(am.RunError, match=r"poses.csv: cannot be read"):
        read_columns(tmp_path / "poses.csv", "poses")
    os.mkfifo(tmp_path / "poses.csv")
    with pytest.raises(am.RunError, match="it is not a regular file"):
        read_columns(tmp_path / "poses.csv", "poses")


def test_a_line_without_end_is_refused_before_it_fills_the_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tables, "LONGEST_LINE", 1000)
    monkeypatch.setattr(tables, "_BLOCK", 100)
    with (tmp_path / "poses.csv").open("wb") as file:
        file.truncate(5000)
    with pytest.raises(am.RunError, match="line 1: is damaged: it is longer than 1000 bytes"):
        read_columns(tmp_path / "poses.csv", "poses")
