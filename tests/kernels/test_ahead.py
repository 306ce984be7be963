"""The list of kernels to compile ahead: what it says, how two processes share it, and whether it is up to date."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from numba.core import types

from amorsim.kernels import ahead
from amorsim.kernels.ahead import LIST, Task, compile_ahead, describe, in_order, read_list, type_of
from amorsim.kernels.grid import Grid

DEMO = """
import json, sys
from amorsim.kernels import compile as compiling
from amorsim.kernels.ahead import describe
asked = []
compile_ = compiling._Kernel.compile
def note(self, signature):
    if type(self) is compiling._Kernel:
        asked.append([self.py_func.__module__, self.py_func.__qualname__, [describe(each) for each in signature]])
    return compile_(self, signature)
compiling._Kernel.compile = note
import amorsim as am
am.run(am.load("demo"), sys.argv[1], duration=1.0)
print(json.dumps(asked))
"""

ODOMETRY = "amorsim.kernels.odometry"

SHARING = """
import sys
from numba.core import event
class Listener(event.Listener):
    def on_start(self, event):
        function = event.data["dispatcher"].py_func
        if function.__module__.startswith("amorsim"):
            print(function.__qualname__, flush=True)
    def on_end(self, event):
        pass
event.register("numba:compile", Listener())
from amorsim.kernels.ahead import compile_ahead, in_order, read_list
from amorsim.kernels.cache import take_turns
take_turns()
tasks = read_list()
few = [task for task, _, callees in in_order(tasks) if not callees and task.is_part][:6]
compile_ahead(few)
assert all(task.dispatcher()._cache.holds(task.signature) for task in few)
"""


# Two functions to share instead of all, for it is the sharing that is tried.
FEW = """
from amorsim.kernels import ahead
few = [task for task, _, callees in ahead.in_order(ahead.read_list()) if not callees and task.is_part][:2]
ahead.read_list = lambda: few
"""

SCRIPT = f"""
{FEW}
import amorsim as am
from amorsim.kernels import beside, cache, folder
beside.cores = lambda: 2
beside._COMMAND = {FEW!r} + beside._COMMAND
am.Map.from_array([[0, 1], [0, 0]], resolution=0.1)
assert cache.KernelCache.claims is not None and len(beside._beside) == 1
print("begun")
ahead.compile_at_first()
assert len(beside._beside) == 1 and beside._beside[0].wait() == 0
assert folder.stamp_file().exists() and not folder.is_cold()
print("shared")
"""


def test_types_are_read_as_they_were_described() -> None:
    array = types.Array(types.float64, 2, "C")
    named = types.BaseTuple.from_types([types.float64] + [types.int64] * 3 + [array] * 4, Grid)
    for each in (array, array.copy(readonly=True), named, types.boolean, types.uint64, types.UniTuple(types.int64, 3)):
        assert type_of(json.loads(json.dumps(describe(each))), {}) == each
    tuples: dict[str, list[Any]] = {}
    other = types.BaseTuple.from_types([types.float64] * 8, Grid)
    told = json.loads(json.dumps([describe(each, tuples) for each in (named, other, named)]))
    assert told[0] == told[2] == ["named", "amorsim.kernels.grid:Grid"]
    assert [type_of(each, tuples) for each in told] == [named, other, named]
    with pytest.raises(ValueError, match="no name"):
        describe(types.literal(3))


def test_callees_come_first() -> None:
    ordered = in_order(read_list())
    for place, (_, _, callees) in enumerate(ordered):
        assert all(callee < place for callee in callees)
    names = {task.name: {ordered[callee][0].name for callee in callees} for task, _, callees in ordered}
    assert names["displaced"] == {"wrap"}
    assert names["wrap"] == set()
    assert ordered[0][0].name in names["march"]


def test_it_is_in_the_alphabets_order_without_a_line_twice() -> None:
    """What merging two changes of it may leave."""
    lines = LIST.read_text(encoding="utf-8").splitlines()
    assert lines == sorted(set(lines)), "write the list anew: python tools/list_kernels.py"


def test_the_list_is_what_the_demo_asks_for(tmp_path: Path) -> None:
    """A few are let pass, so that a change of a kernel can wait for the next writing of the list."""
    told = subprocess.run(
        [sys.executable, "-c", DEMO, str(tmp_path / "run")], check=True, stdout=subprocess.PIPE, text=True
    ).stdout
    asked = {json.dumps(each) for each in json.loads(told.splitlines()[-1])}
    listed = {
        json.dumps([task.module, task.name, [describe(each) for each in task.signature]])
        for task in read_list()
        if not task.is_part
    }
    assert len(asked ^ listed) <= 4, "write the list anew: python tools/list_kernels.py"


def test_two_processes_share_it(tmp_path: Path) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    both = [
        subprocess.Popen([sys.executable, "-c", SHARING], env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    told = [process.communicate(timeout=300)[0].split() for process in both]
    assert [process.returncode for process in both] == [0, 0]
    compiled = told[0] + told[1]
    assert len(compiled) == len(set(compiled)) == 6
    assert not list(tmp_path.rglob("*.claim"))


def test_what_is_no_more_is_left_out() -> None:
    number = types.float64
    compile_ahead(
        [
            Task(ODOMETRY, "no_such_kernel", True, (number,)),
            Task("amorsim.kernels.no_such_file", "compose", True, (number,)),
            Task("amorsim.kernels.poses", "wrap", True, (number,) * 9),
        ]
    )


def test_what_is_compiled_is_not_compiled_at_first(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr(ahead, "begin", lambda: done.append("begin"))
    monkeypatch.setattr(ahead, "take_turns", lambda: done.append("turns"))
    monkeypatch.setattr(ahead, "compile_ahead", lambda: done.append("ahead"))
    monkeypatch.setattr(ahead, "mark_warm", lambda: done.append("warm"))
    monkeypatch.setattr(ahead, "is_cold", lambda: False)
    ahead.compile_at_first()
    assert done == []
    monkeypatch.setattr(ahead, "is_cold", lambda: True)
    ahead.compile_at_first()
    assert done == ["begin", "turns", "ahead", "warm"]


def test_a_script_has_it_compiled_beside_from_its_first_map_on(tmp_path: Path) -> None:
    """By one process, and waits for what it compiles; its own main module is not run again."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    told = subprocess.run(
        [sys.executable, str(script)], env=environment, check=True, stdout=subprocess.PIPE, text=True, timeout=300
    ).stdout.split()
    assert told == ["begun", "shared"]
