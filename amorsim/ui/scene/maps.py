"""Maps as they are drawn: as lines, or as pictures of their cells."""

from __future__ import annotations

import io
import math

import numpy as np
from PIL import Image as Pictures

from amorsim.core.maps.map import Map
from amorsim.ui.scene.wire import MapShape

__all__ = ["MapShapes"]

MOST_SEGMENTS = 20_000  # beyond, a picture is drawn faster than lines
MOST_PIXELS = 4_000_000


class MapShapes:
    """The maps of a scene, each once, and the pictures that they name."""

    def __init__(self) -> None:
        self.shapes: list[MapShape] = []
        self._maps: list[Map] = []

    def add(self, found: Map) -> int:
        """The place of a map in `shapes`."""
        for place, known in enumerate(self._maps):
            if known is found:
                return place
        self._maps.append(found)
        width, height = found.size
        corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
        c, s = math.cos(found.origin[2]), math.sin(found.origin[2])
        world = corners @ np.array([[c, s], [-s, c]]) + found.origin[:2]
        low, high = world.min(axis=0).tolist(), world.max(axis=0).tolist()
        shape: MapShape = {
            "name": found.name,
            "origin": list(found.origin),
            "size": [width, height],
            "extent": [*low, *high],
            "segments": None,
            "image": None,
        }
        if found.segments is not None and len(found.segments) <= MOST_SEGMENTS:
            shape["segments"] = found.segments.tolist()
        else:
            shape["image"] = {"name": f"map-{len(self.shapes)}", "extent": [0.0, 0.0, width, height]}
        self.shapes.append(shape)
        return len(self.shapes) - 1

    def picture(self, name: str) -> bytes:
        """The PNG that a map's shape names: occupied cells black, free ones clear.

        Raises
        ------
        LookupError
            If no map names it.
        """
        for found, shape in zip(self._maps, self.shapes, strict=True):
            if shape["image"] is not None and shape["image"]["name"] == name:
                width, height = found.size
                side = max(found.resolution, math.sqrt(width * height / MOST_PIXELS))
                cells = found.to_array(resolution=side)[::-1]
                pixels = np.zeros((*cells.shape, 2), dtype=np.uint8)
                pixels[..., 1] = np.where(cells, 255, 0)
                out = io.BytesIO()
                Pictures.fromarray(pixels, "LA").save(out, "PNG")
                return out.getvalue()
        raise LookupError(f"there is no picture {name!r}")
