"""Bitmaps of a Stage world: their dark pixels, and the cells of a map that these fill."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, UnidentifiedImageError

from amorsim.core.errors import MapError
from amorsim.core.files.reading import read_bytes, reason
from amorsim.foreign.stage.geometry import Box, Spot

__all__ = ["dark_pixels", "dark_span", "fill", "is_dark_near"]

Cells = npt.NDArray[np.bool_]

_MOST_BYTES = 100_000_000
_MOST_PIXELS = 100_000_000
_FORMATS = ("PNG", "BMP", "GIF", "JPEG", "TIFF", "PPM")
_BAND = 1_000_000  # [cells] that are filled together


def dark_pixels(path: Path) -> Cells:
    """Which pixels of a picture are darker than mid grey, (rows, columns), row 0 lowest.

    Raises
    ------
    MapError
        If it cannot be read, is not a picture, or is too large.
    """
    try:
        data = read_bytes(path, _MOST_BYTES)
    except (OSError, ValueError) as error:
        raise MapError(f"{path}: cannot be read: {reason(error)}") from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data), formats=_FORMATS) as image:
                width, height = image.size
                if width * height > _MOST_PIXELS:
                    raise MapError(f"{path}: it has {width} x {height} pixels; expected {_MOST_PIXELS:g} at most")
                if image.mode in ("I;16", "I;16B", "I;16L", "I"):
                    grey = np.asarray(image).astype(np.int64) >> 8
                else:
                    if image.mode in ("LA", "PA", "RGBA") or "transparency" in image.info:
                        paper = Image.new("RGBA", image.size, "white")
                        shown = Image.alpha_composite(paper, image.convert("RGBA")).convert("L")
                    else:
                        shown = image.convert("L")
                    grey = np.asarray(shown)
    except UnidentifiedImageError:
        raise MapError(f"{path}: it is not a picture of a known kind ({', '.join(_FORMATS)})") from None
    except MapError:
        raise
    except (Exception, Image.DecompressionBombError) as error:  # pillow raises all kinds of them for broken files
        raise MapError(f"{path}: it is not a whole picture: {error}") from None
    return np.ascontiguousarray(grey[::-1] < 127)


def dark_span(dark: Cells) -> tuple[slice, slice]:
    """The rows and columns of a picture between which all its dark pixels are; all of them if none is dark."""
    spans = []
    for axis in (1, 0):
        found = np.flatnonzero(dark.any(axis=axis))
        spans.append(slice(int(found[0]), int(found[-1]) + 1) if len(found) else slice(None))
    return spans[0], spans[1]


def is_dark_near(dark: Cells, box: Box, bounds: tuple[float, float, float, float], margin: float) -> bool:
    """Whether dark pixels of a picture stretched over a box may touch the bounds (xmin, ymin, xmax, ymax)."""
    xmin, ymin, xmax, ymax = bounds
    corners = [(x, y) for x in (xmin - margin, xmax + margin) for y in (ymin - margin, ymax + margin)]
    places = np.array([_inside(box, dark, x, y) for x, y in corners])
    (left, low), (right, high) = np.floor(places.min(axis=0)), np.floor(places.max(axis=0))
    rows, cols = dark.shape
    if right < 0 or high < 0 or left >= cols or low >= rows:
        return False
    return bool(dark[max(int(low), 0) : int(high) + 1, max(int(left), 0) : int(right) + 1].any())


def _inside(box: Box, dark: Cells, x: float, y: float) -> tuple[float, float]:
    """The column and row of a point of the world in a picture that fills a box, with their fractions."""
    rows, cols = dark.shape
    back = Spot(degrees=-box.spot.degrees)
    u, v = back.point(x - box.spot.x, y - box.spot.y)
    return (u / box.width + 0.5) * cols, (v / box.height + 0.5) * rows


def fill(cells: npt.NDArray[np.uint8], side: float, low: tuple[float, float], dark: Cells, box: Box) -> None:
    """Occupy the cells of a map that the dark pixels of a picture fill, which is stretched over a box.

    A cell is occupied if its centre lies in a dark pixel, or the centre of a dark pixel lies in it: nothing grows, and
    no line of pixels gets lost, however large pixels and cells are.

    Parameters
    ----------
    cells
        (rows, columns) of the map, row 0 lowest, to be filled.
    side, low
        Side of a cell [m], and the lower left corner [m] of the first.
    dark
        Which pixels are dark, row 0 lowest.
    """
    rows, cols = dark.shape
    corners = np.array(box.corners())
    first = np.maximum(np.floor((corners.min(axis=0) - low) / side).astype(int), 0)
    last = np.minimum(np.ceil((corners.max(axis=0) - low) / side).astype(int), cells.shape[::-1])
    origin = np.array(_inside(box, dark, *low))
    along = np.array(_inside(box, dark, low[0] + side, low[1])) - origin
    upward = np.array(_inside(box, dark, low[0], low[1] + side)) - origin
    col = np.arange(first[0], last[0]) + 0.5
    step = max(1, _BAND // max(1, len(col)))
    for begin in range(int(first[1]), int(last[1]), step):
        end = min(begin + step, int(last[1]))
        row = (np.arange(begin, end) + 0.5)[:, None]
        u = np.floor(origin[0] + along[0] * col + upward[0] * row).astype(np.int64)
        v = np.floor(origin[1] + along[1] * col + upward[1] * row).astype(np.int64)
        inside = (u >= 0) & (u < cols) & (v >= 0) & (v < rows)
        window = cells[begin:end, first[0] : last[0]]
        window[inside] |= dark[v[inside], u[inside]]
    zero, one, other = (np.array(box.spot.point(*point)) for point in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
    step = max(1, _BAND // cols)
    for begin in range(0, rows, step):
        at_row, at_col = np.nonzero(dark[begin : begin + step])
        x = ((at_col + 0.5) / cols - 0.5) * box.width
        y = ((at_row + begin + 0.5) / rows - 0.5) * box.height
        world = zero + np.outer(x, one - zero) + np.outer(y, other - zero)
        place = np.floor((world - low) / side).astype(np.int64)
        fits = (place >= 0).all(axis=1) & (place[:, 0] < cells.shape[1]) & (place[:, 1] < cells.shape[0])
        cells[place[fits, 1], place[fits, 0]] = 1
