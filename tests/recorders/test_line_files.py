"""Files of whole lines: in the system in time, and whole when the disk is full."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from amorsim.core.errors import RunError
from amorsim.recorders.line_files import LONGEST_WAIT, PAGE, LineFile, LineFiles
from tests.disks import small_disk


def test_lines_reach_the_system_in_time_though_nobody_writes_any_more(tmp_path: Path) -> None:
    files = LineFiles()
    files.add("a", tmp_path / "a.csv", "one,two")
    assert (tmp_path / "a.csv").read_text() == "one,two\n"
    files.write("a", "1,2\n3,4\n")
    deadline = time.monotonic() + LONGEST_WAIT + 0.5  # a second, at most
    while (tmp_path / "a.csv").read_text() != "one,two\n1,2\n3,4\n":
        assert time.monotonic() < deadline
        time.sleep(0.01)
    files.close()


def test_closing_hands_over_what_is_left_and_may_be_done_again(tmp_path: Path) -> None:
    files = LineFiles()
    files.add("a", tmp_path / "a.csv", "head")
    files.write("a", "last\n")
    files.close()
    files.close()
    assert (tmp_path / "a.csv").read_text() == "head\nlast\n"


def test_lines_are_held_back_for_few_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = LineFile(tmp_path / "a.csv", "head")
    written = []
    write = __import__("os").write
    monkeypatch.setattr("os.write", lambda *args: written.append(args) or write(*args))
    for _ in range(1000):
        file.write("line\n")
    assert written == []
    file.close()
    assert len(written) == 2  # pages
    assert (tmp_path / "a.csv").read_text().count("line\n") == 1000


def test_a_short_write_is_gone_on_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = __import__("os").write
    monkeypatch.setattr("os.write", lambda descriptor, data: write(descriptor, data[:3]))
    file = LineFile(tmp_path / "a.csv", "header")
    file.write("äöü,1\n")
    file.close()
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == "header\näöü,1\n"


@small_disk()
def test_a_full_disk_leaves_whole_lines_and_an_error_that_names_the_file(tmp_path: Path) -> None:
    file = LineFile(tmp_path / "a.csv", "head")
    file.write("0123456789012345\n" * 100)
    with pytest.raises(RunError, match=r"a.csv: cannot be written \(File too large\)"):
        file.flush()
    with pytest.raises(RunError, match="File too large"):  # or lines would be missing within it
        file.write("after the gap\n")
    with pytest.raises(RunError, match="File too large"):
        file.close()
    assert (tmp_path / "a.csv").read_text() == "head\n" + "0123456789012345\n" * 58


@small_disk()
def test_a_full_disk_that_the_thread_meets_is_reported_to_the_next_writer(tmp_path: Path) -> None:
    files = LineFiles()
    files.add("a", tmp_path / "a.csv", "head")
    files.add("b", tmp_path / "b.csv", "head")
    files.write("a", "0123456789012345\n" * 100)
    assert files._thread is not None
    files._thread.join(timeout=60.0)
    with pytest.raises(RunError, match="File too large"):
        files.write("b", "1\n")
    with pytest.raises(RunError, match="File too large"):
        files.close()
    assert (tmp_path / "a.csv").read_text().endswith("5\n")


def test_no_line_is_written_in_two_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A kill breaks a write off between two pages: what is written at a time are whole lines, of a page at most."""
    write, written = __import__("os").write, []
    monkeypatch.setattr("os.write", lambda descriptor, data: written.append(bytes(data)) or write(descriptor, data))
    lines = [f"{'x' * (i * 37 % 200)},{i}\n" for i in range(2000)]
    lines[1000] = "y" * 3 * PAGE + "\n"
    file = LineFile(tmp_path / "a.csv", "head")
    file.write("".join(lines))  # at once, more than is held back
    for line in lines:
        file.write(line)
    file.close()
    assert (tmp_path / "a.csv").read_text() == "head\n" + 2 * "".join(lines)
    assert all(data.endswith(b"\n") and (len(data) <= PAGE or data.count(b"\n") == 1) for data in written)
    assert len(written) < 2.5 * sum(map(len, lines)) / (PAGE - 200)


def test_a_file_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    with pytest.raises(RunError, match=r"nowhere/a.csv: cannot be written"):
        LineFile(tmp_path / "nowhere" / "a.csv", "head")
