"""DXF drawings: entities, units, layers, blocks, and how far chords are from their curves."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import ezdxf
import pytest

from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map
from amorsim.maps.dxf import Dxf

# A drawing as R12 programs write it: an arc, a line and a polyline with a bulge, without header.
R12 = """0
SECTION
2
ENTITIES
0
LINE
8
WALLS
10
1.0
20
2.0
11
5.0
21
2.0
0
ARC
8
DOORS
10
0.0
20
0.0
40
2.0
50
0.0
51
90.0
0
POLYLINE
8
WALLS
66
1
70
1
0
VERTEX
8
WALLS
10
0.0
20
5.0
42
1.0
0
VERTEX
8
WALLS
10
2.0
20
5.0
0
SEQEND
0
ENDSEC
0
EOF
"""


def drawn(folder: Path, version: str = "R2010", unit: int = 6, **layers: Any) -> tuple[Any, Any, Path]:
    document = ezdxf.new(version)
    document.header["$INSUNITS"] = unit
    return document, document.modelspace(), folder / "a.dxf"


def lines(world: Map) -> list[list[float]]:
    return sorted([round(number, 9) for number in line] for line in world.segments.tolist())


def test_r12_without_a_header(tmp_path: Path) -> None:
    path = tmp_path / "a.dxf"
    path.write_text(R12.replace("\n", "\r\n"), newline="")
    world = Dxf(unit=1.0, chord_error=0.001).load(path)
    assert [1.0, 2.0, 5.0, 2.0] in lines(world)
    assert [2.0, 5.0, 0.0, 5.0] in lines(world)  # closes the polyline
    assert world.size == pytest.approx((5.0, 5.0), abs=0.02)
    # The bulge of 1 is half a circle, below the line since it turns left.
    assert world.occupied([(1.0, 4.0), (1.0, 4.5), (2 * math.cos(0.7), 2 * math.sin(0.7))]).tolist() == [
        True,
        False,
        True,
    ]
    assert "no unit ($INSUNITS)" in Dxf().load(path).warnings[0]
    assert lines(Dxf(unit=1.0, layers=("walls",)).load(path))[0][0] >= 0.0
    assert len(Dxf(unit=1.0, layers=("DOORS",)).load(path).segments) > 5


@pytest.mark.parametrize("error", [0.1, 0.001])
@pytest.mark.parametrize("kind", ["circle", "arc", "ellipse", "bulge"])
def test_chords_are_as_near_as_stated(tmp_path: Path, kind: str, error: float) -> None:
    document, space, path = drawn(tmp_path)
    if kind == "circle":
        space.add_circle((1, 2), 3)
    elif kind == "arc":
        space.add_arc((1, 2), 3, 30, 200)
    elif kind == "ellipse":
        space.add_ellipse((1, 2), (3, 0, 0), 1.0)
    else:
        space.add_lwpolyline([(4, 2, 1.0), (-2, 2, 0.0)], format="xyb")
    document.saveas(path)
    segments = Dxf(chord_error=error).load(path).segments
    ends, middles = segments[:, :2], 0.5 * (segments[:, :2] + segments[:, 2:])
    assert max(abs(math.hypot(x - 1, y - 2) - 3) for x, y in ends.tolist()) < 1e-9
    assert max(abs(math.hypot(x - 1, y - 2) - 3) for x, y in middles.tolist()) <= error * (1 + 1e-6)
    assert len(segments) < 2 * math.pi * math.sqrt(3 / (8 * error)) * 2.5 + 2


@pytest.mark.parametrize(("code", "metres"), [(1, 0.0254), (4, 0.001), (5, 0.01), (6, 1.0)])
def test_units_of_the_header(tmp_path: Path, code: int, metres: float) -> None:
    document, space, path = drawn(tmp_path, unit=code)
    space.add_line((0, 0), (100, 0))
    document.saveas(path)
    world = Dxf().load(path)
    assert lines(world) == [[0.0, 0.0, pytest.approx(100 * metres), 0.0]]
    assert world.warnings == ()
    assert lines(Dxf(unit=0.5).load(path)) == [[0.0, 0.0, 50.0, 0.0]]


def test_blocks_are_inserted_turned_scaled_and_in_rows(tmp_path: Path) -> None:
    document, space, path = drawn(tmp_path)
    block = document.blocks.new("DESK")
    block.add_line((0, 0), (1, 0))
    outer = document.blocks.new("PAIR")
    outer.add_blockref("DESK", (0, 1))
    space.add_blockref("PAIR", (10, 0), dxfattribs={"rotation": 90, "xscale": 2, "yscale": 2})
    space.add_blockref(
        "DESK", (0, 5), dxfattribs={"row_count": 2, "row_spacing": 1, "column_count": 2, "column_spacing": 3}
    )
    document.saveas(path)
    expected = [[8, 0, 8, 2], [0, 5, 1, 5], [3, 5, 4, 5], [0, 6, 1, 6], [3, 6, 4, 6]]
    assert lines(Dxf().load(path)) == sorted(expected)


def test_layers(tmp_path: Path) -> None:
    document, space, path = drawn(tmp_path)
    for name in ("Walls", "Hidden"):
        document.layers.add(name)
    document.layers.get("Hidden").off()
    block = document.blocks.new("B")
    block.add_line((0, 0), (4, 0))  # on layer 0: that of the insert
    space.add_line((0, 0), (1, 0), dxfattribs={"layer": "Walls"})
    space.add_line((0, 0), (2, 0), dxfattribs={"layer": "Hidden"})
    space.add_line((0, 0), (3, 0))
    space.add_blockref("B", (0, 0), dxfattribs={"layer": "Walls"})
    space.add_text("hello")
    document.saveas(path)
    every = Dxf().load(path)
    assert [line[2] for line in lines(every)] == [1, 3, 4]
    assert every.warnings == ("left out: 1 entities on layers that are off, 1 TEXT",)
    assert [line[2] for line in lines(Dxf(layers=("walls",)).load(path))] == [1, 4]
    assert [line[2] for line in lines(Dxf(layers=("HIDDEN",)).load(path))] == [2]
    with pytest.raises(MapError, match=r"nothing is drawn on a layer 'wals'\..*Did you mean 'walls'"):
        Dxf(layers=("wals",)).load(path)


@pytest.mark.long
def test_blocks_that_multiply_are_refused(tmp_path: Path) -> None:
    document, space, path = drawn(tmp_path)
    document.blocks.new("B0").add_line((0, 0), (1, 0))
    for i in range(1, 9):
        block = document.blocks.new(f"B{i}")
        for j in range(10):
            block.add_blockref(f"B{i - 1}", (j, 0))
    space.add_blockref("B8", (0, 0))
    document.saveas(path)
    with pytest.raises(MapError, match="expected 200000 at most"):
        Dxf().load(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("nothing", "not a DXF drawing: it has no section"),
        ("AC1027" + "\0" * 50, "it is a DWG drawing; save it as DXF"),
        (R12.split("LINE", maxsplit=1)[0] + "ENDSEC\n0\nEOF\n", "it has no line"),
        (R12.replace("40\n2.0", "40\n1e18"), "more than 2000000 lines"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "a.dxf"
    path.write_text(text)
    with pytest.raises(MapError, match=words) as caught:
        Dxf(unit=1.0).load(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_sniff() -> None:
    assert Dxf.sniff(b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n")
    assert not Dxf.sniff(b"0 0 10 0\n")


def test_a_block_in_itself_is_named(tmp_path: Path) -> None:
    drawing = ezdxf.new("R2000")
    for name, inner in (("A", "B"), ("B", "A")):
        drawing.blocks.new(name).add_blockref(inner, (0, 0))
    drawing.modelspace().add_blockref("A", (0, 0))
    drawing.saveas(tmp_path / "a.dxf")
    with pytest.raises(MapError, match="its blocks are inserted in itself: 'a' in 'b' in 'a'"):
        Dxf(unit=1.0).load(tmp_path / "a.dxf")


def test_blocks_that_unpack_to_too_much_are_refused_before_they_are(tmp_path: Path) -> None:
    drawing = ezdxf.new("R2000")
    drawing.blocks.new("B0").add_line((0, 0), (1, 0))
    for level in range(1, 7):
        block = drawing.blocks.new(f"B{level}")
        for _ in range(10):
            block.add_blockref(f"B{level - 1}", (0, 0))
    drawing.modelspace().add_blockref("B6", (0, 0))
    drawing.saveas(tmp_path / "a.dxf")
    began = time.process_time()
    with pytest.raises(MapError, match=r"block 'B6' unpacks to 2\d+ entities, .* expected 200000 at most"):
        Dxf(unit=1.0).load(tmp_path / "a.dxf")
    assert time.process_time() - began < 5.0  # unpacked, 20 s and more


def test_blocks_of_other_files_are_remarked_on(tmp_path: Path) -> None:
    drawing = ezdxf.new("R2000")
    drawing.add_xref_def("other.dxf", "X")
    space = drawing.modelspace()
    space.add_line((0, 0), (1, 0))
    space.add_blockref("X", (0, 0))
    drawing.saveas(tmp_path / "a.dxf")
    assert Dxf(unit=1.0).load(tmp_path / "a.dxf").warnings == (
        "left out: 1 inserts of blocks that are not in the file",
    )


@pytest.mark.parametrize("version", ["R12", "R2000", "R2018"])
def test_binary_drawings_are_read_like_texts(tmp_path: Path, version: str) -> None:
    document = ezdxf.new(version)
    document.modelspace().add_line((0, 0), (3, 2))
    document.modelspace().add_circle((1, 1), 0.5, dxfattribs={"layer": "DOORS"})
    worlds = []
    for name, fmt in (("text.dxf", "asc"), ("binary.dxf", "bin")):
        document.saveas(tmp_path / name, fmt=fmt)
        worlds.append(Dxf(unit=1.0).load(tmp_path / name))
    assert worlds[0].segments is not None
    assert worlds[1].segments is not None
    assert worlds[0].segments.tolist() == worlds[1].segments.tolist()
    assert worlds[1].warnings == ()
    whole = (tmp_path / "binary.dxf").read_bytes()
    (tmp_path / "binary.dxf").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(MapError, match=r"ezdxf cannot read it|not a whole DXF drawing|it has no line"):
        Dxf(unit=1.0).load(tmp_path / "binary.dxf")


def test_a_drawing_that_was_cut_off_is_said_to_be(tmp_path: Path) -> None:
    path = tmp_path / "a.dxf"
    path.write_text(R12[: R12.index("0\nPOLYLINE")])
    with pytest.raises(MapError, match=r"it has no line \(the file does not end with EOF: was it cut off\?\)$"):
        Dxf(unit=1.0).load(path)


@pytest.mark.parametrize("end", ["", "\n", "\r\n\x1a", "\n999\nmade by hand\n"])
def test_a_drawing_may_end_as_programs_end_it(tmp_path: Path, end: str) -> None:
    path = tmp_path / "a.dxf"
    path.write_bytes((R12.rstrip() + end).encode())
    segments = Dxf(unit=1.0).load(path).segments
    assert segments is not None
    assert len(segments) > 3
