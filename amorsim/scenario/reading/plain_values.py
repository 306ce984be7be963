"""Values that no field describes, such as the options of a user's controller."""

from __future__ import annotations

import math
from typing import Any

from amorsim.scenario.reading.faults import Node, shown

__all__ = ["check_values"]


def check_values(node: Node, skip: tuple[str, ...] = ()) -> bool:
    """Whether a table holds only finite numbers, texts, flags, lists and tables; notes faults for all else."""
    before = node.book.count
    for key, child in node.children():
        if key not in skip:
            _check(child)
    return node.book.count == before


def _check(node: Node) -> None:
    value: Any = node.value
    if isinstance(value, dict):
        check_values(node)
    elif isinstance(value, list):
        for item in node.items():
            _check(item)
    elif isinstance(value, float) and not math.isfinite(value):
        node.fault(f"expected a finite number, got {shown(value)}")
    elif not isinstance(value, (bool, int, float, str)):
        node.fault(f"expected a number, a text, true, false, a list or a table, got {shown(value)}")
