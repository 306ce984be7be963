"""Which values of files, forms and scripts are numbers, and how numbers are written into files."""

from __future__ import annotations

import math
from typing import Any

__all__ = ["is_number", "millimetres"]


def is_number(value: Any, below: float = math.inf) -> bool:
    """Whether a value is an int or a float; with `below`, one whose size is less than that. True and False are not."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return below == math.inf or -below < value < below


def millimetres(metres: float) -> str:
    """A length in millimetres for a file; if possible one that gives the same number when divided by 1000."""
    near = metres * 1000
    for value in (float(round(near)), near, math.nextafter(near, math.inf), math.nextafter(near, -math.inf)):
        if value / 1000 == metres:
            return repr(value).removesuffix(".0")
    return repr(near)
