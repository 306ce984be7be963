"""Compiling beside: the steps that are made for it are those of a real robot."""

from __future__ import annotations

import subprocess
import sys

import pytest

from amorsim.simulation import warm


def test_the_steps_can_be_made() -> None:
    warm.main()


def test_one_process_is_started_and_none_on_one_core(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[list[str]] = []
    monkeypatch.setattr(subprocess, "Popen", lambda command, **_: started.append(command))
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    warm.compile_beside()
    assert started == []
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    warm.compile_beside()
    assert started == [[sys.executable, "-c", "from amorsim.simulation.warm import main; main()"]]
