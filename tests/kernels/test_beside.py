"""The process that compiles beside: when it is started, what it does, and that it ends when nobody needs it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from amorsim.kernels import ahead, beside
from amorsim.kernels.claims import Claims
from amorsim.kernels.folder import stamp_file


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """The commands that were started, on two cores where nothing has been compiled."""
    commands: list[list[str]] = []

    def start(command: list[str], **_: object) -> object:
        commands.append(command)
        return command

    monkeypatch.setattr(subprocess, "Popen", start)
    monkeypatch.setattr(beside, "_beside", [])
    monkeypatch.setattr(beside, "is_cold", lambda: True)
    monkeypatch.setattr(beside, "cores", lambda: 2)
    return commands


def test_one_is_started_and_no_second(started: list[list[str]]) -> None:
    assert beside.begin()
    assert not beside.begin()
    assert started == [[sys.executable, "-c", "from amorsim.kernels.beside import main; main()"]]


@pytest.mark.parametrize(("cores", "count"), [(3, 2), (4, 3), (64, 3)])
def test_one_is_started_for_each_core_that_is_left(
    started: list[list[str]], monkeypatch: pytest.MonkeyPatch, cores: int, count: int
) -> None:
    monkeypatch.setattr(beside, "cores", lambda: cores)
    assert beside.begin()
    assert not beside.begin()
    assert len(started) == count


def test_none_is_started_on_one_core_or_when_all_is_compiled(
    started: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(beside, "cores", lambda: 1)
    assert not beside.begin()
    monkeypatch.setattr(beside, "cores", lambda: 2)
    monkeypatch.setattr(beside, "is_cold", lambda: False)
    assert not beside.begin()
    monkeypatch.setattr(beside, "is_cold", lambda: True)
    monkeypatch.setattr(sys, "executable", None)
    assert not beside.begin()
    assert started == []


def test_it_ends_when_it_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beside, "_beside", [])
    monkeypatch.setattr(beside, "_COMMAND", "import time; time.sleep(60)")
    monkeypatch.setattr(beside, "is_cold", lambda: True)
    monkeypatch.setattr(beside, "cores", lambda: 2)
    assert beside.begin()
    process = beside._beside[0]
    beside.stop()
    assert process.poll() is not None
    assert beside._beside == []


def test_it_compiles_what_is_listed_and_says_so_unless_another_does(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    done: list[str] = []
    monkeypatch.setattr(beside, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(beside, "cores", lambda: 2)
    monkeypatch.setattr(beside, "mark_warm", lambda: done.append("warm"))
    monkeypatch.setattr("amorsim.kernels.cache.take_turns", lambda: done.append("turns"))
    monkeypatch.setattr(ahead, "compile_ahead", lambda: done.append("ahead"))
    monkeypatch.setattr(sys, "modules", dict(sys.modules))
    another = Claims(tmp_path)
    claim = another.path("amorsim.kernels.beside", "0")
    assert another.try_for(claim)
    beside.main()
    assert done == []
    another.give_up(claim)
    beside.main()
    assert done == ["turns", "ahead", "warm"]
    assert not list(tmp_path.iterdir())


def test_whether_all_is_compiled_is_told_without_numba() -> None:
    stamp = str(stamp_file())
    code = (
        "import sys; from amorsim.kernels import beside, folder; "
        "assert 'numba' not in sys.modules; print(folder.stamp_file())"
    )
    told = subprocess.run([sys.executable, "-c", code], env=os.environ, check=True, stdout=subprocess.PIPE, text=True)
    assert told.stdout.strip() == stamp
