"""GeoJSON (RFC 7946) as maps: polygons are obstacles, lines are walls; in metres, or in longitude and latitude."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError
from amorsim.core.files.reading import read_bytes, reason
from amorsim.core.maps.cell_lines import extent_of, wall_lines
from amorsim.core.maps.map import Map
from amorsim.core.numbers import is_number
from amorsim.core.parameters import parameter
from amorsim.maps.drawn_lines import Drawing

__all__ = ["GeoJson"]

_MOST_BYTES = 50_000_000
_DEPTH = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
_START = "start"  # the property ``kind`` of a point that is where a robot starts
# WGS 84: half the equator's diameter [m], and the square of the eccentricity.
_RADIUS, _ECCENTRICITY = 6_378_137.0, 0.00669437999014

Points = NDArray[np.float64]


@attrs.frozen(kw_only=True)
class GeoJson(MapLoader):
    """GeoJSON (``.geojson``): polygons, less their holes, are occupied, and so are lines.

    Longitude and latitude are projected on the plane that touches the Earth in the middle of the file, or at
    `latitude` and `longitude`, east along x, with the Earth's curvatures there. Half a kilometre from that point, at
    50 degrees of latitude, this is off by less than 3 cm, and by four times that at twice the distance. Points are
    left out.
    """

    extensions: ClassVar[tuple[str, ...]] = (".geojson",)

    resolution: float = parameter(0.01, unit="m", gt=0, help="side of a cell")
    coordinates: str = parameter("metres", choices=("metres", "degrees"), help="what the file's numbers are")
    latitude: float | None = parameter(
        None, ge=-89, le=89, help="of the world's origin [degrees]; without it the middle of the file"
    )
    longitude: float | None = parameter(
        None, ge=-180, le=180, help="of the world's origin [degrees]; without it the middle of the file"
    )
    fill: bool = parameter(True, help="whether the inside of polygons is occupied, or their outlines alone")

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file's first bytes are those of an object with a type of GeoJSON."""
        start = head.lstrip(b"\xef\xbb\xbf \t\r\n")[:400]
        return start.startswith(b"{") and (b'"FeatureCollection"' in start or b'"GeometryCollection"' in start)

    def load(self, path: Path) -> Map:
        """The map of a file.

        Raises
        ------
        MapError
            If the file cannot be read, is not GeoJSON, or holds neither a line nor a polygon; with the line, or the
            place in the file.
        """
        try:
            return self._load(path)
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    def _load(self, path: Path) -> Map:
        document = _parse(path)
        parts = _Parts(document)
        remarks: list[str] = []
        drawing = Drawing(self.resolution)
        project = self._projection(parts, remarks)
        for line in parts.lines:
            drawing.add_lines(project(line))
        for rings in parts.polygons:
            placed = [project(ring) for ring in rings]
            for ring in placed:
                drawing.add_lines(ring)
            if self.fill:
                drawing.add_area(placed, self.resolution)
        for what, count in parts.left_out.items():
            drawing.leave_out(what, count)
        extent = _box(document) if self.coordinates == "metres" else None
        segments = drawing.segments
        if len(segments) == 0 and extent is None:
            raise MapError("it has neither a line nor a polygon" + "".join(f" ({each})" for each in drawing.remarks))
        return Map.from_segments(
            segments,
            resolution=self.resolution,
            extent=extent,
            start=parts.start if self.coordinates == "metres" else None,
            warnings=(*remarks, *parts.remarks, *drawing.remarks),
            name=path.stem,
        )

    @classmethod
    def save(cls, world: Map, path: Path) -> GeoJson:
        """Write a map's walls as lines in metres, cells from middle to middle; see `amorsim.save_map`."""
        walls = wall_lines(world).reshape(-1, 2, 2).tolist()
        features: list[dict[str, Any]] = [_feature({"kind": "walls"}, "MultiLineString", walls)]
        if world.start is not None:
            x, y, heading = world.start
            features.append(_feature({"kind": _START, "heading_deg": math.degrees(heading)}, "Point", [x, y]))
        document = {"type": "FeatureCollection", "bbox": list(extent_of(world)), "features": features}
        path.write_text(json.dumps(document) + "\n", encoding="ascii", newline="\n")
        return cls(resolution=world.resolution)

    def _projection(self, parts: _Parts, remarks: list[str]) -> Any:
        """A function that turns places of the file (n, 2) into places of the world [m]."""
        places = [*parts.lines, *(ring for rings in parts.polygons for ring in rings)]
        every = np.concatenate(places) if places else np.zeros((1, 2))
        low, high = every.min(axis=0), every.max(axis=0)
        # A ring over the date line may go on beyond 180 degrees.
        is_angular = bool((np.abs(every) <= (360.0, 90.0)).all())
        if self.coordinates == "metres":
            if is_angular and places and max(high - low) < 0.1:
                remarks.append(
                    f"it is {max(high - low):.3g} m long, which looks like longitude and latitude; if so, say "
                    "coordinates = 'degrees'"
                )
            return lambda line: line
        if not is_angular:
            raise MapError("it has numbers that are not longitude and latitude; say coordinates = 'metres'")
        # What lies on both sides of the date line is narrower when counted from 0 to 360 degrees.
        eastward = every[:, 0] % 360.0
        if eastward.max() - eastward.min() < high[0] - low[0]:
            low[0], high[0] = eastward.min(), eastward.max()
        middle = 0.5 * (low + high)
        longitude = _near_zero(float(middle[0])) if self.longitude is None else self.longitude
        latitude = float(middle[1]) if self.latitude is None else self.latitude
        if not abs(latitude) <= 89.0:
            raise MapError(f"it lies about latitude {latitude:.6g}; expected 89 degrees at most from the equator")
        if None in (self.latitude, self.longitude):
            remarks.append(f"the world's origin is at longitude {longitude:.7f}, latitude {latitude:.7f} degrees")
        flat = 1.0 - _ECCENTRICITY * math.sin(math.radians(latitude)) ** 2
        along = _RADIUS / math.sqrt(flat) * math.cos(math.radians(latitude))
        up = _RADIUS * (1.0 - _ECCENTRICITY) / flat**1.5

        def project(line: Points) -> Points:
            apart = line - (longitude, latitude)
            apart[:, 0] -= 360.0 * np.round(apart[:, 0] / 360.0)
            return np.asarray(np.radians(apart) * (along, up))

        return project


class _Parts:
    """Lines and polygons of a document, wherever in it they are; faults name the place."""

    def __init__(self, document: Any) -> None:
        self.lines: list[Points] = []
        self.polygons: list[list[Points]] = []
        self.left_out: dict[str, int] = {}
        self.remarks: list[str] = []
        self.start: tuple[float, float, float] | None = None
        self._unclosed = 0
        to_do: list[tuple[str, Any, Any]] = [("", document, None)]
        while to_do:
            where, item, about = to_do.pop()
            to_do.extend(reversed(self._inside(where, item, about)))
        if self._unclosed:
            self.remarks.append(f"{self._unclosed} rings of polygons end elsewhere than they begin; they are closed")

    def _inside(self, where: str, item: Any, about: Any) -> list[tuple[str, Any, Any]]:
        """Read a geometry, or the parts of a larger object with its properties."""
        if not isinstance(item, dict):
            raise MapError(f"{where or 'the file'}: expected an object with a 'type', got {_shown(item)}")
        kind = item.get("type")
        if kind in ("FeatureCollection", "GeometryCollection"):
            key = "features" if kind == "FeatureCollection" else "geometries"
            inside = item.get(key)
            if not isinstance(inside, list):
                raise MapError(f"{where or 'the file'}: {key}: expected a list, got {_shown(inside)}")
            return [(_join(where, f"{key}[{number}]"), each, about) for number, each in enumerate(inside)]
        if kind == "Feature":
            geometry = item.get("geometry")
            return [] if geometry is None else [(_join(where, "geometry"), geometry, item.get("properties"))]
        if not isinstance(kind, str) or kind not in _DEPTH:
            known = ", ".join((*_DEPTH, "GeometryCollection", "Feature", "FeatureCollection"))
            raise MapError(f"{where or 'the file'}: type is {_shown(kind)}; expected one of {known}")
        self._take(kind, _join(where, "coordinates"), item.get("coordinates"), about)
        return []

    def _take(self, kind: str, where: str, given: Any, about: Any) -> None:
        if kind == "Point" and isinstance(about, dict) and about.get("kind") == _START:
            (place,) = _places(where, [given]).tolist()
            heading = about.get("heading_deg", 0.0)
            degrees = float(heading) if is_number(heading, below=1e6) else 0.0
            self.start = (place[0], place[1], math.radians(degrees))
        elif kind in ("Point", "MultiPoint"):
            self.left_out["points"] = self.left_out.get("points", 0) + 1
        elif kind == "LineString":
            self.lines.append(_places(where, given))
        elif kind == "MultiLineString":
            self.lines += [_places(f"{where}[{i}]", line) for i, line in enumerate(_list(where, given))]
        elif kind == "Polygon":
            self._take_polygon(where, given)
        else:
            for number, polygon in enumerate(_list(where, given)):
                self._take_polygon(f"{where}[{number}]", polygon)

    def _take_polygon(self, where: str, given: Any) -> None:
        rings = []
        for number, each in enumerate(_list(where, given)):
            ring = _places(f"{where}[{number}]", each)
            if not (ring[0] == ring[-1]).all():
                self._unclosed += 1
                ring = np.concatenate((ring, ring[:1]))
            rings.append(ring)
        if rings:
            self.polygons.append(rings)


def _parse(path: Path) -> Any:
    try:
        return json.loads(read_bytes(path, _MOST_BYTES).decode("utf-8-sig"), parse_int=float)
    except UnicodeDecodeError as error:
        raise MapError(f"byte {error.start} is not UTF-8, and GeoJSON is") from error
    except json.JSONDecodeError as error:
        raise MapError(f"line {error.lineno}: this is not JSON: {error.msg}") from error
    except RecursionError as error:
        raise MapError("it is nested too deeply") from error
    except (OSError, ValueError) as error:
        raise MapError(f"cannot be read: {reason(error)}") from error


def _feature(properties: dict[str, Any], kind: str, coordinates: Any) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


def _box(document: Any) -> tuple[float, float, float, float] | None:
    box = document.get("bbox")
    if not (isinstance(box, list) and len(box) == 4 and all(is_number(each, below=1e12) for each in box)):
        return None
    left, bottom, right, top = map(float, box)
    return (left, bottom, right, top) if left < right and bottom < top else None


def _near_zero(degrees: float) -> float:
    """The same longitude, from -180 to 180 degrees."""
    return degrees - 360.0 * round(degrees / 360.0)


def _join(where: str, key: str) -> str:
    return f"{where}.{key}" if where else key


def _list(where: str, given: Any) -> list[Any]:
    if not isinstance(given, list):
        raise MapError(f"{where}: expected a list, got {_shown(given)}")
    return given


def _places(where: str, given: Any) -> Points:
    """Places (n, 2) of a list of positions; heights are ignored."""
    places = []
    for number, place in enumerate(_list(where, given)):
        if not (isinstance(place, list) and len(place) >= 2 and all(is_number(each, below=1e12) for each in place[:2])):
            raise MapError(f"{where}[{number}]: expected [x, y], two numbers below 1e12, got {_shown(place)}")
        places.append((float(place[0]), float(place[1])))
    if not places:
        raise MapError(f"{where}: expected positions, got none")
    return np.array(places, np.float64)


def _shown(value: Any) -> str:
    if isinstance(value, list) and 2 <= len(value) <= 3 and not any(isinstance(each, (list, dict)) for each in value):
        return f"[{', '.join(repr(each)[:20] for each in value)}]"
    if isinstance(value, (list, dict)):
        return f"a {'list' if isinstance(value, list) else 'object'} of {len(value)}"
    return repr(value)[:60]
