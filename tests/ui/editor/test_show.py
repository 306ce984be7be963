"""The Editor's process: what it does before it prints its address, which a user waits for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from amorsim.ui.editor import show
from amorsim.ui.editor.session import EditSession
from amorsim.ui.serve.security import Door

LOADED = (
    "import sys, amorsim.ui.editor.show as show; print(*sorted(name for name in sys.modules if 'amorsim.sim' in name))"
)


def test_the_address_is_printed_before_the_process_that_reads_is_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []

    async def serve(*_: Any, ready: Any, **__: Any) -> None:
        done.append("listens")
        ready(Door(host="127.0.0.1", port=1234))

    monkeypatch.setenv("AMORSIM_STATE", str(tmp_path / "state"))
    monkeypatch.setattr(show, "serve", serve)
    monkeypatch.setattr(EditSession, "start", lambda _: done.append("reads"))
    monkeypatch.setattr(show.gc, "freeze", lambda: None)
    options: dict[str, Any] = {"host": "127.0.0.1", "port": 0, "browser": False, "allow_code": False}
    show.edit("", **options, say=lambda said: done.append(said[:21]), complain=done.append, folder=tmp_path)
    assert done == ["listens", "http://127.0.0.1:1234", "reads"]


def test_the_server_does_not_load_the_engine() -> None:
    loaded = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, text=True, check=True).stdout.split()
    assert set(loaded) <= {"amorsim.simulation", "amorsim.simulation.events"}
