"""Bitmaps: the darker of two colours is occupied, whatever the depth; anything else says what is wrong."""

from __future__ import annotations

import io
import math
import struct
import zlib
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

import amorsim as am
from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.maps.bmp import Bitmap
from tests.examples import settings

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps"

cells = arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 12))).filter(
    lambda found: found.any() and not found.all()
)
colours = st.tuples(*[st.integers(0, 255)] * 3)


def luma(colour: tuple[int, ...]) -> int:
    """Brightness of a colour, Rec. 601, in thousandths."""
    return 299 * colour[0] + 587 * colour[1] + 114 * colour[2]


def saved(folder: Path, image: Image.Image, name: str = "a.bmp") -> Path:
    path = folder / name
    image.save(path)
    return path


def grey(*rows: list[int]) -> Image.Image:
    return Image.fromarray(np.array(rows, np.uint8))


# ------------------------------------------------------------------------------------------------ rows


def test_top_row_of_the_image_is_the_last_of_the_map(tmp_path: Path) -> None:
    loaded = Bitmap(resolution=0.1).load(saved(tmp_path, grey([0, 255, 255], [255, 255, 0])))
    assert loaded.to_array().tolist() == [[0, 0, 1], [1, 0, 0]]
    assert loaded.size == pytest.approx((0.3, 0.2))
    assert loaded.name == "a"


def test_options_place_the_map(tmp_path: Path) -> None:
    path = saved(tmp_path, grey([255, 0], [255, 255]))
    loaded = Bitmap(resolution=0.5, origin_x=1.0, origin_y=-2.0, origin_yaw=math.pi / 2).load(path)
    assert loaded.origin == (1.0, -2.0, math.pi / 2)
    assert loaded.resolution == 0.5
    # Turned left by a right angle, the upper right pixel is the upper left one.
    assert loaded.occupied([(0.25, -1.25), (0.75, -1.25), (0.25, -1.75), (0.75, -1.75)]).tolist() == [
        True,
        False,
        False,
        False,
    ]


def test_default_resolution_is_five_centimetres(tmp_path: Path) -> None:
    assert Bitmap().load(saved(tmp_path, grey([0, 255]))).resolution == 0.05


@pytest.mark.parametrize(
    "options", [{"resolution": 0}, {"threshold": 1.5}, {"threshold": -0.1}, {"origin_x": math.nan}]
)
def test_options_are_checked(options: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match=next(iter(options))):
        Bitmap(**options)


# -------------------------------------------------------------------------------------------- round trips


@settings(deadline=None)
@given(
    occupied=cells,
    mode=st.sampled_from(["1", "L", "P", "RGB", "RGBA", "LA"]),
    suffix=st.sampled_from([".bmp", ".png"]),
    pair=st.tuples(colours, colours).filter(lambda pair: luma(pair[0]) + 2000 < luma(pair[1])),
)
def test_two_colours_of_any_depth(
    tmp_path_factory: pytest.TempPathFactory,
    occupied: np.ndarray,
    mode: str,
    suffix: str,
    pair: tuple[tuple[int, ...], tuple[int, ...]],
) -> None:
    if mode == "LA":
        suffix = ".png"
    if mode == "1":
        pair = (0, 0, 0), (255, 255, 255)
    image = Image.fromarray(np.where(occupied[..., None], *(np.array(colour, np.uint8) for colour in pair)))
    if mode == "P":
        image = image.quantize(2)
    elif mode in ("1", "L", "LA"):
        image = image.convert(mode, dither=Image.Dither.NONE)
    else:
        image = image.convert(mode)
    path = saved(tmp_path_factory.getbasetemp(), image, "a" + suffix)
    assert Bitmap().load(path).to_array()[::-1].astype(bool).tolist() == occupied.tolist()


@given(arrays(np.uint8, st.tuples(st.integers(1, 6), st.integers(1, 6))), st.integers(0, 255))
def test_threshold_takes_what_is_darker(
    tmp_path_factory: pytest.TempPathFactory, values: np.ndarray, level: int
) -> None:
    path = saved(tmp_path_factory.getbasetemp(), Image.fromarray(values), "b.bmp")
    loaded = Bitmap(threshold=(level + 0.5) / 255 if level < 255 else 1.0).load(path)
    darker = values <= level if level < 255 else values < 255
    assert loaded.to_array()[::-1].astype(bool).tolist() == darker.tolist()


def test_bmp_of_one_bit_with_its_colours_swapped(tmp_path: Path) -> None:
    """A palette whose first entry is white: it is the colour that counts, not the index."""
    image = Image.new("P", (2, 1))
    image.putpalette([255, 255, 255, 0, 0, 0])
    image.putdata([0, 1])
    assert Bitmap().load(saved(tmp_path, image)).to_array().tolist() == [[0, 1]]


def test_png_of_sixteen_bits(tmp_path: Path) -> None:
    values = np.array([[0, 65535, 40000]], np.uint16)
    path = saved(tmp_path, Image.fromarray(values), "deep.png")
    assert Bitmap(threshold=0.5).load(path).to_array().tolist() == [[1, 0, 0]]
    assert Bitmap(threshold=0.62).load(path).to_array().tolist() == [[1, 0, 1]]
    with pytest.raises(MapError, match="3 colours"):
        Bitmap().load(path)


def test_transparent_parts_of_a_png_are_free(tmp_path: Path) -> None:
    image = Image.new("RGBA", (3, 1), (0, 0, 0, 0))
    image.putpixel((1, 0), (0, 0, 0, 255))
    assert Bitmap().load(saved(tmp_path, image, "clear.png")).to_array().tolist() == [[0, 1, 0]]


def test_an_unused_alpha_of_a_bmp_does_not_hide_its_colours(tmp_path: Path) -> None:
    """Two pixels of 32 bits under a header (BITMAPV4) that declares an alpha, which is 0 in both."""
    masks = struct.pack("<4I", 0x00FF0000, 0x0000FF00, 0x000000FF, 0xFF000000)
    info = struct.pack("<IiiHHIIiiII", 108, 2, 1, 1, 32, 3, 8, 0, 0, 0, 0) + masks + bytes(52)
    pixels = bytes([255, 255, 255, 0]) + bytes(4)
    path = tmp_path / "clear.bmp"
    path.write_bytes(b"BM" + struct.pack("<IHHI", 14 + 108 + 8, 0, 0, 14 + 108) + info + pixels)
    with Image.open(path) as image:
        assert image.mode == "RGBA"
    assert Bitmap().load(path).to_array().tolist() == [[0, 1]]


@pytest.mark.parametrize("name", ["a.png", "a.pgm", "a.pbm", "a.bmp", "a.gif", "a.tif", "a.tiff", "a.jpg", "a.jpeg"])
def test_every_format_is_read_from_the_top(tmp_path: Path, name: str) -> None:
    occupied = np.zeros((16, 24), bool)
    occupied[0, :] = occupied[8:, 16:] = True
    if name.startswith("a.j"):
        occupied[:8] = True  # whole blocks of a JPEG, which keep their edges
    path = saved(tmp_path, Image.fromarray(np.where(occupied, 0, 255).astype(np.uint8)), name)
    loaded = Bitmap(resolution=0.1).load(path)
    assert loaded.to_array()[::-1].astype(bool).tolist() == occupied.tolist()
    is_lossy = name.startswith("a.j")
    assert [("JPEG" in warning) for warning in loaded.warnings] == [True] * is_lossy


def test_a_pgm_may_have_comments_and_any_white(tmp_path: Path) -> None:
    path = tmp_path / "a.pgm"
    path.write_bytes(b"P5\n# CREATOR: x\n# and y\n3 1\n# so\n100\n" + bytes([0, 49, 100]))
    assert Bitmap(resolution=1.0, threshold=0.5).load(path).to_array().tolist() == [[1, 1, 0]]
    path.write_bytes(b"P2 # plain\n3 1\n100\n0 49 100\n")
    assert Bitmap(resolution=1.0, threshold=0.5).load(path).to_array().tolist() == [[1, 1, 0]]


def test_of_several_pictures_the_first_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    grey([0, 255]).save(path, save_all=True, append_images=[grey([255, 0])])
    loaded = Bitmap(resolution=1.0).load(path)
    assert loaded.to_array().tolist() == [[1, 0]]
    assert loaded.warnings == ("only the first of its 2 pictures is read",)


# ----------------------------------------------------------------------------------------------- size


def test_size_gives_the_resolution(tmp_path: Path) -> None:
    path = saved(tmp_path, grey([0, 255, 255], [255, 255, 0]))
    loaded = Bitmap(size=(1.5, 1.0)).load(path)
    assert (loaded.resolution, loaded.size, loaded.warnings) == (0.5, (1.5, 1.0), ())


@settings(deadline=None)
@given(occupied=cells, wide=st.integers(1, 30), high=st.integers(1, 30))
def test_a_picture_is_stretched_to_a_size_and_resolution(
    tmp_path_factory: pytest.TempPathFactory, occupied: np.ndarray, wide: int, high: int
) -> None:
    path = saved(tmp_path_factory.getbasetemp(), Image.fromarray(np.where(occupied, 0, 255).astype(np.uint8)), "s.png")
    loaded = Bitmap(size=(wide * 0.5, high * 0.5), resolution=0.5).load(path)
    rows, cols = occupied.shape
    expected = [
        [
            int(occupied[rows - 1 - (2 * i + 1) * rows // (2 * high), (2 * j + 1) * cols // (2 * wide)])
            for j in range(wide)
        ]
        for i in range(high)
    ]
    assert loaded.to_array().tolist() == expected
    assert bool(loaded.warnings) == ((rows, cols) != (high, wide))


def test_stretched_too_far_is_refused(tmp_path: Path) -> None:
    path = saved(tmp_path, grey([0, 255]))
    with pytest.raises(MapError, match=r"a\.bmp: stretched to 1000 m x 1000 m it would have .* coarser resolution"):
        Bitmap(size=(1000.0, 1000.0), resolution=0.01).load(path)


def test_a_size_that_was_taken_is_read_the_same_again(tmp_path: Path) -> None:
    import amorsim as am

    path = saved(tmp_path, grey([0, 255, 255], [255, 255, 0], [255, 255, 0]))
    first = am.load_map(path, size=(1.1, 0.9))
    assert first.source.loader.resolution == 1.1 / 3
    assert first.source.loader.load(path) == attrs.evolve(first, source=None)


# ------------------------------------------------------------------------------------------- transparent


@pytest.mark.parametrize(
    ("transparent", "unknown", "cells", "mask"),
    [
        ("white", "free", [[0, 1, 0]], [[0, 0, 0]]),
        ("black", "free", [[1, 1, 0]], [[0, 0, 0]]),
        ("unknown", "free", [[0, 1, 0]], [[1, 0, 0]]),
        ("unknown", "occupied", [[1, 1, 0]], [[1, 0, 0]]),
    ],
)
def test_what_transparent_parts_are(
    tmp_path: Path, transparent: str, unknown: str, cells: list[list[int]], mask: list[list[int]]
) -> None:
    image = Image.new("RGBA", (3, 1), (0, 0, 0, 0))
    image.putpixel((1, 0), (0, 0, 0, 255))
    image.putpixel((2, 0), (255, 255, 255, 255))
    path = saved(tmp_path, image, "clear.png")
    loaded = Bitmap(transparent=transparent, unknown=unknown).load(path)
    assert loaded.to_array().tolist() == cells
    assert loaded.unknown_array().tolist() == mask


# -------------------------------------------------------------------------------------------- colours


@pytest.mark.parametrize(
    ("colour", "occupied"), [("white", 0), ("black", 1), ("#7f7f7f", 1), ("#808080", 0), ("red", 1)]
)
def test_one_colour_is_all_free_or_all_occupied(tmp_path: Path, colour: str, occupied: int) -> None:
    loaded = Bitmap().load(saved(tmp_path, Image.new("RGB", (3, 2), colour)))
    assert loaded.to_array().tolist() == [[occupied] * 3] * 2


def test_more_colours_say_how_many_and_what_to_do(tmp_path: Path) -> None:
    path = saved(tmp_path, grey([0, 100, 200, 255, 255]))
    with pytest.raises(MapError, match=r"a\.bmp: it has 4 colours.*threshold="):
        Bitmap().load(path)
    assert Bitmap(threshold=0.5).load(path).to_array().tolist() == [[1, 1, 0, 0, 0]]


def test_true_colours_are_counted_too(tmp_path: Path) -> None:
    image = Image.new("RGB", (256, 3))
    image.putdata([(i, i // 2, j) for j in range(3) for i in range(256)])
    with pytest.raises(MapError, match="it has 768 colours"):
        Bitmap().load(saved(tmp_path, image))


def test_equally_bright_colours_are_not_guessed(tmp_path: Path) -> None:
    twins = (61, 0, 185), (0, 67, 0)
    assert luma(twins[0]) == luma(twins[1])
    image = Image.new("RGB", (2, 1), twins[0])
    image.putpixel((1, 0), twins[1])
    with pytest.raises(MapError, match="equally bright"):
        Bitmap().load(saved(tmp_path, image))
    image.putpixel((1, 0), (0, 67 - 1, 0))
    assert Bitmap().load(saved(tmp_path, image)).to_array().tolist() == [[0, 1]]


# ---------------------------------------------------------------------------------------- broken files


def test_sniff() -> None:
    buffer = io.BytesIO()
    grey([0, 255]).save(buffer, "BMP")
    assert Bitmap.sniff(buffer.getvalue()[:64])
    buffer = io.BytesIO()
    grey([0, 255]).save(buffer, "PNG")
    assert Bitmap.sniff(buffer.getvalue()[:64])
    assert Bitmap.sniff(b"P5\n2 2\n255\n")
    assert not Bitmap.sniff(b"P7\n")
    assert not Bitmap.sniff(b"")
    assert not Bitmap.sniff(b"0 0 10 0")


@pytest.mark.parametrize("kind", ["BMP", "PNG"])
@given(data=st.data())
@settings(max_examples=150, deadline=None)
def test_broken_files_make_a_map_or_a_map_error(
    tmp_path_factory: pytest.TempPathFactory, kind: str, data: st.DataObject
) -> None:
    buffer = io.BytesIO()
    grey(*[[0, 255] * 4] * 6).save(buffer, kind)
    content = bytearray(buffer.getvalue())
    for _ in range(data.draw(st.integers(0, 4))):
        content[data.draw(st.integers(2, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.getbasetemp() / "broken.bmp"
    path.write_bytes(content[: data.draw(st.integers(0, len(content)) | st.just(len(content)))])
    try:
        loaded: Map | MapError = Bitmap().load(path)
    except MapError as error:
        loaded = error
    assert isinstance(loaded, Map) or "broken.bmp: " in str(loaded)


@pytest.mark.parametrize("kind", ["BMP", "PNG"])
def test_a_file_cut_short_is_refused(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "short.bmp"
    grey(*[[0, 255] * 40] * 60).save(path, kind)
    path.write_bytes(path.read_bytes()[:-60])
    with pytest.raises(MapError, match=r"short\.bmp: it is not a whole BMP, PNG"):
        Bitmap().load(path)


def test_another_kind_of_image_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.bmp"
    grey([0, 255]).save(path, "TGA")
    with pytest.raises(MapError, match="not a BMP, PNG, PNM, JPEG, GIF or TIFF image, or its header is damaged"):
        Bitmap().load(path)


def test_a_missing_file_is_said(tmp_path: Path) -> None:
    with pytest.raises(MapError, match=r"none\.bmp: cannot be read"):
        Bitmap().load(tmp_path / "none.bmp")


_GIF = struct.pack("<HHBBB", 65535, 65535, 0, 0, 0) + b"," + struct.pack("<HHHHB", 0, 0, 65535, 65535, 0)
_BMP = struct.pack("<IHHI", 62, 0, 0, 62) + struct.pack("<IiiHHIIiiII", 40, 40000, 40000, 1, 1, 0, 0, 0, 0, 2, 0)


@pytest.mark.parametrize(
    ("name", "header"),
    [("a.pgm", b"P5\n40000 40000\n255\n"), ("a.gif", b"GIF89a" + _GIF + b"\x02"), ("a.bmp", b"BM" + _BMP)],
)
def test_a_header_of_a_billion_pixels_is_refused(tmp_path: Path, name: str, header: bytes) -> None:
    path = tmp_path / name
    path.write_bytes(header + bytes(100))
    with pytest.raises(
        MapError, match=f"{name}: it is too large to unpack, with \\d{{10,}} pixels: expected 178956970 at"
    ):
        Bitmap().load(path)


@pytest.mark.parametrize("side", [14_000, 40_000])
def test_an_image_that_unpacks_to_too_much_is_refused(tmp_path: Path, side: int) -> None:
    """It is refused by its header: nothing follows that could be unpacked."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    path = tmp_path / "bomb.png"
    header = struct.pack(">IIBBBBB", side, side, 1, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b""))
    with pytest.raises(MapError, match=r"bomb\.png: it is too large to unpack"):
        Bitmap().load(path)


# ------------------------------------------------------------------------------------------ real files


@pytest.mark.parametrize("name", ["autolab", "cave", "hospital_section", "simple_rooms"])
def test_a_real_floor_plan(name: str) -> None:
    path = MAPS / "stage" / "bitmaps" / f"{name}.png"
    if not path.is_file():
        pytest.skip(f"no {path}")
    with Image.open(path) as image:
        values = np.asarray(image.convert("L"))
    expected = values[::-1] < 128
    assert np.array_equal(Bitmap(resolution=0.032, threshold=0.5).load(path).to_array(), expected)
    assert np.array_equal(Bitmap(resolution=0.032).load(path).to_array(), expected)  # of two colours each
    loaded = Bitmap(size=(16.0, 16.0 * values.shape[0] / values.shape[1])).load(path)
    assert loaded.shape == values.shape
    if name == "cave":
        # Where simple.world puts its robot, in a plan of 16 m x 16 m about the origin.
        assert not loaded.occupied([(8.0 - 7.0, 8.0 - 7.0)])[0]


def test_a_real_map_of_many_greys() -> None:
    path = MAPS / "ros" / "willow-full-0.05.pgm"
    if not path.is_file():
        pytest.skip(f"no {path}")
    data = path.read_bytes()
    values = np.frombuffer(data[-1165 * 945 :], np.uint8).reshape(945, 1165)
    loaded = Bitmap(resolution=0.05, threshold=0.4).load(path)
    assert np.array_equal(loaded.to_array(), values[::-1] < 0.4 * 255)
    with pytest.raises(MapError, match="it has 256 colours"):
        Bitmap().load(path)


@pytest.mark.parametrize("ending", ["jpg", "png"])
def test_a_picture_that_wants_to_be_turned_is_remarked_on(tmp_path: Path, ending: str) -> None:
    exif = Image.Exif()
    path = tmp_path / f"a.{ending}"
    for orientation, count in ((1, 0), (6, 1)):
        exif[0x0112] = orientation
        Image.new("L", (4, 3), 255).save(path, exif=exif)
        found = Bitmap(resolution=0.1, threshold=0.5).load(path)
        assert found.shape == (3, 4)
        assert sum("its EXIF orientation (6) is ignored" in warning for warning in found.warnings) == count


def test_damaged_exif_data_do_not_matter(tmp_path: Path) -> None:
    path = tmp_path / "a.jpg"
    Image.new("L", (4, 3), 255).save(path, exif=b"Exif\0\0MM\0*\xff\xff\xff\xff junk")
    assert not any("EXIF" in warning for warning in Bitmap(resolution=0.1, threshold=0.5).load(path).warnings)


@pytest.mark.parametrize("name", ["hall.png", "hall.yaml"])
def test_more_cells_than_a_picture_may_have_pixels_are_refused_before_they_are_unpacked(
    tmp_path: Path, name: str
) -> None:
    hall = Map.from_segments([], extent=(0, 0, 20, 20), resolution=0.001)
    with pytest.raises(MapError, match=r"cells of 0.001 m would be a picture of 20000 x 20000 pixels; expected 178956"):
        am.save_map(hall, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_who_takes_the_limit_of_pixels_away_has_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", None)
    am.save_map(Map.from_array([[0, 1]], resolution=1.0), tmp_path / "hall.png")
    assert Bitmap(resolution=1.0).load(tmp_path / "hall.png").to_array().tolist() == [[0, 1]]


def test_the_map_of_ros_next_to_a_picture_is_named(tmp_path: Path) -> None:
    path = saved(tmp_path, grey([0, 205, 254]), "lab.pgm")
    with pytest.raises(
        MapError, match=r"it has 3 colours, .*=0\.5\) to take every pixel darker than that for occupied$"
    ):
        Bitmap().load(path)
    (tmp_path / "lab.yaml").write_text("image: lab.pgm\nresolution: 0.5\norigin: [0, 0, 0]\n")
    with pytest.raises(MapError, match=r"or read lab\.yaml, which lies next to it, as a map of ROS$"):
        Bitmap().load(path)
    (warning,) = Bitmap(threshold=0.5).load(path).warnings
    assert "no resolution is given" in warning
    assert "lab.yaml" in warning


@pytest.mark.long
def test_a_picture_that_is_a_few_pixels_wide_is_read_as_others(tmp_path: Path) -> None:
    cells = np.random.default_rng(3).integers(0, 2, size=(700_001, 3), dtype=np.uint8)
    colours = np.array([[255, 250, 250], [0, 0, 5]], dtype=np.uint8)[cells]
    Image.fromarray(colours).save(tmp_path / "tall.png")
    world = Bitmap(resolution=0.001).load(tmp_path / "tall.png")
    np.testing.assert_array_equal(world.to_array()[::-1], cells)
