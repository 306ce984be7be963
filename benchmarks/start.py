"""Start-up, from the start of a process to its first step; and what writing all text files costs."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt

import amorsim as am
from benchmarks import worlds
from benchmarks.children import ROOM, TASK
from benchmarks.contest import Clock
from benchmarks.ours import disc, pioneer
from benchmarks.peers import PEERS
from benchmarks.peers.base import Peer
from benchmarks.results import Ratio, Row, ratio_of, spread_of
from benchmarks.task import BEAMS, DT

__all__ = ["measure"]

SECTION = "start"
_STEPS = 3000  # of a tenth as many the time differs by a half, for 15 ms are soon disturbed
_ROBOTS = 10_000
_ONE_STEP = "one step: that all beams were scanned is all that is compared"


def measure(rounds: int, quick: bool, peers: list[type[Peer]], clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """The rows: warm starts in turn with the peers', cold starts, a start of many robots, and the cost of writing.

    Starts of processes are timed by the clock on the wall.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        room = worlds.line_room()
        starts = worlds.places(room, 1, 0.6)
        worlds.write_wld(room.walls, room.size[0], folder / ROOM)
        np.savez(folder / TASK, walls=room.walls, starts=starts, twists=np.full((1, 1, 2), 0.1))
        rows = _warm(rounds, peers, folder, say)
        rows += _cold(1 if quick else min(rounds, 3), folder, say)
    rows += _many(rounds, 100 if quick else _ROBOTS, clock, say)
    return rows + _writing(rounds, 50 if quick else _STEPS, clock, say)


def _warm(rounds: int, peers: list[type[Peer]], folder: Path, say: Callable[[str], None]) -> list[Row]:
    names = {cls: name for name in PEERS for cls in peers if PEERS[name].endswith(f":{cls.__name__}")}
    ours: list[float] = []
    demo: list[float] = []
    whole: list[float] = []
    theirs: dict[str, list[float]] = {cls.name: [] for cls in peers}
    for side in ("amorsim", "demo"):  # whatever was not compiled yet is now
        _until_answer(side, folder, {})
    for number in range(rounds):
        say(f"start: warm, round {number + 1}")
        ours.append(_until_answer("amorsim", folder, {}))
        demo.append(_until_answer("demo", folder, {}))
        whole.append(_whole_run(folder / f"run{number}"))
        for cls, short in names.items():
            theirs[cls.name].append(_until_answer(short, folder, {}))
    rows = [
        _row(
            "warm, process start to first step", "amorsim", ours, "one Pioneer, line room from its .wld file, one step"
        ),
        _row("warm, the demo's first step", "amorsim", demo, "amorsim.load('demo') and one step in Python"),
        _row(
            "warm, the demo from start to end",
            "amorsim",
            whole,
            "amorsim run demo --duration 0.1, with files and picture",
        ),
    ]
    for cls in peers:
        found = theirs[cls.name]
        ratio = Ratio(spread=ratio_of(ours, found, less_is_better=True), counts=False, why_not=_ONE_STEP)
        note = "the line room and one step with one scan of 181 beams"
        row = _row("warm, process start to first step", f"{cls.name} {cls.version()}", found, note, ratio)
        rows.append(row)
    return rows


def _cold(rounds: int, folder: Path, say: Callable[[str], None]) -> list[Row]:
    found, whole = [], []
    for number in range(rounds):
        say(f"start: cold, round {number + 1}")
        cache = folder / f"cache{number}"
        cache.mkdir()
        found.append(_until_answer("demo", folder, {"NUMBA_CACHE_DIR": str(cache)}))
        cache = folder / f"cache{number} of a run"
        cache.mkdir()
        whole.append(_whole_run(cache / "out", {"NUMBA_CACHE_DIR": str(cache)}))
    return [
        _row(
            "cold, the demo's first step",
            "amorsim",
            found,
            "an empty cache: kernels are compiled as they are called, in one process",
        ),
        _row(
            "cold, the demo from start to end",
            "amorsim",
            whole,
            "amorsim run demo --duration 0.1 with an empty cache: kernels compiled in two processes, files and picture",
        ),
    ]


def _many(rounds: int, robots: int, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """Making a simulation of many robots."""
    say(f"start: {robots} discs")
    world = worlds.office(5.0 * math.ceil(math.sqrt(10.0 * robots) / 5.0))
    places = worlds.places(world, robots, 0.45, 0.85)
    made = [disc(f"disc{i}", place) for i, place in enumerate(places)]
    found = []
    for _ in range(rounds + 1):
        started = clock()
        am.Simulation(am.Scenario(map=world.map, robots=made, dt=DT, seed=11))
        found.append(clock() - started)
    note = "am.Scenario and am.Simulation, with the first scans; the robots and the map are there already"
    return [_row(f"a simulation of {robots} discs is made", "amorsim", found[1:], note)]


def _writing(rounds: int, steps: int, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """One Pioneer in the line room, all sensors in every step: stepped alone, and stepped and recorded, in turn."""
    say("start: writing text files")
    room = worlds.line_room()
    robot = pioneer("rover", worlds.places(room, 1, 0.6)[0])
    with tempfile.TemporaryDirectory() as folder:  # only a map from a file can be recorded
        worlds.write_wld(room.walls, room.size[0], Path(folder) / ROOM)
        return _recorded(Path(folder), robot, rounds, steps, clock)


def _recorded(place: Path, robot: am.Robot, rounds: int, steps: int, clock: Clock) -> list[Row]:
    """Steps, and steps and what is written of them, until all of it is in the files and these are closed."""
    # Drawing the picture comes after the steps, and is not what is asked.
    scenario = am.Scenario(map=am.load_map(place / ROOM), robots=[robot], dt=DT, recording=am.Recording(picture=False))
    alone: list[float] = []
    written: list[float] = []
    ratios: dict[str, list[float]] = {"": [], "by the clock on the wall": []}
    size = 0
    for number in range(rounds + 1):
        simulation = am.Simulation(scenario)
        lone = _times(clock)
        for _ in range(steps):
            simulation.step()
        lone = _times(clock) - lone
        simulation = am.Simulation(scenario)
        folder = place / f"run{number}"
        with am.record(simulation, folder, duration=steps * DT) as session:
            both = _times(clock)
            for _ in range(steps):
                simulation.step()
                session.keep()
            session.close()
            both = _times(clock) - both
        size = sum(path.stat().st_size for path in folder.rglob("*.csv"))
        if number:  # the first round warms the kernels up
            alone.append(float(lone[0]) / steps)
            written.append(float(both[0]) / steps)
            for found, ratio in zip(ratios.values(), both / lone, strict=True):
                found.append(float(ratio))
    parts = []
    for which, found in ratios.items():
        spread = spread_of(found)
        parts.append(f"{spread.median:.2f} x the step alone ({spread.low:.2f} to {spread.high:.2f}) {which}".strip())
    note = f"{size / steps:.0f} bytes a step, and the files closed; {', '.join(parts)}"
    return [
        _row("one Pioneer, a step", "amorsim", alone, "kept in memory"),
        _row("one Pioneer, a step with all text files", "amorsim", written, note),
    ]


def _times(clock: Clock) -> npt.NDArray[np.float64]:
    """By the clock that was asked for, and by the one on the wall [s]: whether anything is done beside it."""
    return np.array([clock(), time.perf_counter()])


def _row(setting: str, side: str, values: list[float], note: str, ratio: Ratio | None = None) -> Row:
    return Row(section=SECTION, setting=setting, side=side, unit="s", rounds=tuple(values), ratio=ratio, note=note)


def _until_answer(side: str, folder: Path, changes: dict[str, str]) -> float:
    """Seconds from the start of a process to its answer, which it gives when its first step is made."""
    command = [sys.executable, "-m", "benchmarks.children", "first-step", side, str(folder)]
    started = time.perf_counter()
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=_environment(changes)
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        answer = next((line for line in process.stdout if line.startswith("{")), "{}")
        taken = time.perf_counter() - started
        if process.wait() or json.loads(answer).get("beams") != BEAMS:
            raise RuntimeError(f"the first step of {side} made no scan of {BEAMS} beams:\n{process.stderr.read()}")
    return taken


def _whole_run(out: Path, changes: dict[str, str] | None = None) -> float:
    command = [sys.executable, "-m", "amorsim", "run", "demo", "--duration", "0.1", "--quiet", "--out", str(out)]
    started = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=_environment(changes or {}))
    return time.perf_counter() - started


def _environment(changes: dict[str, str]) -> dict[str, str]:
    """The present one, with changes; and Python keeps its byte code, as pip does that of the peers."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return kept | changes
