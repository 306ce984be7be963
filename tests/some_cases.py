"""Cases of a test, some of which are tried every day and the others with the long tests."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

__all__ = ["one_in"]


def one_in(interval: int, cases: Iterable[Any]) -> list[Any]:
    """Cases for `pytest.mark.parametrize`: every day the first, and each so many after it; a tuple is one case."""
    return [
        case
        if number % interval == 0
        else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.long)
        for number, case in enumerate(cases)
    ]
