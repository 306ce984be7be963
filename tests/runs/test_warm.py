"""Compiling ahead, with a second process that fails or never ends."""

from __future__ import annotations

import sys
import time

import pytest

from amorsim.runs import warm


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The trials that were made in this process, none of which is one."""
    names: list[str] = []
    monkeypatch.setattr(warm, "_try_all", lambda some, one_more: names.extend(some))
    monkeypatch.setattr(warm, "mark_warm", lambda: None)
    return names


def test_a_second_process_that_does_not_end_is_ended(tried: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    endless = [sys.executable, "-c", "import time; time.sleep(60)"]
    monkeypatch.setattr(warm, "_command", lambda: endless)
    monkeypatch.setattr(warm, "LONGEST_SECOND", 0.3)
    started = time.monotonic()
    warm.compile_kernels()
    assert time.monotonic() - started < 20.0
    assert "roll" in tried


def test_the_second_process_does_not_look_into_the_present_folder() -> None:
    assert warm._command()[1] == "-P"
