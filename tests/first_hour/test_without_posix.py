"""amorsim where there is no POSIX, as on Windows: what is not there is hidden, and the usual commands work.

What only another system's own Python can show (its paths, its files that are locked while they are open) is not tested.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

# Libraries are told by sys.platform which system this is, so they are loaded before.
HIDE = """
import asyncio, multiprocessing.synchronize, os, signal, sys
import numba, numpy, PIL.Image, rich.progress, scipy.spatial, shapely, tomlkit, typer

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name in ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Hidden())
for name in ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty"):
    sys.modules.pop(name, None)
for name in (
    "fork", "forkpty", "getuid", "geteuid", "getgid", "killpg", "setsid", "getpgid", "sched_getaffinity", "sysconf",
    "pidfd_open", "mkfifo", "uname", "getloadavg", "register_at_fork", "O_NOFOLLOW", "O_NONBLOCK", "O_DIRECTORY",
):
    if hasattr(os, name):
        delattr(os, name)
for name in ("SIGHUP", "SIGUSR1", "SIGUSR2", "SIGALRM", "SIGQUIT", "pause", "setitimer", "pidfd_send_signal"):
    if hasattr(signal, name):
        delattr(signal, name)
import faulthandler
del faulthandler.register
"""


def _python(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", HIDE + code], cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )


def _amorsim(folder: Path, *arguments: str) -> str:
    found = _python(f"sys.argv = {['amorsim', *arguments]!r}\nfrom amorsim.cli import main\nmain()\n", folder)
    assert found.returncode == 0, found.stdout + found.stderr
    return found.stdout


def test_what_is_hidden_is_not_there(tmp_path: Path) -> None:
    found = _python("import fcntl\n", tmp_path)
    assert "No module named 'fcntl'" in found.stderr
    assert _python("print(hasattr(os, 'fork'), hasattr(signal, 'SIGHUP'))", tmp_path).stdout == "False False\n"


@pytest.mark.long
def test_scenarios_are_made_checked_run_and_shown(tmp_path: Path) -> None:
    _amorsim(tmp_path, "new", "mine")
    assert "no faults" in _amorsim(tmp_path, "check", "mine/scenario.toml")
    _amorsim(tmp_path, "run", "mine/scenario.toml", "--duration", "2", "--out", "run")
    assert (tmp_path / "run" / "picture.png").stat().st_size > 1000
    assert "the same" in _amorsim(tmp_path, "reproduce", "run")
    _amorsim(tmp_path, "report", "run")
    _amorsim(tmp_path, "export", "run", "--to", "html")


STUDY = """
format = 1
scenario = "mine/scenario.toml"
duration = 2.0
[axes]
"robots.rover.controller.speed" = [0.1, 0.2]
[metrics]
final_error = { use = "position_error" }
"""


@pytest.mark.long
def test_a_study_runs(tmp_path: Path) -> None:
    _amorsim(tmp_path, "new", "mine")
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    _amorsim(tmp_path, "sweep", "study.toml", "--out", "study")
    assert (tmp_path / "study" / "table.parquet").exists() or (tmp_path / "study" / "table.csv").exists()


@pytest.mark.long
def test_programs_are_checked_in_a_process_of_their_own(tmp_path: Path) -> None:
    _amorsim(tmp_path, "new", "mine")
    code = "import amorsim as am\nprint(am.check_code(am.load('mine/scenario.toml'), time_limit=20.0))\n"
    found = _python(code, tmp_path)
    assert found.stdout == "()\n", found.stderr


@pytest.mark.long
def test_a_recorded_run_plays_in_the_window(tmp_path: Path) -> None:
    pytest.importorskip("uvicorn")
    _amorsim(tmp_path, "run", "demo", "--duration", "2", "--out", "run")
    command = [sys.executable, "-c", HIDE + "sys.argv = ['amorsim', 'replay', 'run', '--no-open']\n"]
    command[-1] += "from amorsim.cli import main\nmain()\n"
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        assert process.stdout is not None
        lines: list[str] = []
        for line in process.stdout:
            lines.append(line)
            if "http://" in line:
                break
        else:
            pytest.fail("".join(lines))
    finally:
        process.terminate()
        process.communicate(timeout=30)


def test_grading_says_what_it_needs(tmp_path: Path) -> None:
    """Grading fences submissions in with a program of Linux."""
    code = "sys.platform = 'win32'\nfrom amorsim.grading.fence import find_fence\nfind_fence([])\n"
    found = _python(code, tmp_path)
    assert "is for Linux alone" in found.stderr.splitlines()[-1]
