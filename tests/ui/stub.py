"""A server of two sessions that answer without simulating.

`python -m tests.ui.stub` prints an opening address, and another one for each line that it reads.
"""

from __future__ import annotations

import asyncio
import sys
import threading
from collections.abc import Mapping
from typing import Any

from amorsim.ui.serve.pages import Pages
from amorsim.ui.serve.security import Door
from amorsim.ui.serve.server import serve


class StubSession:
    """Counts its windows; every frame is a header with a number, and nothing else."""

    def __init__(self) -> None:
        self.windows: set[str] = set()
        self.number = 1
        self.asked: list[dict[str, Any]] = []
        self._release: asyncio.Event | None = None

    def hold(self) -> asyncio.Event:
        """Answer no command ``wait`` before this is set."""
        self._release = asyncio.Event()
        return self._release

    def open_window(self, tab: str = "") -> str:
        name = f"window-{len(self.windows) + 1}"
        self.windows.add(name)
        return name

    def close_window(self, window: str) -> None:
        self.windows.discard(window)

    async def newest_frame(self, after: int = 0, window: str = "") -> bytes:
        while self.number <= after:
            await asyncio.sleep(0.001)
        return b"amf1" + bytes(4) + self.number.to_bytes(4, "little") + bytes(68)

    def only_asks(self, name: str) -> bool:
        return name == "state"

    async def ask(self, window: str, command: Mapping[str, Any]) -> dict[str, Any]:
        self.asked.append(dict(command))
        if command.get("do") == "wait" and self._release is not None:
            await self._release.wait()
        return {"ok": True, "window": window, "said": command.get("do")}


def invite(door: Door) -> None:
    """Print an address now, and another for each line that is read."""

    def print_addresses() -> None:
        print(door.new_address(), flush=True)
        for _ in sys.stdin:
            print(door.new_address(), flush=True)

    threading.Thread(target=print_addresses, daemon=True).start()


if __name__ == "__main__":
    both = Pages()
    both.add("run", "one", StubSession())
    both.add("run", "two", StubSession())
    asyncio.run(serve(both, ready=invite))
