"""Studies: what sweeping costs over simulating the same batches, and what a second process is worth.

`python -m benchmarks.studies` measures a smaller study, in about three minutes of a machine that nothing else uses.
"""

from __future__ import annotations

import argparse
import functools
import os
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import amorsim as am
from benchmarks.results import Row, spread_of

__all__ = ["main", "measure"]

SECTION = "studies"
_POINTS, _REPLICAS, _DURATION = 100, 100, 60.0
_SHORT = 20  # points
_QUICK = 6, 10, 6.0  # shows that it runs: in so small a study, most of the time is that of its beginning
_TRACK = "robots.rover.errors.drive.track.scale"


class _Taken(NamedTuple):
    """Seconds: of processors, of all processes together, and on the wall."""

    processor: float
    wall: float


def measure(rounds: int, quick: bool, say: Callable[[str], None]) -> list[Row]:
    """The rows: the demo's batches by `Simulation.run` alone, as a study in one process, and in two; in turn.

    Each side is timed both by the processor's time of all its processes and by the clock on the wall. On a machine
    that others use, only the former is fair; the gain of a second process is then what it would be with a free core
    for each, if the work is shared evenly.
    """
    return _measured(*(_QUICK if quick else (_POINTS, _REPLICAS, _DURATION)), rounds, say)


def _measured(points: int, replicas: int, duration: float, rounds: int, say: Callable[[str], None]) -> list[Row]:
    tables: dict[str, Any] = {
        "format": 1,
        "scenario": "demo",
        "replicas": replicas,
        "duration": duration,
        "axes": {_TRACK: {"from": 1.0, "to": 1.1, "count": points}},
        "metrics": {"final_error": {"use": "position_error", "at": "end"}},
    }
    taken: dict[str, list[_Taken]] = {"bare": [], "one": [], "two": []}
    _bare(tables | {"axes": {_TRACK: {"from": 1.0, "to": 1.1, "count": 2}}})  # compiles
    with tempfile.TemporaryDirectory() as name:
        for number in range(rounds):
            say(f"studies: round {number + 1}")
            taken["bare"].append(_timed(lambda: _bare(tables)))
            for side, jobs in (("one", 1), ("two", 2)):
                out = Path(name) / side
                taken[side].append(_timed(functools.partial(_swept, tables, out, jobs)))
                shutil.rmtree(out)
    return _rows(taken, f"the demo, {points} points x {replicas} replicas x {duration:g} s")


def _rows(taken: dict[str, list[_Taken]], setting: str) -> list[Row]:
    work = {side: [each.processor for each in found] for side, found in taken.items()}
    wall = {side: [each.wall for each in found] for side, found in taken.items()}
    over = spread_of([one / bare for bare, one in zip(work["bare"], work["one"], strict=True)])
    shared = spread_of([2.0 * one / two for one, two in zip(work["one"], work["two"], strict=True)])
    seen = spread_of([one / two for one, two in zip(wall["one"], wall["two"], strict=True)])
    notes = {
        "bare": "Simulation.run of each batch, nothing measured or written",
        "one": f"am.sweep, jobs=1: {over.median:.3f} x the processor's time of the batches alone "
        f"({over.low:.3f} to {over.high:.3f}); with metric, digests, files and table",
        "two": f"am.sweep, jobs=2: {shared.median:.2f} x as fast as one process with a core for each "
        f"({shared.low:.2f} to {shared.high:.2f}; twice the processor's time of one over that of two, start of the "
        f"processes included); by the clock on the wall {seen.median:.2f} x ({seen.low:.2f} to {seen.high:.2f})",
    }
    names = {"bare": "Simulation.run", "one": "amorsim, one process", "two": "amorsim, two processes"}
    return [
        Row(
            section=SECTION,
            setting=setting,
            side=names[side],
            unit="s of a processor",
            rounds=tuple(work[side]),
            note=notes[side],
        )
        for side in ("bare", "one", "two")
    ]


def _timed(do: Callable[[], Any]) -> _Taken:
    began, used = time.perf_counter(), _used()
    do()
    return _Taken(_used() - used, time.perf_counter() - began)


def _used() -> float:
    """The processor's time [s] of this process, and of those that it has started and that have ended."""
    found = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in found)


def _bare(tables: dict[str, Any]) -> None:
    axis = tables["axes"][_TRACK]
    step = (axis["to"] - axis["from"]) / (axis["count"] - 1)
    for point in range(axis["count"]):
        scenario = am.load(tables["scenario"], [f"{_TRACK}={axis['from'] + point * step!r}"])
        am.Simulation(scenario, replicas=tables["replicas"]).run(tables["duration"])


def _swept(tables: dict[str, Any], out: Path, jobs: int) -> None:
    study = am.sweep(tables, out, jobs=jobs)
    if not study.is_complete or study.failures:
        raise RuntimeError(f"the study failed: {study.failures[:1]}")
    if jobs > 1:
        from joblib.externals.loky import get_reusable_executor

        get_reusable_executor().shutdown(wait=True)  # or their time would not be known, and the next round's start free


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.studies", description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=_SHORT)
    parser.add_argument("--replicas", type=int, default=_REPLICAS)
    parser.add_argument("--duration", type=float, default=_DURATION)
    parser.add_argument("--rounds", type=int, default=1)
    chosen = parser.parse_args(arguments)

    def say(what: str) -> None:
        print(f"{what}; load {os.getloadavg()[0]:.2f}", file=sys.stderr, flush=True)

    rows = _measured(chosen.points, chosen.replicas, chosen.duration, chosen.rounds, say)
    print(rows[0].setting)
    for row in rows:
        print(f"{row.side}: {', '.join(f'{each:.1f}' for each in row.rounds)} s of a processor; {row.note}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
