"""A GIF of the view, of the pictures that the window took."""

from __future__ import annotations

import io
import struct
from collections.abc import AsyncIterator

import attrs
from PIL import Image

from amorsim.core.errors import AmorsimError

__all__ = ["Film", "FilmError", "gif_of", "read_film"]

MOST_BYTES = 64 * 2**20
MOST_PICTURES = 300
MOST_PIXELS = 200e6  # of all pictures together: each takes somewhat more than a byte
WIDEST = 2000  # [px]
_HEAD = struct.Struct(">8s4x4sII")  # of a PNG, up to its size


class FilmError(AmorsimError):
    """Raised for a film that is malformed."""


@attrs.frozen(kw_only=True)
class Film:
    """Pictures as PNG, and how long each is seen [ms]."""

    pictures: list[bytes]
    every: int


async def read_film(body: AsyncIterator[bytes], every: str) -> Film:
    """A film of a request's body: pictures, each led by its length in four bytes, little endian."""
    if not (every.isascii() and every.isdigit() and len(every) <= 4 and 20 <= int(every) <= 2000):
        raise FilmError(f"expected every= from 20 to 2000 [ms], got {every[:20]!r}")
    data = bytearray()
    async for part in body:
        data += part
        if len(data) > MOST_BYTES:
            raise FilmError(f"this film is larger than {MOST_BYTES // 2**20} MB")
    pictures = []
    at = 0
    while at < len(data):
        length = int.from_bytes(data[at : at + 4], "little")
        pictures.append(bytes(data[at + 4 : at + 4 + length]))
        if not length or len(pictures[-1]) < length or len(pictures) > MOST_PICTURES:
            raise FilmError(f"expected at most {MOST_PICTURES} pictures, each led by its length")
        at += 4 + length
    if not pictures:
        raise FilmError("there is no picture in this film")
    areas = [width * height for width, height in map(_size, pictures)]
    pixels = max(sum(areas), len(areas) * areas[0])  # all get the first one's size
    if pixels > MOST_PIXELS:
        raise FilmError(
            f"this film has {pixels / 1e6:.0f} million pixels, at most {MOST_PIXELS / 1e6:.0f} can be made a GIF; make "
            f"it shorter"
        )
    return Film(pictures=pictures, every=int(every))


def gif_of(film: Film) -> bytes:
    """The film as a GIF; all its pictures share the colours of some of them."""
    size = _picture(film.pictures[0]).size
    palette = _colours(film, size)

    def frame(data: bytes) -> Image.Image:
        picture = _picture(data)
        if picture.size != size:  # the window was made larger meanwhile
            picture = picture.resize(size)
        return picture.quantize(palette=palette, dither=Image.Dither.NONE)

    first, *rest = film.pictures
    made = io.BytesIO()
    frame(first).save(
        made,
        "GIF",
        save_all=True,
        append_images=map(frame, rest),  # one after the other: all at once would take as much again
        duration=film.every,
        loop=0,
        optimize=False,
        disposal=1,
    )
    return made.getvalue()


def _colours(film: Film, size: tuple[int, int]) -> Image.Image:
    """128 colours of up to five pictures, spread over the film."""
    last = len(film.pictures) - 1
    chosen = sorted({round(last * part / 4) for part in range(5)})
    strip = Image.new("RGB", (size[0], size[1] * len(chosen)))
    for place, number in enumerate(chosen):
        strip.paste(_picture(film.pictures[number]).resize(size), (0, place * size[1]))
    return strip.quantize(128)


def _size(data: bytes) -> tuple[int, int]:
    """The width and height of a PNG, from its head."""
    try:
        start, kind, width, height = _HEAD.unpack_from(data)
    except struct.error:
        start, kind, width, height = b"", b"", 0, 0
    if start != b"\x89PNG\r\n\x1a\n" or kind != b"IHDR" or not width or not height:
        raise FilmError("a picture is not a PNG")
    if max(width, height) > WIDEST:
        raise FilmError(f"a picture is larger than {WIDEST} pixels")
    return width, height


def _picture(data: bytes) -> Image.Image:
    size = _size(data)
    try:
        picture = Image.open(io.BytesIO(data), formats=["PNG"])
        if picture.size != size:
            raise ValueError("it has two sizes")
        return picture.convert("RGB")
    except Exception as error:  # a damaged picture makes Pillow raise nearly anything
        raise FilmError(f"a picture cannot be read: {error}") from None
