"""Which windows there are, and which of them has the controls."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Mapping
from typing import Any

from amorsim.core.errors import AmorsimError

__all__ = ["Controls"]


class Controls:
    """The windows of a session; may be asked from any thread.

    Attributes
    ----------
    holder
        The window that has the controls, or nothing.
    asking
        Those that have asked for them, in order.
    """

    def __init__(self) -> None:
        self.holder = ""
        self.asking: list[str] = []
        self._windows: set[str] = set()
        self._lock = threading.Lock()

    def open(self) -> str:
        """A new window's word; where nobody has the controls, it gets them."""
        window = secrets.token_urlsafe(12)
        with self._lock:
            self._windows.add(window)
            if not self.holder:
                self.holder = window
        return window

    def close(self, window: str) -> bool:
        """Forget a window; whether it had the controls, which go to the first that asks for them."""
        with self._lock:
            self._windows.discard(window)
            self.asking = [one for one in self.asking if one != window]
            if self.holder != window:
                return False
            self.holder = self.asking.pop(0) if self.asking else ""
            return True

    def knows(self, window: str) -> bool:
        """Whether there is such a window."""
        return window in self._windows

    def told(self) -> dict[str, Any]:
        """As windows are told of it."""
        return {"holder": self.holder, "asking": list(self.asking)}

    def carry_out(self, window: str, command: Mapping[str, Any]) -> dict[str, Any]:
        """The answer to a window's command ``controls``.

        Raises
        ------
        AmorsimError
            If the controls are not this window's to take or to give.
        """
        want, to = command.get("want"), command.get("to")
        with self._lock:
            if want == "take":
                if self.holder not in ("", window):
                    raise AmorsimError("another window has the controls; ask for them")
                self.holder = window
            elif want == "ask":
                if self.holder in ("", window):
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
            return {"ok": True, **self.told()}
