"""The newest frame, for whoever waits for it: one is kept, one is under way, and none waits for a window."""

from __future__ import annotations

import asyncio
import contextlib
import math
import threading
import time
from collections.abc import Callable

from amorsim.ui.protocol import FRAME_HEADER, FrameFlag, with_flags

__all__ = ["Mailbox"]

FRESH = 0.1  # [s] that a frame is new for
_FLAGS = 9  # their place in a frame's header


class Mailbox:
    """Holds the newest frame.

    Parameters
    ----------
    ask
        Asks the child for a frame, at once or when something has changed; whether it could.
    """

    def __init__(self, ask: Callable[[bool], bool]) -> None:
        self._ask = ask
        self._number, self._frame = 0, b""
        self._at = -math.inf  # when it came, as long as nothing was done since
        self._is_asked = False
        self._is_still = False  # whether no newer one can come
        self._waiting: list[tuple[asyncio.AbstractEventLoop, asyncio.Future[bytes]]] = []
        self._lock = threading.RLock()

    @property
    def waiting(self) -> int:
        """How many wait."""
        return len(self._waiting)

    async def newest(self, after: int) -> bytes:
        """The newest frame whose number is above `after`, as soon as there is one."""
        loop = asyncio.get_running_loop()
        with self._lock:
            is_newer = self._number > after
            if self._frame and is_newer and (self._is_still or time.monotonic() - self._at < FRESH):
                return self._frame
            waiter: asyncio.Future[bytes] = loop.create_future()
            self._waiting.append((loop, waiter))
            self._want(now=is_newer)
        try:
            return await waiter
        finally:
            with self._lock:
                self._waiting = [one for one in self._waiting if one[1] is not waiter]

    def _want(self, *, now: bool) -> None:
        """Ask for the next frame; `now` for one even where nothing has changed since the last."""
        if now or not self._is_asked:
            self._is_asked = self._ask(now)

    def take(self, data: bytes) -> None:
        """Take a frame that came."""
        with self._lock:
            self._is_asked = self._is_still = False
            self._at = time.monotonic()
            self._publish(data, FRAME_HEADER.unpack_from(data)[_FLAGS])

    def _publish(self, data: bytes, flags: int) -> None:
        self._number += 1
        self._frame = with_flags(data, self._number, flags)
        waiting, self._waiting = self._waiting, []
        for loop, waiter in waiting:
            _settle(loop, waiter, self._frame)

    def spoil(self) -> None:
        """Something was done: whoever asks next is to see it."""
        self._at = -math.inf

    def stand_still(self) -> None:
        """Show that no frame comes any more for the time being."""
        with self._lock:
            self._is_still = True
            if self._frame:
                flags = FRAME_HEADER.unpack_from(self._frame)[_FLAGS] & ~FrameFlag.RUNNING
                self._publish(self._frame, flags | FrameFlag.HANG)

    def move_on(self) -> None:
        """Frames come again, maybe from another child: ask for one if anybody waits."""
        with self._lock:
            self._is_asked = self._is_still = False
            self._at = -math.inf
            if self._waiting:
                self._want(now=True)


def _settle(loop: asyncio.AbstractEventLoop, waiter: asyncio.Future[bytes], data: bytes) -> None:
    def settle() -> None:
        if not waiter.done():
            waiter.set_result(data)

    with contextlib.suppress(RuntimeError):  # the loop has ended
        loop.call_soon_threadsafe(settle)
