"""What holds for all tests."""

import os
import signal

import pytest
from hypothesis import settings
from PIL import Image

# Some hundred processes are started. Each would compile amorsim's sources if none might write bytecode.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Timing is never what decides: a kernel compiles in its first example, and machines are shared. A fifth of the examples
# is tried every day; all of them with pytest -m hypothesis --hypothesis-profile=all
settings.register_profile("all", deadline=None, max_examples=100)
settings.register_profile("everyday", deadline=None, max_examples=20)
settings.load_profile("everyday")

# A command that a shell starts in the background ignores Ctrl-C, and under nohup the terminal's end; all that it starts
# would ignore them too.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.fixture(autouse=True)
def cheap_files(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files need not reach the disk, and a run's picture is small and empty unless the test is marked ``pictures``.

    Waiting for the disk and drawing would be the larger part of most tests that run a scenario.
    """
    monkeypatch.setattr(os, "fsync", lambda _: None)
    if request.node.get_closest_marker("pictures") is None:
        monkeypatch.setattr("amorsim.runs.session.draw_run", lambda *_, **__: Image.new("RGB", (8, 8)))
