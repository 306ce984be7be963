"""The command: `python -m benchmarks [--only SECTIONS] [--rounds N] [--quick] [--out DIR]`."""

from __future__ import annotations

import argparse
import importlib.util
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks import (
    avoiders,
    compositions,
    crowd,
    filters,
    fleet,
    graphs,
    mapping,
    maps,
    memory,
    mixed,
    planners,
    rays,
    start,
    studies,
)
from benchmarks.machine import circumstances
from benchmarks.peers import installed
from benchmarks.picture import draw
from benchmarks.published import BESIDE
from benchmarks.results import Row, as_json
from benchmarks.table import as_text

__all__ = ["main"]

SECTIONS = (
    "rays",
    "fleet",
    "compositions",
    "mixed",
    "crowd",
    "memory",
    "maps",
    "start",
    "filters",
    "mapping",
    "graphs",
    "planners",
    "avoiders",
    "studies",
    "learning",
)
CLOCKS = {"wall": time.perf_counter, "cpu": time.process_time}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure what was asked for, and write the table as text, JSON and a picture; the exit status."""
    parser = _parser()
    given = parser.parse_args(arguments)
    if given.threads > 1 and given.clock == "cpu":
        parser.error("argument --threads: the processor's time adds threads up; expected --clock wall beside it")
    began = time.perf_counter()

    def say(what: str) -> None:
        print(f"[{time.perf_counter() - began:6.1f} s] {what}", file=sys.stderr, flush=True)

    clock = CLOCKS[given.clock]
    about = circumstances()
    about["clock"] = f"{given.clock}; of memory and of starts of processes always the one on the wall"
    peers, missing = installed()
    rows: list[Row] = []
    plain_rates: tuple[float, ...] = ()
    if "rays" in given.only:
        rows, plain_rates = rays.measure(given.rounds, given.quick, clock, say)
    if "fleet" in given.only:
        rows += fleet.measure(given.rounds, given.quick, peers, clock, say, given.threads)
    if "compositions" in given.only:
        rows += compositions.measure(given.rounds, given.quick, peers, clock, say)
    if "mixed" in given.only:
        rows += mixed.measure(given.rounds, given.quick, clock, say)
    if "crowd" in given.only:
        rows += crowd.measure(given.rounds, given.quick, clock, say)
    if "mapping" in given.only:
        rows += mapping.measure(given.rounds, given.quick, clock, say)
    if "memory" in given.only:
        rows += memory.measure(given.rounds, given.quick, say)
    if "maps" in given.only:
        rows += maps.measure(given.rounds, given.quick, clock, say)
    if "start" in given.only:
        rows += start.measure(given.rounds, given.quick, peers, clock, say)
    if "filters" in given.only:
        rows += filters.measure(given.rounds, given.quick, clock, say)
    if "graphs" in given.only:
        rows += graphs.measure(given.rounds, given.quick, clock, say)
    if "planners" in given.only:
        rows += planners.measure(given.rounds, given.quick, clock, say)
    if "avoiders" in given.only:
        rows += avoiders.measure(given.rounds, given.quick, clock, say)
    if "studies" in given.only:
        rows += studies.measure(given.rounds, given.quick, say)
    if "learning" in given.only and importlib.util.find_spec("gymnasium") is not None:
        from benchmarks import learning

        rows += learning.measure(given.rounds, given.quick, clock, say)
    command = "python -m benchmarks " + " ".join(arguments if arguments is not None else sys.argv[1:])
    about["took"] = f"{time.perf_counter() - began:.0f} s, {given.rounds} rounds"
    text = as_text(rows, about, command.strip(), plain_rates, [*missing, *BESIDE])
    given.out.mkdir(parents=True, exist_ok=True)
    (given.out / "table.txt").write_text(text, encoding="utf-8")
    document = {
        "command": command.strip(),
        "about": about,
        "not_installed": missing,
        "plain_rays_per_second": plain_rates,
        "rows": as_json(rows),
    }
    (given.out / "table.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    if any(row.rounds and row.section in ("rays", "fleet") for row in rows):
        draw(rows, given.out / "table.png", f"amorsim beside its peers, {about['date']}, {about['processor']}")
    print(text)
    say(f"written: {given.out}/table.txt, .json and .png")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="amorsim beside its peers, in turn, several rounds. Installs nothing: pip install '.[bench]' does.",
    )
    parser.add_argument(
        "--only",
        type=_sections,
        default=SECTIONS,
        metavar="SECTIONS",
        help=f"some of {','.join(SECTIONS)}, with commas between; all without it",
    )
    parser.add_argument("--rounds", type=_count, default=5, metavar="N", help="how often each side runs (5)")
    parser.add_argument(
        "--clock",
        choices=sorted(CLOCKS),
        default="wall",
        help="cpu counts the processor's time of the process: fair on a machine that others use too, while every side "
        "runs in one thread (wall)",
    )
    parser.add_argument(
        "--threads",
        type=_count,
        default=1,
        metavar="N",
        help="of amorsim in fleets of 100 robots and more; with the clock on the wall only (1)",
    )
    parser.add_argument("--quick", action="store_true", help="smaller worlds and fleets: to see that all runs")
    parser.add_argument(
        "--out", type=Path, default=Path("benchmark-results"), metavar="DIR", help="where the table goes"
    )
    return parser


def _sections(text: str) -> tuple[str, ...]:
    wanted = tuple(name.strip() for name in text.split(","))
    for name in wanted:
        if name not in SECTIONS:
            raise argparse.ArgumentTypeError(f"there is no section {name!r}; expected some of {', '.join(SECTIONS)}")
    return wanted


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number > 0, got {text!r}")
    return int(text)
