"""SVG drawings as maps: every outline is a wall, curves as chords; parsed by svgelements."""

from __future__ import annotations

import io
import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError
from amorsim.core.maps.cell_lines import extent_of, wall_lines
from amorsim.core.maps.map import Map
from amorsim.core.parameters import LARGEST, SMALLEST, parameter
from amorsim.maps.drawn_lines import Drawing, chord_error
from amorsim.maps.svg_xml import Viewport, length, local, parse_svg, prepare

__all__ = ["Svg"]

_UNIT = 0.01  # [m]
_NO_UNIT = (
    f"no unit is given, and its width is in none, so a unit of its is taken for {_UNIT:g} m; say how long one is, as "
    "in unit = 0.001"
)
_METRES = {"mm": 0.001, "cm": 0.01, "in": 0.0254, "pt": 0.0254 / 72, "pc": 0.0254 / 6, "q": 0.00025, "m": 1.0}
_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"


@attrs.frozen(kw_only=True)
class Svg(MapLoader):
    """SVG drawings (``.svg``): outlines of all shapes are walls, whatever their colours; nothing is filled.

    A unit of the drawing has the length `unit`, or else the one that the file's width in mm, cm or in gives it, times
    `scale`. Hidden shapes, texts, images and patterns are left out.
    """

    extensions: ClassVar[tuple[str, ...]] = (".svg",)

    resolution: float = parameter(0.01, unit="m", gt=0, help="side of a cell")
    unit: float | None = parameter(
        None, unit="m", gt=0, help="length of a unit of the drawing; without it by the file's width, else 0.01"
    )
    scale: float = parameter(1.0, gt=0, help="metres in the world to a metre on paper: 100 for a plan of 1:100")
    layers: tuple[str, ...] = parameter(
        (), help="groups that are read, by id or by Inkscape's label; all if none is named"
    )
    chord_error: float = chord_error()
    origin_x: float | None = parameter(
        None, unit="m", help="x of the drawing's point (0, 0); without it such that its left edge is at 0"
    )
    origin_y: float | None = parameter(
        None, unit="m", help="y of the drawing's point (0, 0); without it such that its lower edge is at 0"
    )

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether an element ``svg`` begins in a file's first bytes."""
        return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<") and b"<svg" in head

    def load(self, path: Path) -> Map:
        """The map of a drawing.

        Raises
        ------
        MapError
            If the file cannot be read, is not SVG, has no line or too many, or svgelements is not installed.
        """
        try:
            return self._load(path)
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    def _load(self, path: Path) -> Map:
        drawing = Drawing(self.chord_error)
        root, lines_of = parse_svg(path)
        box = _view_box(root)
        remarks: list[str] = []
        unit = self._unit_of(root, box, remarks)
        if not SMALLEST <= unit <= LARGEST:
            raise MapError(f"a unit of its viewBox would be {unit:g} m long; expected a width and a viewBox that fit")
        found = set() if not self.layers else _keep_layers(root, set(self.layers))
        if missing := set(self.layers) - found:
            raise MapError(f"it has no group of the id or label {', '.join(map(repr, sorted(missing)))}")
        prepare(root, lines_of, _viewport(root, box), drawing)
        for key in ("width", "height", "viewBox", "preserveAspectRatio", "x", "y"):
            root.attrib.pop(key, None)
        lines = Drawing(self.chord_error / unit)
        for shape in _shapes(ET.tostring(root), drawing):
            for part in shape:
                _add(part, lines)
        segments = lines.segments
        if len(segments) == 0:
            raise MapError("it has no line" + "".join(f" ({each})" for each in drawing.remarks))
        if box is None:
            corners = segments.reshape(-1, 2)
            (left, top), (right, bottom) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        else:
            left, top, right, bottom = box
        x = -left * unit if self.origin_x is None else self.origin_x
        y = bottom * unit if self.origin_y is None else self.origin_y
        with np.errstate(over="ignore", invalid="ignore"):  # refused by the map
            walls = segments * (unit, -unit, unit, -unit) + (x, y, x, y)
        return Map.from_segments(
            walls,
            resolution=self.resolution,
            extent=(left * unit + x, y - bottom * unit, right * unit + x, y - top * unit),
            warnings=(*remarks, *drawing.remarks),
            name=path.stem,
        )

    @classmethod
    def save(cls, world: Map, path: Path) -> Svg:
        """Write a map's walls as lines, a unit for a metre, cells from middle to middle; see `amorsim.save_map`."""
        left, bottom, right, top = extent_of(world)
        width, height = world.size if world.origin[2] == 0.0 else (right - left, top - bottom)
        data = "".join(f"M{x0!r} {-y0!r}L{x1!r} {-y1!r}" for x0, y0, x1, y1 in wall_lines(world).tolist())
        path.write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{1000 * width:.12g}mm" height="{1000 * height:.12g}mm" '
            f'viewBox="{left!r} {-top!r} {width!r} {height!r}">\n'
            f'<path fill="none" stroke="black" stroke-width="{world.resolution!r}" stroke-linecap="square" '
            f'd="{data}"/>\n'
            "</svg>\n",
            encoding="ascii",
            newline="\n",
        )
        return cls(resolution=world.resolution, unit=1.0, origin_x=0.0, origin_y=0.0)

    def _unit_of(self, root: ET.Element, box: tuple[float, ...] | None, remarks: list[str]) -> float:
        """The length [m] of a unit of the drawing."""
        if self.unit is not None:
            return self.unit * self.scale
        width = length(root.get("width"))
        if width is not None and width[1].lower() in _METRES and width[0] > 0.0:
            metres = width[0] * _METRES[width[1].lower()]
            # Without a box, a unit is a pixel of CSS.
            on_paper = 0.0254 / 96.0 if root.get("viewBox") is None or box is None else metres / (box[2] - box[0])
            return float(f"{on_paper:.9g}") * self.scale
        remarks.append(_NO_UNIT)
        return _UNIT * self.scale


def _view_box(root: ET.Element) -> tuple[float, float, float, float] | None:
    """left, top, right, bottom of the drawing in its units, or None."""
    words = (root.get("viewBox") or "").replace(",", " ").split()
    numbers = [length(word) for word in words]
    values = [number[0] for number in numbers if number is not None and math.isfinite(number[0])]
    if len(words) != 4:
        sides = [length(root.get(key)) for key in ("width", "height")]
        values = [0.0, 0.0, *(side[0] for side in sides if side is not None and side[1].lower() in ("", "px"))]
    if len(values) != 4 or values[2] <= 0.0 or values[3] <= 0.0:
        return None
    left, top, width, height = values
    return left, top, left + width, top + height


def _viewport(root: ET.Element, box: tuple[float, float, float, float] | None) -> Viewport | None:
    """The size to which percentages refer: the box, or else the size on paper in CSS's pixels."""
    if box is not None:
        return Viewport(box[2] - box[0], box[3] - box[1])
    sides = [length(root.get(key)) for key in ("width", "height")]
    pixels = [
        side[0] * _METRES[side[1].lower()] * 96.0 / 0.0254 for side in sides if side and side[1].lower() in _METRES
    ]
    return Viewport(*pixels) if len(pixels) == 2 else None


def _keep_layers(root: ET.Element, names: set[str]) -> set[str]:
    """Remove all but groups of these names, their ancestors, and definitions; returns the names that were found."""
    found: set[str] = set()

    def keep(element: ET.Element) -> bool:
        own = {element.get("id"), element.get(_LABEL)} & names
        if own:
            found.update(filter(None, own))
            return True
        if local(element) in ("defs", "symbol", "style"):
            return True
        kept = [child for child in element if keep(child)]
        for child in list(element):
            if not any(child is each for each in kept):
                element.remove(child)
        return any(local(child) != "defs" for child in kept)

    keep(root)
    return found


def _shapes(data: bytes, drawing: Drawing) -> Iterator[Any]:
    """The paths of a drawing's shapes, in its units."""
    try:
        import svgelements
    except ImportError as error:
        raise MapError("SVG drawings are read by svgelements: pip install 'amorsim[drawings]'") from error
    try:
        for element in svgelements.SVG.parse(io.BytesIO(data), reify=True).elements():
            if isinstance(element, svgelements.Shape):
                path = svgelements.Path(element)
                path.reify()
                yield path
            elif isinstance(element, svgelements.Text | svgelements.Image):
                drawing.leave_out("texts or images")
    except MapError:
        raise
    except Exception as error:  # a damaged file makes it raise nearly anything
        raise MapError(f"svgelements cannot read it: {type(error).__name__}: {str(error)[:200]}") from error


def _add(part: Any, lines: Drawing) -> None:
    """Add a segment of a path."""
    import svgelements

    if isinstance(part, svgelements.Move) or part.start is None or part.end is None:
        return
    if isinstance(part, svgelements.QuadraticBezier):
        lines.add_bezier([tuple(part.start), tuple(part.control), tuple(part.end)])
    elif isinstance(part, svgelements.CubicBezier):
        lines.add_bezier([tuple(part.start), tuple(part.control1), tuple(part.control2), tuple(part.end)])
    elif isinstance(part, svgelements.Arc):
        middle = np.array(tuple(part.center))
        axes = [np.array(tuple(axis)) - middle for axis in (part.prx, part.pry)]
        lines.add_arc(middle, axes, float(part.get_start_t()), float(part.sweep))
    else:
        lines.add_lines([tuple(part.start), tuple(part.end)])
