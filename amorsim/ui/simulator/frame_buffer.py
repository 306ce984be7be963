"""The newest frame for the windows: one is kept, one is on its way, and the simulation waits for no window."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable
from typing import NamedTuple

from amorsim.ui.simulator.frames.packing import Bundle, FrameFlag

__all__ = ["FrameBuffer"]

FRESH = 0.1  # [s] that a frame is new for


class FrameBuffer:
    """Holds the newest bundle, and makes of it each window's frame; for one event loop.

    Parameters
    ----------
    ask
        Asks the child for a bundle, at once or when something has changed; whether it could.
    """

    def __init__(self, ask: Callable[[bool], bool]) -> None:
        self._ask = ask
        self._number = 0
        self._bundle: Bundle | None = None
        self._flags: int | None = None  # in place of the bundle's
        self._at = -math.inf  # when it came, as long as nothing was done since
        self._is_asked = False
        self._is_still = False  # whether no newer one can come
        self._is_turned = False  # whether a window has turned to another robot since it was asked for
        self._waiting: list[_Waiter] = []

    @property
    def waiting(self) -> int:
        """How many wait."""
        return len(self._waiting)

    async def newest(self, after: int, robot: Callable[[], int]) -> bytes:
        """The newest frame whose number is above `after`, as soon as there is one.

        It contains everything about the robot that `robot` gives when it is there.
        """
        is_newer = self._number > after
        if is_newer and (self._is_still or time.monotonic() - self._at < FRESH):
            frame = self._frame(robot())
            if frame is not None:
                return frame
        waiter = _Waiter(asyncio.get_running_loop().create_future(), robot)
        self._waiting.append(waiter)
        is_missed = self._bundle is not None and robot() not in self._bundle.robots
        self._want(now=is_newer or is_missed or self._is_turned)
        try:
            return await waiter.frame
        finally:
            self._waiting = [one for one in self._waiting if one is not waiter]

    def _want(self, *, now: bool) -> None:
        """Ask for the next bundle; with `now` also if nothing has changed since the last one."""
        if now or not self._is_asked:
            self._is_asked = self._ask(now)

    def _frame(self, robot: int) -> bytes | None:
        if self._bundle is None:
            return None
        frame = self._bundle.frame(robot, self._number, self._flags)
        if frame is None and self._is_still:
            return self._bundle.bare_frame(robot, self._number, self._flags or 0)
        return frame

    def take(self, bundle: Bundle) -> None:
        """Take a bundle that came."""
        self._is_asked = self._is_still = self._is_turned = False
        self._at = time.monotonic()
        self._publish(bundle, None)

    def _publish(self, bundle: Bundle, flags: int | None) -> None:
        self._number += 1
        self._bundle, self._flags = bundle, flags
        still_waiting = []
        for waiter in self._waiting:
            frame = self._frame(waiter.robot())
            if frame is None:  # who looks at another robot since it was asked for
                still_waiting.append(waiter)
            elif not waiter.frame.done():
                waiter.frame.set_result(frame)
        self._waiting = still_waiting
        if still_waiting:
            self._want(now=True)

    def spoil(self) -> None:
        """Something was done: the next frame must show it."""
        self._at = -math.inf

    def turn(self) -> None:
        """A window selected another robot: the next frame must show it, even if nothing moves."""
        self._at = -math.inf
        self._is_turned = True
        if self._is_still and self._bundle is not None:
            self._publish(self._bundle, self._flags)
        elif self._waiting:
            self._want(now=True)

    def stand_still(self) -> None:
        """Note that no frames come for the time being."""
        self._is_still = True
        if self._bundle is not None:
            flags = self._bundle.flags & ~FrameFlag.RUNNING
            self._publish(self._bundle, flags | FrameFlag.HANG)

    def move_on(self) -> None:
        """Note that frames come again, perhaps from another child; ask for one if a window waits."""
        self._is_asked = self._is_still = False
        self._at = -math.inf
        if self._waiting:
            self._want(now=True)


class _Waiter(NamedTuple):
    frame: asyncio.Future[bytes]
    robot: Callable[[], int]
