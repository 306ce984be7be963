"""The table as a picture: a bar for each side, on a scale of powers of ten, with the spread of its rounds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from benchmarks.results import Row
from benchmarks.table import figure

__all__ = ["draw"]

_WIDTH, _LABEL, _BAR, _GAP = 1400, 520, 18, 6
_OURS, _COUNTS, _DOES_NOT, _INK = "#1b7837", "#4575b4", "#b8c6db", "#202020"
_KEY = (
    (_OURS, "amorsim (scales are logarithmic, a white line is a power of ten)"),
    (_COUNTS, "a peer, whose ratio counts"),
    (_DOES_NOT, "a peer, scaled from published figures or not alike"),
)


def draw(rows: Sequence[Row], path: Path, title: str) -> None:
    """Draw rates of the sections ``rays`` and ``fleet`` into a PNG file, where there is more than one side."""
    shown = [row for row in rows if row.rounds and row.section in ("rays", "fleet")]
    # Each setting has a scale of its own, so a bar by itself says nothing.
    shown = [row for row in shown if len(_of(shown, row.section, row.setting)) > 1]
    settings = list(dict.fromkeys((row.section, row.setting) for row in shown))
    height = 110 + sum(34 + (_BAR + _GAP) * len(_of(shown, *setting)) for setting in settings)
    image = Image.new("RGB", (_WIDTH, height), "white")
    pen = ImageDraw.Draw(image)
    large, small = ImageFont.load_default(20), ImageFont.load_default(14)
    pen.text((20, 14), title, fill=_INK, font=large)
    left = 20
    for colour, meaning in _KEY:
        pen.rectangle((left, 52, left + 14, 66), fill=colour)
        pen.text((left + 20, 50), meaning, fill=_INK, font=small)
        left += 60 + round(pen.textlength(meaning, font=small))
    y = 84
    for section, setting in settings:
        group = _of(shown, section, setting)
        pen.text((20, y + 8), f"{setting} [{group[0].unit}]", fill=_INK, font=small)
        y += 30
        values = [value for row in group for value in row.rounds]
        low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)) + 1e-9)
        for row in group:
            _bar(pen, row, y, (low, max(high, low + 1)), small)
            y += _BAR + _GAP
        y += 4
    image.save(path)


def _of(rows: Sequence[Row], section: str, setting: str) -> list[Row]:
    return [row for row in rows if (row.section, row.setting) == (section, setting)]


def _bar(
    pen: ImageDraw.ImageDraw,
    row: Row,
    y: int,
    decades: tuple[int, int],
    font: ImageFont.FreeTypeFont | ImageFont.ImageFont,
) -> None:
    spread = row.spread
    assert spread is not None

    def x(value: float) -> float:
        share = (math.log10(value) - decades[0]) / (decades[1] - decades[0])
        return _LABEL + share * (_WIDTH - _LABEL - 330)

    colour = _OURS if row.side.startswith("amorsim") else _COUNTS if row.ratio and row.ratio.counts else _DOES_NOT
    pen.text((_LABEL - 12, y + _BAR / 2), row.side, fill=_INK, font=font, anchor="rm")
    pen.rectangle((_LABEL, y, max(x(spread.median), _LABEL + 2), y + _BAR), fill=colour)
    middle = y + _BAR / 2
    pen.line((x(spread.low), middle, x(spread.high), middle), fill=_INK, width=2)
    for decade in range(decades[0] + 1, decades[1]):
        if (at := x(10.0**decade)) < x(spread.median):
            pen.line((at, y, at, y + _BAR), fill="white")
    text = figure(spread.median)
    if row.ratio is not None:
        text += f"   amorsim is {row.ratio.spread.median:.3g} x"
    pen.text((max(x(spread.median), x(spread.high)) + 8, middle), text, fill=_INK, font=font, anchor="lm")
