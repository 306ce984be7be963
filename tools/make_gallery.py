"""Makes the pictures of the gallery: the worlds in ``docs/worlds``, a file of each format, drawn as scenarios are.

They are looked at and not compared, so make them again only where they should look different::

    python tools/make_gallery.py
"""

from __future__ import annotations

from pathlib import Path

from PIL import Image

import amorsim as am
from amorsim.render.picture import draw_run
from amorsim.runs.scenario_argument import read_scenario
from amorsim.runs.traces import Traces

__all__ = ["OPTIONS", "make", "scenario_of"]

DOCS = Path(__file__).resolve().parents[1] / "docs"
SIZE = 720  # pixels of the longer side
COLOURS = 32
# What a file does not say of itself, or what shows more of it.
OPTIONS: dict[str, tuple[str, ...]] = {
    "flat.svg": ("world.scale=100", "world.resolution=0.02"),
    "hall.wld": ("world.resolution=0.02",),
    "plan.png": ("world.size=[10.0, 6.5]",),
    "valley.map": ("world.resolution=0.5",),
    "workshop.dxf": ("world.resolution=0.02",),
    "court.geojson": ("world.resolution=0.1",),
}


def scenario_of(path: Path) -> am.Scenario:
    """The scenario of a file of the gallery, with its options."""
    return read_scenario(str(path), changes=OPTIONS.get(path.name, ()))


def make(folder: Path) -> None:
    """Write the pictures into `folder`."""
    for path in sorted((DOCS / "worlds").iterdir()):
        if path.suffix == ".pgm":  # the picture of a map of ROS
            continue
        scenario = scenario_of(path)
        at_start = Traces(am.Simulation(scenario))
        picture = draw_run(
            scenario.map,
            at_start.paths(),
            zones=[zone.outline for zone in scenario.zones],
            patches=scenario.floor.patches,
            things=at_start.things(),
            size=SIZE,
        ).convert("RGB")
        small = picture.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        small.save(folder / f"format-{path.stem}.png", optimize=True)


if __name__ == "__main__":
    make(DOCS / "pictures")
