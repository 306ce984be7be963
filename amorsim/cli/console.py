"""What all commands say, and where."""

from __future__ import annotations

import sys
from collections.abc import Callable

from amorsim.kernels import COMPILING

__all__ = ["compile_once", "complain", "say"]


def say(text: str) -> None:
    """A line for the user."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def complain(text: str) -> None:
    """A line about what went wrong."""
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


def compile_once(look: Callable[[], None], quiet: bool = False) -> bool:
    """Say so and compile what nearly every command needs, if no process has done so yet; whether none had.

    `look` raises what is wrong with what was asked for, as far as that can be told before, and is called only then:
    where nothing is to be compiled, what follows tells it as soon.
    """
    from amorsim.kernels import beside
    from amorsim.kernels.folder import is_cold

    if not is_cold():
        return False
    beside.begin()  # it imports numba while this process looks
    try:
        look()
    except BaseException:
        beside.stop()
        raise
    if not quiet:
        say(COMPILING)
    from amorsim.kernels.ahead import compile_together

    compile_together()
    return True
