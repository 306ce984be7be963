"""The open windows, and which of them has the controls."""

from __future__ import annotations

import math
import secrets
import time
from collections.abc import Callable, Mapping
from typing import Any

from amorsim.core.errors import AmorsimError

__all__ = ["Controls"]

GRACE = 5.0  # [s] that the controls wait for a window that has gone: its page may be loaded again


class Controls:
    """The windows of a session.

    The first window has the controls, until it gives them or goes. A window that is loaded again in its tab, or whose
    connection was lost, gets them back if it is there again within `GRACE`, also when others have come or asked
    meanwhile. `clock` returns seconds.

    Attributes
    ----------
    holder
        The window that has the controls, or nothing.
    asking
        Those that have asked for them, in order.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.holder = ""
        self.asking: list[str] = []
        self._windows: dict[str, str] = {}  # the tab that each is in
        self._awaited = ""  # the tab whose window had the controls, and until when they wait for it
        self._until = -math.inf
        self._clock = clock

    def open(self, tab: str = "") -> str:
        """A new window's name; it gets the controls if nobody has them and no other window waits, or it is alone.

        `tab` is the same for the windows that one tab shows after one another.
        """
        window = secrets.token_urlsafe(12)
        is_due = self._clock() >= self._until or tab == self._awaited or not self._windows
        self._windows[window] = tab
        if not self.holder and is_due:
            self.holder, self._until = window, -math.inf
        return window

    def close(self, window: str) -> bool:
        """Forget a window; returns whether it had the controls, which wait for its tab or go to the first that asks."""
        tab = self._windows.pop(window, "")
        self.asking = [one for one in self.asking if one != window]
        if self.holder != window:
            return False
        self.holder = ""
        # A tab that is copied has two windows.
        if tab and tab not in self._windows.values():
            self._awaited, self._until = tab, self._clock() + GRACE
        self.pass_on()
        return True

    def pass_on(self) -> bool:
        """Give the controls to the first that asks, if nobody has them and no tab is awaited; returns whether it did.

        A session whose state is not asked for all the time calls this now and then.
        """
        is_due = not self.holder and bool(self.asking) and self._clock() >= self._until
        if is_due:
            self.holder = self.asking.pop(0)
        return is_due

    def knows(self, window: str) -> bool:
        """Whether there is such a window."""
        return window in self._windows

    def state(self) -> dict[str, Any]:
        """Who has the controls and who asks for them, for a window's state."""
        self.pass_on()
        return {"holder": self.holder, "asking": list(self.asking)}

    def carry_out(self, window: str, command: Mapping[str, Any]) -> dict[str, Any]:
        """The answer to a window's command ``controls``.

        Raises
        ------
        AmorsimError
            If the controls are not this window's to take or to give.
        """
        want, to = command.get("want"), command.get("to")
        self.pass_on()
        if want == "take":
            if self.holder not in ("", window):
                raise AmorsimError("another window has the controls; ask for them")
            self.holder = window
        elif want == "ask":
            if self.holder == window or (not self.holder and self._clock() >= self._until):
                self.holder = window
            elif window not in self.asking:
                self.asking.append(window)
        elif want == "give":
            if self.holder != window:
                raise AmorsimError("this window does not have the controls")
            if to is not None and to not in self._windows:
                raise AmorsimError("there is no such window any more")
            self.holder = str(to) if to else (self.asking[0] if self.asking else "")
        else:
            raise AmorsimError(f"want: expected 'take', 'ask' or 'give', got {want!r}")
        self.asking = [one for one in self.asking if one != self.holder]
        return {"ok": True, "holder": self.holder, "asking": list(self.asking)}
