"""A GIF of the view, of the pictures that the window took."""

from __future__ import annotations

import io
from collections.abc import AsyncIterator

import attrs
from PIL import Image, UnidentifiedImageError

from amorsim.core.errors import AmorsimError

__all__ = ["Film", "FilmError", "gif_of", "read_film"]

MOST_BYTES = 64 * 2**20
MOST_PICTURES = 300
WIDEST = 2000  # [px]


class FilmError(AmorsimError):
    """What a window sent is no film."""


@attrs.frozen(kw_only=True)
class Film:
    """Pictures as PNG, and how long each is seen [ms]."""

    pictures: list[bytes]
    every: int


async def read_film(body: AsyncIterator[bytes], every: str) -> Film:
    """A film of a request's body: pictures, each led by its length in four bytes, little endian."""
    if not (every.isascii() and every.isdigit() and 20 <= int(every) <= 2000):
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
    return Film(pictures=pictures, every=int(every))


def gif_of(film: Film) -> bytes:
    """The film as a GIF; all its pictures share the colours of some of them."""
    size = _picture(film.pictures[0]).size
    palette = _colours(film, size)
    frames = []
    for data in film.pictures:
        picture = _picture(data)
        if picture.size != size:  # the window was made larger meanwhile
            picture = picture.resize(size)
        frames.append(picture.quantize(palette=palette, dither=Image.Dither.NONE))
    made = io.BytesIO()
    frames[0].save(
        made, "GIF", save_all=True, append_images=frames[1:], duration=film.every, loop=0, optimize=False, disposal=1
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


def _picture(data: bytes) -> Image.Image:
    try:
        picture = Image.open(io.BytesIO(data), formats=["PNG"])
        if max(picture.size) > WIDEST:
            raise FilmError(f"a picture is larger than {WIDEST} pixels")
        return picture.convert("RGB")
    except (UnidentifiedImageError, OSError, ValueError) as error:
        raise FilmError(f"a picture cannot be read: {error}") from None
