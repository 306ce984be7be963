"""`amorsim view` as a process, for the tests of its life: started, driven as a window does it, ended."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from amorsim.cli.console import compile_once
from amorsim.ui.simulator.frames.packing import FRAME_HEADER
from tests.processes import is_running
from tests.ui.aside import aside


class View:
    """`amorsim view` with these arguments, once it has printed its address; `first` is done by the process before.

    Or a script that opens a window.
    """

    def __init__(
        self,
        *arguments: str,
        cwd: Path,
        command: str = "view",
        first: str = "",
        script: str = "",
        is_opened: bool = False,
    ) -> None:
        main = f"import sys\n{first}\nfrom amorsim.cli import main\nmain()"
        opening = "--open" if is_opened else "--no-open"
        self.process = subprocess.Popen(
            [sys.executable, script] if script else [sys.executable, "-c", main, command, *arguments, opening],
            cwd=cwd,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        assert self.process.stdout is not None
        self.lines = []
        while line := self.process.stdout.readline():
            self.lines.append(line)
            if line.startswith("http://"):
                break
        else:
            raise AssertionError(self.process.communicate())
        self.address = line.strip()  # which works once
        # The child that it started, and none else.
        self.children = [int(pid) for pid in children_of(self.process.pid)]

    def end(self, number: signal.Signals) -> tuple[float, str]:
        """Send a signal; how long it took until the process and its child were gone [s], and what it said then."""
        began = time.monotonic()
        self.process.send_signal(number)
        said, _ = self.process.communicate(timeout=60.0)
        until_gone(self.children)
        return time.monotonic() - began, said


def children_of(pid: int) -> list[str]:
    found: list[str] = []
    for task in Path(f"/proc/{pid}/task").iterdir():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # a thread that has ended meanwhile
            found += (task / "children").read_text(encoding="ascii").split()
    return found


def until_gone(pids: list[int]) -> float:
    """Wait until none of these processes is left; how long it took [s]."""
    began = time.monotonic()
    while any(is_running(pid) for pid in pids):
        assert time.monotonic() - began < 60.0, "an orphan is left"
        time.sleep(0.01)
    return time.monotonic() - began


@pytest.fixture
def views() -> Iterator[list[View]]:
    """Views that end with the test. Kernels are compiled before: a view that does so has more children for a while."""
    compile_once(lambda: None, quiet=True)
    started: list[View] = []
    yield started
    for view in started:
        if view.process.poll() is None:
            view.process.kill()
            view.process.communicate()


def cookie_of(view: View) -> str:
    """What the view's address is good for; the view has another address then."""
    parts = urlsplit(view.address)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port or 0, timeout=60.0)
    connection.request("GET", f"{parts.path}?{parts.query}")
    cookie = (connection.getresponse().getheader("set-cookie") or "").partition(";")[0]
    connection.close()
    assert view.process.stdout is not None
    view.lines.append(view.process.stdout.readline())
    view.address = view.lines[-1].split()[-1]
    return cookie


def first_page(view: View, cookie: str) -> str:
    """The path of the page that is shown first."""
    parts = urlsplit(view.address)
    connection = http.client.HTTPConnection(parts.hostname or "", parts.port or 0, timeout=60.0)
    connection.request("GET", "/", headers={"Cookie": cookie})
    path = connection.getresponse().getheader("location") or ""
    connection.close()
    return path


def drive(view: View) -> None:
    """Let it run, as a window does."""
    import websockets

    async def talk() -> None:
        parts = urlsplit(view.address)
        origin, cookie = f"http://{parts.netloc}", cookie_of(view)
        path = first_page(view, cookie)
        async with websockets.connect(
            f"ws://{parts.netloc}/amorsim/socket{path}",
            additional_headers={"Cookie": cookie},
            origin=origin,  # type: ignore[arg-type]
        ) as socket:
            await socket.send(json.dumps({"id": 1, "do": "speed", "factor": 5.0}))
            await socket.send(json.dumps({"id": 2, "do": "run"}))
            while True:
                said: Any = await asyncio.wait_for(socket.recv(), 60.0)
                if isinstance(said, bytes):
                    header = FRAME_HEADER.unpack_from(said)
                    await socket.send(json.dumps({"drawn": header[2]}))
                    if header[7] > 5:
                        return

    aside(talk())
