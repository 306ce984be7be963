"""The XML of an SVG drawing, read strictly, and corrected where svgelements differs from browsers."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

from amorsim.core.errors import MapError
from amorsim.core.files.reading import read_bytes, reason
from amorsim.maps.drawn_lines import Drawing

__all__ = ["Lines", "Viewport", "length", "local", "parse_svg", "prepare"]

_MOST_BYTES = 50_000_000
_MOST_ELEMENTS = 200_000
_DEEPEST = 100
_SVG = "{http://www.w3.org/2000/svg}"
_HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_LENGTH = re.compile(rf"\s*({_NUMBER})\s*([a-zA-Z%]*)\s*")
_ROWS = {
    "d": re.compile(rf"(?:[\s,MmZzLlHhVvCcSsQqTtAa]|{_NUMBER})*"),
    "points": re.compile(rf"(?:[\s,]|{_NUMBER})*"),
}
# Numbers may follow one another without a gap, as in 1.5.5-2; each is taken whole, so that a match takes no time.
_NUMBERS = rf"(?>{_NUMBER})(?:(?:[\s,]+|(?=[+.-]))(?>{_NUMBER}))*"
_TRANSFORM = re.compile(rf"(?:[\s,]*(?:matrix|translate|scale|rotate|skewX|skewY)\s*\(\s*{_NUMBERS}[\s,]*\))*[\s,]*")
_ACROSS = ("x", "width", "cx", "rx", "x1", "x2")
_UP = ("y", "height", "cy", "ry", "y1", "y2")
_MEASURED = ("rect", "circle", "ellipse", "line", "use")
_SHAPES = ("rect", "circle", "ellipse", "line", "use", "svg")
# Drawn only where something uses them, or not at all.
_NO_WALLS = ("metadata", "title", "desc", "style", "script", "namedview", "mask", "marker", "pattern", "clipPath")
_OTHERS = {"text": "texts", "image": "images", "foreignObject": "foreign objects"}
_FIT = re.compile(r"\s*(none|x(Min|Mid|Max)Y(Min|Mid|Max))(?:\s+(meet|slice))?\s*")
_SHARE = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}

Lines = Mapping[ET.Element, int]
"""The line, counted from 1, that each element begins in."""


class Viewport(NamedTuple):
    """Width and height that percentages are of, in units of the drawing."""

    width: float
    height: float


def parse_svg(path: Path) -> tuple[ET.Element, Lines]:
    """The root of a drawing, and the lines of its elements.

    Raises
    ------
    MapError
        If the file cannot be read, is not SVG, declares entities, or is too deep or too long.
    """
    try:
        data = read_bytes(path, _MOST_BYTES)
    except (OSError, ValueError) as error:
        raise MapError(f"cannot be read: {reason(error)}") from error
    if data.startswith(b"\x1f\x8b"):
        raise MapError("it is compressed; save it as plain SVG, or unpack it with gunzip")
    builder, lines, depth = ET.TreeBuilder(), dict[ET.Element, int](), 0
    parser = expat.ParserCreate(namespace_separator="}")
    parser.buffer_text = True

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            raise MapError(f"its elements are nested more than {_DEEPEST} deep")
        if len(lines) >= _MOST_ELEMENTS:
            raise MapError(f"it has more than {_MOST_ELEMENTS} elements")
        element = builder.start(_named(tag), {_named(key): value for key, value in attributes.items()})
        lines[element] = parser.CurrentLineNumber

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(_named(tag))

    def refuse(*_: object) -> None:
        raise MapError("it declares entities, which may unpack to any size; save it as plain SVG")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = builder.data
    parser.EntityDeclHandler = refuse
    try:
        parser.Parse(data, True)
        root: ET.Element = builder.close()
    except expat.ExpatError as error:
        raise MapError(f"line {error.lineno}: this is not XML: {str(error).split(':')[0]}") from error
    except (ValueError, LookupError) as error:
        raise MapError(f"this is not XML: {error}") from error
    if root.tag not in ("svg", f"{_SVG}svg"):
        raise MapError(f"its root is {root.tag[:60]!r}; expected 'svg'")
    return root, lines


def _named(tag: str) -> str:
    return f"{{{tag}" if "}" in tag else tag


def local(element: ET.Element) -> str:
    """An element's name without its namespace."""
    return str(element.tag).rpartition("}")[2]


def length(text: str | None) -> tuple[float, str] | None:
    """The number and the unit of a length, or None if it is none."""
    found = _LENGTH.fullmatch(text or "")
    return None if found is None else (float(found[1]), found[2])


def prepare(root: ET.Element, lines: Lines, viewport: Viewport | None, drawing: Drawing) -> None:
    """Remove and count what is not a wall; turn percentages into lengths, and place inner drawings.

    Raises
    ------
    MapError
        If a path or a row of points does not hold numbers, a length or transform is malformed, a length is a share of
        nothing, or uses unpack to too much.
    """
    _prune(root, drawing)
    _refuse_too_many_uses(root)
    for element in root.iter():
        _check_numbers(element, lines)
        for key, allowed in _ROWS.items():
            text = element.get(key) or ""
            found = allowed.match(text)
            if local(element) in ("path", "polyline", "polygon") and found and found.end() < len(text):
                begin = text[found.end() :][:20]
                raise MapError(f"{_where(element, lines)}: {key} has {begin!r}, where a number was expected")
    _place(root, lines, viewport)


def _check_numbers(element: ET.Element, lines: Lines) -> None:
    """Raise `MapError` for an invalid length or transform: svgelements would leave its shape out."""
    if local(element) in _MEASURED:
        for key in (*_ACROSS, *_UP, "r"):
            text = (element.get(key) or "").strip()
            if text not in ("", "auto") and length(text) is None:
                raise MapError(
                    f"{_where(element, lines)}: {key} is {text[:20]!r}; expected a length, such as 20 or 2e1"
                )
    text = element.get("transform") or ""
    if text.strip() not in ("", "none") and not _TRANSFORM.fullmatch(text):
        raise MapError(
            f"{_where(element, lines)}: transform is {text[:40]!r}; expected such as translate(1,2) rotate(30)"
        )


def _where(element: ET.Element, lines: Lines) -> str:
    name = f" {element.get('id')!r}" if element.get("id") else ""
    return f"line {lines[element]}: {local(element)}{name}"


def _is_hidden(element: ET.Element) -> bool:
    style = (element.get("style") or "").replace(" ", "")
    display, visibility = element.get("display"), element.get("visibility")
    return (
        display == "none"
        or visibility in ("hidden", "collapse")
        or any(word in style for word in ("display:none", "visibility:hidden"))
    )


def _prune(root: ET.Element, drawing: Drawing) -> None:
    named = {element.get("id"): element for element in root.iter() if element.get("id")}
    for parent in list(root.iter()):
        for child in list(parent):
            name = local(child)
            if _is_hidden(child):
                drawing.leave_out("hidden shapes or groups")
            elif name in _OTHERS:
                drawing.leave_out(_OTHERS[name])
            elif name == "use" and _target(child) not in named:
                drawing.leave_out("uses of what is not in the file")
            elif name == "use" and local(symbol := named[_target(child)]) == "symbol" and symbol.get("viewBox"):
                drawing.leave_out("uses of symbols with a size of their own")
            elif name == "symbol" and local(parent) != "defs":
                # Drawn only where it is used.
                at = list(parent).index(child)
                parent.remove(child)
                parent.insert(at, ET.Element(f"{_SVG}defs"))
                parent[at].append(child)
                continue
            elif name not in _NO_WALLS:
                continue
            parent.remove(child)


def _target(use: ET.Element) -> str:
    return (next((use.get(key) for key in _HREFS if use.get(key)), "") or "").removeprefix("#")


def _refuse_too_many_uses(root: ET.Element) -> None:
    """Raise an error if elements that use others, again and again, would expand to too many."""
    named = {element.get("id"): element for element in root.iter() if element.get("id")}
    weights: dict[ET.Element, float] = {}

    def weigh(element: ET.Element, depth: int) -> float:
        if depth > 3 * _DEEPEST:
            raise MapError("it uses an element within itself, or too deep")
        if element not in weights:
            weight = 1.0 + sum(weigh(child, depth + 1) for child in element)
            if local(element) == "use":
                target = named.get(_target(element))
                weight += 0.0 if target is None else weigh(target, depth + 1)
            weights[element] = weight
        return weights[element]

    if weigh(root, 0) > _MOST_ELEMENTS:
        raise MapError(f"it unpacks to more than {_MOST_ELEMENTS} elements, by uses of uses")


def _place(parent: ET.Element, lines: Lines, viewport: Viewport | None) -> None:
    """Resolve percentages within an element, and turn the drawings in it into groups."""
    for child in parent:
        within = viewport
        name = local(child)
        if name in _SHAPES:
            for key in (*_ACROSS, *_UP, "r"):
                share = length(child.get(key))
                if share is None or share[1] != "%":
                    continue
                if viewport is None:
                    raise MapError(f"{_where(child, lines)}: {key} is {share[0]:g} percent of a size that is not given")
                diagonal = math.hypot(*viewport) / math.sqrt(2.0)
                whole = viewport.width if key in _ACROSS else viewport.height if key in _UP else diagonal
                child.set(key, repr(share[0] / 100.0 * whole))
        if name == "svg":
            within = _as_group(child, lines, viewport)
        _place(child, lines, within)


def _as_group(inner: ET.Element, lines: Lines, outer: Viewport | None) -> Viewport | None:
    """Turn a drawing in a drawing into a group with its transform; its own viewport."""
    x, y = (_units(inner, key, 0.0, lines) for key in ("x", "y"))
    sides = [
        _units(inner, key, None if outer is None else outer[number], lines)
        for number, key in enumerate(("width", "height"))
    ]
    box = [number[0] for word in re.split(r"[\s,]+", inner.get("viewBox") or "") if (number := length(word))]
    transform = f"translate({x!r},{y!r})"
    width, height = sides
    within = None if width is None or height is None else Viewport(width, height)
    if len(box) == 4 and box[2] > 0.0 and box[3] > 0.0:
        if within is None:
            raise MapError(f"{_where(inner, lines)}: it has a viewBox, and neither it nor the drawing says its size")
        fit = _FIT.fullmatch(inner.get("preserveAspectRatio") or "") or _FIT.fullmatch("xMidYMid")
        assert fit is not None
        across, up = within.width / box[2], within.height / box[3]
        if fit[1] == "none":
            left = top = 0.0
        else:
            across = up = max(across, up) if fit[4] == "slice" else min(across, up)
            left = _SHARE[fit[2]] * (within.width - across * box[2])
            top = _SHARE[fit[3]] * (within.height - up * box[3])
        transform += f" translate({left!r},{top!r}) scale({across!r},{up!r}) translate({-box[0]!r},{-box[1]!r})"
        within = Viewport(box[2], box[3])
    for key in ("x", "y", "width", "height", "viewBox", "preserveAspectRatio"):
        inner.attrib.pop(key, None)
    inner.tag = f"{_SVG}g"
    own = inner.get("transform")
    inner.set("transform", f"{own} {transform}" if own else transform)
    return within


def _units(element: ET.Element, key: str, default: float | None, lines: Lines) -> float | None:
    """A length in units of the drawing."""
    text = element.get(key)
    if text is None or text.strip() == "auto":
        return default
    found = length(text)
    if found is None or found[1].lower() not in ("", "px"):
        raise MapError(f"{_where(element, lines)}: {key} is {text[:20]!r}; expected a number in a drawing in a drawing")
    return found[0]
