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

from amorsim.array_types import Array, Bools, Ints32
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.mapping.scan_cells import HIT, MISSED, Area, Window, see

__all__ = [
    "Evidence",
    "Scans",
    "add_counts",
    "add_evidence",
    "add_log_odds",
    "probabilities_of_counts",
    "probabilities_of_log_odds",
]


class Scans(NamedTuple):
    """A scan of each row."""

    poses: Array  # (N, 3) of the lasers in the world
    ranges: Array  # (N, k) [m]
    fresh: Bools  # (N, 1) whether it is to be used
    cos_b: Array  # (B, k), B = 1 or N: cosines and sines of the beams' bearings
    sin_b: Array
    range_max: Array  # (R, 1), R = 1 or N [m]


class Evidence(NamedTuple):
    """The amounts that a hit and a miss add to a cell's log-odds, and their bounds."""

    hit: np.float32
    miss: np.float32  # negative
    least: np.float32
    most: np.float32


@part
def add_evidence(
    area: Area, window: Window, first_row: int, first_col: int, evidence: Evidence, cells: npt.NDArray[np.float32]
) -> None:
    """Add a scan, marked in a window, to a map (rows * cols,) of log-odds."""
    start = max(first_col, 0)
    count = min(first_col + window.side, area.cols) - start
    if count <= 0:
        return
    for row in range(max(first_row, 0), min(first_row + window.side, area.rows)):
        mark = (row - first_row) * window.side + start - first_col
        cell = row * area.cols + start
        # Slices that are indexed from 0 on: LLVM makes the loop a vector's.
        states = window.marks[mark : mark + count]
        held = cells[cell : cell + count]
        for i in range(count):
            before = held[i]
            known = np.float32(0.0) if math.isnan(before) else before
            hit = min(known + evidence.hit, evidence.most)
            miss = max(known + evidence.miss, evidence.least)
            held[i] = miss if states[i] == MISSED else (hit if states[i] == HIT else before)


@kernel
def add_log_odds(
    area: Area, origins: Array, scans: Scans, evidence: Evidence, window: Window, log_odds: npt.NDArray[np.float32]
) -> None:
    """Add scans to maps (N, rows * cols) of log-odds, nan where nothing was seen; `origins` (N, 2) [m]."""
    for i in range(scans.ranges.shape[0]):
        if not scans.fresh[i, 0]:
            continue
        b = i if scans.cos_b.shape[0] > 1 else 0
        reach = scans.range_max[i if scans.range_max.shape[0] > 1 else 0, 0]
        row, col = see(area, origins[i], scans.poses[i], scans.ranges[i], scans.cos_b[b], scans.sin_b[b], reach, window)
        add_evidence(area, window, row, col, evidence, log_odds[i])


@kernel
def add_counts(
    area: Area,
    origins: Array,
    scans: Scans,
    window: Window,
    hit_counts: Ints32,
    miss_counts: Ints32,
) -> None:
    """Add scans to maps (N, rows * cols) of hits and of misses; `origins` (N, 2) [m]."""
    for i in range(scans.ranges.shape[0]):
        if not scans.fresh[i, 0]:
            continue
        b = i if scans.cos_b.shape[0] > 1 else 0
        reach = scans.range_max[i if scans.range_max.shape[0] > 1 else 0, 0]
        row, col = see(area, origins[i], scans.poses[i], scans.ranges[i], scans.cos_b[b], scans.sin_b[b], reach, window)
        start = max(col, 0)
        count = max(0, min(col + window.side, area.cols) - start)
        for r in range(max(row, 0), min(row + window.side, area.rows)):
            mark = (r - row) * window.side + start - col
            cell = r * area.cols + start
            states = window.marks[mark : mark + count]
            hits = hit_counts[i, cell : cell + count]
            misses = miss_counts[i, cell : cell + count]
            for j in range(count):
                hits[j] += 1 if states[j] == HIT else 0
                misses[j] += 1 if states[j] == MISSED else 0


@kernel
def probabilities_of_log_odds(log_odds: npt.NDArray[np.float32], out: Array) -> None:
    """Probabilities (N, n) that cells are occupied; nan where nothing was seen."""
    for i in range(log_odds.shape[0]):
        for j in range(log_odds.shape[1]):
            value = float(log_odds[i, j])
            out[i, j] = value if math.isnan(value) else 1.0 / (1.0 + math.exp(-value))


@kernel
def probabilities_of_counts(hit_counts: Ints32, miss_counts: Ints32, out: Array) -> None:
    """Shares (N, n) of hits among all observations of cells; nan where there are none."""
    for i in range(hit_counts.shape[0]):
        for j in range(hit_counts.shape[1]):
            seen = hit_counts[i, j] + miss_counts[i, j]
            out[i, j] = hit_counts[i, j] / seen if seen > 0 else math.nan
