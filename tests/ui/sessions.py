"""Sessions for tests: a scenario in a folder, and what ends all that a test started."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.session import Session

ROOM = "width 6000\nheight 5000\n0 0 6000 0\n6000 0 6000 5000\n6000 5000 0 5000\n0 5000 0 0\n"
SCENARIO = """
format = 1
world = {{ map = "room.wld" }}
simulation = {{ dt = 0.1, duration = {duration}, seed = 5 }}

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = {{ x = 1.5, y = 2.5 }}
controller = {{ use = "{controller}" }}

[[robots]]
name = "other"
model = "pioneer2dx"
pose = {{ x = 1.5, y = 1.2 }}
controller = {{ use = "manual" }}
"""
CONTROLLERS = """
import os, threading, time
import amorsim as am

class Circling:
    def __init__(self):
        self.calls = 0

    def command(self, readings, estimate, clock):
        self.calls += 1
        return am.Twist(0.2, 0.4 + 0.001 * self.calls)

class Raising(Circling):
    def command(self, readings, estimate, clock):
        if clock.tick == 40:
            raise ZeroDivisionError("by design")
        return super().command(readings, estimate, clock)

class Endless(Circling):
    def command(self, readings, estimate, clock):
        while clock.tick == 40:
            pass
        return super().command(readings, estimate, clock)

class Sleeping(Circling):
    def command(self, readings, estimate, clock):
        if clock.tick == 40:
            time.sleep(3600)
        return super().command(readings, estimate, clock)

class Exiting(Circling):
    def command(self, readings, estimate, clock):
        if clock.tick == 40:
            os._exit(3)
        return super().command(readings, estimate, clock)

class Held(Exiting):
    def __init__(self):
        super().__init__()
        self.lock = threading.Lock()  # which nothing can copy

class Compiling(Circling):
    # As though a kernel were compiled for the first time, for as long as there is a file.
    def command(self, readings, estimate, clock):
        from numba.core.compiler_lock import global_compiler_lock

        @global_compiler_lock
        def compiles():
            while os.path.exists("compiling"):
                time.sleep(0.01)

        if clock.tick == 40:
            compiles()
        return super().command(readings, estimate, clock)

def printing(readings, estimate, clock):
    print("J" * 100)
    return am.Twist(0.1, 0.0)
"""

Make = Callable[..., Session]


def write_project(folder: Path, controller: str = "own.py:Circling", duration: float = 60.0) -> Path:
    """A scenario of two robots in a room; the first has a controller of the user's, the second stands."""
    (folder / "room.wld").write_text(ROOM)
    (folder / "own.py").write_text(CONTROLLERS)
    path = folder / "scenario.toml"
    path.write_text(SCENARIO.format(controller=controller, duration=duration))
    return path


def in_time() -> float:
    """The two seconds [s] that are promised, and what else there is to do on this machine at present.

    To start Python ten times takes some tenths of a second where there is nothing else.
    """
    began = time.monotonic()
    subprocess.run([sys.executable, "-c", ""], check=True)
    return 2.0 + 10.0 * (time.monotonic() - began)


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Make]:
    """Starts a session of the scenario, with another controller if one is named."""
    started: list[Session] = []

    def make(controller: str = "own.py:Circling", duration: float = 60.0, **options: Any) -> Session:
        path = write_project(tmp_path, controller, duration)
        session = Session(Recipe(name=str(path)), project=tmp_path, **options)
        started.append(session)
        session.start()
        return session

    yield make
    for session in started:
        session.close()
