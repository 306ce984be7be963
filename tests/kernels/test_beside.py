"""The process that compiles beside: when it is started, what it does, and that it ends when nobody needs it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from amorsim.kernels import ahead, beside
from amorsim.kernels.beside import command_for
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
    (command,) = started
    assert command[:3] == [sys.executable, "-P", "-c"]
    assert command[3].endswith("from amorsim.kernels.beside import main; main()")


def test_no_file_of_the_present_folder_is_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("own", "present"):
        (tmp_path / name).mkdir()
    (tmp_path / "own" / "helper.py").write_text("import struct\n\ndef main():\n    print(struct.__file__)\n")
    (tmp_path / "present" / "struct.py").write_text("from _struct import *\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "own"))
    told = subprocess.run(
        command_for("helper", "main"), cwd=tmp_path / "present", check=True, stdout=subprocess.PIPE, text=True
    )
    assert Path(told.stdout.strip()).parent != tmp_path / "present"


def test_the_deadline_holds_from_before_the_first_module_is_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "endless.py").write_text("while True:\n    pass\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(beside, "_LONGEST", 0.2)
    ended = subprocess.run(command_for("endless", "main"), check=False, stderr=subprocess.DEVNULL, timeout=30.0)
    assert ended.returncode == 1


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
    monkeypatch.setattr(beside, "command_for", lambda *_: [sys.executable, "-c", "import time; time.sleep(60)"])
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
