"""Claims: each kernel is compiled by one process, and nobody waits for one that is gone."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from amorsim.kernels import claims
from amorsim.kernels.claims import Claims

COMPILING = """
from numba.core import event
class Listener(event.Listener):
    def on_start(self, event):
        function = event.data["dispatcher"].py_func
        if function.__module__.startswith("amorsim"):
            print(function.__qualname__, flush=True)
    def on_end(self, event):
        pass
event.register("numba:compile", Listener())
from amorsim.kernels.cache import take_turns
take_turns()
import numpy as np
from amorsim.kernels.poses import compose
out = np.empty((1, 3))
compose(np.array([[1.0, 2.0, 0.0]]), np.array([[1.0, 0.0, 0.5]]), out)
assert out.tolist() == [[2.0, 2.0, 0.5]]
"""


def test_two_processes_compile_each_kernel_once(tmp_path: Path) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    both = [
        subprocess.Popen([sys.executable, "-c", COMPILING], env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    told = [process.communicate(timeout=120)[0].split() for process in both]
    assert [process.returncode for process in both] == [0, 0]
    compiled = told[0] + told[1]
    assert "compose" in compiled
    assert len(compiled) == len(set(compiled))
    assert not list(tmp_path.rglob("*.claim"))


def test_one_has_a_claim_until_it_is_given_up(tmp_path: Path) -> None:
    mine, theirs = Claims(tmp_path), Claims(tmp_path)
    path = mine.path("a.b", "(float64,)")
    assert path != mine.path("a.b", "(int64,)")
    assert mine.try_for(path)
    assert mine.try_for(path)  # compiling failed, and is tried again
    assert not theirs.try_for(path)
    theirs.give_up(path)
    assert path.exists()
    mine.give_up(path)
    assert theirs.try_for(path)


@pytest.mark.skipif(os.name != "posix", reason="elsewhere nobody asks whether a process lives")
def test_a_claim_of_a_process_that_is_gone_counts_for_nothing(tmp_path: Path) -> None:
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    path = tmp_path / "a.claim"
    path.write_text(str(gone.pid))
    assert Claims(tmp_path).try_for(path)


@pytest.mark.skipif(not hasattr(os, "waitid"), reason="there a child is told from one that has ended by asking it")
def test_nor_does_one_of_a_child_that_has_ended_and_was_not_asked_how(tmp_path: Path) -> None:
    child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    path = tmp_path / "a.claim"
    path.write_text(str(child.pid))
    assert not Claims(tmp_path).try_for(path)
    child.kill()
    deadline = time.monotonic() + 20.0
    while not Claims(tmp_path).try_for(path):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert child.wait() == -9  # it was left to whoever started it to ask
    assert child.stdin is not None
    child.stdin.close()


def test_an_old_claim_counts_for_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.claim"
    path.write_text(str(os.getpid()))
    assert not Claims(tmp_path).try_for(path)
    old = time.time() - claims.LONGEST - 1.0
    os.utime(path, (old, old))
    assert Claims(tmp_path).try_for(path)


def test_where_no_file_can_be_made_nobody_waits(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert Claims(tmp_path / "file").try_for(tmp_path / "file" / "a.claim")
