"""Sessions for tests: a scenario in a folder, and what ends all that a test started."""

from __future__ import annotations

import asyncio
import concurrent.futures
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

import pytest

from amorsim.ui.simulator.link import Link
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


class Driven:
    """A session in an event loop of its own, asked from the tests' thread."""

    def __init__(self, recipe: Recipe, **options: Any) -> None:
        self.session = Session(recipe, **options)
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

    def _later(self, work: Coroutine[Any, Any, T]) -> concurrent.futures.Future[T]:
        return asyncio.run_coroutine_threadsafe(work, self._loop)

    def call(self, function: Callable[..., T], *arguments: Any) -> T:
        """What a function returns that the session's loop calls."""

        async def called() -> T:
            return function(*arguments)

        return self._later(called()).result(60.0)

    def start(self) -> None:
        self._later(self.session.start()).result(600.0)

    def close(self) -> None:
        if self._loop.is_closed():
            return
        self._later(self.session.close()).result(60.0)
        self._later(self._finish()).result(60.0)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(60.0)
        self._loop.close()

    async def _finish(self) -> None:
        others = [task for task in asyncio.all_tasks() if task is not asyncio.current_task()]
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)
        await self._loop.shutdown_default_executor()

    def __enter__(self) -> Driven:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def request(self, command: Mapping[str, Any]) -> dict[str, Any]:
        try:
            return self._later(self.session.request(command)).result(600.0)
        except concurrent.futures.CancelledError:  # its window's socket would be closed
            return {"ok": False, "error": "the session was closed"}

    async def ask(self, window: str, command: Mapping[str, Any]) -> dict[str, Any]:
        return await asyncio.wrap_future(self._later(self.session.ask(window, command)))

    async def newest_frame(self, after: int = 0, window: str = "") -> bytes:
        return await asyncio.wrap_future(self._later(self.session.newest_frame(after, window)))

    def open_window(self) -> str:
        return self.call(self.session.open_window)

    def close_window(self, window: str) -> None:
        self.call(self.session.close_window, window)

    @property
    def link(self) -> Link:
        found = self.session._supervisor.link
        assert found is not None
        return found

    @property
    def hang(self) -> dict[str, Any] | None:
        return self.session._supervisor.hang

    @property
    def scene(self) -> Any:
        return self.session.scene

    @property
    def holder(self) -> str:
        return self.session.holder

    @property
    def folder(self) -> str:
        return self.session.folder


T = TypeVar("T")
Make = Callable[..., Driven]


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
    started: list[Driven] = []

    def make(controller: str = "own.py:Circling", duration: float = 60.0, **options: Any) -> Driven:
        path = write_project(tmp_path, controller, duration)
        session = Driven(Recipe(name=str(path)), project=tmp_path, **options)
        started.append(session)
        session.start()
        return session

    yield make
    for session in started:
        session.close()
