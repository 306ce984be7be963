"""A process beside this one that compiles what nearly every run asks for; numba is imported there, and not here.

It runs none of the user's code, and may be started at any time: what it compiles, others find in the cache.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading

from amorsim.kernels.claims import Claims
from amorsim.kernels.folder import cache_folder, is_cold, mark_warm

__all__ = ["begin", "deadline", "main", "stop"]

_COMMAND = f"from {__name__} import main; main()"
_LONGEST = 120.0  # [s]
_beside: list[subprocess.Popen[bytes]] = []


def begin() -> bool:
    """Start it, if no process has compiled all yet, and this one has started none; whether it did."""
    if _beside or (os.cpu_count() or 1) < 2 or not is_cold():
        return False
    with contextlib.suppress(OSError):  # it only saves time
        # Held, for nobody waits for it, and one that is let go while it runs is warned about.
        _beside.append(
            subprocess.Popen(
                [sys.executable, "-c", _COMMAND],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        )
    return bool(_beside)


def stop() -> None:
    """End it, for it was started for nothing."""
    while _beside:
        process = _beside.pop()
        process.terminate()
        process.wait()


def main() -> None:
    """Compile what is listed, with whoever started this process, and leave word that it is."""
    last = deadline()
    folder = cache_folder()
    if folder is not None:
        claims = Claims(folder)
        mine = claims.path(__name__, "")
        if claims.try_for(mine):  # one is enough
            try:
                _compile()
            finally:
                claims.give_up(mine)
    last.cancel()


def _compile() -> None:
    # numba would import it, where it is installed, for linear algebra, which no kernel has.
    sys.modules.setdefault("scipy", None)  # type: ignore[arg-type]
    from amorsim.kernels.ahead import compile_ahead
    from amorsim.kernels.cache import take_turns

    take_turns()
    compile_ahead()
    mark_warm()


def deadline() -> threading.Timer:
    """Let this process end by itself after a while, for nobody waits for it; until it is cancelled."""
    last = threading.Timer(_LONGEST, os._exit, (1,))
    last.daemon = True
    last.start()
    return last
