"""A window's WebSocket: frames wait for the window, never the other way; commands keep their order."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import Any, ClassVar

import pytest

pytest.importorskip("starlette", reason="the extra 'ui' is not installed")

from amorsim.ui.serve import talk
from amorsim.ui.serve.talk import Talk
from tests.ui.aside import aside
from tests.ui.stub import StubSession


class Line:
    """A WebSocket's two ends, as far as `Talk` uses them."""

    query_params: ClassVar[dict[str, str]] = {}

    def __init__(self) -> None:
        self.heard: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.texts: list[dict[str, Any]] = []
        self.frames: list[int] = []

    async def accept(self) -> None:
        pass

    async def receive(self) -> dict[str, Any]:
        return await self.heard.get()

    async def send_text(self, text: str) -> None:
        self.texts.append(json.loads(text))

    async def send_bytes(self, data: bytes) -> None:
        self.frames.append(int.from_bytes(data[8:12], "little"))

    def say(self, **message: Any) -> None:
        self.heard.put_nowait({"type": "websocket.receive", "text": json.dumps(message)})

    def go(self) -> None:
        self.heard.put_nowait({"type": "websocket.disconnect", "code": 1001})


async def until(holds: Callable[[], bool]) -> None:
    """Let the talk go on until something holds, however long it takes a busy machine."""
    loop = asyncio.get_running_loop()
    end = loop.time() + 30.0
    while not holds():
        assert loop.time() < end
        await asyncio.sleep(0.001)


def hold(conversation: Any) -> None:
    """Run `await conversation(line, session)` beside a talk that has begun, which must then end by itself."""

    async def whole() -> None:
        line, session = Line(), StubSession()
        running = asyncio.create_task(Talk(line, session).run())  # type: ignore[arg-type]
        await until(lambda: line.frames == [1] and bool(line.texts))
        await conversation(line, session)
        line.go()
        await asyncio.wait_for(running, 30.0)
        assert not session.windows  # a window that goes is forgotten

    aside(whole())


def test_no_frame_goes_out_before_the_last_is_drawn() -> None:
    async def conversation(line: Line, session: StubSession) -> None:
        assert line.texts[0] == {"window": "window-1"}
        for number in range(2, 40):
            session.number = number
            await asyncio.sleep(0.002)
        assert line.frames == [1]  # a window that draws nothing is sent nothing
        line.say(drawn=0)
        await until(lambda: len(line.frames) > 1)
        assert line.frames == [1, 39]  # then the newest, not what it missed

    hold(conversation)


def test_frames_keep_to_their_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(talk, "FRAME_RATE", 20.0)

    async def conversation(line: Line, session: StubSession) -> None:
        clock = asyncio.get_running_loop().time
        began = clock()
        while len(line.frames) < 10:
            assert clock() - began < 30.0
            session.number += 1
            line.say(drawn=0)
            await asyncio.sleep(0.005)
            # One that comes late does not put off the next; so two may come together, and no more.
            assert len(line.frames) <= 20.0 * (clock() - began) + 3.0

    hold(conversation)


def test_commands_are_done_in_order_and_questions_meanwhile() -> None:
    async def conversation(line: Line, session: StubSession) -> None:
        release = session.hold()
        line.say(id=1, do="wait")
        line.say(id=2, do="run")
        line.say(id=3, do="state")
        await until(lambda: len(line.texts) > 1)
        assert [text["answer"] for text in line.texts[1:]] == [3]
        release.set()
        await until(lambda: len(line.texts) > 3)
        assert [text["answer"] for text in line.texts[1:]] == [3, 1, 2]
        assert [command["do"] for command in session.asked] == ["wait", "state", "run"]

    hold(conversation)


def test_a_flood_of_commands_is_refused_not_kept() -> None:
    async def conversation(line: Line, session: StubSession) -> None:
        release = session.hold()
        line.say(id=0, do="wait")
        await until(lambda: bool(session.asked))
        most = talk.MOST_WAITING
        for number in range(1, most + 11):
            line.say(id=number, do="step")
        await until(lambda: len(line.texts) > 10)
        release.set()
        await until(lambda: len(line.texts) > most + 11)
        refused = [text for text in line.texts[1:] if not text["said"]["ok"]]
        assert [text["answer"] for text in refused] == list(range(most + 1, most + 11))

    hold(conversation)


@pytest.mark.parametrize(
    "junk",
    [
        *(
            "no json",
            "[1]",
            '"run"',
            "\x00",
            "",
            "{}",
            "[" * 60_000,
            "9" * 5000,
            '{"do": ["run"]}',
            '{"do": {"x": NaN}}',
        ),
        *('{"drawn": "1"}', '{"drawn": -1}', '{"drawn": 1e400}', '{"drawn": Infinity}'),
        None,  # bytes
    ],
    ids=lambda junk: str(junk)[:20],
)
def test_what_is_no_message_is_answered_and_the_talk_goes_on(junk: str | None) -> None:
    async def conversation(line: Line, session: StubSession) -> None:
        line.heard.put_nowait({"type": "websocket.receive", **({"bytes": b"junk"} if junk is None else {"text": junk})})
        line.say(id=7, do="state")
        await until(lambda: len(line.texts) > 2)
        refused, answered = line.texts[1:]
        assert refused["answer"] is None
        assert not refused["said"]["ok"]
        assert len(refused["said"]["error"]) < 200
        assert answered == {"answer": 7, "said": {"ok": True, "window": "window-1", "said": "state"}}
        assert line.frames == [1]

    hold(conversation)


@pytest.mark.parametrize("number", ["x", [1], -1, 1.5, 10**400, True, None])
def test_a_command_whose_number_is_none_is_answered_without(number: Any) -> None:
    async def conversation(line: Line, session: StubSession) -> None:
        line.say(id=number, do="state")
        await until(lambda: len(line.texts) > 1)
        assert line.texts[1]["answer"] is None
        assert line.texts[1]["said"]["ok"]

    hold(conversation)
