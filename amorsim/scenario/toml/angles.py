"""Angles: degrees in files, radians in Python, and there and back to the same bits.

Not every double in radians is the image of a double in degrees (the factor between them thins some ranges
out), so degrees that are written may have more digits than a double holds, and are then converted from their
digits.
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

__all__ = ["LongDegrees", "parse_float", "to_degrees", "to_radians"]

# 60 digits of pi: with them a product of 40 digits rounds to the nearest double.
_PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")
_DIGITS = 40
# 17 digits distinguish a double from its neighbours; three more leave no doubt which radians are meant.
_WRITTEN_DIGITS = 20


class LongDegrees(float):
    """A number whose text in the file has more digits than a double holds."""

    text: str

    def __new__(cls, text: str) -> LongDegrees:
        """The number that the text is nearest to, with the text kept."""
        made = super().__new__(cls, text)
        made.text = text
        return made

    def __getnewargs__(self) -> tuple[str]:  # type: ignore[override]
        return (self.text,)


def parse_float(text: str) -> float:
    """The number of a text in TOML; a `LongDegrees` if it has more digits than a double holds."""
    plain = text.replace("_", "")
    number = float(plain)
    if not math.isfinite(number) or Decimal(repr(number)) == Decimal(plain):
        return number
    return LongDegrees(plain)


def to_radians(degrees: float) -> float:
    """Radians of an angle given in degrees."""
    if isinstance(degrees, LongDegrees):
        with localcontext() as context:
            context.prec = _DIGITS
            return float(Decimal(degrees.text) * _PI / 180)
    return math.radians(degrees)


def to_degrees(radians: float) -> float:
    """The shortest number of degrees from which `to_radians` makes exactly this angle."""
    nearest = math.degrees(radians)
    below, above = math.nextafter(nearest, -math.inf), math.nextafter(nearest, math.inf)
    rounded = (float(f"{nearest:.{digits}g}") for digits in (15, 16))
    fitting = [degrees for degrees in (*rounded, nearest, below, above) if math.radians(degrees) == radians]
    if fitting:
        return min(fitting, key=lambda degrees: len(repr(degrees)))
    with localcontext() as context:
        context.prec = _DIGITS
        exact = Decimal(radians) * 180 / _PI
        context.prec = _WRITTEN_DIGITS
        text = f"{+exact:f}"
    return LongDegrees(text if "." in text else text + ".0")
