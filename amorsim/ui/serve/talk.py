"""The messages between the server and one window over the window's WebSocket.

From the window comes text (see `amorsim.ui.serve.wire`): commands, each answered by ``{"answer": n, "said": ...}``, and
which frame it has drawn. What is neither is answered too, with what is wrong with it. To the window go
frames as bytes, but none before the last is drawn, and at most `FRAME_RATE` a second: a slow, hidden or vanished window
slows nothing and piles up nothing.
"""

from __future__ import annotations

import asyncio
import json
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from amorsim.ui.serve.pages import Talks
from amorsim.ui.serve.wire import MessageError, decode, number_of

__all__ = ["FRAME_RATE", "Talk"]

FRAME_RATE = 40.0  # [Hz]
MOST_WAITING = 64  # commands of one window
MOST_OF_TAB = 64  # letters

Table = dict[str, Any]


class Talk:
    """The conversation with one window."""

    def __init__(self, websocket: WebSocket, session: Talks) -> None:
        self.websocket = websocket
        self.session = session
        self.window = ""
        self.drawn = asyncio.Event()
        self.commands: asyncio.Queue[Table] = asyncio.Queue(MOST_WAITING)
        self.reads: set[asyncio.Task[None]] = set()
        self.sending = asyncio.Lock()

    async def run(self) -> None:
        """Serve the connection until the window is closed."""
        await self.websocket.accept()
        self.window = self.session.open_window(self.websocket.query_params.get("tab", "")[:MOST_OF_TAB])
        tasks = [asyncio.create_task(work()) for work in (self._hear, self._show, self._obey)]
        try:
            await self._send({"window": self.window})
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in (*tasks, *self.reads):
                task.cancel()
            self.session.close_window(self.window)
            ends = await asyncio.gather(*tasks, *self.reads, return_exceptions=True)
        for end in ends:
            # A window that goes while something is sent to it is not a fault; anything else is ours, and is raised.
            if isinstance(end, Exception) and not isinstance(end, (WebSocketDisconnect, RuntimeError, OSError)):
                raise end

    async def _send(self, message: Table) -> None:
        async with self.sending:
            await self.websocket.send_text(json.dumps(message))

    async def _hear(self) -> None:
        while True:
            received = await self.websocket.receive()
            if received["type"] == "websocket.disconnect":
                raise WebSocketDisconnect(received.get("code", 1000))
            try:
                message = decode(received.get("text"))
            except MessageError as error:
                await self._refuse(None, str(error))
                continue
            if "drawn" in message:
                self.drawn.set()
            elif self.session.only_asks(message["do"]) and len(self.reads) < MOST_WAITING:
                task = asyncio.create_task(self._answer(message))
                self.reads.add(task)
                task.add_done_callback(self.reads.discard)
            elif self.commands.full():
                await self._refuse(number_of(message), "Too much at once.")
            else:
                self.commands.put_nowait(message)

    async def _refuse(self, number: int | None, problem: str) -> None:
        await self._send({"answer": number, "said": {"ok": False, "error": problem}})

    async def _obey(self) -> None:
        while True:
            await self._answer(await self.commands.get())

    async def _answer(self, message: Table) -> None:
        number = number_of(message)
        message.pop("id", None)
        await self._send({"answer": number, "said": await self.session.ask(self.window, message)})

    async def _show(self) -> None:
        after = 0
        clock = asyncio.get_running_loop().time
        due = clock()
        coming = self._coming(after)
        try:
            while frame := await coming:
                after = int.from_bytes(frame[8:12], "little")
                self.drawn.clear()
                async with self.sending:
                    await self.websocket.send_bytes(frame)
                coming = self._coming(after)  # made while the window draws this one
                await self.drawn.wait()
                # By the clock, not by the last frame: one that comes late does not put off those after it.
                due = max(due, clock() - 1.0 / FRAME_RATE) + 1.0 / FRAME_RATE
                await asyncio.sleep(max(0.0, due - clock()))
                if coming.done():  # the window took its time, and something newer may have come
                    coming = self._coming(after)
        finally:
            coming.cancel()

    def _coming(self, after: int) -> asyncio.Task[bytes]:
        return asyncio.create_task(self.session.newest_frame(after, self.window))
