"""Pictures as pillow reads them: decoded within limits, and classified pixel by pixel without unpacking colours."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from amorsim.core.errors import MapError
from amorsim.core.reading import check_readable, reason

__all__ = ["OPAQUE", "SIGNATURES", "Picture", "open_picture"]

FORMATS = ("BMP", "PNG", "PPM", "JPEG", "GIF", "TIFF")
SIGNATURES = (
    *(b"BM", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"GIF87a", b"GIF89a", b"II*\x00", b"MM\x00*"),
    *(b"P%d%c" % (kind, blank) for kind in range(1, 7) for blank in b" \t\r\n"),
)
OPAQUE = 255
# Largest file: the largest picture that pillow unpacks, at four bytes a pixel.
_MOST_BYTES = 800_000_000
# [pixels] that are read together, so that their colours take little memory.
_BAND = 500_000
_GREYS = ("1", "L", "F")
_DEEP = ("I;16", "I;16B", "I;16L", "I;16N", "I")
_CLEAR = ("LA", "La", "PA", "RGBA", "RGBa")

Colours = NDArray[np.uint16]
"""(n, 4): red, green and blue, up to `Picture.white`, and opacity up to `OPAQUE`."""
Rule = Callable[[Colours], NDArray[np.uint8]]
"""Classes (n,) of some colours (n, 4)."""


@attrs.frozen(kw_only=True)
class Picture:
    """A decoded picture. Pixels of one byte or of a deep grey are classified by a table of all that there may be."""

    image: Image.Image
    remarks: tuple[str, ...] = ()

    @property
    def white(self) -> int:
        """The largest value of red, green and blue."""
        return 0xFFFF if self.image.mode in _DEEP else 0xFF

    @property
    def format(self) -> str:
        """Pillow's name of the format."""
        return str(self.image.format)

    @property
    def has_opacity(self) -> bool:
        """Whether pixels may be transparent. A BMP's fourth channel, which few programs fill in, is ignored."""
        is_clear = self.image.mode in _CLEAR or "transparency" in self.image.info
        return is_clear and self.format != "BMP" and self.image.mode not in _DEEP

    def classes(self, rule: Rule, paper: str | None = None) -> NDArray[np.uint8]:
        """What a rule makes of each pixel, (rows, columns), the picture's bottom row first.

        With `paper`, the name of a colour, the rule is given the colours as they look on it, all opaque.
        """
        height = self.image.height
        out = np.empty((height, self.image.width), dtype=np.uint8)
        table = self._table(paper)
        made = None if table is None else rule(table)
        for top, band in self._bands():
            found = rule(self._colours(band, paper)) if made is None else made[_values(band)]
            rows = found.reshape(-1, self.image.width)
            out[height - top - len(rows) : height - top] = rows[::-1]
        return out

    def colours(self, paper: str) -> Colours:
        """The different colours (n, 4) on paper of that colour, in ascending order."""
        table = self._table(paper)
        if table is not None:
            used = np.zeros(len(table), np.bool_)
            for _, band in self._bands():
                used[_values(band)] = True
            return np.unique(table[used], axis=0)
        used = np.zeros(1 << 24, np.bool_)
        for _, band in self._bands():
            red, green, blue, _ = (channel.astype(np.uint32) for channel in self._colours(band, paper).T)
            used[(red << 16) | (green << 8) | blue] = True
        codes = np.flatnonzero(used)
        parts = (codes >> 16, (codes >> 8) & 0xFF, codes & 0xFF, np.full(len(codes), OPAQUE))
        return np.stack(parts, axis=-1).astype(np.uint16)

    def _bands(self) -> Iterator[tuple[int, Image.Image]]:
        """The number of the first row, and some rows, from the top."""
        width, height = self.image.size
        rows = max(1, _BAND // width)
        for top in range(0, height, rows):
            yield top, self.image.crop((0, top, width, min(top + rows, height)))

    def _table(self, paper: str | None) -> Colours | None:
        """The colour (n, 4) of every value that a pixel of one channel may have; None for more channels."""
        if self.image.mode in _DEEP:
            grey = np.arange(0x10000, dtype=np.uint16)
            return np.stack((grey, grey, grey, np.full_like(grey, OPAQUE)), axis=-1)
        if self.image.mode not in (*_GREYS, "P"):
            return None
        every = Image.frombytes("L" if self.image.mode in _GREYS else "P", (256, 1), bytes(range(256)))
        every.info = dict(self.image.info)
        if self.image.mode == "P" and self.image.palette is not None:
            mode = self.image.palette.mode
            every.putpalette(self.image.getpalette(mode) or [], mode)
        return self._colours(every, paper)

    def _colours(self, image: Image.Image, paper: str | None) -> Colours:
        if not self.has_opacity:
            colours = image.convert("RGB").convert("RGBA")
        else:
            colours = image.convert("RGBA")
            if paper is not None:
                colours = Image.alpha_composite(Image.new("RGBA", image.size, paper), colours)
        return np.asarray(colours).reshape(-1, 4).astype(np.uint16)


def _values(image: Image.Image) -> NDArray[Any]:
    """The values of pixels of one channel, as `Picture._table` counts them."""
    if image.mode in _DEEP:
        return np.asarray(image).clip(0, 0xFFFF).astype(np.uint16).ravel()
    return np.asarray(image if image.mode in ("L", "P") else image.convert("L")).ravel()


def open_picture(path: Path) -> Picture:
    """The picture in a file, wholly read.

    Raises
    ------
    MapError
        If the file cannot be read, is no picture or a damaged one, or has too many pixels; that is found out
        before any is unpacked. The message does not name the file.
    """
    try:
        check_readable(path, _MOST_BYTES)
        file = path.open("rb")
    except (OSError, ValueError) as error:
        raise MapError(f"cannot be read: {reason(error)}") from error
    try:
        with file, warnings.catch_warnings():
            # Up to twice the number of pixels that pillow warns of, which takes 720 MB at the most, it unpacks them.
            warnings.filterwarnings("ignore", category=Image.DecompressionBombWarning)
            warnings.filterwarnings("ignore", category=UserWarning, module="PIL")
            image = Image.open(file, formats=FORMATS)
            frames = getattr(image, "n_frames", 1)
            image.load()
    except Image.DecompressionBombError as error:
        most = 2 * (Image.MAX_IMAGE_PIXELS or 0)
        problem = f"expected {most} pixels at most; make it smaller, or the map of larger cells (resolution)"
        raise MapError(f"it is too large to unpack: {problem}") from error
    except UnidentifiedImageError as error:  # its text names the file object, which does not help a user
        raise MapError(f"it is no {_formats()} image, or its header is damaged") from error
    except Exception as error:  # a damaged file makes pillow raise nearly anything
        raise MapError(f"it is no whole {_formats()} image: {error}") from error
    if 0 in image.size:
        raise MapError(f"its size is {image.size[0]} x {image.size[1]} pixels: there is nothing in it")
    remark = (f"only the first of its {frames} pictures is read",) if frames > 1 else ()
    return Picture(image=image, remarks=remark)


def _formats() -> str:
    names = ["PNM" if name == "PPM" else name for name in FORMATS]
    return f"{', '.join(names[:-1])} or {names[-1]}"
