"""Words and lengths in pictures."""

from __future__ import annotations

import functools
import math

from PIL import ImageFont

__all__ = [
    "NOTHING",
    "Font",
    "font",
    "in_words",
    "percent",
    "round_length",
    "rounded",
    "shortened",
    "significant",
    "with_interval",
]

NOTHING = 1e-12
"""Smaller values come from rounding and are written as 0."""

Font = ImageFont.FreeTypeFont | ImageFont.ImageFont


@functools.lru_cache(maxsize=16)
def font(height: float) -> Font:
    """Pillow's own font, of about a height [px]."""
    return ImageFont.load_default(max(8, round(height)))


def round_length(about: float) -> float:
    """The greatest of 1, 2 and 5 times a power of ten that is not more than `about`."""
    power = 10.0 ** math.floor(math.log10(about))
    return max(digit * power for digit in (1, 2, 5) if digit * power <= about * (1 + 1e-9))


def in_words(metres: float) -> str:
    """A length in words: 2 km, 5 m, 20 cm, 1 mm."""
    for unit, size in (("km", 1000.0), ("m", 1.0), ("cm", 0.01)):
        if metres >= size * (1 - 1e-9):
            return f"{metres / size:g} {unit}"
    return f"{metres * 1000:g} mm"


def percent(share: float) -> str:
    """A share in per cent, with one digit; never "-0.0 %"."""
    return f"{round(100.0 * share, 1) + 0.0:.1f} %"


def significant(value: float, digits: int = 4) -> str:
    """A number with some digits that count, without an exponent where it is of usual size; ``-`` for nan."""
    if math.isnan(value):
        return "-"
    if abs(value) < NOTHING or math.isinf(value):
        return f"{value:g}" if math.isinf(value) else "0"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{places}f}" if places <= 9 and abs(value) < 1e7 else f"{value:.{digits - 1}e}"


def rounded(value: float, half_width: float) -> str:
    """A number with as many places as its interval allows: to two digits of half the interval's width.

    Without a width, as `significant`.
    """
    if not (math.isfinite(value) and NOTHING < half_width < math.inf):
        return significant(value)
    places = 1 - math.floor(math.log10(half_width))
    shown = round(value, places) + 0.0  # 0.0 takes the sign from a zero
    if places <= 6 and abs(shown) < 1e7:
        return f"{shown:.{max(0, places)}f}"
    digits = max(0, places + math.floor(math.log10(abs(shown)))) if shown else 0
    return f"{shown:.{digits}e}" if shown else "0"


def with_interval(value: float, low: float, high: float) -> tuple[str, str, str]:
    """A value and the ends of its interval, each as `rounded`; no end that is not 0 is rounded to it."""
    half = 0.5 * (high - low)
    return rounded(value, half), _end(low, half), _end(high, half)


def _end(value: float, half_width: float) -> str:
    text = rounded(value, half_width)
    return significant(value, 1) if math.isfinite(value) and float(text) == 0.0 else text


def shortened(text: str, font: Font, width: float) -> str:
    """The text on one line, its end left out if it is too wide."""
    text = " ".join(text.split())
    if font.getlength(text) <= width:
        return text
    while text and font.getlength(text + "...") > width:
        text = text[:-1]
    return text + "..."
