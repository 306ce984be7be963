"""What is measured: rows of a table, ratios between two sides, and when a ratio counts."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

__all__ = [
    "AGREEMENT",
    "Conduct",
    "Ratio",
    "Row",
    "Spread",
    "as_json",
    "compare",
    "mean_range",
    "ratio_of",
    "spread_of",
]

AGREEMENT = 0.01
"""How far mean ranges, of the scans first and of the way driven then, may differ (1 %)."""
_SAME_WAY = 0.05


@attrs.frozen
class Spread:
    """Median, least and largest of the rounds."""

    median: float
    low: float
    high: float


@attrs.frozen(kw_only=True)
class Conduct:
    """What one side did while it was timed: without it no ratio counts."""

    first_range: float | None  # [m] mean of the first scan's ranges; beams without a return count as range_max
    mean_range: float | None  # [m] of all scans
    distance: float | None = None  # [m] driven by a robot in the mean; none where nothing is meant to move
    stopped: float | None = None  # share of robot-steps in which the robot neither drove nor turned
    steps: int | None = None
    all_beams: bool = True  # whether a scan with all its beams was seen to be new in every step


@attrs.frozen(kw_only=True)
class Ratio:
    """amorsim's figure over the other's (for times and sizes: the other's over amorsim's), round by round."""

    spread: Spread
    counts: bool
    why_not: str = ""


@attrs.frozen(kw_only=True)
class Row:
    """One line of the table: one side in one setting."""

    section: str  # one of `benchmarks.command.SECTIONS`
    setting: str
    side: str
    unit: str
    rounds: tuple[float, ...] = ()
    ratio: Ratio | None = None  # of amorsim to this side
    conduct: Conduct | None = None
    note: str = ""

    @property
    def spread(self) -> Spread | None:
        """Of the rounds, if it was measured."""
        return spread_of(self.rounds) if self.rounds else None


def spread_of(values: Sequence[float]) -> Spread:
    """Median, least and largest."""
    return Spread(statistics.median(values), min(values), max(values))


def ratio_of(ours: Sequence[float], theirs: Sequence[float], *, less_is_better: bool = False) -> Spread:
    """The spread of ratios, each of one round, so that what slows the machine slows both sides.

    Raises
    ------
    ValueError
        If the sides have not made the same rounds.
    """
    if len(ours) != len(theirs):
        raise ValueError(f"{len(ours)} rounds against {len(theirs)}: a ratio is of the same rounds")
    pairs = zip(theirs, ours, strict=True) if less_is_better else zip(ours, theirs, strict=True)
    return spread_of([a / b for a, b in pairs])


def compare(ours: Conduct, theirs: Conduct) -> str:
    """Why a ratio between these two does not count; nothing if it does.

    First the first scans, then the mean ranges, then whether both moved, and as far as each other.
    """
    for who, conduct in (("amorsim", ours), ("the peer", theirs)):
        if not conduct.all_beams:
            return f"{who} did not evaluate all beams in every step"
    for what, a, b in (
        ("first scans", ours.first_range, theirs.first_range),
        ("mean ranges", ours.mean_range, theirs.mean_range),
    ):
        if a is None or b is None:
            return f"{what} are not known of both sides"
        if not abs(a - b) <= AGREEMENT * max(a, b):
            return f"{what} differ: {a:.3f} m against {b:.3f} m"
    if ours.distance is not None and theirs.distance is not None:
        if min(ours.distance, theirs.distance) <= 0.0:
            return "one side does not move"
        if abs(ours.distance - theirs.distance) > _SAME_WAY * ours.distance:
            return f"ways differ: {ours.distance:.3f} m against {theirs.distance:.3f} m"
    return ""


def mean_range(ranges: npt.NDArray[np.float64], range_max: float) -> float:
    """Mean of ranges [m], where a beam without a return counts as `range_max`."""
    return float(np.minimum(ranges, range_max).mean())


def as_json(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The rows as plain dicts, with the spreads of their rounds."""
    made = []
    for row in rows:
        made.append(attrs.asdict(row) | {"spread": None if row.spread is None else attrs.asdict(row.spread)})
    return made
