"""Known relations between the poses of a log, published by experts for data without a true path."""

from __future__ import annotations

import gzip
import math
import os
import zlib

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.core.arguments import numbers, path_of
from amorsim.core.errors import AnalysisError
from amorsim.core.parameters import LARGEST, ParameterError

__all__ = ["clock_offset", "read_relations"]


_SAME = 0.01  # [s] in which two times are of one scan: logs and relations are rounded differently
_MOST_MOMENTS = 1000  # of relations that are compared


def read_relations(path: str | os.PathLike[str]) -> Array:
    """The relations in a file of Kümmerle et al. (2009), `(M, 5)`, as `relation_errors` takes them.

    Lines are ``time1 time2 x y z roll pitch yaw`` [s, m, rad]: the pose at the second time in the frame of that at the
    first. What follows on a line is left out; a file whose name ends in ``.gz`` is unpacked.

    Raises
    ------
    AnalysisError
        If it cannot be read, with the line.
    """
    file = path_of(path, "path", "the path of a file of relations")
    try:
        data = file.read_bytes()
        text = (gzip.decompress(data) if file.suffix == ".gz" else data).decode("utf-8", "replace")
    except (OSError, EOFError, zlib.error) as error:
        raise AnalysisError(f"{file}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    rows = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            first, second, x, y, _, _, _, heading = map(float, words[:8])
        except ValueError:
            first = second = x = y = heading = math.nan
        row = first, second, x, y, heading
        if not all(map(math.isfinite, row)):
            raise AnalysisError(f"{file}, line {number}: expected 8 numbers: time1 time2 x y z roll pitch yaw")
        rows.append(row)
    if not rows:
        raise AnalysisError(f"{file}: expected relations, lines of time1 time2 x y z roll pitch yaw; found none")
    return np.array(rows)


def clock_offset(relations: npt.ArrayLike, times: npt.ArrayLike) -> float:
    """How far the clock of relations (M, 5) is ahead of a log's, whose scans are at `times` (T,) [s].

    Logs often count from their start, and relations from 1970. It is the difference that most pairs of times have; 0 if
    none is much more frequent than by chance, or several are alike, as with scans at regular times.

    Raises
    ------
    AnalysisError
        If these are not finite numbers of these shapes.
    """
    try:
        given, scans = numbers(relations, "relations", ("M", 5)), numbers(times, "times", ("T",))
    except ParameterError as error:
        raise AnalysisError(str(error)) from None
    for name, array in (("relations", given), ("times", scans)):
        if not (np.abs(array) <= LARGEST).all():
            raise AnalysisError(f"{name}: expected finite numbers, at most {LARGEST:g}")
    if not (len(given) and len(scans)):
        return 0.0
    moments = np.unique(given[:, :2])
    moments = moments[:: -(-len(moments) // _MOST_MOMENTS)]
    apart = np.sort((moments[:, None] - scans).ravel())
    # Of each difference, how many are at most that much larger.
    alike = np.searchsorted(apart, apart + _SAME, side="right") - np.arange(len(apart))
    best = int(np.argmax(alike))
    offset = float(np.median(apart[best : best + alike[best]]))
    others = alike[np.abs(apart - offset) > 2.0 * _SAME]
    by_chance = len(apart) * _SAME / max(float(apart[-1] - apart[0]), _SAME)
    most_by_chance = by_chance + 6.0 * math.sqrt(by_chance) + 5.0
    is_clear = alike[best] >= max(most_by_chance, 1.5 * others.max(initial=0))
    return offset if is_clear else 0.0
