"""Pictures as pillow reads them: decoded within limits, and classified band by band without unpacking all colours."""

from __future__ import annotations

import contextlib
import functools
import re
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, UnidentifiedImageError

from amorsim.array_types import AnyArray, Ints
from amorsim.core.errors import MapError
from amorsim.core.files.reading import check_readable, reason
from amorsim.core.maps.map import Map
from amorsim.maps.png_strips import PngFile, png_file

__all__ = ["OPAQUE", "SIGNATURES", "Picture", "open_picture", "refuse_too_many_pixels"]

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
# [pixels] of several channels from which on a picture is decoded in strips where it can be: 16 MB as a whole.
_IN_STRIPS = 4_000_000
_MOST_NUMBERED = 256  # colours that a byte can number
_GREYS = ("1", "L", "F")
_DEEP = ("I;16", "I;16B", "I;16L", "I;16N", "I")
_CLEAR = ("LA", "La", "PA", "RGBA", "RGBa")

Colours = NDArray[np.uint16]
"""(n, 4): red, green and blue, up to `Picture.white`, and opacity up to `OPAQUE`."""
Rule = Callable[[Colours], NDArray[np.uint8]]
"""Classes (n,) of some colours (n, 4)."""


@attrs.frozen(kw_only=True)
class Picture:
    """A picture. Pixels of one byte or of a deep grey are classified by a table of all possible values."""

    image: Image.Image
    remarks: tuple[str, ...] = ()
    strips: Callable[[int], Iterator[tuple[int, Image.Image]]] | None = None
    """Reads the pixels of a picture that is too large to be held decoded, so many rows at a time; else None."""

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
        """Whether pixels may be transparent. A BMP's fourth channel, which few programs set, is ignored."""
        is_clear = self.image.mode in _CLEAR or "transparency" in self.image.info
        return is_clear and self.format != "BMP" and self.image.mode not in _DEEP

    def classes(self, rule: Rule, paper: str | None = None) -> NDArray[np.uint8]:
        """The class of each pixel by a rule, (rows, columns), the picture's bottom row first.

        With `paper`, the name of a colour, the rule is given the colours as they look on it, all opaque.
        """
        height = self.image.height
        out = np.empty((height, self.image.width), dtype=np.uint8)
        table = self._table(paper)
        made = None if table is None else rule(table)
        for top, band in self._bands():
            found = self._by_runs(band, rule, paper) if made is None else _looked_up(made, band)
            rows = found.reshape(-1, self.image.width)
            out[height - top - len(rows) : height - top] = rows[::-1]
        return out

    def colours(self, paper: str) -> Colours:
        """The different colours (n, 4) on paper of that colour."""
        table = self._table(paper)
        if table is not None:
            used = np.zeros(len(table), np.bool_)
            for _, band in self._bands():
                used[_values(band)] = True
            return np.unique(table[used], axis=0)
        return self._numbered(paper)[0]

    def classes_by(self, choose: Callable[[Colours], Rule], paper: str) -> NDArray[np.uint8]:
        """The class of each pixel on paper, by the rule that is chosen from all different colours; see `classes`."""
        if self._table(paper) is not None:
            return self.classes(choose(self.colours(paper)), paper)
        colours, numbers = self._numbered(paper)
        rule = choose(colours)
        if len(colours) > _MOST_NUMBERED:
            del numbers
            return self.classes(rule, paper)
        made = np.zeros(256, np.uint8)
        made[: len(colours)] = rule(colours)
        flat = numbers.reshape(-1)
        for first in range(0, len(flat), _BAND):  # not row by row: a picture may be a few pixels wide
            flat[first : first + _BAND] = _entries(made, flat[first : first + _BAND])
        return numbers

    def _numbered(self, paper: str) -> tuple[Colours, NDArray[np.uint8]]:
        """The different colours, and the number of each pixel's, (rows, columns), the picture's bottom row first.

        Of more than 256 colours only the first have numbers. The pixels are read once, as to decode them takes longer
        than all else.
        """
        height, width = self.image.height, self.image.width
        number_of = np.full(1 << 24, -1, np.int16)
        found: list[NDArray[np.uint32]] = []
        out = np.empty((height, width), np.uint8)
        count = 0
        for top, band in self._bands():
            pixels = _pixels(self._rgba(band))
            starts, lengths = _runs(pixels)
            red, green, blue, _ = self._on_paper(pixels[starts], paper).T.astype(np.uint32)
            codes = (red << 16) | (green << 8) | blue
            if (new := np.unique(codes[number_of[codes] < 0])).size:
                number_of[new] = np.minimum(np.arange(count, count + len(new)), _MOST_NUMBERED)
                found.append(new)
                count += len(new)
            if count <= _MOST_NUMBERED:
                rows = np.repeat(number_of[codes].astype(np.uint8), lengths).reshape(-1, width)
                out[height - top - len(rows) : height - top] = rows[::-1]
        every = np.concatenate(found)
        parts = (every >> 16, (every >> 8) & 0xFF, every & 0xFF, np.full(len(every), OPAQUE))
        return np.stack(parts, axis=-1).astype(np.uint16), out

    def _by_runs(self, band: Image.Image, rule: Rule, paper: str | None) -> NDArray[np.uint8]:
        """The class of each pixel of a band by a rule; neighbours of one colour are classified once."""
        pixels = _pixels(self._rgba(band))
        starts, lengths = _runs(pixels)
        return np.repeat(rule(self._on_paper(pixels[starts], paper)), lengths)

    def _bands(self) -> Iterator[tuple[int, Image.Image]]:
        """The number of the first row, and some rows, from the top."""
        width, height = self.image.size
        rows = max(1, _BAND // width)
        if self.strips is not None:
            yield from self.strips(rows)
            return
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
        return self._on_paper(_pixels(self._rgba(every)), paper)

    def _rgba(self, image: Image.Image) -> Image.Image:
        if not self.has_opacity and image.mode != "RGB":
            image = image.convert("RGB")
        return image.convert("RGBA")

    def _on_paper(self, pixels: NDArray[np.uint32], paper: str | None) -> Colours:
        """The colours (n, 4) of some pixels, on paper if its colour is given."""
        colours = pixels.view(np.uint8).reshape(-1, 4)
        if paper is not None and self.has_opacity:
            image = Image.fromarray(colours[np.newaxis], "RGBA")
            colours = np.asarray(Image.alpha_composite(Image.new("RGBA", image.size, paper), image)).reshape(-1, 4)
        return colours.astype(np.uint16)


def _pixels(image: Image.Image) -> NDArray[np.uint32]:
    """The pixels (n,) of an RGBA picture, the four bytes of each as one number."""
    return np.asarray(image).reshape(-1).view(np.uint32)


def _runs(pixels: NDArray[np.uint32]) -> tuple[Ints, Ints]:
    """Where runs of equal pixels begin, and how long they are."""
    starts = np.flatnonzero(np.concatenate(([True], pixels[1:] != pixels[:-1])))
    return starts, np.diff(starts, append=len(pixels))


def _values(image: Image.Image) -> AnyArray:
    """The values of pixels of one channel, as indices into `Picture._table`."""
    if image.mode in _DEEP:
        return np.asarray(image).clip(0, 0xFFFF).astype(np.uint16).ravel()
    return np.asarray(image if image.mode in ("L", "P") else image.convert("L")).ravel()


def _looked_up(table: NDArray[np.uint8], band: Image.Image) -> NDArray[np.uint8]:
    """The entry of a table for each pixel of one channel."""
    values = _values(band)
    return _entries(table, values) if values.dtype == np.uint8 else table[values]


def _entries(table: NDArray[np.uint8], values: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The entry of a table of 256 for each value, in half the time that NumPy takes."""
    return np.frombuffer(values.tobytes().translate(table.tobytes()), np.uint8)


def open_picture(path: Path) -> Picture:
    """The picture in a file, wholly read.

    Raises
    ------
    MapError
        If the file cannot be read, is not a picture or is damaged, or has too many pixels; that is found out
        before any is unpacked. The message does not name the file.
    """
    try:
        check_readable(path, _MOST_BYTES)
        file = path.open("rb")
    except (OSError, ValueError) as error:
        raise MapError(f"cannot be read: {reason(error)}") from error
    with file, _complaints(), warnings.catch_warnings():
        # Up to twice the number of pixels that pillow warns of, which takes at most 720 MB, it unpacks them.
        warnings.filterwarnings("ignore", category=Image.DecompressionBombWarning)
        warnings.filterwarnings("ignore", category=UserWarning, module="PIL")
        image = Image.open(file, formats=FORMATS)
        frames = getattr(image, "n_frames", 1)
        remarks = tuple(_ignored(image, frames))
        png = png_file(file) if image.width * image.height >= _IN_STRIPS else None
        if png is None:
            image.load()
    if 0 in image.size:
        raise MapError(f"its size is {image.size[0]} x {image.size[1]} pixels: there is nothing in it")
    strips = None if png is None else functools.partial(_strips, path, png)
    return Picture(image=image, remarks=remarks, strips=strips)


def refuse_too_many_pixels(world: Map) -> None:
    """Raise `MapError` if a map has more cells than a picture may have pixels that `open_picture` reads."""
    rows, columns = world.shape
    if Image.MAX_IMAGE_PIXELS is not None and rows * columns > _most_pixels():
        raise MapError(
            f"its cells of {world.resolution:g} m would be a picture of {columns} x {rows} pixels; expected "
            f"{_most_pixels()} pixels at most, so take larger cells (resolution)"
        )


def _most_pixels() -> int:
    return 2 * (Image.MAX_IMAGE_PIXELS or 0)


def _ignored(image: Image.Image, frames: int) -> Iterator[str]:
    """The parts of an opened file that are not looked at."""
    if frames > 1:
        yield f"only the first of its {frames} pictures is read"
    turn = 1
    if "exif" in image.info:
        with contextlib.suppress(Exception):  # damaged EXIF data make pillow raise nearly anything
            turn = image.getexif().get(ExifTags.Base.Orientation, 1)
    if turn != 1:
        yield f"its EXIF orientation ({turn}) is ignored: the first row of the file is the top; turn the picture itself"


def _strips(path: Path, png: PngFile, rows: int) -> Iterator[tuple[int, Image.Image]]:
    """The strips of a PNG file, so many rows each; like `open_picture`, it raises nothing but `MapError`."""
    with _complaints(), path.open("rb") as file:
        yield from png.strips(file, rows)


@contextlib.contextmanager
def _complaints() -> Iterator[None]:
    """A block in which errors of pillow and zlib about a file become errors of maps."""
    try:
        yield
    except Image.DecompressionBombError as error:
        # Its text has the number, which is known only there.
        found = re.search(r"\d+", str(error))
        raise MapError(
            f"it is too large to unpack, with {found[0] if found else 'too many'} pixels: expected {_most_pixels()} at "
            "most; make the picture smaller"
        ) from error
    except UnidentifiedImageError as error:  # its text names the file object, which does not help a user
        raise MapError(f"it is not a {_formats()} image, or its header is damaged") from error
    except Exception as error:  # a damaged file makes pillow raise nearly anything
        raise MapError(f"it is not a whole {_formats()} image: {error}") from error


def _formats() -> str:
    names = ["PNM" if name == "PPM" else name for name in FORMATS]
    return f"{', '.join(names[:-1])} or {names[-1]}"
