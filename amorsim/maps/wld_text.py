"""Line worlds as their authors wrote them: walls are drawn, moved and deleted in the text, and the rest stays."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence

from amorsim.core.numbers import millimetres
from amorsim.maps.wld_statements import WallLine, direction, parse_world

__all__ = ["with_walls"]

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+\Z")
_FOUR = re.compile(r"(\s*)\S+\s+\S+\s+\S+\s+\S+(.*)", re.DOTALL)
_DIGITS = 4  # of a millimetre, in a frame that is turned

Wall = Sequence[float]


def with_walls(
    text: str,
    *,
    add: Iterable[Wall] = (),
    change: Mapping[int, Wall] | None = None,
    remove: Collection[int] = (),
    push_sign: str = "clockwise",
) -> str:
    """The text of a line world with other walls; lines about other things keep every byte.

    Parameters
    ----------
    add
        New walls, ``x1, y1, x2, y2`` [m] in the world; they are written at the end, outside of all frames.
    change, remove
        Walls by their number in `parse_world`'s `segments`.

    Raises
    ------
    MapError
        If the text is not a line world, or would not be one.
    """
    mark = "\N{BOM}" if text.startswith("\N{BOM}") else ""
    text = text.removeprefix(mark)
    world = parse_world(text, push_sign=push_sign)
    lines = _LINE.findall(text)
    end = next((re.search(r"[\r\n]+\Z", line)[0] for line in lines if line[-1] in "\r\n"), "\n")  # type: ignore[index]
    end = "\r\n" if "\r\n" in end else end[:1]
    others = change or {}
    of_line: dict[int, list[int]] = {}
    for number, wall in enumerate(world.lines):
        of_line.setdefault(wall.line, []).append(number)
    for line in {world.lines[number].line for number in (*others, *remove)}:
        kept = [number for number in of_line[line] if number not in remove]
        walls = [others.get(number, world.segments[number].tolist()) for number in kept]
        lines[line - 1] = _rewritten(lines[line - 1], world.lines[of_line[line][0]], walls, end)
    new = [" ".join(map(millimetres, wall)) + end for wall in add]
    if new:
        at = min(world.outside, len(lines))
        if at and lines[at - 1] and lines[at - 1][-1] not in "\r\n":
            lines[at - 1] += end
        lines[at:at] = new
    found = mark + "".join(lines)
    parse_world(found.removeprefix(mark), push_sign=push_sign)
    return found


def _rewritten(line: str, where: WallLine, walls: Sequence[Wall], end: str) -> str:
    """A line for these walls in place of its own."""
    texts = [" ".join(_in_frame(wall, where.frame)) for wall in walls]
    four = _FOUR.fullmatch(line)
    if where.is_plain and len(texts) == 1 and four is not None:
        return f"{four[1]}{texts[0]}{four[2]}"
    return "".join(words + end for words in texts)


def _in_frame(wall: Wall, frame: tuple[float, float, float]) -> list[str]:
    """The numbers [mm] of a wall [m] in a frame."""
    if frame == (0.0, 0.0, 0.0):
        return [millimetres(value) for value in wall]
    left, bottom, degrees = frame
    cosine, sine = direction(degrees)
    numbers: list[float] = []
    for x, y in (wall[:2], wall[2:]):
        across, up = x * 1000 - left, y * 1000 - bottom
        numbers += [across * cosine + up * sine, up * cosine - across * sine]
    return [repr(round(number, _DIGITS) + 0.0).removesuffix(".0") for number in numbers]
