"""Compiling ahead, with a second process that fails or never ends."""

from __future__ import annotations

import sys
import time

import pytest

import amorsim as am
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
    monkeypatch.setattr(warm, "_command", lambda names: endless)
    monkeypatch.setattr(warm, "LONGEST_SECOND", 0.3)
    started = time.monotonic()
    warm.compile_kernels()
    assert time.monotonic() - started < 20.0
    assert tried == ["look", "demo"]


def test_the_second_process_does_not_look_into_the_present_folder() -> None:
    assert warm._command(["wander"])[1] == "-P"


def test_every_trial_is_made_once_and_counted(tried: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[list[str]] = []

    def command(names: list[str]) -> list[str]:
        asked.append(list(names))
        return [sys.executable, "-c", "print('done')"]

    monkeypatch.setattr(warm, "_command", command)
    monkeypatch.setattr(warm, "_try_all", lambda some, one_more: [one_more() for _ in some] and tried.extend(some))
    counted: list[tuple[int, int]] = []
    warm.compile_kernels(lambda done, total: counted.append((done, total)), more=True)
    assert sorted(tried + asked[0]) == sorted(warm._TRIALS)
    assert counted == [(done, 5) for done in range(6)]


@pytest.mark.parametrize("name", list(warm._TRIALS))
def test_a_trial_simulates_what_it_is_for(name: str) -> None:
    scenario, steps = warm._TRIALS[name]()
    simulation = am.Simulation(scenario)
    simulation.run(steps * scenario.dt)
    met = {event.other for event in simulation.events if event.kind == "collision"}
    assert met == ({"wall", "robot0", "robot1"} if name == "collide" else set())
