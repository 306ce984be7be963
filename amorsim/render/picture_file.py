"""Reading a picture file of a user."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

from PIL import Image, UnidentifiedImageError

from amorsim.core.errors import RunError
from amorsim.core.files.reading import read_bytes, reason

__all__ = ["read_png"]

_MOST_BYTES = 100_000_000
_MOST_PIXELS = 70_000_000  # of 8192 x 8192, the largest that amorsim draws


def read_png(path: Path) -> bytes:
    """The bytes of a file that is a whole PNG.

    Raises
    ------
    RunError
        If it cannot be read, is damaged, no PNG, or has more than 70 million pixels: before they are unpacked.
    """
    try:
        data = read_bytes(path, _MOST_BYTES)
    except (OSError, ValueError) as error:
        raise RunError(f"{path}: cannot be read ({reason(error)})") from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data), formats=["PNG"]) as image:
                width, height = image.size
                if width * height > _MOST_PIXELS:
                    raise RunError(f"{path}: has {width} x {height} pixels; expected {_MOST_PIXELS} at most")
                image.load()
    except RunError:
        raise
    except (Exception, Image.DecompressionBombError) as error:  # pillow raises all kinds of them for broken files
        what = "it is not a PNG" if isinstance(error, UnidentifiedImageError) else f"it is damaged: {error}"
        raise RunError(f"{path}: cannot be read ({what})") from None
    return data
