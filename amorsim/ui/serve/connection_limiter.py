"""Before the door: connections that do not identify themselves in time, and those beyond a limit, are closed.

The server library caps how long the head of a request may be. It has no setting for how long one may take, nor for how
many may be under way. Once a request has come whole, the guard refuses it or lets it in (`amorsim.ui.serve.security`).
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

__all__ = ["ConnectionLimiter"]

PATIENCE = 10.0  # [s]
MOST_WAITING = 64
# What ends the head of a request; a lone line feed ends a line, too.
ENDS = (b"\n\r\n", b"\n\n")


class ConnectionLimiter:
    """Receives connections for a server: makes for each the protocol that `make` would make, and watches it.

    Parameters
    ----------
    make
        Makes a connection's protocol of keywords.
    most
        How many may be there whose request has not come whole; of more, the oldest is closed.
    patience
        How long [s] one gets for that.
    """

    def __init__(
        self, make: Callable[..., asyncio.Protocol], *, most: int = MOST_WAITING, patience: float = PATIENCE
    ) -> None:
        self.patience = patience
        self._make = make
        self._most = most
        self._waiting: dict[_Visitor, None] = {}  # in the order in which they came

    def receive(self, **keywords: Any) -> asyncio.Protocol:
        """The protocol of a new connection."""
        return _Visitor(self, self._make(**keywords))

    def enter(self, visitor: _Visitor) -> None:
        """Let one wait, and the oldest go where there are too many."""
        self._waiting[visitor] = None
        if len(self._waiting) > self._most:
            next(iter(self._waiting)).send_away()

    def leave(self, visitor: _Visitor) -> None:
        """One does not wait any more."""
        self._waiting.pop(visitor, None)


class _Visitor(asyncio.Protocol):
    """A connection that passes all it receives on to `inner`, until another takes its place (as for a WebSocket)."""

    def __init__(self, limiter: ConnectionLimiter, inner: asyncio.Protocol) -> None:
        self._limiter = limiter
        self._inner = inner
        self._last = b""  # of what has come
        self._transport: asyncio.Transport | None = None
        self._timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        self._transport = transport
        self._timer = asyncio.get_running_loop().call_later(self._limiter.patience, self.send_away)
        self._limiter.enter(self)
        self._inner.connection_made(transport)

    def data_received(self, data: bytes) -> None:
        if self._timer is not None:
            seen = self._last + data
            self._last = seen[-2:]
            if any(end in seen for end in ENDS):
                self._settle()
        self._inner.data_received(data)

    def send_away(self) -> None:
        self._settle()
        if self._transport is not None:
            self._transport.abort()

    def _settle(self) -> None:
        self._limiter.leave(self)
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def connection_lost(self, exc: Exception | None) -> None:
        self._settle()
        self._inner.connection_lost(exc)

    def eof_received(self) -> bool | None:
        return self._inner.eof_received()

    def pause_writing(self) -> None:
        self._inner.pause_writing()

    def resume_writing(self) -> None:
        self._inner.resume_writing()
