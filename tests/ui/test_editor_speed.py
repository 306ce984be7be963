"""What a frame of the Editor costs in large worlds, while they are panned, dragged and painted."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.long

TOOL = Path(__file__).parents[2] / "tools" / "measure_editor.py"


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processor times are read from /proc")
@pytest.mark.usefixtures("browser")  # which says whether there is one
def test_a_frame_of_a_large_world_costs_less_than_it_may() -> None:
    done = subprocess.run(
        [sys.executable, str(TOOL), "--check", "--seconds", "2"],
        capture_output=True,
        text=True,
        timeout=300.0,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
