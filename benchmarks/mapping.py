"""Occupancy grids: scans of 181 beams put into cells of 5 cm, by amorsim's kernel and by a plain loop in Python."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.estimators.map_area import log_odds_evidence
from amorsim.kernels.mapping.occupancy import Scans, add_log_odds
from amorsim.kernels.mapping.scan_cells import Area, window_for
from benchmarks.contest import Clock
from benchmarks.results import Ratio, Row, ratio_of

__all__ = ["measure", "plain_scan"]

Array = npt.NDArray[np.float64]

SECTION = "mapping"
_AREA = Area(800, 800, 0.05)  # 40 m x 40 m
_BEARINGS = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 181)
_REACH = 8.0  # m
_SCANS = 200


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """Scans a second of both sides, all beams 8 m long."""
    say("mapping: 181 beams of 8 m into cells of 5 cm")
    poses = np.random.default_rng(1).uniform((-10.0, -10.0, -math.pi), (10.0, 10.0, math.pi), (_SCANS, 3))
    origin = np.array([[-20.0, -20.0]])
    ours, theirs = [], []
    room = window_for(_AREA, _REACH)
    cells = np.full((1, _AREA.rows * _AREA.cols), np.nan, dtype=np.float32)
    scans = [_scan(pose) for pose in poses]
    few = 1 if quick else 4

    def draw() -> None:
        for scan in scans:
            add_log_odds(_AREA, origin, scan, log_odds_evidence(), room, cells)

    draw()
    for _ in range(rounds):
        ours.append(_SCANS / _timed(draw, clock))
        grid: dict[tuple[int, int], Any] = {}
        theirs.append(few / _timed(functools.partial(_plain_scans, poses[:few], grid), clock))
    setting = "181 beams of 8 m, cells of 5 cm"
    microseconds = 1e6 / float(np.median(ours))
    plain = Row(
        section=SECTION,
        setting=setting,
        side="plain Python",
        unit="scans/s",
        rounds=tuple(theirs),
        ratio=Ratio(spread=ratio_of(ours, theirs), counts=True),
        note="the same cells, beam by beam, in a dictionary",
    )
    note = f"{microseconds:.0f} µs a scan; each cell once in a scan, hits before misses"
    return [Row(section=SECTION, setting=setting, side="amorsim", unit="scans/s", rounds=tuple(ours), note=note), plain]


def _scan(pose: Array) -> Scans:
    ranges = np.full((1, len(_BEARINGS)), _REACH - 1e-3)
    fresh = np.ones((1, 1), dtype=bool)
    cos_b, sin_b = np.cos(_BEARINGS)[None], np.sin(_BEARINGS)[None]
    return Scans(pose[None].copy(), ranges, fresh, cos_b, sin_b, np.array([[_REACH]]))


def _plain_scans(poses: Array, grid: dict[tuple[int, int], Any]) -> None:
    for pose in poses:
        plain_scan(pose, grid)


def plain_scan(pose: Array, grid: dict[tuple[int, int], Any]) -> None:
    """Add a scan to log-odds by cell, as one writes it first: along each beam, from cell to cell."""
    side, evidence = _AREA.resolution, log_odds_evidence()
    x, y, heading = (float(value) for value in pose)
    ends, crossed = set(), set()
    for bearing in _BEARINGS.tolist():
        dx, dy = math.cos(heading + bearing), math.sin(heading + bearing)
        reach = _REACH - 1e-3
        col, row = math.floor(x / side), math.floor(y / side)
        end = math.floor((x + reach * dx) / side), math.floor((y + reach * dy) / side)
        step_x, step_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
        while (col, row) != end:
            crossed.add((col, row))
            to_x = (((col + (step_x > 0)) * side) - x) / dx if dx else math.inf
            to_y = (((row + (step_y > 0)) * side) - y) / dy if dy else math.inf
            if min(to_x, to_y) > reach:
                break
            if to_x <= to_y:
                col += step_x
            else:
                row += step_y
        ends.add(end)
    for cell in ends:
        grid[cell] = min(grid.get(cell, 0.0) + evidence.hit, evidence.most)
    for cell in crossed - ends:
        grid[cell] = max(grid.get(cell, 0.0) + evidence.miss, evidence.least)


def _timed(work: Callable[[], Any], clock: Clock) -> float:
    started = clock()
    work()
    return clock() - started
