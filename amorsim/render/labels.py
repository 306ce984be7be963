"""Names next to places in pictures, clear of one another if possible."""

from __future__ import annotations

from collections.abc import Iterable

from PIL import ImageDraw

from amorsim.render.marks import COLOURS
from amorsim.render.robot_paths import Points
from amorsim.render.words import Font

__all__ = ["write_names"]

_Box = tuple[float, float, float, float]


def write_names(
    pen: ImageDraw.ImageDraw,
    names: Iterable[tuple[str, Points]],
    marked: Points,
    *,
    within: _Box,
    reach: float,
    edge: int,
    font: Font,
) -> None:
    """Write names next to places.

    Parameters
    ----------
    names
        Each name with its places (V, 2) [px].
    marked
        Places (K, 2) [px] of marks that names should not cover, of the size `reach` [px].
    within
        The plot [px], in which the names should be.
    edge
        How wide [px] a white edge about the letters is.
    """
    left, top, right, bottom = within
    taken: list[_Box] = [
        (x - 0.8 * reach, y - 0.8 * reach, x + 0.8 * reach, y + 0.8 * reach) for x, y in marked.tolist()
    ]
    for name, ends in names:
        for x, y in ends.clip((left, top), (right, bottom)).tolist():
            places = [
                ((x + reach, y - reach), "ls"),
                ((x - reach, y - reach), "rs"),
                ((x + reach, y + reach), "lt"),
                ((x - reach, y + reach), "rt"),
            ]
            boxes = [pen.textbbox(place, name, font, anchor=anchor) for place, anchor in places]
            inside = [box[0] >= left and box[1] >= top and box[2] <= right and box[3] <= bottom for box in boxes]
            clear = [not any(_overlap(box, other) for other in taken) for box in boxes]
            # The first that is inside and clear; failing that, inside; failing that, any.
            best = max(range(4), key=lambda i: (inside[i] + clear[i], inside[i]))
            place, anchor = places[best]
            taken.append(boxes[best])
            pen.text(place, name, COLOURS["text"], font, anchor=anchor, stroke_width=edge, stroke_fill="white")


def _overlap(a: _Box, b: _Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
