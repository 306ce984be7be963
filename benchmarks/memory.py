"""Memory and loading time of 1 mm line worlds, by length of wall: each load in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import amorsim as am
from benchmarks import worlds
from benchmarks.results import Row

__all__ = ["measure"]

SECTION = "memory"
_CITIES = (50.0, 200.0, 500.0, 1000.0)  # m


def measure(rounds: int, quick: bool, say: Callable[[str], None]) -> list[Row]:
    """The rows: memory held and loading time by length of wall, and the time to prepare maps that are in memory."""
    with tempfile.TemporaryDirectory() as folder:
        settings = [("room of 40 lines, 10 m", worlds.room_walls(), 10.0)]
        settings += [(f"city of {side:g} m", worlds.city_walls(side), side) for side in _CITIES[: 1 if quick else None]]
        files = []
        # Of no house: what the children get warm with.
        worlds.write_wld(np.array([[0.0, 0.0, 1.0, 0.0]]), 1.0, Path(folder) / "warm.wld")
        for number, (_, walls, side) in enumerate(settings):
            files.append(Path(folder) / f"world{number}.wld")
            worlds.write_wld(walls, side, files[-1])
        answers: list[list[dict[str, float]]] = [[] for _ in settings]
        for _ in range(rounds):
            for (name, *_), file, found in zip(settings, files, answers, strict=True):
                say(f"memory: {name}")
                found.append(_child(file))
    rows = []
    for (name, walls, _), found in zip(settings, answers, strict=True):
        length = float(np.hypot(walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]).sum())
        setting = f"{name}, {length / 1000.0:.2f} km of walls"
        grid = found[0]["grid"] / 1e6
        rows.append(_row(setting, "MB held", [f["resident"] / 1e6 for f in found], f"the cells take {grid:.1f} MB"))
        rows.append(_row(setting, "MB at the peak", [f["peak"] / 1e6 for f in found], "while the file is loaded"))
        rows.append(_row(setting, "s to load", [f["seconds"] for f in found], "the .wld file, read and drawn"))
    return rows + _preparing(rounds, say)


def _row(setting: str, unit: str, values: list[float], note: str) -> Row:
    return Row(section=SECTION, setting=setting, side="amorsim", unit=unit, rounds=tuple(values), note=note)


def _child(file: Path) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.children", "memory", str(file)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    answer: dict[str, float] = json.loads(done.stdout)
    return answer


def _preparing(rounds: int, say: Callable[[str], None]) -> list[Row]:
    say("memory: preparing maps")
    walls, cells = worlds.room_walls(), worlds.office().cells
    lines, bitmap = [], []
    for _ in range(rounds):
        lines.append(_timed(lambda: am.Map.from_segments(walls, extent=(0.0, 0.0, 10.0, 10.0))))
        bitmap.append(_timed(lambda: am.Map.from_array(cells, resolution=worlds.OFFICE_CELL)))
    return [
        _row("preparing the 10 m room, 1 mm", "s", lines, "Map.from_segments of 40 lines"),
        _row("preparing the 1000 x 1000 bitmap", "s", bitmap, "Map.from_array"),
    ]


def _timed(work: Callable[[], object]) -> float:
    started = time.perf_counter()
    work()
    return time.perf_counter() - started
