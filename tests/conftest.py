"""What holds for all tests."""

import os
import signal

from hypothesis import settings

# Some hundred processes are started anew, each of which would read amorsim's sources where none may keep what it read.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Timing is never what decides: a kernel compiles in its first example, and machines are shared.
settings.register_profile("amorsim", deadline=None)
settings.load_profile("amorsim")

# A command that a shell starts in the background ignores Ctrl-C, and under nohup the terminal's end; all that it starts
# would ignore them too.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
