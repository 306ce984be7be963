"""A GIF of the pictures that a window took."""

from __future__ import annotations

import contextlib
import io
import random
from collections.abc import AsyncIterator

import pytest
from PIL import Image

from amorsim.ui.serve import gif
from amorsim.ui.serve.gif import FilmError, gif_of, read_film
from tests.ui.aside import aside


def png(colour: tuple[int, int, int], size: tuple[int, int] = (40, 30)) -> bytes:
    out = io.BytesIO()
    Image.new("RGB", size, colour).save(out, "PNG")
    return out.getvalue()


def sized(width: int, height: int) -> bytes:
    """A picture whose head says that it is so large."""
    whole = png((0, 0, 0))
    return whole[:16] + width.to_bytes(4, "big") + height.to_bytes(4, "big") + whole[24:]


def packed(*pictures: bytes) -> bytes:
    return b"".join(len(picture).to_bytes(4, "little") + picture for picture in pictures)


def read(data: bytes, every: str = "100") -> gif.Film:
    async def body() -> AsyncIterator[bytes]:
        for at in range(0, len(data), 7):
            yield data[at : at + 7]

    return aside(read_film(body(), every))


def test_a_film_becomes_a_gif_of_as_many_pictures() -> None:
    made = gif_of(read(packed(png((255, 0, 0)), png((255, 0, 0), (80, 60)), png((0, 0, 255)))))
    with Image.open(io.BytesIO(made)) as gif:
        assert gif.format == "GIF"
        assert gif.size == (40, 30)
        seen = []
        for number in range(gif.n_frames):
            gif.seek(number)
            seen.append((gif.info["duration"], gif.convert("RGB").getpixel((5, 5))))
        # Equal neighbours are one, seen as long as both.
        assert seen == [(200, (255, 0, 0)), (100, (0, 0, 255))]


@pytest.mark.parametrize(
    ("data", "every"),
    [
        (b"", "100"),
        (b"\x01", "100"),
        (packed(b"")[:4], "100"),
        (packed(png((0, 0, 0)))[:-1], "100"),
        (packed(png((0, 0, 0))), "5"),
        (packed(png((0, 0, 0))), "-100"),
        (packed(png((0, 0, 0))), "1e3"),
        (packed(png((0, 0, 0))), "1" * 5000),
        (packed(png((0, 0, 0))), "٣٠٠"),
        (packed(b"no png"), "100"),
        (packed(png((0, 0, 0))[:20]), "100"),
        (packed(b"GIF89a" + png((0, 0, 0))[6:]), "100"),
        (packed(sized(0, 5)), "100"),
        (packed(sized(gif.WIDEST + 1, 1)), "100"),
        (packed(sized(2**32 - 1, 2**32 - 1)), "100"),
        (packed(*[b"x"] * (gif.MOST_PICTURES + 1)), "100"),
    ],
)
def test_what_is_no_film_is_refused(data: bytes, every: str) -> None:
    with pytest.raises(FilmError):
        read(data, every)


def test_a_film_that_is_too_large_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gif, "MOST_BYTES", 1000)
    with pytest.raises(FilmError, match="larger"):
        read(bytes(2000))


def test_only_png_of_a_sane_size_is_read() -> None:
    out = io.BytesIO()
    Image.new("RGB", (4, 4)).save(out, "TIFF")
    with pytest.raises(FilmError, match="not a PNG"):
        read(packed(out.getvalue()))
    with pytest.raises(FilmError, match="larger"):
        read(packed(png((0, 0, 0), (gif.WIDEST + 1, 1))))


def test_films_of_too_many_pixels_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gif, "MOST_PIXELS", 40 * 30 * 2.5)
    one, small = png((0, 0, 0)), png((0, 0, 0), (1, 1))
    assert len(read(packed(one, one)).pictures) == 2
    with pytest.raises(FilmError, match=r"million pixels.*make it shorter"):
        read(packed(one, one, one))
    with pytest.raises(FilmError, match="million pixels"):  # for those after the first become as large
        read(packed(one, small, small))


@pytest.mark.parametrize("seed", range(150))
def test_a_damaged_picture_is_a_film_error_or_a_gif(seed: int) -> None:
    choose = random.Random(seed)
    data = bytearray(png((10, 200, 30)))
    for _ in range(choose.randint(1, 6)):
        data[choose.randrange(16, len(data))] = choose.randrange(256)
    if choose.random() < 0.3:
        del data[choose.randrange(24, len(data)) :]
    with contextlib.suppress(FilmError):
        gif_of(read(packed(bytes(data))))
