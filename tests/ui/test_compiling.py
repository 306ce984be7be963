"""A kernel that is being compiled is no controller that hangs."""

from __future__ import annotations

import sys
import traceback

import numba

from amorsim.ui.child import is_compiling


def test_the_compiler_is_known_by_its_stack() -> None:
    seen: list[bool] = []

    def look(frame: object, event: str, argument: object) -> None:
        if event == "call" and len(seen) < 200:
            seen.append(is_compiling(traceback.extract_stack(frame)))  # type: ignore[arg-type]

    function = numba.njit(lambda x: x + 1.0)
    before = sys.getprofile()
    sys.setprofile(look)
    try:
        function(1.0)
    finally:
        sys.setprofile(before)
    assert any(seen)
    assert not is_compiling(traceback.extract_stack())
