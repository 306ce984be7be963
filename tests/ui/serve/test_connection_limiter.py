"""Before the door: who does not say in time what he wants is sent away, as is who comes with too many."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest

from amorsim.ui.serve.connection_limiter import ConnectionLimiter
from tests.ui.aside import aside

LONG = 30.0  # [s] that a busy machine gets


class Echo(asyncio.Protocol):
    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        assert isinstance(self.transport, asyncio.Transport)
        self.transport.write(data)


Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


def hold(limiter: ConnectionLimiter, visit: Callable[[Callable[[], Awaitable[Streams]]], Awaitable[None]]) -> None:
    """Run `await visit(connect)` with a server behind the limiter."""

    async def whole() -> None:
        server = await asyncio.get_running_loop().create_server(limiter.receive, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        opened: list[asyncio.StreamWriter] = []

        async def connect() -> Streams:
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            opened.append(writer)
            return reader, writer

        try:
            await asyncio.wait_for(visit(connect), LONG)
        finally:
            for writer in opened:
                writer.close()
            server.close()

    aside(whole())


async def is_closed(reader: asyncio.StreamReader) -> bool:
    try:
        return await reader.read() == b""
    except ConnectionResetError:
        return True


@pytest.mark.parametrize("said", [b"", b"GET / HTTP/1.1\r\n", b"GET / HTTP/1.1\r\nHost: x\r\n"])
def test_who_does_not_say_all_in_time_is_sent_away(said: bytes) -> None:
    async def visit(connect: Callable[[], Awaitable[Streams]]) -> None:
        reader, writer = await connect()
        writer.write(said)
        assert await reader.readexactly(len(said)) == said
        assert await is_closed(reader)

    hold(ConnectionLimiter(Echo, patience=0.1), visit)


@pytest.mark.parametrize("end", [b"\r\n\r\n", b"\n\n", b"\n\r\n"])
def test_who_has_said_all_may_stay(end: bytes) -> None:
    async def visit(connect: Callable[[], Awaitable[Streams]]) -> None:
        reader, writer = await connect()
        head = b"GET / HTTP/1.1\r\nHost: x" + end
        for at in range(len(head)):  # however it comes
            writer.write(head[at : at + 1])
            await reader.readexactly(1)
        await asyncio.sleep(0.4)
        writer.write(b"more")
        assert await reader.readexactly(4) == b"more"

    hold(ConnectionLimiter(Echo, patience=0.2), visit)


def test_of_too_many_the_oldest_that_waits_goes() -> None:
    async def visit(connect: Callable[[], Awaitable[Streams]]) -> None:
        settled = await connect()
        settled[1].write(b"GET\r\n\r\n")
        await settled[0].readexactly(7)
        waiting = []
        for _ in range(4):
            waiting.append(await connect())
            waiting[-1][1].write(b"x")
            await waiting[-1][0].readexactly(1)
        assert await is_closed(waiting[0][0])
        for reader, writer in (settled, *waiting[1:]):
            writer.write(b"y")
            assert await reader.readexactly(1) == b"y"

    hold(ConnectionLimiter(Echo, most=3, patience=LONG), visit)


def test_who_goes_by_himself_makes_room() -> None:
    async def visit(connect: Callable[[], Awaitable[Streams]]) -> None:
        first = await connect()
        first[1].write(b"x")
        await first[0].readexactly(1)
        for _ in range(5):
            reader, writer = await connect()
            writer.write(b"x")
            await reader.readexactly(1)
            writer.close()
            await writer.wait_closed()
        first[1].write(b"y")
        assert await first[0].readexactly(1) == b"y"

    hold(ConnectionLimiter(Echo, most=2, patience=LONG), visit)
