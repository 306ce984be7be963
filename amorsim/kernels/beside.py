"""Processes beside this one that compile what nearly every run asks for; numba is imported there, and not here.

They run none of the user's code, and may be started at any time: what they compile, others find in the cache.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys

from amorsim.kernels.claims import Claims
from amorsim.kernels.folder import cache_folder, is_cold, mark_warm

__all__ = ["begin", "command_for", "cores", "main", "stop"]

_LONGEST = 120.0  # [s]
_MOST = 3  # beside this one: more would wait for the longest chain of functions that call each other
_beside: list[subprocess.Popen[bytes]] = []


def begin() -> bool:
    """Start one on each processor that is left, if none has compiled all yet and none was started; whether it did."""
    if _beside or not sys.executable or not is_cold():  # a program that Python is part of may name none
        return False
    with contextlib.suppress(OSError):  # it only saves time
        for _ in range(_places()):
            # Held, for nobody waits for it, and one that is let go while it runs is warned about.
            _beside.append(
                subprocess.Popen(
                    command_for(__name__, "main"),
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                )
            )
    return bool(_beside)


def command_for(module: str, function: str) -> list[str]:
    """The command that calls a function in a process of its own, which ends after a while, for nobody waits for it.

    No file of the present folder is run (``-P``). The deadline is set before anything else is loaded, and holds also
    where Python code never lets go.
    """
    script = (
        f"import faulthandler; faulthandler.dump_traceback_later({_LONGEST}, exit=True); "
        f"from {module} import {function}; {function}()"
    )
    return [sys.executable, "-P", "-c", script]


def cores() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _places() -> int:
    return min(cores() - 1, _MOST)


def stop() -> None:
    """End what was started for nothing."""
    while _beside:
        process = _beside.pop()
        process.terminate()
        process.wait()


def main() -> None:
    """Compile what is listed, with whoever started this process, and leave word that it is."""
    folder = cache_folder()
    if folder is not None:
        claims = Claims(folder)
        places = [claims.path(__name__, str(number)) for number in range(_places())]
        # Several that begin at once start no more than one of them would.
        mine = next((place for place in places if claims.try_for(place)), None)
        if mine is not None:
            try:
                _compile()
            finally:
                claims.give_up(mine)


def _compile() -> None:
    # numba would import it, where it is installed, for linear algebra, which no kernel has.
    sys.modules.setdefault("scipy", None)  # type: ignore[arg-type]
    from amorsim.kernels.ahead import compile_ahead
    from amorsim.kernels.cache import take_turns

    take_turns()
    compile_ahead()
    mark_warm()
