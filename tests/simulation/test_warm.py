"""Compiling beside a run: who is started, and what the contact that is compiled is made of."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from amorsim.kernels.beside import command_for
from amorsim.simulation import warm


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
    assert started == [command_for("amorsim.simulation.warm", "meet")]
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
