"""The runs that the website plays, of bundled scenarios and of labs' good solutions; `docs/conf.py` makes them."""

from __future__ import annotations

import os
import shutil
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import attrs

import amorsim as am
from amorsim.labs import Lab, find_labs
from amorsim.plugins.manager import make_registry
from amorsim.recorders.arrays import Arrays

__all__ = ["make_runs"]

LONGEST, LONGEST_LAB = 40.0, 90.0  # [s] of simulated time
BELIEFS_EVERY = 0.5  # [s]


def make_runs(folder: Path) -> None:
    """Simulate bundled scenarios and labs and write their pages, ``NAME.html`` and ``lab-06.html``, into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        waiting = [pool.submit(_make_lab, lab, folder) for lab in find_labs()]
        for entry in make_registry(entry_points=[]).entries("scenario"):
            waiting.append(pool.submit(_make_run, entry.name, folder / f"{entry.name}.html", LONGEST))
        for each in waiting:
            each.result()


def _make_lab(lab: Lab, folder: Path) -> None:
    with tempfile.TemporaryDirectory() as temporary:
        for file in lab.handed_out:
            shutil.copy(file, temporary)
        solutions = lab.folder / "solutions"
        shutil.copy(solutions / "good.py", Path(temporary) / lab.handed_in.name)
        for network in solutions.glob("*.onnx"):
            shutil.copy(network, temporary)
        _make_run(str(Path(temporary) / "lab.toml"), folder / f"lab-{lab.number:02d}.html", LONGEST_LAB)


def _make_run(name: str, page: Path, longest: float) -> None:
    scenario = am.load(name)
    beliefs = Arrays(every=BELIEFS_EVERY)
    recording = attrs.evolve(scenario.recording, picture=False, also=[*scenario.recording.also, beliefs])
    with tempfile.TemporaryDirectory() as temporary:
        run = Path(temporary) / "run"
        duration = min(scenario.duration, longest)
        am.run(attrs.evolve(scenario, recording=recording), run, duration=duration, progress=False)
        am.run_page(run, page)


if __name__ == "__main__":
    import sys

    make_runs(Path(sys.argv[1]))
