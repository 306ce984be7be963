"""Worlds from elsewhere, generated ones, and replicas with a world each: how long they take, and how much memory."""

from __future__ import annotations

import functools
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

import amorsim as am
from benchmarks.contest import Clock
from benchmarks.results import Row

__all__ = ["measure", "stage_world"]

SECTION = "maps"
_MODELS = 1000
_OFFICES = 1000
_REPLICAS = 1000
_SIZE = (40.0, 25.0)  # m, of an office


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """The rows: a large picture, a Stage world of many models, offices, and steps of replicas with a world each."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        side = 1_000 if quick else 10_000
        picture, stage = Path(folder) / "plan.png", Path(folder) / "park.world"
        Image.fromarray(plan(side)).save(picture)
        stage.write_text(stage_world(_MODELS // (10 if quick else 1)), encoding="ascii")
        say(f"maps: a picture of {side} x {side} pixels")
        answers = [_child(picture) for _ in range(rounds)]
        what = f"a grey picture of {side} x {side} pixels"
        rows.append(_row(what, "s to load", [answer["seconds"] for answer in answers], "processor time"))
        rows.append(_row(what, "MB at the peak", [answer["peak"] / 1e6 for answer in answers], "while it is loaded"))
        say("maps: a Stage world")
        am.load(stage)  # what is compiled, and what Python imports, is not part of a file
        seconds = [_timed(clock, lambda: am.load(stage)) for _ in range(rounds)]
        rows.append(
            _row(
                f"a Stage world of {_MODELS // (10 if quick else 1)} models",
                "s to load",
                seconds,
                "robots with a ranger, and boxes",
            )
        )
    offices = _OFFICES // (50 if quick else 1)
    say(f"maps: {offices} offices")
    am.worlds.office(0, size=_SIZE)
    seconds = [
        _timed(clock, lambda: [am.worlds.office(seed, size=_SIZE) for seed in range(offices)]) for _ in range(rounds)
    ]
    rows.append(
        _row(f"{offices} offices of {_SIZE[0]:g} m x {_SIZE[1]:g} m", "s to generate", seconds, "cells of 5 cm")
    )
    return rows + _replicas(rounds, _REPLICAS // (20 if quick else 1), clock, say)


def _replicas(rounds: int, count: int, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """A step of as many replicas in one world, and in a world each; robots wander by a laser of 181 beams."""
    rows = []
    for per, name in (("study", "in one forest"), ("replica", "in a forest each")):
        say(f"maps: {count} replicas {name}")
        robot = am.load_robot("pioneer2dx", controller=am.controllers.Wander(), on_collision="continue")
        world = am.worlds.forest(1, per=per, size=(15.0, 12.0))
        simulation = am.Simulation(am.Scenario(map=world, robots=[robot]), replicas=count)
        simulation.run(1.0)
        seconds = [_timed(clock, functools.partial(simulation.run, 1.0)) / 10 for _ in range(rounds)]
        rows.append(_row(f"{count} replicas {name}", "s a step", seconds, "a Pioneer with laser and sonars in each"))
    return rows


def plan(side: int) -> np.ndarray:
    """A grey plan of `side` x `side` pixels: walls, doors, and pieces of many greys."""
    draw = np.random.default_rng(20261122)
    grey = np.full((side, side), 230, dtype=np.uint8)
    for at in range(0, side, 250):
        grey[at : at + 6] = 20
        grey[:, at : at + 6] = 20
    for _ in range(side // 3):
        row, col = draw.integers(0, side - 100, 2)
        grey[row : row + draw.integers(10, 90), col : col + draw.integers(10, 90)] = draw.integers(256)
    return grey


def stage_world(models: int) -> str:
    """A Stage world of as many models: every other one a robot with a ranger, the others boxes."""
    lines = [
        "define rover position( size [0.4 0.3 0.2]",
        '  ranger( sensor( range [0 5] fov 180 samples 91 ) ) ctrl "wander" )',
        "floorplan( size [130 130 1] boundary 1 )",
    ]
    for number in range(models):
        row, col = divmod(number, 40)
        place = f"pose [{-58.0 + 4.0 * row:g} {-58.0 + 2.9 * col:g} 0 {number % 360}]"
        kind = f'rover( name "r{number}"' if number % 2 else f'model( name "m{number}" size [0.6 0.5 1]'
        lines.append(f"{kind} {place} )")
    return "\n".join(lines) + "\n"


def _timed(clock: Clock, work: Callable[[], object]) -> float:
    began = clock()
    work()
    return clock() - began


def _row(setting: str, unit: str, values: list[float], note: str) -> Row:
    return Row(section=SECTION, setting=setting, side="amorsim", unit=unit, rounds=tuple(values), note=note)


def _child(file: Path) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.children", "picture", str(file)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    answer: dict[str, float] = json.loads(done.stdout)
    return answer
