"""DXF drawings (R12 and later) as maps: lines, polylines, arcs and circles are walls; parsed by ezdxf."""

from __future__ import annotations

import io
import logging
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError, did_you_mean
from amorsim.core.files.reading import read_bytes, reason
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.maps.drawn_lines import Drawing, chord_error

__all__ = ["Dxf"]

_MOST_BYTES = 50_000_000
_MOST_ENTITIES = 500_000
_MOST_INSERTED = 200_000  # by one insert: ezdxf takes some 40 us for each
_DEEPEST = 20
_UNIT = 0.001  # [m]
_BINARY = b"AutoCAD Binary DXF"
_CUT_OFF = "the file does not end with EOF: was it cut off?"  # of what is cut off, ezdxf reads whole sections alone
_NO_UNIT = (
    f"the drawing says no unit ($INSUNITS), so one of its is taken for {_UNIT:g} m; say how long one is, as in "
    "unit = 0.0254"
)
# [m] of the values of $INSUNITS that buildings are drawn in.
_METRES = {1: 0.0254, 2: 0.3048, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 10: 0.9144, 14: 0.1, 21: 1200 / 3937}


@attrs.frozen(kw_only=True)
class Dxf(MapLoader):
    """DXF drawings (``.dxf``): lines, polylines, arcs, circles, ellipses, splines and inserted blocks are walls.

    They are seen from above; heights are ignored. A unit of the drawing has the length `unit`, or else the one that its
    header sets, or else 1 mm. Layers that are off or frozen, texts, hatches, dimensions and the like are left out.
    """

    extensions: ClassVar[tuple[str, ...]] = (".dxf",)

    resolution: float = parameter(0.01, unit="m", gt=0, help="side of a cell")
    unit: float | None = parameter(
        None, unit="m", gt=0, help="length of a unit of the drawing; without it as its header says, else 0.001"
    )
    layers: tuple[str, ...] = parameter((), help="layers that are read; all that are not off if none is named")
    chord_error: float = chord_error()

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file begins with a section, as a text or in binary."""
        words = head[:400].split()
        return head.startswith(_BINARY) or words[:2] == [b"0", b"SECTION"]

    def load(self, path: Path) -> Map:
        """The map of a drawing.

        Raises
        ------
        MapError
            If the file cannot be read, is not DXF, has no line or too many, lacks a layer that is named, or ezdxf is
            not installed.
        """
        try:
            return self._load(path)
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    def _load(self, path: Path) -> Map:
        document, is_whole = _parse(path)
        drawing = Drawing(self.chord_error)
        remarks: list[str] = []
        unit = self.unit
        if unit is None:
            unit = _METRES.get(int(document.header.get("$INSUNITS", 0) or 0))
        if unit is None:
            unit = _UNIT
            remarks.append(_NO_UNIT)
        layers = {layer.dxf.name.casefold(): layer for layer in document.layers}
        drawn = _Walls(
            Drawing(self.chord_error / unit),
            drawing,
            wanted={name.casefold() for name in self.layers},
            off={name for name, layer in layers.items() if layer.is_off() or layer.is_frozen()},
        )
        try:
            drawn.add(document.modelspace(), 0)
        except MapError:
            raise
        except Exception as error:  # a damaged file makes it raise nearly anything
            raise MapError(f"ezdxf cannot read it: {type(error).__name__}: {str(error)[:200]}") from error
        for name in self.layers:
            if name.casefold() not in drawn.seen:
                raise MapError(f"nothing is drawn on a layer {name!r}.{did_you_mean(name, sorted(drawn.seen))}")
        segments = drawn.lines.segments
        if len(segments) == 0:
            notes = drawing.remarks if is_whole else (*drawing.remarks, _CUT_OFF)
            raise MapError("it has no line" + "".join(f" ({each})" for each in notes))
        with np.errstate(over="ignore", invalid="ignore"):  # refused by the map
            walls = segments * unit
        return Map.from_segments(
            walls, resolution=self.resolution, warnings=(*remarks, *drawing.remarks), name=path.stem
        )


class _Walls:
    """The lines of entities on some layers; other entities are left out and counted."""

    def __init__(self, lines: Drawing, drawing: Drawing, *, wanted: set[str], off: set[str]) -> None:
        self.lines = lines
        self.seen: set[str] = set()
        """Layers on which something is drawn."""
        self._drawing = drawing
        self._wanted = wanted
        self._off = off
        self._count = 0
        self._weights: dict[str, int] = {}

    def add(self, entities: Iterable[Any], depth: int, above: str = "0") -> None:
        """Add the lines of some entities; `above` is the layer of the block that they are in."""
        for entity in entities:
            self._count += 1
            if self._count > _MOST_ENTITIES:
                raise MapError(f"it has more than {_MOST_ENTITIES} entities, those of inserted blocks included")
            layer = str(entity.dxf.get("layer", "0")).casefold()
            # What is on layer 0 of a block is on the layer that the block was inserted on.
            layer = above if layer == "0" and depth > 0 else layer
            kind = entity.dxftype()
            if kind == "INSERT":
                if layer in self._off:
                    self._drawing.leave_out("blocks on layers that are off")
                else:
                    self._add_insert(entity, depth, layer)
                continue
            self.seen.add(layer)
            if self._wanted and layer not in self._wanted:
                continue
            if layer in self._off and layer not in self._wanted:
                self._drawing.leave_out("entities on layers that are off")
            elif kind in ("LWPOLYLINE", "POLYLINE"):
                self.add(entity.virtual_entities(), depth + 1, layer)
            else:
                self._add_entity(entity, kind)

    def _add_insert(self, insert: Any, depth: int, layer: str) -> None:
        block = insert.block()
        if block is None or block.block.is_xref:
            self._drawing.leave_out("inserts of blocks that are not in the file")
            return
        weight = insert.mcount * self._weigh(block, ())
        if self._count + weight > _MOST_ENTITIES or weight > _MOST_INSERTED:
            raise MapError(
                f"block {block.name!r} unpacks to {weight} entities, with the blocks that are inserted in it; expected "
                f"{_MOST_INSERTED} at most"
            )
        for each in insert.multi_insert() if insert.mcount > 1 else (insert,):
            self.add(each.virtual_entities(), depth + 1, layer)

    def _weigh(self, block: Any, outer: tuple[str, ...]) -> int:
        """The entities of a block, those of blocks that are inserted in it included."""
        name = str(block.name).casefold()
        if name in outer or len(outer) > _DEEPEST:
            way = " in ".join(repr(each) for each in (name, *reversed(outer[-3:])))
            problem = "in itself" if name in outer else f"more than {_DEEPEST} deep"
            raise MapError(f"its blocks are inserted {problem}: {way}")
        if name not in self._weights:
            weight = len(block)
            for insert in block.query("INSERT"):
                inner = insert.block()
                if inner is not None:
                    weight += int(insert.mcount) * self._weigh(inner, (*outer, name))
            self._weights[name] = weight
        return self._weights[name]

    def _add_entity(self, entity: Any, kind: str) -> None:
        error = self.lines.error
        if kind == "LINE":
            self._add_points([entity.dxf.start, entity.dxf.end])
        elif kind in ("ARC", "CIRCLE"):
            radius = abs(float(entity.dxf.radius))
            sweep = 2.0 * math.pi
            if kind == "ARC":
                sweep = math.radians((entity.dxf.end_angle - entity.dxf.start_angle) % 360.0) or sweep
            self.lines.refuse_too_many(sweep * math.sqrt(radius / (8.0 * error)))
            if radius > 0.0:
                self._add_points(entity.flattening(min(error, 0.25 * radius)))
        elif kind in ("ELLIPSE", "SPLINE"):
            self._add_points(entity.flattening(error))
        elif kind in ("SOLID", "TRACE", "3DFACE"):
            corners = list(entity.wcs_vertices())
            self._add_points([*corners, corners[0]])
        else:
            self._drawing.leave_out(kind)

    def _add_points(self, points: Iterable[Any]) -> None:
        places = []
        for point in points:
            places.append((float(point.x), float(point.y)))
            if len(places) % 4096 == 0:
                self.lines.refuse_too_many(len(places))
        if places:
            self.lines.add_lines(places)


def _parse(path: Path) -> tuple[Any, bool]:
    """The drawing in a file, as a text or in binary, and whether the file has its end."""
    try:
        import ezdxf
        from ezdxf import recover
        from ezdxf.lldxf.const import DXFError
    except ImportError as error:
        raise MapError("DXF drawings are read by ezdxf: pip install 'amorsim[drawings]'") from error
    try:
        data = read_bytes(path, _MOST_BYTES)
    except (OSError, ValueError) as error:
        raise MapError(f"cannot be read: {reason(error)}") from error
    if data.startswith(b"AC10"):
        raise MapError("it is a DWG drawing; save it as DXF")
    if b"SECTION" not in data:
        raise MapError("this is not a DXF drawing: it has no section")
    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)  # what it mends is nothing for a user
    is_whole = b"EOF" in data[-200:]
    try:
        if data.startswith(_BINARY):
            return ezdxf.readfile(path), is_whole  # type: ignore[attr-defined]
        # Programs of DOS end a text with the sign 26.
        return recover.read(io.BytesIO(data.rstrip(b"\x1a")))[0], is_whole
    except DXFError as error:
        raise MapError(f"this is not a whole DXF drawing: {str(error)[:200]}") from error
    except Exception as error:  # a damaged file makes it raise nearly anything
        raise MapError(f"ezdxf cannot read it: {type(error).__name__}: {str(error)[:200]}") from error
