"""Makes the pictures of the page on generated worlds: one of each kind, drawn as maps are.

They are looked at and not compared, so make them again only where they should look different::

    python tools/make_world_pictures.py
"""

from __future__ import annotations

from pathlib import Path

from PIL import Image

import amorsim as am
from amorsim.plugins.manager import make_registry
from amorsim.render.picture import draw_map
from amorsim.worlds.made import MadeWorld, make_world

__all__ = ["make"]

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
SIZE = 800  # pixels of the longer side
COLOURS = 32
# What shows the kind better than its defaults do.
OPTIONS: dict[str, dict[str, object]] = {
    "office": {"seed": 7, "size": (40.0, 25.0)},
    "maze": {"seed": 3, "loops": 0.05},
    "cave": {"seed": 3},
    "barn": {"seed": 2},
}


def make(folder: Path) -> None:
    """Write the pictures into `folder`."""
    registry = make_registry(entry_points=[])
    for name in registry.names("world_generator"):
        options = {"seed": 1, **OPTIONS.get(name, {})}
        seed = options.pop("seed")
        assert isinstance(seed, int)
        world: am.Map = make_world(MadeWorld(generator=registry.get("world_generator", name)(**options), seed=seed))
        picture = draw_map(world, size=SIZE).convert("RGB")
        small = picture.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        small.save(folder / f"world-{name}.png", optimize=True)


if __name__ == "__main__":
    make(PICTURES)
