"""Ctrl-C while a kernel is compiled: the compiler's library calls back into Python, where nothing may be raised."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from amorsim.core.execution.interrupt_signal import raise_interrupt

# Both calls back for a kernel: before it is loaded, and after it was compiled.
IN_A_CALL_BACK = """
import signal, time, numba
from numba.core.codegen import CPUCodeLibrary as Library

def interrupted(hook):
    def call(*values):
        signal.raise_signal(signal.SIGINT)
        return hook(*values)
    return call

for name in ("_object_compiled_hook", "_object_getbuffer_hook"):
    setattr(Library, name, interrupted(getattr(Library, name)))
from amorsim.core.execution.interrupt import Interrupt
from amorsim.core.execution.interrupt_signal import raise_interrupt
signal.signal(signal.SIGINT, raise_interrupt)
try:
    {body}
    print("went on")
except KeyboardInterrupt:
    print("interrupted")
assert signal.getsignal(signal.SIGINT) is raise_interrupt
"""
COMPILED = "numba.njit(lambda x: x + 1)(1); time.sleep(5.0)"
IN_A_RUN = f"""with Interrupt() as interrupt:
        signal.raise_signal(signal.SIGINT)
        {COMPILED}"""


@pytest.mark.parametrize("body", [COMPILED, IN_A_RUN], ids=["alone", "second"])
def test_it_is_raised_after_the_library_has_returned(body: str) -> None:
    code = IN_A_CALL_BACK.replace("{body}", body)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "interrupted\n", "")


def test_elsewhere_it_is_raised_at_once() -> None:
    before = signal.signal(signal.SIGINT, raise_interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)
