"""A study needs no more memory for many points than for few: chunks are let go once they are written."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.sweeps import executors, folder, table
from amorsim.sweeps.chunk import Outcome
from amorsim.sweeps.plan import Plan
from tests.sweeps.studies import METRICS, TRACK, needs_extra, tables

POINTS = 40
FEW = 3  # outcomes alive at once: the one that comes, the one before, and one that a loop still names


class Alive:
    """Counts the outcomes that are alive whenever another is made."""

    def __init__(self) -> None:
        self._made: list[weakref.ref[Outcome]] = []
        self.most = 0

    def count(self, outcome: Outcome) -> Outcome:
        self._made.append(weakref.ref(outcome))
        self.most = max(self.most, sum(each() is not None for each in self._made))
        return outcome


def made(plan: Plan, index: int, where: str = "") -> Outcome:
    """What a simulation would give."""
    values = {name: [float(index)] * plan.replicas for name in METRICS}
    return Outcome(index=index, values=values, digests=["0" * 32] * plan.replicas)


@pytest.mark.long
def test_outcomes_are_let_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gc.disable()  # what only the collector finds counts as kept
    try:
        computed, read = Alive(), Alive()
        monkeypatch.setattr(executors, "run_chunk", lambda *given: computed.count(made(*given)))
        real = folder.StudyFolder._read
        monkeypatch.setattr(folder.StudyFolder, "_read", lambda self, index: read.count(real(self, index)))
        monkeypatch.setattr(table, "_ROWS", 10)
        parts = []
        real_parts = table._parts

        def counted(*given: Any) -> Any:
            for part in real_parts(*given):
                parts.append(len(part["point"]))
                yield part

        monkeypatch.setattr(table, "_parts", counted)
        given = tables(tmp_path / "s", axes={TRACK: {"from": 1.0, "to": 1.1, "count": POINTS}}, replicas=2)
        study = am.sweep(given, tmp_path / "out")
    finally:
        gc.enable()
    assert study["length"].tolist() == [float(point) for point in range(POINTS) for _ in range(2)]
    assert computed.most <= FEW
    assert read.most <= FEW
    assert sum(parts) == 2 * POINTS
    assert max(parts) < 10 + 2


@needs_extra
@pytest.mark.long
@pytest.mark.filterwarnings("default")
def test_processes_get_work_only_as_they_need_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ahead: list[int] = []
    begun = 0
    real = executors.in_processes

    def counted(plan: Plan, todo: Sequence[int], work_of: executors.MakeWork, jobs: int) -> Any:
        def begin(index: int) -> executors.Work:
            nonlocal begun
            begun += 1
            return work_of(index)

        for done, outcome in enumerate(real(plan, todo, begin, jobs)):
            ahead.append(begun - done)
            yield outcome

    monkeypatch.setattr("amorsim.sweeps.sweep.in_processes", counted)
    axes = {TRACK: {"from": 1.0, "to": 1.1, "count": 40}}
    study = am.sweep(tables(tmp_path / "s", axes=axes, replicas=1, duration=0.2), tmp_path / "out", jobs=2)
    assert study.is_complete
    assert len(ahead) == 40
    # A process may finish several while this one looks at the next: dispatch is bounded by what is done, not seen.
    assert ahead[0] < 40
