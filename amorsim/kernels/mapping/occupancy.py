"""Occupancy grids over rows: evidence for and against each cell, added scan by scan.

Two models of what a scan says. Log-odds: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics" (2005), 9.2. Counting:
hits and misses, whose share is the most likely reflectance, ibid. 9.4 and D. Hähnel, "Mapping with Mobile Robots"
(2004). In one scan a cell is hit once or missed once, and a hit goes before misses.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.mapping.scan_cells import Area, Seen, see

__all__ = [
    "Evidence",
    "Scans",
    "add_counts",
    "add_evidence",
    "add_log_odds",
    "probabilities_of_counts",
    "probabilities_of_log_odds",
]

Floats = npt.NDArray[np.float64]


class Scans(NamedTuple):
    """A scan of each row."""

    poses: Floats  # (N, 3) of the lasers in the world
    ranges: Floats  # (N, k) [m]
    fresh: npt.NDArray[np.bool_]  # (N, 1) whether it is to be used
    cos_b: Floats  # (B, k), B = 1 or N: cosines and sines of the beams' bearings
    sin_b: Floats
    range_max: Floats  # (R, 1), R = 1 or N [m]


class Evidence(NamedTuple):
    """What a hit and a miss add to a cell's log-odds, and the bounds of these."""

    hit: float
    miss: float  # negative
    least: float
    most: float


@part
def add_evidence(seen: Seen, hits: int, misses: int, evidence: Evidence, cells: npt.NDArray[np.float32]) -> None:
    """Add what a scan says to a map (n,) of log-odds."""
    for j in range(hits):
        before = cells[seen.hit[j]]
        cells[seen.hit[j]] = min((0.0 if math.isnan(before) else before) + evidence.hit, evidence.most)
    for j in range(misses):
        before = cells[seen.missed[j]]
        cells[seen.missed[j]] = max((0.0 if math.isnan(before) else before) + evidence.miss, evidence.least)


@kernel
def add_log_odds(
    area: Area, origins: Floats, scans: Scans, evidence: Evidence, seen: Seen, log_odds: npt.NDArray[np.float32]
) -> None:
    """Add scans to maps (N, rows * cols) of log-odds, nan where nothing was seen; `origins` (N, 2) [m]."""
    for i in range(scans.ranges.shape[0]):
        if not scans.fresh[i, 0]:
            continue
        b = i if scans.cos_b.shape[0] > 1 else 0
        reach = scans.range_max[i if scans.range_max.shape[0] > 1 else 0, 0]
        hits, misses = see(
            area, origins[i], scans.poses[i], scans.ranges[i], scans.cos_b[b], scans.sin_b[b], reach, seen
        )
        add_evidence(seen, hits, misses, evidence, log_odds[i])


@kernel
def add_counts(
    area: Area,
    origins: Floats,
    scans: Scans,
    seen: Seen,
    hit_counts: npt.NDArray[np.int32],
    miss_counts: npt.NDArray[np.int32],
) -> None:
    """Add scans to maps (N, rows * cols) of hits and of misses; `origins` (N, 2) [m]."""
    for i in range(scans.ranges.shape[0]):
        if not scans.fresh[i, 0]:
            continue
        b = i if scans.cos_b.shape[0] > 1 else 0
        reach = scans.range_max[i if scans.range_max.shape[0] > 1 else 0, 0]
        hits, misses = see(
            area, origins[i], scans.poses[i], scans.ranges[i], scans.cos_b[b], scans.sin_b[b], reach, seen
        )
        for j in range(hits):
            hit_counts[i, seen.hit[j]] += 1
        for j in range(misses):
            miss_counts[i, seen.missed[j]] += 1


@kernel
def probabilities_of_log_odds(log_odds: npt.NDArray[np.float32], out: Floats) -> None:
    """Probabilities (N, n) that cells are occupied; nan where nothing was seen."""
    for i in range(log_odds.shape[0]):
        for j in range(log_odds.shape[1]):
            value = float(log_odds[i, j])
            out[i, j] = value if math.isnan(value) else 1.0 / (1.0 + math.exp(-value))


@kernel
def probabilities_of_counts(hit_counts: npt.NDArray[np.int32], miss_counts: npt.NDArray[np.int32], out: Floats) -> None:
    """Shares (N, n) of hits in all that was seen of cells; nan where nothing was."""
    for i in range(hit_counts.shape[0]):
        for j in range(hit_counts.shape[1]):
            seen = hit_counts[i, j] + miss_counts[i, j]
            out[i, j] = hit_counts[i, j] / seen if seen > 0 else math.nan
