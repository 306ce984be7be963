"""Running sides in turn, round after round: each watched once, and then timed in the same loop as all others."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

import attrs
import numpy as np
import numpy.typing as npt

from benchmarks.results import AGREEMENT, Conduct, mean_range
from benchmarks.task import BEAMS, RANGE_MAX, RANGE_STD, Track

__all__ = ["Clock", "Pass", "Seen", "Side", "Watched", "drive", "strayed", "track_conduct", "watch"]

Array = npt.NDArray[np.float64]
Clock = Callable[[], float]
"""Seconds: of the clock on the wall, or of the processor's time that the process took."""


class Side(Protocol):
    """What can be put at a start and makes steps."""

    def reset(self) -> None:
        """Back to the start."""

    def step(self, index: int) -> None:
        """Make one step."""


class Watched(Side, Protocol):
    """A side whose scans and poses are looked at between steps."""

    def ranges(self) -> Array:
        """The last scans."""

    def poses(self) -> Array:
        """The present poses."""


@attrs.frozen(kw_only=True)
class Pass:
    """Steps made, and the time [s] that they took."""

    steps: int
    seconds: float


@attrs.frozen(kw_only=True, eq=False)
class Seen:
    """What a side did while it was watched, and where that left it: a timed drive must end there too."""

    conduct: Conduct
    scan: Array
    poses: Array


def drive(side: Side, steps: int, at_least: float, clock: Clock) -> Pass:
    """Make `steps` steps from the start, again and again until `at_least` seconds have been timed.

    All sides are timed by this loop, with nothing between the steps.
    """
    made, seconds = 0, 0.0
    while seconds < at_least or not made:
        side.reset()
        started = clock()
        for index in range(steps):
            side.step(index)
        seconds += clock() - started
        made += steps
    return Pass(steps=made, seconds=seconds)


def watch(side: Watched, steps: int, at_most: float) -> Seen:
    """What a side sees and drives in up to `steps` steps from the start, but in no new one after `at_most` seconds.

    A scan counts as evaluated if it has all beams and is not the last one over again, where the robot has moved and
    sees something.
    """
    side.reset()
    before, last = side.poses(), None
    ranges, way, stopped = [], 0.0, 0.0
    made, all_beams = 0, True
    began = time.perf_counter()
    for index in range(steps):
        side.step(index)
        made += 1
        scan, after = side.ranges(), side.poses()
        moved = np.abs(after - before).max(axis=1) > 1e-6
        all_beams &= scan.shape == (len(after), BEAMS)
        if last is not None and scan.shape == last.shape:
            is_new = (scan != last).any(axis=1) | ~(scan < RANGE_MAX).any(axis=1)
            all_beams &= bool(is_new[moved].all())
        ranges.append(mean_range(scan, RANGE_MAX))
        way += float(np.hypot(*(after - before)[:, :2].T).mean())
        stopped += float(1.0 - moved.mean())
        before, last = after, scan
        if time.perf_counter() - began > at_most:
            break
    assert last is not None
    conduct = Conduct(
        first_range=ranges[0],
        mean_range=float(np.mean(ranges)),
        distance=way,
        stopped=stopped / made,
        steps=made,
        all_beams=all_beams,
    )
    return Seen(conduct=conduct, scan=last, poses=before)


def strayed(side: Watched, seen: Seen) -> str:
    """How a timed drive ended elsewhere than the one that was watched, or without its scan; nothing if it did not.

    Scans may differ by their noise.
    """
    poses, scan = side.poses(), side.ranges()
    if np.abs(poses - seen.poses).max() > 1e-3:
        return "timed, it did not go the way that was watched"
    if scan.shape != seen.scan.shape:
        return "timed, it did not make the scans that were watched"
    far = np.abs(np.minimum(scan, RANGE_MAX) - np.minimum(seen.scan, RANGE_MAX)) > 20.0 * RANGE_STD
    return "timed, it did not make the scans that were watched" if far.mean() > AGREEMENT else ""


def track_conduct(track: Track, steps: int, lag: int = 0) -> Conduct:
    """What amorsim did in the first steps, its scans taken as late as a peer's that trail by `lag` steps."""
    scans = track.mean_range[1 - lag : 1 - lag + steps]
    return Conduct(
        first_range=float(scans[0]),
        mean_range=float(scans.mean()),
        distance=float(track.way[:steps].sum()),
        stopped=float(track.stopped[:steps].mean()),
        steps=steps,
    )
