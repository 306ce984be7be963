"""What holds for all tests."""

import os

from hypothesis import settings

# Some hundred processes are started anew, each of which would read amorsim's sources where none may keep what it read.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Timing is never what decides: a kernel compiles in its first example, and machines are shared.
settings.register_profile("amorsim", deadline=None)
settings.load_profile("amorsim")
