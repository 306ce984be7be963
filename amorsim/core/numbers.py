"""What counts as a number among the values that files, forms and scripts give."""

from __future__ import annotations

import math
from typing import Any

__all__ = ["is_number"]


def is_number(value: Any, below: float = math.inf) -> bool:
    """Whether a value is an int or a float; with `below`, one whose size is less than that. True and False are not."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return below == math.inf or -below < value < below
