"""What holds for all tests."""

from hypothesis import settings

# Timing is never what decides: a kernel compiles in its first example, and machines are shared.
settings.register_profile("amorsim", deadline=None)
settings.load_profile("amorsim")
