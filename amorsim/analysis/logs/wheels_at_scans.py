"""What the wheels had counted when scans were taken, where a log has their readings at other times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amorsim.analysis.logs.run_log import LogEntry
from amorsim.sensors.encoder import Encoder

__all__ = ["with_wheels_at_scans"]

_LEAP = 100.0  # [rad] between two readings in which nothing tells how a wheel turned, or the counter began anew


def with_wheels_at_scans(entries: Sequence[LogEntry], laser: str, encoder: str, sensor: Encoder) -> list[LogEntry]:
    """The entries of a log, each scan with the counts at its time: between two readings wheels turn evenly.

    A scan before the first reading, after the last one, or between two that are far apart stays as it is.
    """
    read = [(entry.time, entry.readings[encoder]) for entry in entries if encoder in entry.readings]
    read = [(time, counts) for time, counts in read if np.isfinite(counts).all()]
    if not read:
        return list(entries)
    times, counts = np.array([time for time, _ in read]), np.array([one for _, one in read], dtype=np.float64)
    is_even = np.abs(np.diff(sensor.angles(counts), axis=0)).max(axis=1, initial=0.0) < _LEAP
    found = []
    for entry in entries:
        after = int(np.searchsorted(times, entry.time))
        lacks = laser in entry.readings and encoder not in entry.readings
        if lacks and 0 < after < len(times) and is_even[after - 1]:
            share = (entry.time - times[after - 1]) / (times[after] - times[after - 1])
            between = (1.0 - share) * counts[after - 1] + share * counts[after]
            entry = entry._replace(readings={**entry.readings, encoder: between})
        found.append(entry)
    return found
