"""Large PNG pictures decoded in strips: the same pixels as decoded whole, and errors of damaged files."""

from __future__ import annotations

import io
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from amorsim.core.errors import MapError
from amorsim.maps import pictures
from amorsim.maps.bmp import Bitmap
from amorsim.maps.pictures import OPAQUE, open_picture
from amorsim.maps.png_strips import png_file
from tests.examples import settings

MODES = {"RGB": 3, "RGBA": 4, "LA": 2}


@pytest.fixture
def strips(monkeypatch):
    monkeypatch.setattr(pictures, "_IN_STRIPS", 1)
    monkeypatch.setattr(pictures, "_BAND", 40)


def any_class(colours):
    """A class that depends on every channel."""
    return (colours.astype(np.int64) @ [1, 3, 5, 7] % 251).astype(np.uint8)


def pixels_of(path):
    """What a rule makes of the pixels, decoded whole and decoded in strips."""
    whole = open_picture(path)
    assert whole.strips is None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pictures, "_IN_STRIPS", 1)
        patch.setattr(pictures, "_BAND", 40)
        parts = open_picture(path)
        assert parts.strips is not None
        for paper in (None, "white", "black"):
            yield whole.classes(any_class, paper), parts.classes(any_class, paper)


@settings(max_examples=60, deadline=None)
@given(
    mode=st.sampled_from(sorted(MODES)),
    size=st.tuples(st.integers(1, 30), st.integers(1, 30)),
    seed=st.integers(0, 2**32 - 1),
    few=st.booleans(),
    level=st.integers(0, 9),
    clear=st.booleans(),
)
def test_strips_have_the_pixels_of_the_whole(tmp_path_factory, mode, size, seed, few, level, clear):
    path = tmp_path_factory.mktemp("strips") / "a.png"
    draw = np.random.default_rng(seed)
    # Of few values neighbours are often alike, and pillow chooses other filters for its rows.
    values = (
        draw.choice([0, 80, 255], size=(*size, MODES[mode])) if few else draw.integers(0, 256, (*size, MODES[mode]))
    )
    extra = {"transparency": tuple(int(v) for v in values[0, 0])} if mode == "RGB" and clear else {}
    Image.fromarray(values.astype(np.uint8), mode).save(path, compress_level=level, **extra)
    for whole, parts in pixels_of(path):
        assert np.array_equal(whole, parts)


def test_all_filters_of_rows_are_decoded_across_strips(tmp_path):
    draw = np.random.default_rng(3)
    width, rows = 7, 25  # five rows a strip, and a filter that goes round in seven
    lines = [bytes([row % 7 % 5]) + draw.integers(0, 256, 3 * width, np.uint8).tobytes() for row in range(rows)]
    path = tmp_path / "a.png"
    path.write_bytes(png(width, rows, b"".join(lines), pieces=11))
    for whole, parts in pixels_of(path):
        assert np.array_equal(whole, parts)


def test_a_picture_in_strips_is_never_decoded_whole(tmp_path, strips):
    path = tmp_path / "a.png"
    Image.new("RGB", (10, 50), (200, 10, 10)).save(path)
    picture = open_picture(path)
    assert picture.strips is not None
    heights = [(top, strip.height) for top, strip in picture.strips(4)]
    assert heights == [(top, min(4, 50 - top)) for top in range(0, 50, 4)]


def test_two_colours_are_told_apart_in_strips(tmp_path, strips):
    cells = np.random.default_rng(4).random((30, 20)) < 0.3
    path = tmp_path / "a.png"
    Image.fromarray(np.where(cells[..., None], np.uint8([90, 0, 0]), np.uint8([0, 90, 0]))).save(path)
    assert np.array_equal(Bitmap(resolution=0.1).load(path).to_array(), cells[::-1])


def test_many_colours_in_strips_are_counted(tmp_path, strips):
    path = tmp_path / "a.png"
    codes = np.arange(300, dtype=np.uint32)
    pixels = np.stack([codes % 256, codes // 256, np.zeros_like(codes)], axis=-1).astype(np.uint8).reshape(15, 20, 3)
    Image.fromarray(pixels).save(path)
    with pytest.raises(MapError, match="it has 300 colours"):
        Bitmap(resolution=0.1).load(path)


@pytest.mark.parametrize("mode", ["L", "P", "1", "I;16"])
def test_pictures_of_one_channel_are_decoded_whole(tmp_path, strips, mode):
    path = tmp_path / "a.png"
    Image.new(mode, (9, 9)).save(path)
    assert open_picture(path).strips is None


def test_interlaced_and_animated_pictures_are_decoded_whole(tmp_path):
    frames = [Image.new("RGB", (4, 4), colour) for colour in ("red", "blue")]
    path = tmp_path / "a.png"
    frames[0].save(path, save_all=True, append_images=frames[1:])
    with path.open("rb") as file:
        assert png_file(file) is None
    interlaced = png(4, 4, bytes(4 * 13), last=b"\0\0\1")
    assert png_file(io.BytesIO(interlaced)) is None
    assert png_file(io.BytesIO(png(4, 4, bytes(4 * 13)))) is not None


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("short", lambda packed: packed[:-40]),
        ("its sum is wrong", lambda packed: packed[:-1] + bytes([packed[-1] ^ 1])),
        ("not packed data", lambda packed: b"\xff" * len(packed)),
        ("no such filter", lambda packed: zlib.compress(b"\x09" + zlib.decompress(packed)[1:])),
    ],
)
def test_damaged_data_give_an_error_of_maps(tmp_path, strips, name, change):
    path = tmp_path / "a.png"
    data = np.random.default_rng(1).integers(0, 255, (20, 61), np.uint8)
    data[:, 0] = 0
    path.write_bytes(png(20, 20, data.tobytes(), change=change))
    with pytest.raises(MapError, match=r"a\.png: it is not a whole .* image: "):
        Bitmap(resolution=0.1, threshold=0.5).load(path)


def test_what_follows_the_pixels_is_not_unpacked(tmp_path, strips):
    path = tmp_path / "a.png"
    row = b"\0" + bytes(3 * 4)
    path.write_bytes(png(4, 2, 2 * row + bytes(30_000_000)))
    assert Bitmap(resolution=0.1, threshold=0.5).load(path).to_array().all()


def test_opaque_is_the_opacity_of_a_picture_without(tmp_path, strips):
    path = tmp_path / "a.png"
    Image.new("RGB", (4, 4), (1, 2, 3)).save(path)
    seen = []
    open_picture(path).classes(lambda colours: seen.append(colours) or np.zeros(len(colours), np.uint8))
    assert np.unique(np.concatenate(seen), axis=0).tolist() == [[1, 2, 3, OPAQUE]]


MEMORY = """
import re
import sys
import amorsim as am

def most():
    with open("/proc/self/status") as file:
        return 1024 * int(re.search(r"VmHWM:\\s+(\\d+)", file.read())[1])

am.load_map(sys.argv[1], resolution=0.05, threshold=0.5)
before = most()
am.load_map(sys.argv[2], resolution=0.05, threshold=0.5)
print(most() - before)
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="the memory is read from /proc")
def test_a_large_picture_in_colours_takes_less_than_three_bytes_a_pixel(tmp_path):
    side = 5000
    pixels = np.full((side, side, 3), 230, np.uint8)
    pixels[::250] = pixels[:, ::250] = [40, 10, 10]
    Image.fromarray(pixels).save(tmp_path / "large.png", compress_level=1)
    Image.fromarray(pixels[:9, :9]).save(tmp_path / "small.png")
    command = [sys.executable, "-c", MEMORY, str(tmp_path / "small.png"), str(tmp_path / "large.png")]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    # One for its cells, one for the search of outlines; pillow alone would hold four.
    assert int(done.stdout) < 3 * side * side


def png(width, height, data, *, pieces=1, change=bytes, last=b"\0\0\0"):
    """The bytes of an RGB file, its packed data changed and cut into some chunks."""

    def chunk(kind, held):
        return struct.pack(">I", len(held)) + kind + held + struct.pack(">I", zlib.crc32(kind + held))

    packed = change(zlib.compress(data))
    step = -(-len(packed) // pieces)
    cut = [packed[at : at + step] for at in range(0, len(packed), step)]
    header = struct.pack(">II", width, height) + b"\x08\x02" + last
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        [chunk(b"IHDR", header), *(chunk(b"IDAT", part) for part in cut), chunk(b"IEND", b"")]
    )
