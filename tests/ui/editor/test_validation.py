"""When a document is checked: at once after a change, and again for what was changed meanwhile."""

from __future__ import annotations

import asyncio
import queue
import threading
from pathlib import Path
from typing import Any

import pytest

from amorsim.ui.editor.looking import Looked
from amorsim.ui.editor.reader import Reader
from amorsim.ui.editor.session import EditSession
from amorsim.ui.editor.work import Work
from tests.ui.aside import aside
from tests.ui.editor.talking import do

ROBOT = '\n[[robots]]\nname = "r{n}"\nmodel = "pioneer2dx"\npose = {{ x = {n}.0, y = 1.0 }}\n'


class Noting(Reader):
    """Notes which texts it is asked to look at, and answers once it may."""

    def __init__(self) -> None:
        super().__init__()
        self.asked: queue.Queue[str] = queue.Queue()
        self.may_answer = threading.Event()

    def start(self) -> None:
        pass

    def ask(self, name: str, /, **arguments: Any) -> Any:
        self.asked.put(arguments["text"])
        assert self.may_answer.wait(30.0)
        return Looked(faults=[], things=[], still=None)


def seed(session: EditSession, value: int) -> Any:
    change = {"op": "set", "path": "simulation.seed", "value": value}
    return do(session, do="edit", label="seed", changes=[change])


@pytest.mark.parametrize("count", [1, pytest.param(1000, marks=pytest.mark.long)])
def test_a_change_is_checked_without_waiting_for_anything_else(count: int, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("format = 1\n" + "".join(ROBOT.format(n=n) for n in range(count)))

    async def say() -> None:
        reader = Noting()
        async with EditSession(Work(str(file), tmp_path), reader=reader) as session:
            reader.may_answer.set()
            while (await do(session, do="document", after=0))["is_behind"]:
                await asyncio.sleep(0.0)
            reader.asked.get_nowait()
            await seed(session, 7)
            for _ in range(3):  # turns of the loop, in which no time is waited for
                await asyncio.sleep(0.0)
            # The loop stands still here, so that a timer would not run off.
            assert "seed = 7" in reader.asked.get(timeout=5.0)

    aside(say())


def test_of_changes_while_one_is_checked_the_last_is_checked_next(tmp_path: Path) -> None:
    async def say() -> None:
        reader = Noting()
        async with EditSession(Work("", tmp_path), reader=reader) as session:
            await asyncio.to_thread(reader.asked.get, timeout=5.0)
            for value in (1, 2, 3):
                await seed(session, value)
            assert session.state()["is_behind"]
            reader.may_answer.set()
            assert "seed = 3" in await asyncio.to_thread(reader.asked.get, timeout=5.0)
            while session.state()["is_behind"]:
                await asyncio.sleep(0.0)
            assert reader.asked.empty()

    aside(say())
