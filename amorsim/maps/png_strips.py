"""Large pictures in PNG files, decoded strip by strip; as a whole, pillow needs 4 bytes for each pixel of colour.

The compressed data are unpacked as a stream, and packed again, uncompressed, into small PNG files of some rows each,
which pillow decodes. A row may be given as its difference from the row above. So each strip but the first begins with
the last row of the strip before it.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple

from PIL import Image

__all__ = ["PngFile", "png_file"]

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {2: 3, 4: 2, 6: 4}  # by the type of colour: RGB, grey and opacity, RGB and opacity
_ANIMATED = (b"acTL", b"fcTL")
_MOST_KEPT = 4096  # bytes of the chunk for the transparent colour; it has 6
_PIECE = 1 << 18  # bytes that are read at a time


class PngFile(NamedTuple):
    """The content of a PNG file before its pixels, and where these begin."""

    width: int
    height: int
    depth_and_colour: bytes
    """The last five bytes of its header."""
    channels: int
    transparency: bytes
    """The chunk with the transparent colour; empty for none."""
    start: int
    """Where its first chunk of pixels begins."""

    def strips(self, file: BinaryIO, rows: int) -> Iterator[tuple[int, Image.Image]]:
        """The number of its first row and the picture of each strip of `rows` rows, from the top.

        Raises
        ------
        OSError, zlib.error
            If the file ends early, or its data are damaged.
        """
        above = b""
        top = 0
        file.seek(self.start)
        length = 1 + self.width * self.channels
        for data in _unpacked(file, rows * length, self.height * length):
            strip = self._strip(above + data, length)
            above = b"\0" + strip.crop((0, strip.height - 1, self.width, strip.height)).tobytes()
            new = strip.crop((0, 1, self.width, strip.height)) if top else strip
            yield top, new
            top += new.height

    def _strip(self, data: bytes, length: int) -> Image.Image:
        """The picture of some rows, each of `length` bytes, as the file holds them."""
        header = struct.pack(">II", self.width, len(data) // length) + self.depth_and_colour
        pixels = _chunk(b"IDAT", zlib.compress(data, 0))
        parts = (_SIGNATURE, *_chunk(b"IHDR", header), self.transparency, *pixels, *_chunk(b"IEND", b""))
        strip = Image.open(io.BytesIO(b"".join(parts)), formats=("PNG",))
        strip.load()
        return strip


def png_file(file: BinaryIO) -> PngFile | None:
    """The content of a PNG file before its pixels, if it can be decoded in strips; None for any other file.

    It can if its pixels have several channels of 8 bits, and if it is neither interlaced nor animated. The file is left
    where it was.
    """
    before = file.tell()
    try:
        return _read(file)
    finally:
        file.seek(before)


def _read(file: BinaryIO) -> PngFile | None:
    file.seek(0)
    if file.read(8) != _SIGNATURE:
        return None
    header, transparency = b"", b""
    while True:
        start = file.tell()
        head = file.read(8)
        if len(head) < 8:
            return None
        length, kind = int.from_bytes(head[:4], "big"), head[4:]
        if kind == b"IDAT":
            break
        if kind in _ANIMATED:
            return None
        if kind in (b"IHDR", b"tRNS"):
            data = file.read(min(length, _MOST_KEPT) + 4)
            if kind == b"IHDR":
                header = data[:-4]
            else:
                transparency = head + data
        else:
            file.seek(length + 4, io.SEEK_CUR)
    if len(header) != 13 or header[8] != 8 or header[9] not in _CHANNELS or header[10:] != b"\0\0\0":
        return None
    width, height = struct.unpack(">II", header[:8])
    return PngFile(width, height, header[8:], _CHANNELS[header[9]], transparency, start)


def _unpacked(file: BinaryIO, size: int, total: int) -> Iterator[bytes]:
    """The first `total` bytes of a file's pixels, unpacked, `size` at a time; the last may be fewer."""
    stream = zlib.decompressobj()
    waiting: list[bytes] = []
    missing = min(size, total)
    for piece in _pieces(file):
        while total > 0:
            waiting.append(stream.decompress(piece, missing))
            piece = stream.unconsumed_tail
            missing -= len(waiting[-1])
            if missing > 0:
                break
            whole = b"".join(waiting)
            waiting.clear()
            yield whole
            total -= len(whole)
            missing = min(size, total)
        if total == 0 and (stream.eof or stream.decompress(piece, 1)):
            return  # the sum at the end is right, or something follows that is not looked at
    if total > 0:
        raise OSError("image file is truncated")


def _pieces(file: BinaryIO) -> Iterator[bytes]:
    """The compressed data from a file's first chunk of pixels on, some at a time."""
    while True:
        head = file.read(8)
        left = int.from_bytes(head[:4], "big")
        if head[4:] != b"IDAT":
            return
        while left > 0:
            piece = file.read(min(left, _PIECE))
            if not piece:
                return
            yield piece
            left -= len(piece)
        file.read(4)  # the sum of the chunk, which pillow does not check either


def _chunk(kind: bytes, data: bytes) -> tuple[bytes, ...]:
    """The parts of a chunk, to be joined."""
    return struct.pack(">I", len(data)), kind, data, struct.pack(">I", zlib.crc32(data, zlib.crc32(kind)))
