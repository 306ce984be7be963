"""Footprints: the shape with which a robot or an obstacle touches others and is seen by them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence

import attrs
import numpy as np
import shapely
from numpy.typing import ArrayLike

from amorsim.array_types import Array, Ints
from amorsim.core.arguments import checked
from amorsim.core.errors import ShapeError
from amorsim.kernels.collision.footprints import Bodies

__all__ = ["Shape", "pack"]

Point = tuple[float, float]
Ring = tuple[Point, ...]

# Vertices nearer than this, relative to the polygon's size, to the line through their neighbours are no
# corners.
_FLAT = 1e-12
_CIRCLE_POINTS = 64
SMALLEST = 1e-6
"""The least distance [m] from its body's origin at which a shape may end."""
LARGEST = 1e6
"""The largest distance [m] from its body's origin that a shape may reach."""


@checked
@attrs.frozen(cache_hash=True)
class Shape:
    """A footprint in the frame of its body: convex parts, each rounded by one radius.

    Make one with `Shape.circle`, `Shape.rectangle` or `Shape.polygon`. Shapes compare, hash and pickle by
    value.

    Parameters
    ----------
    vertices
        The vertices [m] of each convex part, anticlockwise. A part of one vertex is a disc, one of two a
        capsule.
    radius
        The outward rounding of each part [m].
    border
        The vertices [m] of the outline as drawn, anticlockwise.
    """

    vertices: tuple[Ring, ...]
    radius: float
    border: Ring

    def __attrs_post_init__(self) -> None:
        if not self.vertices or not all(self.vertices):
            raise ShapeError("a shape has one convex part at least, and a part one vertex")
        if not math.isfinite(self.radius) or self.radius < 0.0:
            raise ShapeError(f"the radius of a shape is 0 m or more, not {self.radius!r}")
        for part in self.vertices:
            if len(part) < 3 and self.radius == 0.0:
                raise ShapeError(f"a part of {len(part)} vertices needs a radius above 0 m to have an area")
            if len(part) > 2 and (_area(part) <= 0.0 or _reflex_corner(part) is not None):
                raise ShapeError(f"a part is convex and anticlockwise, which {part} is not")
        if not SMALLEST <= self.reach <= LARGEST:
            raise ShapeError(
                f"expected a shape that reaches {SMALLEST:g} m to {LARGEST:g} m from its body's origin, "
                f"got {self.reach:.6g} m"
            )

    @classmethod
    @checked
    def circle(cls, radius: float, *, x: float = 0.0, y: float = 0.0) -> Shape:
        """A disc of `radius` [m] around (x, y) [m] in the body's frame.

        Raises
        ------
        ShapeError
            If the radius is not above 0, or a number is not finite.
        """
        radius, x, y = float(radius), float(x), float(y)
        if not math.isfinite(radius) or radius <= 0.0:
            raise ShapeError(f"expected a circle with a radius above 0 m, got {radius!r}")
        _check_finite(((x, y),), "the centre of a circle")
        angles = [2.0 * math.pi * i / _CIRCLE_POINTS for i in range(_CIRCLE_POINTS)]
        border = tuple((x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in angles)
        return cls(vertices=(((x, y),),), radius=radius, border=border)

    @classmethod
    @checked
    def rectangle(cls, length: float, width: float, *, x: float = 0.0, y: float = 0.0) -> Shape:
        """A rectangle, `length` [m] along x and `width` [m] along y, around (x, y) [m] in the body's frame.

        Raises
        ------
        ShapeError
            If a side is not above 0, or a number is not finite.
        """
        for name, side in (("length", length), ("width", width)):
            if not math.isfinite(side) or side <= 0.0:
                raise ShapeError(f"expected a rectangle with a {name} above 0 m, got {side!r}")
        _check_finite(((float(x), float(y)),), "the centre of a rectangle")
        left, right = x - length / 2.0, x + length / 2.0
        low, high = y - width / 2.0, y + width / 2.0
        return cls.polygon([(left, low), (right, low), (right, high), (left, high)])

    @classmethod
    def polygon(cls, vertices: ArrayLike | Iterable[Sequence[float]], *, rounding: float = 0.0) -> Shape:
        """A simple polygon, convex or not, of `vertices` [m] (V, 2) in either order, grown by `rounding` [m].

        A last vertex that repeats the first is dropped, as are vertices that lie straight between their
        neighbours.

        Raises
        ------
        ShapeError
            If there are fewer than three vertices, a number is not finite, the polygon has no area or its
            border meets itself, or the rounding is negative.
        """
        ring = _ring(vertices)
        if not math.isfinite(rounding) or rounding < 0.0:
            raise ShapeError(f"the rounding of a polygon is 0 m or more, not {rounding!r}")
        if 0.0 < rounding < SMALLEST:
            raise ShapeError(f"the rounding of a polygon is 0 m, or {SMALLEST:g} m at least, not {rounding!r}")
        parts = tuple(_convex_parts(ring))
        border = ring
        if rounding > 0.0:
            grown = shapely.Polygon(ring).buffer(rounding, quad_segs=_CIRCLE_POINTS // 4).exterior.normalize()
            points = [(float(x), float(y)) for x, y in grown.coords[:-1]]
            border = tuple(points if _area(points) > 0.0 else reversed(points))
        return cls(vertices=parts, radius=float(rounding), border=border)

    @property
    def parts(self) -> tuple[Array, ...]:
        """Vertices [m] of each convex part, (V, 2), anticlockwise, before they are rounded by `radius`."""
        return tuple(np.array(part, dtype=np.float64) for part in self.vertices)

    @property
    def outline(self) -> Array:
        """Vertices [m] of the border for drawing, (V, 2), anticlockwise; arcs are cut into chords."""
        return np.array(self.border, dtype=np.float64)

    @property
    def area(self) -> float:
        """Area [m^2] within the border, its arcs cut into chords: the true one or a little less."""
        return abs(_area(self.border))

    @property
    def reach(self) -> float:
        """Distance [m] from the body's origin to the farthest point of the shape."""
        return max(math.hypot(x, y) for part in self.vertices for x, y in part) + self.radius


def pack(shapes: Iterable[Shape]) -> Bodies:
    """The footprints of bodies 0, 1, … as arrays for kernels."""
    shapes = list(shapes)
    known = {shape: shape.parts for shape in set(shapes)}
    parts = [known[shape] for shape in shapes]
    flat = list(itertools.chain.from_iterable(parts))
    reach = {shape: shape.reach for shape in known}
    return Bodies(
        vertices=np.concatenate(flat) if flat else np.empty((0, 2)),
        vertex_first=_starts([len(part) for part in flat]),
        part_first=_starts([len(of_body) for of_body in parts]),
        radius=np.array([shape.radius for shape in shapes], dtype=np.float64),
        reach=np.array([reach[shape] for shape in shapes], dtype=np.float64),
    )


def _starts(counts: list[int]) -> Ints:
    starts = np.zeros(len(counts) + 1, dtype=np.int64)
    np.cumsum(counts, out=starts[1:])
    return starts


def _check_finite(points: Sequence[Point], what: str) -> None:
    for point in points:
        if not all(map(math.isfinite, point)):
            raise ShapeError(f"{what} is given in finite numbers [m], not {point}")
        if max(map(abs, point)) > LARGEST:
            raise ShapeError(f"{what} is at most {LARGEST:g} m from its body's origin, not at {point}")


def _area(ring: Sequence[Point]) -> float:
    """Area [m²], negative if clockwise."""
    x0, y0 = ring[0]
    return 0.5 * sum((ax - x0) * (by - y0) - (bx - x0) * (ay - y0) for (ax, ay), (bx, by) in itertools.pairwise(ring))


def _size(ring: Sequence[Point]) -> float:
    xs = [x for x, _ in ring]
    ys = [y for _, y in ring]
    return max(max(xs) - min(xs), max(ys) - min(ys))


def _bend(before: Point, corner: Point, after: Point) -> float:
    """How far [m] a corner lies outside the chord of its neighbours; negative at a reflex corner."""
    dx, dy = after[0] - before[0], after[1] - before[1]
    chord = math.hypot(dx, dy)
    if chord == 0.0:
        return -math.hypot(corner[0] - before[0], corner[1] - before[1])
    return (dy * (corner[0] - before[0]) - dx * (corner[1] - before[1])) / chord


def _ring(vertices: ArrayLike | Iterable[Sequence[float]]) -> Ring:
    """The corners of a simple polygon, anticlockwise."""
    try:
        array = np.asarray(
            vertices if isinstance(vertices, np.ndarray) else list(vertices),  # type: ignore[arg-type]
            dtype=np.float64,
        )
    except (TypeError, ValueError, OverflowError):
        raise ShapeError("the vertices of a polygon are pairs of numbers [m], as in [[0, 0], [1, 0], [0, 1]]") from None
    if array.ndim != 2 or array.shape[1] != 2:
        raise ShapeError(f"the vertices of a polygon are pairs [m], (V, 2), not an array of shape {array.shape}")
    ring: list[Point] = [(float(x), float(y)) for x, y in array]
    _check_finite(ring, "a vertex of a polygon")
    if len(ring) > 1 and ring[0] == ring[-1]:
        ring.pop()
    if len(ring) < 3:
        raise ShapeError(f"expected a polygon of three vertices at least, got {len(ring)}")
    size = _size(ring)
    if abs(_area(ring)) <= _FLAT * size * size:
        # Equal lobes of a figure of eight cancel, so the message names which of the two is wrong.
        if shapely.MultiPoint(ring).convex_hull.area <= _FLAT * size * size:
            raise ShapeError(f"expected a polygon with an area, got vertices on one line: {ring}")
        raise ShapeError(f"expected a polygon whose border does not meet itself, got {ring}")
    outline = shapely.Polygon(ring)
    if not outline.is_valid:
        reason = shapely.is_valid_reason(outline)
        raise ShapeError(f"expected a polygon whose border does not meet itself, got one with a {reason}")
    if _area(ring) < 0.0:
        ring.reverse()
    i = 0
    while i < len(ring) and len(ring) > 3:
        if abs(_bend(ring[i - 1], ring[i], ring[(i + 1) % len(ring)])) <= _FLAT * size:
            del ring[i]
            i = max(i - 1, 0)
        else:
            i += 1
    return tuple(ring)


def _reflex_corner(ring: Sequence[Point]) -> int | None:
    """Index of a corner where the border turns right, if there is one."""
    flat = -_FLAT * _size(ring)
    for i, corner in enumerate(ring):
        if _bend(ring[i - 1], corner, ring[(i + 1) % len(ring)]) < flat:
            return i
    return None


def _convex_parts(ring: Ring) -> Iterable[Ring]:
    """Cut a simple polygon along diagonals from its reflex corners until no part has one."""
    waiting = [ring]
    while waiting:
        part = waiting.pop()
        corner = _reflex_corner(part)
        if corner is None:
            yield part
            continue
        turned = part[corner:] + part[:corner]
        end = _best_diagonal(turned)
        waiting.append(turned[: end + 1])
        waiting.append((turned[0], *turned[end:]))


def _best_diagonal(ring: Ring) -> int:
    """Where a diagonal from corner 0, a reflex one, best ends: few reflex corners left, then short."""
    outline = shapely.Polygon(ring)
    shapely.prepare(outline)
    choices = []
    for end in range(2, len(ring) - 1):
        # Wholly inside, touching the border at its two ends only.
        if shapely.relate_pattern(shapely.LineString((ring[0], ring[end])), outline, "TFF******"):
            halves = (ring[: end + 1], (ring[0], *ring[end:]))
            # Both halves have new corners at the ends of the diagonal.
            reflex = sum(_bend(half[-1], half[0], half[1]) < 0.0 for half in halves)
            reflex += _bend(ring[end - 1], ring[end], ring[0]) < 0.0
            reflex += _bend(ring[0], ring[end], ring[end + 1]) < 0.0
            choices.append((reflex, math.dist(ring[0], ring[end]), end))
    if not choices:
        raise ShapeError(f"a polygon whose border nearly meets itself cannot be cut into convex parts: {ring}")
    return min(choices)[2]
