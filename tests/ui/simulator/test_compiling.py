"""A kernel that is being compiled is not a controller that hangs; and the user sees that it is being compiled."""

from __future__ import annotations

import itertools
import sys
import traceback
from pathlib import Path

import numba
import pytest

from amorsim.kernels import COMPILING
from amorsim.ui.simulator.process.stacks import is_compiling
from tests.ui.sessions import Make
from tests.ui.simulator.test_session import done, frame, state, until


def test_the_compiler_is_known_by_its_stack() -> None:
    seen: list[tuple[bool, bool]] = []
    calls = itertools.count()

    def look(frame: object, event: str, argument: object) -> None:
        if event == "call" and next(calls) % 50 == 0 and not (seen and seen[-1][1]):
            stack = traceback.extract_stack(frame)  # type: ignore[arg-type]
            seen.append((is_compiling(stack), is_compiling(stack, reading_counts=False)))

    function = numba.njit(lambda x: x + 1.0)
    before = sys.getprofile()
    sys.setprofile(look)
    try:
        function(1.0)
    finally:
        sys.setprofile(before)
    assert any(whole for whole, _ in seen)
    assert any(compiled for _, compiled in seen)
    assert not any(compiled and not whole for whole, compiled in seen)
    assert not is_compiling(traceback.extract_stack())


def test_the_user_sees_a_message_while_kernels_are_compiled(
    start: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("compiling").touch()
    noticed: list[str] = []
    session = start("own.py:Compiling", patience=1.0, notice=noticed.append)
    window = session.open_window()
    assert state(session, window)["status"] == "paused"
    frame(session)
    done(session, "speed", factor=None)
    done(session, "run")
    shown = until(lambda: (s := state(session, window))["status"] == "compiling" and s)
    assert shown["fault"] is None  # it is not a hang, however long it takes
    assert shown["holder"] == window
    assert noticed == [COMPILING]
    # A page that is loaded meanwhile gets its scene.
    assert session.hang is None
    Path("compiling").unlink()
    until(lambda: state(session, window)["status"] == "ended")
    assert noticed == [COMPILING]
