"""Places, outlines and colours of the models of a Stage world."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import shapely
import shapely.affinity
from PIL import ImageColor

from amorsim.foreign.stage.entities import Model
from amorsim.foreign.stage.notes import Notes

__all__ = [
    *("Box", "Spot", "colour_of", "moved", "neat", "outline_of", "polygons", "pose_of", "rectangle", "segments_of"),
    *("size_of", "spot_of", "vertices"),
]

# What Stage gives a model without one.
_SIZE = (0.4, 0.4, 1.0)
_MOST_POINTS = 10_000
_THIN = 1e-4  # [m] narrower bodies are left out
_GREY = re.compile(r"gr[ae]y([0-9]{1,3})", re.IGNORECASE)


class Spot(NamedTuple):
    """A place and a direction: x, y [m], and the heading in degrees, so that right angles are exact."""

    x: float = 0.0
    y: float = 0.0
    degrees: float = 0.0

    def then(self, inner: Spot) -> Spot:
        """A spot in the frame of this one, in the frame that this one is in."""
        x, y = self.point(inner.x, inner.y)
        return Spot(x, y, self.degrees + inner.degrees)

    def point(self, x: float, y: float) -> tuple[float, float]:
        """A point of this frame, in the frame that this one is in."""
        cosine, sine = _direction(self.degrees)
        return self.x + x * cosine - y * sine, self.y + x * sine + y * cosine

    def table(self) -> dict[str, float]:
        """As a pose in a scenario."""
        return {"x": neat(self.x), "y": neat(self.y), "heading_deg": neat(_wrapped(self.degrees))}


class Box(NamedTuple):
    """A rectangle at a spot, its middle there."""

    spot: Spot
    width: float
    height: float

    def corners(self) -> list[tuple[float, float]]:
        """Anticlockwise from the lower left."""
        x, y = self.width / 2, self.height / 2
        return [self.spot.point(*corner) for corner in ((-x, -y), (x, -y), (x, y), (-x, y))]


def neat(number: float) -> float:
    """A number without the rounding errors of its last digits."""
    return round(number, 9) + 0.0


def _wrapped(degrees: float) -> float:
    turn = degrees % 360.0
    return turn - 360.0 if turn > 180.0 else turn


def _direction(degrees: float) -> tuple[float, float]:
    """Cosine and sine, exact at right angles."""
    turn = degrees % 360.0
    if turn % 90.0 == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(turn // 90.0) % 4]
    return math.cos(math.radians(turn)), math.sin(math.radians(turn))


def spot_of(model: Model, key: str, notes: Notes) -> Spot:
    """The spot at a key, as ``[x y z heading]``, or as in Stage 2, ``[x y heading]``."""
    numbers = notes.numbers(model.values, key, 2)
    if len(numbers) == 3 and numbers[2]:
        notes.remark(
            "three numbers",
            f"{key} has three numbers: they are taken for x, y and heading, as in Stage 2, not for x, y and z",
            model.values[key].place,
        )
        return Spot(*numbers)
    degrees = numbers[3] if len(numbers) > 3 else 0.0
    return Spot(numbers[0], numbers[1], degrees) if numbers else Spot()


def pose_of(model: Model, notes: Notes) -> Spot:
    """Where a model is in the one that holds it."""
    return spot_of(model, "pose", notes)


def size_of(model: Model, notes: Notes) -> tuple[float, float, float]:
    """Length, width and height [m] of a model."""
    numbers = notes.numbers(model.values, "size", 2)
    if not numbers:
        return _SIZE
    if min(numbers[:2]) < 0:
        notes.fault(model.values["size"].place, f"size: expected numbers of at least 0, got {min(numbers[:2]):g}")
        return _SIZE
    return numbers[0], numbers[1], numbers[2] if len(numbers) > 2 and numbers[2] > 0 else _SIZE[2]


def outline_of(model: Model, notes: Notes) -> Any:
    """The area that a model covers, in its own frame: its blocks scaled to its size, or a rectangle of that size.

    None where it covers none: a model that is a line.
    """
    length, width, _ = size_of(model, notes)
    blocks = [area for each in model.inner if each.kind == "block" and (area := _block(each, notes)) is not None]
    if not blocks:
        area = _disc(length, width) if notes.text(model.values, "shape") == "circle" else rectangle(length, width)
    else:
        xmin, ymin, xmax, ymax = shapely.total_bounds(blocks).tolist()
        if min(xmax - xmin, ymax - ymin) < _THIN:
            return None
        area = shapely.unary_union(blocks)
        area = shapely.affinity.translate(area, -(xmin + xmax) / 2, -(ymin + ymax) / 2)
        area = shapely.affinity.scale(area, length / (xmax - xmin), width / (ymax - ymin), origin=(0, 0))
    if min(length, width) < _THIN:
        return None
    return moved(area, spot_of(model, "origin", notes))


def _block(block: Model, notes: Notes) -> Any:
    count = notes.count(block.values, "points", 0, _MOST_POINTS)
    notes.check_keys(block, frozenset({"points", "point", "z"}))
    points = []
    for number in range(count):
        point = notes.numbers(block.values, f"point[{number}]", 2)
        if not point:
            if f"point[{number}]" not in block.values:
                notes.fault(block.place, f"the block has {count} points, and no point[{number}]")
            return None
        points.append((point[0], point[1]))
    if len(points) < 3:
        notes.fault(block.place, f"expected a block of three points at least, got {len(points)}")
        return None
    area = shapely.make_valid(shapely.Polygon(points))
    return area if area.area > 0 else None


def rectangle(length: float, width: float) -> Any:
    """A rectangle about the origin, its length along x."""
    return shapely.box(-length / 2, -width / 2, length / 2, width / 2)


def _disc(length: float, width: float) -> Any:
    return shapely.affinity.scale(shapely.Point(0, 0).buffer(0.5, quad_segs=8), length, width)


def moved(area: Any, spot: Spot) -> Any:
    """An area of the frame of a spot, in the frame that the spot is in."""
    cosine, sine = _direction(spot.degrees)
    return shapely.affinity.affine_transform(area, [cosine, -sine, sine, cosine, spot.x, spot.y])


def polygons(area: Any) -> list[Any]:
    """The polygons of an area, without slivers."""
    parts = getattr(area, "geoms", [area])
    return [part for part in parts if part.geom_type == "Polygon" and part.area > _THIN**2]


def vertices(polygon: Any) -> list[list[float]]:
    """The border of a polygon as a list of points, anticlockwise, without points that lie on a straight line."""
    border = shapely.geometry.polygon.orient(polygon.simplify(1e-6)).exterior
    return [[neat(x), neat(y)] for x, y in list(border.coords)[:-1]]


def segments_of(rings: Iterable[Sequence[tuple[float, float]]]) -> list[tuple[float, float, float, float]]:
    """The sides of closed rings of points."""
    return [(*one, *other) for ring in rings for one, other in zip(ring, [*ring[1:], ring[0]], strict=True)]


def colour_of(model: Model, notes: Notes) -> str | None:
    """The colour of a model as scenarios spell it, or None."""
    rgba = notes.numbers(model.values, "color_rgba", 3)
    if rgba:
        return "#" + "".join(f"{round(255 * min(max(part, 0.0), 1.0)):02x}" for part in rgba[:3])
    name = notes.text(model.values, "color")
    if not name or name == "random":
        return None
    if grey := _GREY.fullmatch(name):  # of X11
        return "#" + 3 * f"{round(2.55 * min(int(grey[1]), 100)):02x}"
    try:
        red, green, blue = ImageColor.getrgb(name)[:3]
    except ValueError:
        notes.remark(f"colour {name}", f"there is no colour {name!r} in CSS; left out", model.values["color"].place)
        return None
    return f"#{red:02x}{green:02x}{blue:02x}"
