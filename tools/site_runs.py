"""The runs that the website plays: one page for each bundled scenario; `docs/conf.py` makes them."""

from __future__ import annotations

import os
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import attrs

import amorsim as am
from amorsim.plugins.manager import make_registry
from amorsim.recorders.arrays import Arrays

__all__ = ["make_runs"]

LONGEST = 40.0  # [s] of simulated time
BELIEFS_EVERY = 0.5  # [s]


def make_runs(folder: Path) -> None:
    """Simulate each bundled scenario and write its page, ``NAME.html``, into a folder."""
    names = [entry.name for entry in make_registry(entry_points=[]).entries("scenario")]
    folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for _ in pool.map(_make_run, names, [folder] * len(names)):
            pass


def _make_run(name: str, folder: Path) -> None:
    scenario = am.load(name)
    beliefs = Arrays(every=BELIEFS_EVERY)
    recording = attrs.evolve(scenario.recording, picture=False, also=[*scenario.recording.also, beliefs])
    with tempfile.TemporaryDirectory() as temporary:
        run = Path(temporary) / name
        duration = min(scenario.duration, LONGEST)
        am.run(attrs.evolve(scenario, recording=recording), run, duration=duration, progress=False)
        am.run_page(run, folder / f"{name}.html")


if __name__ == "__main__":
    import sys

    make_runs(Path(sys.argv[1]))
