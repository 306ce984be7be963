"""Bitmaps (``.bmp``, ``.png``) as maps: dark pixels are occupied."""

from __future__ import annotations

import io
import struct
import warnings
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError
from amorsim.core.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.reading import read_bytes, reason

__all__ = ["Bitmap"]

# Largest file: the largest image that pillow unpacks, at four bytes a pixel.
_MOST_BYTES = 800_000_000
_SIGNATURES = (b"BM", b"\x89PNG\r\n\x1a\n")
# [pixels] that are read together.
_BAND = 1_000_000
# Rec. 601 luma in thousandths; integers, so that comparing the brightness of two colours is exact.
_LUMA = (299, 587, 114)
# Errors that pillow can raise for broken files; its documented UnidentifiedImageError is an OSError.
_BROKEN = (OSError, SyntaxError, ValueError, EOFError, IndexError, KeyError, TypeError, OverflowError)
_BROKEN_INSIDE = (struct.error, zlib.error, MemoryError)


_RESOLUTION = 0.05  # [m]
_NO_RESOLUTION = (
    f"no resolution is given, so a pixel is taken for {_RESOLUTION:g} m; say how large one is, as in resolution = 0.02"
)


@attrs.frozen(kw_only=True)
class Bitmap(MapLoader):
    """Bitmaps (``.bmp``, ``.png``) of two colours, the darker one occupied, or of any with a `threshold`.

    An image of one colour is all occupied if that is darker than mid grey, else all free. Transparent parts of a
    PNG count as white, as on paper. A BMP's fourth channel, which few programs fill in, is ignored.
    """

    extensions: ClassVar[tuple[str, ...]] = (".bmp", ".png")

    resolution: float | None = parameter(None, unit="m", gt=0, help="side of a pixel; without it 0.05, with a warning")
    origin_x: float = parameter(0.0, unit="m", help="x of the lower left corner of the lower left pixel")
    origin_y: float = parameter(0.0, unit="m", help="y of the lower left corner of the lower left pixel")
    origin_yaw: float = parameter(0.0, unit="rad", help="turn of the image about that corner")
    threshold: float | None = parameter(
        None, ge=0, le=1, help="greys below it are occupied, 0 black, 1 white; any image will do then"
    )

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file's first bytes are the signature of one of the formats."""
        return head.startswith(_SIGNATURES)

    def load(self, path: Path) -> Map:
        """The map of an image file.

        Raises
        ------
        MapError
            If the file cannot be read, is damaged or too large, or has more than two colours and no
            `threshold` is given.
        """
        try:
            data = read_bytes(path, _MOST_BYTES)
        except (OSError, ValueError) as error:
            raise MapError(f"{path}: cannot be read: {reason(error)}") from error
        try:
            occupied = self._occupied(_decode(data))
            return Map.from_array(
                # An image's first row is its top one, a map's is its bottom one.
                np.ascontiguousarray(occupied[::-1]),
                resolution=_RESOLUTION if self.resolution is None else self.resolution,
                origin=(self.origin_x, self.origin_y, self.origin_yaw),
                warnings=() if self.resolution is not None else (_NO_RESOLUTION,),
                name=path.stem,
            )
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    @classmethod
    def save(cls, world: Map, path: Path) -> Bitmap:
        """Write a map's cells, black where they are occupied; see `amorsim.save_map`."""
        occupied = world.to_array()[::-1]
        Image.fromarray(np.where(occupied, 0, 255).astype(np.uint8)).convert("1").save(path)
        x, y, yaw = world.origin
        return cls(resolution=world.resolution, origin_x=x, origin_y=y, origin_yaw=yaw)

    def _occupied(self, image: Image.Image) -> NDArray[np.bool_]:
        """Which pixels are occupied, (rows, columns) from the top."""
        occupied = np.empty((image.height, image.width), dtype=np.bool_)
        if self.threshold is not None:
            for top, pixels, white in _bands(image):
                occupied[top : top + len(pixels)] = _luma(pixels) < self.threshold * white * sum(_LUMA)
            return occupied
        colours, white = _colours(image)
        luma = _luma(colours)
        if len(colours) == 1:
            occupied[:] = 2 * luma[0] < white * sum(_LUMA)
            return occupied
        if len(colours) > 2:
            raise MapError(
                f"it has {len(colours)} colours, and a bitmap map has two, the darker one occupied; pass "
                "threshold= (0 to 1, 0.5 for mid grey) to take every pixel darker than that for occupied"
            )
        if luma[0] == luma[1]:
            raise MapError("its two colours are equally bright, so neither is the darker, occupied one; make one black")
        darker = colours[int(np.argmin(luma))]
        for top, pixels, _ in _bands(image):
            occupied[top : top + len(pixels)] = np.all(pixels == darker, axis=-1)
        return occupied


def _decode(data: bytes) -> Image.Image:
    """The image of a file's bytes, wholly read."""
    try:
        with warnings.catch_warnings():
            # Pillow only warns of an image up to twice its limit, and a file of a few kB may unpack to that size.
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            warnings.filterwarnings("ignore", category=UserWarning, module="PIL")
            image = Image.open(io.BytesIO(data), formats=("BMP", "PNG"))
            image.load()
    except (Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        raise MapError(f"it is too large to unpack: {error}") from error
    except UnidentifiedImageError as error:  # its text names the buffer, which does not help a user
        raise MapError("it is no BMP or PNG image, or its header is damaged") from error
    except (*_BROKEN, *_BROKEN_INSIDE) as error:
        raise MapError(f"it is no whole BMP or PNG image: {error}") from error
    if 0 in image.size:
        raise MapError(f"its size is {image.size[0]} x {image.size[1]} pixels: there is nothing in it")
    return image


def _bands(image: Image.Image) -> Iterator[tuple[int, NDArray[Any], int]]:
    """Bands of a few rows of an image, which save memory: number of the first row, and the result of `_pixels`."""
    is_bmp = image.format == "BMP"
    rows = max(1, _BAND // image.width)
    for top in range(0, image.height, rows):
        band = image.crop((0, top, image.width, min(top + rows, image.height)))
        yield top, *_pixels(band, is_bmp)


def _pixels(image: Image.Image, is_bmp: bool) -> tuple[NDArray[Any], int]:
    """Unsigned values (rows, columns, 1 or 3) of grey or of red, green and blue; and the value of white."""
    if image.mode in ("I;16", "I;16B", "I;16L", "I;16N", "I"):
        return np.asarray(image).astype(np.uint16)[..., np.newaxis], 0xFFFF
    is_transparent = image.mode in ("LA", "La", "PA", "RGBA", "RGBa") or "transparency" in image.info
    if is_transparent and not is_bmp:
        colours = image.convert("RGBA")
        paper = Image.new("RGBA", image.size, "white")
        return np.asarray(Image.alpha_composite(paper, colours).convert("RGB")), 0xFF
    if image.mode in ("1", "L"):
        return np.asarray(image.convert("L"))[..., np.newaxis], 0xFF
    return np.asarray(image.convert("RGB")), 0xFF


def _colours(image: Image.Image) -> tuple[NDArray[Any], int]:
    """The different colours (colours, channels), found by a table instead of sorting; and the value of white."""
    used = np.zeros(0, np.bool_)
    for _, pixels, white in _bands(image):
        channels = pixels.shape[-1]
        if not len(used):
            used = np.zeros(white + 1 if channels == 1 else 1 << 24, np.bool_)
        if channels == 1:
            used[pixels.ravel()] = True
        else:
            red, green, blue = (pixels[..., channel].astype(np.uint32) for channel in range(3))
            used[(red << 16) | (green << 8) | blue] = True
    codes = np.flatnonzero(used)
    parts = (codes,) if channels == 1 else (codes >> 16, (codes >> 8) & 0xFF, codes & 0xFF)
    return np.stack(parts, axis=-1).astype(pixels.dtype), white


def _luma(pixels: NDArray[Any]) -> NDArray[np.int32]:
    """Brightness in thousandths of a channel's step; the last axis, that of channels, is removed."""
    if pixels.shape[-1] == 1:
        return pixels[..., 0].astype(np.int32) * sum(_LUMA)
    red, green, blue = (pixels[..., channel].astype(np.int32) * _LUMA[channel] for channel in range(3))
    return np.asarray(red + green + blue)
