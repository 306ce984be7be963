"""Small maps of the formats that are fuzzed together, whole, and the options of their loaders."""

from __future__ import annotations

from typing import Any

from amorsim.maps.dxf import Dxf
from amorsim.maps.geojson import GeoJson
from amorsim.maps.maz import Maz
from amorsim.maps.movingai import MovingAI
from amorsim.maps.ros import Ros
from amorsim.maps.svg import Svg

__all__ = ["LOADERS", "MAPS"]

_DXF = """0 SECTION 2 HEADER 9 $INSUNITS 70 6 0 ENDSEC 0 SECTION 2 BLOCKS
0 BLOCK 8 0 2 C 70 0 10 0.0 20 0.0 3 C 0 LINE 8 0 10 0.0 20 0.0 11 1.0 21 0.0 0 ENDBLK 8 0
0 BLOCK 8 0 2 B 70 0 10 0.0 20 0.0 3 B
0 LINE 8 0 10 0.0 20 0.0 11 1.0 21 1.0 0 INSERT 8 0 2 C 10 1.0 20 1.0 0 ENDBLK 8 0 0 ENDSEC 0 SECTION 2 ENTITIES
0 LINE 8 W 10 1.0 20 2.0 11 5.0 21 2.0 0 ARC 8 D 10 0.0 20 0.0 40 2.0 50 0.0 51 90.0 0 CIRCLE 8 D 10 4.0 20 3.0 40 1.0
0 POLYLINE 8 W 66 1 70 1 0 VERTEX 8 W 10 0.0 20 5.0 42 1.0 0 VERTEX 8 W 10 2.0 20 5.0 0 SEQEND 0 ELLIPSE 8 W 10 3.0
20 3.0 11 1.0 21 0.0 40 0.5 41 0.0 42 6.28 0 INSERT 8 W 2 B 10 3.0 20 1.0 41 2.0 50 30.0 70 2 71 2 44 1.0 45 1.0
0 SOLID 8 W 10 0.0 20 0.0 11 1.0 21 0.0 12 0.0 22 1.0 13 1.0 23 1.0
0 TEXT 8 W 10 0.0 20 0.0 40 1.0 1 hi 0 ENDSEC 0 EOF"""

MAPS = {
    "yaml": b"image: lab.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.5]\nnegate: 0\noccupied_thresh: 0.65\n"
    b"free_thresh: 0.196\nmode: scale\n",
    "map": b"type octile\nheight 3\nwidth 5\nmap\n@@@@@\n@.SWT\nO.G.@\n",
    "geojson": b'{"type": "FeatureCollection", "bbox": [0, 0, 6, 6], "features": [{"type": "Feature", "properties": '
    b'{"kind": "start"}, "geometry": {"type": "Point", "coordinates": [1, 1]}}, {"type": "Feature", "properties": {}, '
    b'"geometry": {"type": "Polygon", "coordinates": [[[1, 1], [4, 1], [4, 4], [1, 1]], [[2, 1.5], [3, 1.5], [3, 2], '
    b'[2, 1.5]]]}}, {"type": "LineString", "coordinates": [[0, 0], [5, 5.5]]}]}',
    "svg": b'<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="50mm" viewBox="0 0 60 50"><defs><g id="a">'
    b'<rect x="1" y="2" width="9" height="8" rx="2"/></g></defs><use href="#a" x="4"/><g transform="rotate(30) '
    b'scale(2 1)"><circle cx="20" cy="9" r="5"/><path d="M1 2L3 4H9V3Q5 6 7 8T9 9C1 2 3 4 5 6S2 3 4 5A4 3 20 1 0 9 1z'
    b'"/><polygon points="1,2 3,4 5,6"/></g><text>a</text></svg>',
    "dxf": "\n".join(_DXF.split()).encode(),
    "maz": b" _ _ _\n|   | |\n| |_  |\n|S|___|\n360\n",
}

LOADERS: dict[str, tuple[Any, dict[str, tuple[Any, ...]]]] = {
    "yaml": (Ros, {"unknown": ("free", "occupied")}),
    "map": (MovingAI, {"swamp": ("free", "occupied"), "origin_yaw": (0.0, 1.0)}),
    "geojson": (GeoJson, {"coordinates": ("metres", "degrees"), "fill": (True, False), "latitude": (0.0, 89.0)}),
    "svg": (Svg, {"unit": (0.001, 1.0, 1e6), "chord_error": (1e-9, 1.0), "layers": (("a",), ()), "scale": (100.0,)}),
    "dxf": (Dxf, {"unit": (0.001, 1.0, 1e6), "chord_error": (1e-9, 1.0), "layers": (("W",), ())}),
    "maz": (Maz, {"cell": (0.01, 1.0, 1e3)}),
}
