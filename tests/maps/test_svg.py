"""SVG drawings: shapes, units, layers, and how far chords are from their curves."""

from __future__ import annotations

import gzip
import math
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import amorsim as am
from amorsim.core.errors import MapError
from amorsim.maps.svg import Svg
from tests.examples import settings

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '


def written(folder: Path, inside: str, root: str = 'viewBox="0 0 10 8"') -> Path:
    path = folder / "a.svg"
    path.write_text(f"{HEAD}{root}>{inside}</svg>")
    return path


def lines(world: am.Map) -> list[list[float]]:
    return sorted([round(number, 9) for number in line] for line in world.segments.tolist())


def test_shapes_lie_the_right_way_up(tmp_path: Path) -> None:
    inside = '<rect x="1" y="1" width="3" height="2"/><line x1="0" y1="8" x2="10" y2="8"/>'
    inside += '<g transform="translate(5 0)"><polyline points="0,0 1,1 2,0"/><polygon points="0,4 1,4 1,5"/></g>'
    world = Svg(unit=1.0, resolution=0.1).load(written(tmp_path, inside))
    expected = [[1, 7, 4, 7], [4, 7, 4, 5], [4, 5, 1, 5], [1, 5, 1, 7], [0, 0, 10, 0], [5, 8, 6, 7], [6, 7, 7, 8]]
    expected += [[5, 4, 6, 4], [6, 4, 6, 3], [6, 3, 5, 4]]
    assert lines(world) == sorted(expected)
    assert (world.origin, world.size) == ((0.0, 0.0, 0.0), (10.0, 8.0))
    assert world.warnings == ()


CURVES = {
    "circle": ('<circle cx="4" cy="4" r="3"/>', lambda x, y: math.hypot(x - 4, y - 4) - 3),
    "ellipse": (
        '<ellipse cx="1" cy="2" rx="1" ry=".5" transform="translate(3 2) scale(2 4)"/>',
        lambda x, y: math.hypot(x - 5, (8 - y) - 10) - 2,
    ),
    "arc": ('<path d="M 1 4 A 3 3 0 0 1 7 4"/>', lambda x, y: math.hypot(x - 4, y - 4) - 3),
    "parabola": ('<path d="M 0 8 Q 2 8 4 4"/>', lambda x, y: (y - x * x / 4) / math.hypot(1, x / 2)),
    "cubic": ('<path d="M 0 8 C 1 8 2 8 3 5"/>', lambda x, y: (y - x**3 / 9) / math.hypot(1, x * x / 3)),
}


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("error", [0.1, 0.001])
def test_chords_are_as_near_as_stated(tmp_path: Path, name: str, error: float) -> None:
    inside, distance = CURVES[name]
    world = Svg(unit=1.0, resolution=0.05, chord_error=error).load(written(tmp_path, inside))
    # Middles of chords are farthest off, and their ends are on the curve.
    ends, middles = world.segments[:, :2], 0.5 * (world.segments[:, :2] + world.segments[:, 2:])
    assert max(abs(distance(x, y)) for x, y in ends.tolist()) < 1e-9
    worst = max(abs(distance(x, y)) for x, y in middles.tolist())
    assert 0.05 * error < worst <= error * (1 + 1e-9)


@pytest.mark.parametrize(
    ("root", "options", "metres"),
    [
        ('width="10mm" height="8mm" viewBox="0 0 10 8"', {}, 0.001),
        ('width="10cm" height="8cm" viewBox="0 0 10 8"', {"scale": 100.0}, 1.0),
        ('width="1in" height="1in" viewBox="0 0 96 96"', {}, 0.0254 / 96),
        ('width="5cm" height="5cm"', {"scale": 50.0}, 50 * 0.0254 / 96),
        ('width="10" height="8"', {}, 0.01),
        ('width="10" height="8"', {"unit": 0.5}, 0.5),
    ],
)
def test_units(tmp_path: Path, root: str, options: dict[str, float], metres: float) -> None:
    path = written(tmp_path, '<line x1="1" y1="1" x2="7" y2="1"/>', root)
    world = Svg(resolution=0.0001, **options).load(path)
    x0, _, x1, _ = world.segments[0]
    assert x1 - x0 == pytest.approx(6 * metres)
    is_stated = bool(options.get("unit")) or 'width="10"' not in root
    assert [("no unit is given" in warning) for warning in world.warnings] == [True] * (not is_stated)


def test_layers_by_id_or_label(tmp_path: Path) -> None:
    inside = (
        '<g inkscape:label="walls"><line x1="0" y1="0" x2="1" y2="0"/></g><g><g id="doors"><line x2="2"/></g></g>'
        '<g id="furniture"><line x2="3"/></g><line x2="4"/>'
    )
    path = written(tmp_path, inside)

    def lengths(*layers: str) -> list[float]:
        return sorted(line[2] - line[0] for line in Svg(unit=1.0, layers=layers).load(path).segments.tolist())

    assert lengths() == [1, 2, 3, 4]
    assert lengths("walls") == [1]
    assert lengths("walls", "doors") == [1, 2]
    with pytest.raises(MapError, match="it has no group of the id or label 'wals'"):
        lengths("walls", "wals")


def test_what_is_left_out_is_remarked_on_once(tmp_path: Path) -> None:
    inside = '<line x2="3"/><text>a</text><text>b</text><g style="display: none"><line x2="9"/></g><title>t</title>'
    world = Svg(unit=1.0).load(written(tmp_path, inside))
    assert len(world.segments) == 1
    assert world.warnings == ("left out: 2 texts, 1 hidden shapes or groups",)


def test_uses_are_followed(tmp_path: Path) -> None:
    inside = '<defs><line id="a" x2="1"/></defs><use href="#a" y="3"/><use href="#a" x="2" y="4"/>'
    assert lines(Svg(unit=1.0).load(written(tmp_path, inside))) == [[0, 5, 1, 5], [2, 4, 3, 4]]


BOMB = '<line id="a0" x2="1"/>' + "".join(
    f'<g id="a{i}">{"".join(f"""<use href="#a{i - 1}"/>""" for _ in range(10))}</g>' for i in range(1, 12)
)


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        ("<line", "line 1: this is not XML"),
        ("\n\n<g></h>", "line 3: this is not XML"),
        ("", "it has no line"),
        ("<text>a</text>", r"it has no line \(left out: 1 texts\)"),
        (BOMB, "more than 200000 elements, by uses of uses"),
        ('<g id="b"><use href="#b"/></g>', "uses an element within itself"),
        ("<g>" * 200 + "</g>" * 200, "nested more than 100 deep"),
        ('<circle r="1e15"/>', "more than 2000000 lines|too large"),
        ('<line x2="1e300"/>', "too large|finite"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, inside: str, words: str) -> None:
    path = written(tmp_path, inside)
    with pytest.raises(MapError, match=words) as caught:
        Svg(unit=1.0).load(path)
    assert str(caught.value).startswith(f"{path}: ")


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        ('\n<path d="M0 0 L10 10 L x 5"/>', r"line 2: path: d has 'x 5', where a number was expected"),
        ('<polygon id="a" points="0,0 5,5 ?"/>', r"line 1: polygon 'a': points has '\?', where a number"),
        ('\n<rect id="r" width="wide" height="5"/>', "line 2: rect 'r': width is 'wide'; expected a length"),
        ('<g><circle r="1,5"/></g>', "line 1: circle: r is '1,5'; expected a length"),
        ('\n<g transform="rotat(30)"><rect width="1" height="5"/></g>', r"line 2: g: transform is 'rotat\(30\)'; exp"),
        ('<rect width="1" height="5" transform="scale(2"/>', "line 1: rect: transform is 'scale"),
        ('\n\n<svg viewBox="0 0 1 1" width="5mm" height="5"/>', "line 3: svg: width is '5mm'; expected a number"),
    ],
)
def test_what_cannot_be_meant_is_said_with_its_line(tmp_path: Path, inside: str, words: str) -> None:
    with pytest.raises(MapError, match=words):
        Svg(unit=1.0).load(written(tmp_path, inside))


def test_percentages_are_of_the_drawings_size(tmp_path: Path) -> None:
    path = written(tmp_path, '<rect x="10%" width="50%" height="50%"/>')
    assert lines(Svg(unit=1.0).load(path)) == [[1, 4, 1, 8], [1, 8, 6, 8], [6, 4, 1, 4], [6, 8, 6, 4]]
    path = written(tmp_path, '<line x2="50%"/>', 'width="25.4mm" height="25.4mm"')
    assert lines(Svg(unit=1.0).load(path))[0][2] == pytest.approx(48.0)
    with pytest.raises(MapError, match="line 1: rect: width is 50 percent of a size that is not given"):
        Svg(unit=1.0).load(written(tmp_path, '<rect width="50%" height="1"/>', ""))


@pytest.mark.parametrize(
    ("about", "corners"),
    [
        ("", (2, 2, 4, 4)),  # as large as fits, in the middle
        ('preserveAspectRatio="none"', (2, 1, 4, 5)),
        ('preserveAspectRatio="xMaxYMax slice"', (0, 1, 4, 5)),
        ('transform="translate(1 0)"', (3, 2, 5, 4)),
    ],
)
def test_a_drawing_in_a_drawing_has_its_place(tmp_path: Path, about: str, corners: tuple[int, ...]) -> None:
    """The shape in it takes neither place nor size from it, as svgelements would have it."""
    place = f'x="2" y="3" width="2" height="4" viewBox="0 0 4 4" {about}'
    world = Svg(unit=1.0).load(written(tmp_path, f'<svg {place}><rect width="4" height="4"/></svg>'))
    found = np.array(world.segments).reshape(-1, 2)
    assert (*found.min(axis=0), *found.max(axis=0)) == pytest.approx(corners)


def test_what_is_drawn_only_where_it_is_used_is_no_wall(tmp_path: Path) -> None:
    kinds = ("mask", "marker", "pattern", "clipPath", "symbol")
    inside = "".join(f'<{kind} id="{kind}"><line x2="5"/></{kind}>' for kind in kinds)
    inside += '<line x2="3"/><use href="#symbol" y="1"/>'
    assert lines(Svg(unit=1.0).load(written(tmp_path, inside))) == [[0, 7, 5, 7], [0, 8, 3, 8]]


def test_uses_that_cannot_be_followed_are_remarked_on(tmp_path: Path) -> None:
    inside = '<symbol id="s" viewBox="0 0 9 9"><line x2="9"/></symbol><use href="#s" width="1" height="1"/>'
    world = Svg(unit=1.0).load(written(tmp_path, f'<line x2="3"/><use href="other.svg#a"/><use href="#b"/>{inside}'))
    assert len(world.segments) == 1
    expected = "left out: 2 uses of what is not in the file, 1 uses of symbols with a size of their own"
    assert world.warnings == (expected,)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("entity", ['a "b"', 'a SYSTEM "file:///etc/passwd"', '% a SYSTEM "file:///etc/passwd"'])
def test_entities_are_refused_in_every_encoding(tmp_path: Path, encoding: str, entity: str) -> None:
    path = tmp_path / "a.svg"
    text = f'<?xml version="1.0" encoding="{encoding}"?><!DOCTYPE svg [<!ENTITY {entity}>]><svg><line x2="9"/></svg>'
    path.write_bytes(text.encode(encoding))
    with pytest.raises(MapError, match="declares entities"):
        Svg().load(path)


def test_entities_and_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.svg"
    path.write_text('<!DOCTYPE svg [<!ENTITY a "b">]><svg>&a;</svg>')
    with pytest.raises(MapError, match="declares entities"):
        Svg().load(path)
    path.write_text("<html/>")
    with pytest.raises(MapError, match="its root is 'html'"):
        Svg().load(path)
    assert Svg.sniff(b'<?xml version="1.0"?>\n<svg ')
    assert not Svg.sniff(b"<html>")


@settings(max_examples=60, deadline=None)
@given(
    walls=hnp.arrays(np.float64, st.tuples(st.integers(1, 6), st.just(4)), elements=st.floats(-1, 1, width=64)),
    resolution=st.sampled_from([0.003, 0.01, 0.25]),
)
def test_any_lines_come_back(tmp_path_factory, walls, resolution) -> None:
    room = am.Map.from_segments(walls, resolution=resolution, extent=(-1, -1, 1, 1))
    again = am.save_map(room, tmp_path_factory.mktemp("maps") / "any.svg")
    assert np.array_equal(again.to_array(), room.to_array())
    assert np.array_equal(again.segments, room.segments)


@settings(max_examples=60, deadline=None)
@given(
    cells=hnp.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9))).filter(np.any),
    corner=st.integers(-50, 50),
)
def test_any_cells_come_back(tmp_path_factory, cells, corner) -> None:
    plan = am.Map.from_array(cells, resolution=0.05, origin=(corner * 0.05, 0.0, 0.0))
    again = am.save_map(plan, tmp_path_factory.mktemp("maps") / "any.svg")
    assert np.array_equal(again.to_array(), plan.to_array())


def test_a_written_drawing_has_its_true_size(tmp_path: Path) -> None:
    am.save_map(am.Map.from_segments([(0, 0, 3, 0)], resolution=0.01, extent=(0, 0, 4, 3)), tmp_path / "a.svg")
    world = am.load_map(tmp_path / "a.svg")
    assert (world.size, world.segments.tolist()) == ((4.0, 3.0), [[0.0, 0.0, 3.0, 0.0]])


@pytest.mark.parametrize(
    "transform",
    [
        "",
        " translate(1)",
        "matrix(1 0 0 1 2e0 -.5),rotate( 30 , 1 2 )",
        "scale (2)\n skewX(-3) skewY(+3)",
        "translate(1.5.5-2)",
        "none",
    ],
)
def test_transforms_that_browsers_take_are_taken(tmp_path: Path, transform: str) -> None:
    Svg(unit=1.0).load(
        written(
            tmp_path,
            f'<rect width="auto" rx="auto" height="5" transform="{transform}"/><line x1="1" x2="20%" y1=" 3px "/>',
        )
    )


@pytest.mark.parametrize("numbers", ["1" * 200_000, "1.5" * 100_000, "1 " * 100_000, " " * 200_000, "+" * 200_000])
def test_long_texts_take_no_time(tmp_path: Path, numbers: str) -> None:
    for shape in (f'<g transform="scale({numbers}?"/>', f'<rect width="{numbers}?"/>'):
        before = time.process_time()
        with pytest.raises(MapError, match=r"line 1: (g: transform|rect: width) is"):
            Svg().load(written(tmp_path, shape))
        assert time.process_time() - before < 5.0


def test_a_compressed_drawing_is_named_as_such(tmp_path: Path) -> None:
    path = tmp_path / "a.svg"
    path.write_bytes(gzip.compress(b"<svg/>"))
    with pytest.raises(MapError, match="it is compressed; save it as plain SVG, or unpack it with gunzip"):
        Svg().load(path)


@pytest.mark.parametrize("width", ["1e-320", "1e300"])
def test_a_unit_that_no_drawing_has_is_refused(tmp_path: Path, width: str) -> None:
    path = written(tmp_path, '<circle cx="2" cy="3" r="1"/>', f'width="60mm" height="50mm" viewBox="0 0 {width} 50"')
    with pytest.raises(MapError, match="expected a width and a viewBox that fit"):
        Svg().load(path)
