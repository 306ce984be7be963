"""Compiling in two processes: who is started, and what the contact that is compiled beside is made of."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from amorsim.simulation import warm


def test_one_process_is_started_and_none_on_one_core(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[list[str]] = []
    compiled: list[int] = []
    monkeypatch.setattr(subprocess, "Popen", lambda command, **_: started.append(command))
    monkeypatch.setattr(warm, "take_turns", lambda: None)
    monkeypatch.setattr(warm, "compile_ahead", lambda: compiled.append(len(started)))
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    warm.compile_together()
    assert started == []
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    warm.compile_together()
    assert started == [[sys.executable, "-c", "from amorsim.simulation.warm import main; main()"]]
    assert compiled == [0, 1]  # in this process too, once the other is on its way


def test_the_process_beside_compiles_what_is_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr(warm, "take_turns", lambda: done.append("turns"))
    monkeypatch.setattr(warm, "compile_ahead", lambda: done.append("ahead"))
    warm.main()
    assert done == ["turns", "ahead"]


def test_robots_meet_a_wall_and_each_other() -> None:
    met = {(event.name, event.other) for event in warm.collide().events}
    assert {("first", "wall"), ("second", "first")} <= met


def test_contact_is_compiled_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    started: list[list[str]] = []
    monkeypatch.setattr(subprocess, "Popen", lambda command, **_: started.append(command))
    monkeypatch.setattr(warm, "take_turns", lambda: None)
    monkeypatch.setattr(warm, "_contact_stamp", lambda: tmp_path / "stamp")
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    monkeypatch.setattr(warm, "_end_with_the_other", lambda: None)
    warm.compile_contact_beside()
    assert started == [[sys.executable, "-c", "from amorsim.simulation.warm import meet; meet()"]]
    assert not (tmp_path / "stamp").exists()
    warm.meet()
    assert (tmp_path / "stamp").exists()
    warm.compile_contact_beside()
    assert len(started) == 1


def test_it_ends_with_whoever_started_it() -> None:
    long = "import time; from amorsim.simulation import warm; warm.collide = lambda: time.sleep(60); warm.meet()"
    process = subprocess.Popen([sys.executable, "-c", long], stdin=subprocess.PIPE)
    assert process.stdin is not None
    process.stdin.close()
    assert process.wait(40.0) == 1
