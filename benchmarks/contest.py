"""Running sides in turn, round after round, each watched while it is timed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import attrs
import numpy as np
import numpy.typing as npt

from benchmarks.results import Conduct, mean_range
from benchmarks.task import BEAMS, RANGE_MAX, Track

__all__ = ["Clock", "Pass", "Side", "drive", "followed", "track_conduct"]

Array = npt.NDArray[np.float64]
Clock = Callable[[], float]
"""Seconds: of the clock on the wall, or of the processor's time that the process took."""


class Side(Protocol):
    """Whoever can be put to a start and make steps."""

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


def drive(side: Side, steps: int, at_least: float, clock: Clock) -> Pass:
    """Make `steps` steps from the start, again and again until `at_least` seconds have been timed."""
    made, seconds = 0, 0.0
    while seconds < at_least or not made:
        side.reset()
        started = clock()
        for index in range(steps):
            side.step(index)
        seconds += clock() - started
        made += steps
    return Pass(steps=made, seconds=seconds)


def followed(side: Watched, steps: int, at_most: float, clock: Clock) -> tuple[Pass, Conduct]:
    """Make up to `steps` steps from the start, but no new one after `at_most` seconds; and what was seen and driven.

    Only the steps are timed. A scan counts as evaluated if it has all beams and is not the last one over again,
    where the robot has moved.
    """
    side.reset()
    before, last = side.poses(), None
    ranges, way, stopped = [], 0.0, 0.0
    seconds, made, all_beams = 0.0, 0, True
    for index in range(steps):
        started = clock()
        side.step(index)
        seconds += clock() - started
        made += 1
        scan, after = side.ranges(), side.poses()
        moved = np.abs(after - before).max(axis=1) > 1e-6
        all_beams &= scan.shape == (len(after), BEAMS)
        if last is not None and scan.shape == last.shape:
            all_beams &= bool((scan != last).any(axis=1)[moved].all())
        ranges.append(mean_range(scan, RANGE_MAX))
        way += float(np.hypot(*(after - before)[:, :2].T).mean())
        stopped += float(1.0 - moved.mean())
        before, last = after, scan
        if seconds > at_most:
            break
    return Pass(steps=made, seconds=seconds), Conduct(
        first_range=ranges[0],
        mean_range=float(np.mean(ranges)),
        distance=way,
        stopped=stopped / made,
        steps=made,
        all_beams=all_beams,
    )


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
