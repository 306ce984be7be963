"""The window's process: it keeps a session and serves its window until it is told to end."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import importlib.util
import json
import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from amorsim.core.errors import AmorsimError
from amorsim.ui.serve.opening import OpeningPage
from amorsim.ui.simulator.orphan import stay
from amorsim.ui.simulator.recipe import Recipe

if TYPE_CHECKING:
    from amorsim.ui.serve.security import Door

__all__ = ["check_extra", "main", "show"]

LONGEST_REST = 0.5  # [s] that the server gets to end once the simulation has

Say = Callable[[str], None]


def check_extra() -> None:
    """Raise what says what to install where the window's own libraries are not there."""
    if any(importlib.util.find_spec(name) is None for name in ("starlette", "uvicorn", "websockets")):
        raise AmorsimError('the window needs the extra "ui"; in the checkout: python -m pip install -e ".[ui]"')


def show(
    recipe: Recipe,
    *,
    out: Path | None,
    host: str,
    port: int,
    browser: bool,
    say: Say,
    complain: Say,
    notice: Say | None,
) -> None:
    """Serve the window of a simulation until Ctrl-C. The process is not to do anything more then: it may be ended here.

    Parameters
    ----------
    recipe, out, notice
        As for `Session`.
    host, port
        Where; port 0 takes one that is free.
    browser
        Whether to open the window in the browser.
    say, complain
        Told the addresses and where results lie, and what the user should know before.
    """
    from amorsim.ui.serve.pages import Pages
    from amorsim.ui.serve.server import serve
    from amorsim.ui.simulator.session import Session

    session = Session(recipe, out=out, notice=notice)
    told = threading.Lock()  # the last word, once: here, or by the timer that waits for nothing
    opening: list[OpeningPage] = []

    def tell() -> None:
        if told.acquire(blocking=False) and session.folder:
            say(f"results: {session.folder}")

    def leave() -> None:
        tell()
        sys.stdout.flush()
        os._exit(0)

    async def end() -> None:
        await session.close()
        forget_opening()
        # The files are whole. What the server still does (a GIF that is being made) shall not hold up the end.
        rest = threading.Timer(LONGEST_REST, leave)
        rest.daemon = True
        rest.start()

    def forget_opening() -> None:
        for page in opening:
            page.remove()

    def ready(door: Door) -> None:
        if not door.is_for_this_machine:
            complain(
                f"served on {host} without encryption: whoever can read this network's traffic can see the window and "
                f"take it over. Where you do not trust the network, leave the host out and forward the port by ssh -L"
            )
        say(door.new_address(used=lambda: invite(door)))
        if browser:
            try:
                opening.append(OpeningPage(door.new_address(used=forget_opening)))
            except AmorsimError as error:
                complain(str(error))
            else:
                opening[-1].open()

    def invite(door: Door) -> None:
        """Say where another browser gets in, once the address that was said last has been used."""
        with contextlib.suppress(OSError):  # nobody reads what is said any more
            say(f"for another browser: {door.new_address(used=lambda: invite(door))}")

    with asyncio.Runner() as runner:
        try:
            runner.run(session.start())
            for remark in session.remarks:
                complain(remark)
            pages = Pages()
            pages.add("run", Path(recipe.name).stem, session)
            with contextlib.suppress(KeyboardInterrupt):
                runner.run(serve(pages, host=host, port=port, ready=ready, ending=end))
        finally:
            runner.run(session.close())
            forget_opening()
            # Python's last look for what nobody uses takes a second with all that numba holds.
            gc.freeze()
    tell()


def main() -> None:
    """Read the order as a line of standard input, and show that until the end of standard input.

    Answers are lines: ``say``, ``complain`` or ``error``, and a text.
    """
    order = json.loads(sys.stdin.readline())
    answers = sys.stdout
    sys.stdout = sys.stderr

    def tell(kind: str) -> Say:
        def told(text: str) -> None:
            answers.write(json.dumps([kind, text]) + "\n")
            answers.flush()

        return told

    def watch() -> None:
        sys.stdin.read()
        signal.raise_signal(signal.SIGINT)

    threading.Thread(target=watch, name="amorsim-end", daemon=True).start()
    stay()
    try:
        show(
            Recipe.from_json(order["recipe"]),
            out=Path(order["out"]) if order["out"] else None,
            host=order["host"],
            port=order["port"],
            browser=order["browser"],
            say=tell("say"),
            complain=tell("complain"),
            notice=tell("say"),
        )
    except AmorsimError as error:
        tell("error")(str(error))
    except KeyboardInterrupt:  # before there was a window
        os._exit(0)
