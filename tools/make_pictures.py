"""Makes the pictures of the README and the docs: runs the demo and the scenario of ``amorsim new``.

They are looked at and not compared, so make them again only where they should look different::

    python tools/make_pictures.py
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image

import amorsim as am

__all__ = ["PICTURES", "make", "save_small"]

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
WIDTH = 1200  # pixels
COLOURS = 256
SCENARIOS = (
    "car-park",
    "synchro-hall",
    "khepera-maze",
    "convoy",
    "yard",
    "landmarks",
    "find-yourself",
    "kidnapped",
    "loop",
    "find-the-way",
    "parking-lot",
    "unknown-maze",
    "learned",
    "crossing",
    "doors",
    "line",
)
MAPS = {"map-the-office": "rover-slam"}  # of each scenario, which of the maps that it leaves


def make(folder: Path) -> None:
    """Write the pictures into `folder`."""
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        _amorsim(work, "run", "demo", "--out", "demo", "--quiet")
        _amorsim(work, "new", "first")
        _amorsim(work, "run", "first/scenario.toml", "--out", "monday", "--quiet")
        _amorsim(work, "plot", "monday")
        for scenario in SCENARIOS:
            _amorsim(work, "run", scenario, "--out", scenario, "--quiet")
            save_small(work / scenario / "picture.png", folder / f"{scenario}.png")
        _amorsim(work, "run", "swarm", "--duration", "20", "--out", "swarm", "--quiet")
        save_small(work / "swarm" / "picture.png", folder / "swarm.png", width=800, colours=48)
        for scenario, name in MAPS.items():
            _amorsim(work, "run", scenario, "--out", scenario, "--quiet")
            save_small(work / scenario / "estimated-maps" / f"{name}.pgm", folder / f"{scenario}.png")
        film = ("--duration", "15", "--gif", str(folder / "crowd.gif"), "--gif-size", "640", "--force")
        _amorsim(work, "run", "crowd", *film, "--out", "crowd", "--quiet")
        for source, target in (
            ("demo/picture.png", "demo.png"),
            ("monday/picture.png", "first-run.png"),
            ("monday/plots/monday-rover-seed1-error.png", "first-run-error.png"),
        ):
            save_small(work / source, folder / target)
        am.draw(*_of_notebook(), replica=2, title="replica 2 after a minute").save(work / "notebook.png")
        save_small(work / "notebook.png", folder / "notebook.png")


def _of_notebook() -> tuple[am.Simulation, dict[str, Any]]:
    """What is drawn on the page "Work in a notebook"."""
    simulation = am.Simulation(am.load("demo"), replicas=20)
    return simulation, simulation.run(60, keep=("true_pose", "estimated_pose"))


def _amorsim(work: Path, *arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "amorsim", *arguments], cwd=work, check=True)


def save_small(source: Path, target: Path, width: int = WIDTH, colours: int = COLOURS) -> None:
    """Save a picture with few colours, at most `width` pixels wide; twice as large if it is small."""
    with Image.open(source) as opened:
        picture = opened.convert("RGB")
    if 2 * picture.width < width:  # a map, a pixel for each cell
        picture = picture.resize((2 * picture.width, 2 * picture.height), Image.Resampling.NEAREST)
    if picture.width > width:
        height = round(picture.height * width / picture.width)
        picture = picture.resize((width, height), Image.Resampling.LANCZOS)
    picture.quantize(colours, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(target, optimize=True)


if __name__ == "__main__":
    make(PICTURES)
