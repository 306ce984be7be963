"""The bar of long work: where it appears, and where it does not."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.core.execution import progress as module
from amorsim.core.execution.progress import progress_shown
from tests import building


class Bar:
    """What a bar is shown, in place of one."""

    def __init__(self) -> None:
        self.shares: list[float] = []
        self.opened = self.closed = 0

    def __call__(self, what: str) -> Bar:
        return self

    def __enter__(self) -> Any:
        self.opened += 1
        return self.shares.append

    def __exit__(self, *_: object) -> None:
        self.closed += 1


@pytest.fixture
def bar(monkeypatch: pytest.MonkeyPatch) -> Bar:
    made = Bar()
    monkeypatch.setattr(module, "_bar_here", lambda: made)
    monkeypatch.setattr(module, "_AFTER", 0.0)
    monkeypatch.setattr(module, "_EVERY", 0.0)
    return made


def simulation() -> am.Simulation:
    return am.Simulation(building.scenario(building.robot(), map=building.room(6.0, 4.0, 0.01), duration=0.5))


def test_nobody_looks_where_there_is_no_terminal() -> None:
    with progress_shown(True, "working", float) as show:
        assert show is None


def test_short_work_has_no_bar(bar: Bar, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_AFTER", 1000.0)
    simulation().run()
    assert bar.opened == 0


def test_a_simulation_shows_each_step_and_the_bar_goes(bar: Bar) -> None:
    simulation().run(0.5)
    assert bar.shares == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0])
    assert (bar.opened, bar.closed) == (1, 1)
    simulation().run(0.5, progress=False)
    assert bar.opened == 1


def test_a_run_and_its_repetition_show_one_bar_each(bar: Bar, tmp_path: Path) -> None:
    am.run(simulation().scenario, tmp_path / "run")
    assert bar.shares[-1] == 1.0
    am.reproduce(tmp_path / "run")
    assert (bar.opened, bar.closed) == (2, 2)
    told: list[float] = []
    am.run(simulation().scenario, tmp_path / "told", progress=told.append)
    assert told[-1] == 1.0
    assert bar.opened == 2


def test_work_within_other_work_has_no_bar_of_its_own(bar: Bar) -> None:
    with progress_shown(True, "outside", float) as show:
        assert show is not None
        simulation().run(0.5)
        show(0.5)
    assert bar.shares == [0.5]


def test_the_bar_goes_when_work_fails(bar: Bar) -> None:
    def fail() -> None:
        with progress_shown(True, "working", float) as show:
            assert show is not None
            show(0.1)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert (bar.opened, bar.closed) == (1, 1)
    simulation().run(0.5)
    assert bar.opened == 2


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
def test_in_a_terminal_it_is_drawn_and_ctrl_c_keeps_what_is_done(tmp_path: Path) -> None:
    code = (
        "import amorsim as am\nfrom amorsim.core.execution import progress\nfrom tests import building\n"
        "progress._AFTER = 0.0\n"
        "sim = am.Simulation(building.scenario(building.robot(), map=building.room(6.0, 4.0, 0.01)))\n"
        "try:\n    sim.run(1e6)\nexcept KeyboardInterrupt:\n    print('kept', sim.tick > 0)\n"
    )
    theirs, ours = pty.openpty()
    child = subprocess.Popen(
        [sys.executable, "-c", code], stderr=ours, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[2]
    )
    os.close(ours)
    seen = b""
    until = time.monotonic() + 120.0
    while b"simulating" not in seen and time.monotonic() < until:
        seen += os.read(theirs, 4096)
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=60)
    os.close(theirs)
    assert b"simulating" in seen
    assert out == "kept True\n"


def test_in_a_notebook_it_is_an_element_that_is_updated(monkeypatch: pytest.MonkeyPatch) -> None:
    import types

    shown: list[str] = []
    handle = types.SimpleNamespace(update=shown.append)
    display = types.ModuleType("IPython.display")
    display.HTML = str  # type: ignore[attr-defined]
    display.display = lambda content, display_id: shown.append(content) or handle  # type: ignore[attr-defined]
    ipython = types.ModuleType("IPython")
    ipython.get_ipython = lambda: type("ZMQInteractiveShell", (), {})()  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setattr(module, "_AFTER", 0.0)
    with progress_shown(True, "working", float) as show:
        assert show is not None
        show(0.25)
    assert '<progress value="0.250"' in shown[1]
    assert shown[-1] == ""
