"""The section of studies: all three sides simulate the same, and the second process's time is counted."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks import studies
from benchmarks.table import as_text
from tests.sweeps.studies import needs_extra


@needs_extra
@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_studies_are_timed_by_all_their_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(studies, "_QUICK", (2, 2, 0.3))
    seen: list[Any] = []
    bare = studies._bare
    monkeypatch.setattr(studies, "_bare", lambda tables: (seen.append(tables["replicas"]), bare(tables)))
    rows = studies.measure(1, True, lambda _: None)
    assert [row.side for row in rows] == ["Simulation.run", "amorsim, one process", "amorsim, two processes"]
    assert seen == [2, 2]  # once before, to compile
    alone, one, two = (row.rounds[0] for row in rows)
    assert two > one + 0.2  # the start of two processes
    assert min(alone, one) > 0.0
    assert "as fast as one process" in as_text(rows, {}, "", (), ())


@needs_extra
def test_the_short_command_prints_all_sides(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seen: list[int] = []
    monkeypatch.setattr(studies, "_bare", lambda tables: seen.append(tables["axes"][studies._TRACK]["count"]))
    monkeypatch.setattr(studies, "_swept", lambda tables, out, jobs: (seen.append(jobs), out.mkdir()))
    assert studies.main(["--points", "3", "--rounds", "2"]) == 0
    assert seen == [2, 3, 1, 2, 3, 1, 2]
    said = capsys.readouterr()
    assert "3 points x 100 replicas x 60 s" in said.out
    assert "amorsim, two processes: " in said.out
    assert "round 2; load " in said.err
