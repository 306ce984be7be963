"""Compiling ahead, with a second process that fails or never ends."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

import amorsim as am
from amorsim.plugins.manager import make_registry
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
        return [sys.executable, "-c", f"for _ in range({len(names)}): print('done')"]

    monkeypatch.setattr(warm, "_command", command)
    monkeypatch.setattr(warm, "_try_all", lambda some, one_more: [one_more() for _ in some] and tried.extend(some))
    counted: list[tuple[int, int]] = []
    warm.compile_kernels(lambda done, total: counted.append((done, total)), more=True)
    bundled = [name for name in make_registry(entry_points=()).names("scenario") if name != "learned"]  # needs an extra
    known = [*warm._TRIALS, *warm._OTHERS, *bundled]
    assert sorted(tried + asked[0]) == sorted(known)
    assert counted == [(done, len(known)) for done in range(len(known) + 1)]


@pytest.mark.parametrize("name", list(warm._TRIALS))
def test_a_trial_simulates_what_it_is_for(name: str) -> None:
    scenario, steps = warm._TRIALS[name]()
    simulation = am.Simulation(scenario)
    simulation.run(steps * scenario.dt)
    met = {event.other for event in simulation.events if event.kind == "collision"}
    assert met == ({"wall", "robot0", "robot1"} if name == "collide" else set())


def test_all_that_avoid_things_are_tried() -> None:
    names = {robot.name for robot in warm._avoiders().robots}
    assert names >= {"bug2", "dwa", "mppi", "orca", "vfh_plus"}


@pytest.mark.long
def test_worlds_and_planners_have_all_their_kernels_after_compiling() -> None:
    code = """
import importlib, pkgutil
from amorsim.kernels import search
from amorsim.runs import warm
for other in warm._OTHERS.values():
    other()
names = [f"amorsim.kernels.search.{module.name}" for module in pkgutil.iter_modules(search.__path__)]
for name in [*names, "amorsim.kernels.grid.disc_places"]:
    for key, value in vars(importlib.import_module(name)).items():
        # Parts of kernels come from the cache within them, and tell of no signatures then.
        is_kernel = getattr(value, "__module__", "") == name and getattr(value, "targetoptions", {}).get("_nrt", True)
        if is_kernel and getattr(value, "signatures", None) == []:
            print(name, key)
"""
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == ""
