"""The window's logic, without a browser: what is in `logic` is run by Deno."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

DENO = shutil.which("deno")


@pytest.mark.skipif(DENO is None, reason="there is no deno")
def test_the_logic_of_the_window() -> None:
    folder = Path(__file__).with_name("logic")
    command = [str(DENO), "test", "--no-check", "--no-lock", "--quiet", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 failed" in done.stdout
