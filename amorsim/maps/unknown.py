"""What unknown cells of a map are to rays and bodies: an option that loaders share."""

from __future__ import annotations

from typing import Any

from amorsim.core.parameters import parameter

__all__ = ["OCCUPIED", "UNKNOWN", "unknown_as"]

OCCUPIED, UNKNOWN = 1, 2
"""Bits of a cell's class; 0 is a cell that is known to be free."""


def unknown_as() -> Any:
    """The field ``unknown`` of a loader."""
    return parameter(
        "free",
        choices=("free", "occupied"),
        help="what unknown cells are to beams and bodies; robots that are given no place start in known cells",
    )
