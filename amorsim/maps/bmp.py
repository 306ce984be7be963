"""Pictures (``.png``, ``.bmp``, ``.pgm``, ``.jpg``, ``.gif``, ``.tif``) as maps: dark pixels are occupied."""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from amorsim.array_types import Ints32
from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError
from amorsim.core.files.reading import is_file
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.maps.pictures import OPAQUE, SIGNATURES, Colours, Rule, open_picture, refuse_too_many_pixels
from amorsim.maps.unknown import OCCUPIED, UNKNOWN, map_of_classes, unknown_as

__all__ = ["Bitmap"]

# Rec. 601 luma in thousandths; integers, so that comparing the brightness of two colours is exact.
_LUMA = (299, 587, 114)
_RESOLUTION = 0.05  # [m]
_NO_RESOLUTION = (
    f"no resolution is given, so a pixel is taken for {_RESOLUTION:g} m; say how large one is, as in resolution = "
    "0.02, or how large the picture is, as in size = [12.0, 8.0]"
)
_MID_GREY = 0.5
_LOSSY = "the colours of a JPEG are not exact, so all that is darker than mid grey is occupied (threshold = 0.5)"
_MOST_CELLS = 10**8  # of a picture that is stretched
_SAVED_AS = {".jpg": "JPEG", ".jpeg": "JPEG", ".pgm": "PPM", ".pnm": "PPM", ".pbm": "PPM", ".ppm": "PPM"}


@attrs.frozen(kw_only=True)
class Bitmap(MapLoader):
    """Pictures of two colours, the darker one occupied, or of any colours with a `threshold`.

    Formats: PNG, BMP, PNM (``.pgm`` and its like), JPEG, GIF and TIFF; of several pictures in a file, the first.
    An image of one colour is all occupied if that is darker than mid grey, else all free. A JPEG without a threshold
    gets one of 0.5. Transparent parts count as white, as on paper, unless `transparent` is set. A BMP's
    fourth channel, which few programs fill in, is ignored.
    """

    extensions: ClassVar[tuple[str, ...]] = (
        *(".bmp", ".png", ".pgm", ".pbm", ".ppm", ".pnm", ".jpg", ".jpeg", ".gif", ".tif", ".tiff"),
    )
    read_only: ClassVar[tuple[str, ...]] = (".jpg", ".jpeg")

    resolution: float | None = parameter(
        None, unit="m", gt=0, help="side of a pixel; without it and `size` 0.05, with a warning"
    )
    size: tuple[float, float] | None = parameter(
        None,
        unit="m",
        gt=0,
        help="width and height of the whole picture, which is stretched to square cells if its pixels are not square",
    )
    origin_x: float = parameter(0.0, unit="m", help="x of the lower left corner of the lower left pixel")
    origin_y: float = parameter(0.0, unit="m", help="y of the lower left corner of the lower left pixel")
    origin_yaw: float = parameter(0.0, unit="rad", help="turn of the image about that corner")
    threshold: float | None = parameter(
        None, ge=0, le=1, help="greys below it are occupied, 0 black, 1 white; any image will do then"
    )
    transparent: str = parameter(
        "white",
        choices=("white", "black", "unknown"),
        help="what transparent parts are: as on white or black paper, or unknown where the opacity is below a half",
    )
    unknown: str = unknown_as()

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file's first bytes are the signature of one of the formats."""
        return head.startswith(SIGNATURES)

    def load(self, path: Path) -> Map:
        """The map of an image file.

        Raises
        ------
        MapError
            If the file cannot be read, is damaged or too large, or has more than two colours and no
            `threshold` is given.
        """
        try:
            classes, remarks = self._classes(path)
            side = self._side(classes.shape[1])
            classes, stretched = self._stretched(classes, side, _ros_map_of(path))
            return map_of_classes(
                classes,
                resolution=side,
                origin=(self.origin_x, self.origin_y, self.origin_yaw),
                warnings=(*remarks, *stretched),
                name=path.stem,
            )
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    @classmethod
    def save(cls, world: Map, path: Path) -> Bitmap:
        """Write a map's cells, black where they are occupied; see `amorsim.save_map`.

        Unknown cells are written as transparent ones, where the format has such.
        """
        kind = _SAVED_AS.get(path.suffix.lower())
        if path.suffix.lower() in cls.read_only:
            raise MapError("a JPEG blurs the cells of a map; save it as .png")
        refuse_too_many_pixels(world)
        x, y, yaw = world.origin
        loader = cls(resolution=world.resolution, origin_x=x, origin_y=y, origin_yaw=yaw)
        cells = np.where(world.to_array()[::-1], 0, 255).astype(np.uint8)
        if world.unknown is None or path.suffix.lower() not in (".png", ".tif", ".tiff"):
            image = Image.fromarray(cells)
            (image if path.suffix.lower() == ".pgm" else image.convert("1")).save(path, kind)
            return loader
        is_unknown = world.unknown_array()[::-1] != 0
        opacity = np.where(is_unknown, 0, OPAQUE).astype(np.uint8)
        Image.fromarray(np.stack((cells, opacity), axis=-1), "LA").save(path, kind)
        as_what = "occupied" if (cells[is_unknown] == 0).all() else "free"
        # With a threshold, because what is transparent is a colour of its own.
        return attrs.evolve(loader, threshold=_MID_GREY, transparent="unknown", unknown=as_what)

    def _side(self, columns: int) -> float:
        if self.resolution is not None:
            return self.resolution
        return _RESOLUTION if self.size is None else self.size[0] / columns

    def _stretched(
        self, classes: NDArray[np.uint8], side: float, other: str
    ) -> tuple[NDArray[np.uint8], tuple[str, ...]]:
        """The classes of the cells for a given `size`: each that of the pixel at the cell's middle."""
        if self.size is None:
            return classes, () if self.resolution is not None else (_NO_RESOLUTION + other,)
        rows, columns = classes.shape
        wide, high = (max(1, round(length / side)) for length in self.size)
        if (high, wide) == (rows, columns):
            return classes, ()
        if wide * high > _MOST_CELLS:
            raise MapError(
                f"stretched to {self.size[0]:g} m x {self.size[1]:g} m it would have {wide} x {high} cells of {side:g} "
                f"m; expected {_MOST_CELLS:g} at most: give a coarser resolution"
            )
        across = ((np.arange(wide) + 0.5) * (columns / wide)).astype(np.int64)
        up = ((np.arange(high) + 0.5) * (rows / high)).astype(np.int64)
        remark = (
            f"its {columns} x {rows} pixels are stretched to {wide} x {high} cells of {side:.4g} m, for a size of "
            f"{self.size[0]:g} m x {self.size[1]:g} m"
        )
        return np.ascontiguousarray(classes[np.ix_(up, across)]), (remark,)

    def _classes(self, path: Path) -> tuple[NDArray[np.uint8], tuple[str, ...]]:
        """The class of each pixel, (rows, columns) from the bottom, and remarks; the picture is released."""
        picture = open_picture(path)
        paper = "black" if self.transparent == "black" else "white"
        threshold, remarks = self.threshold, picture.remarks
        if threshold is None and picture.format == "JPEG":
            threshold, remarks = _MID_GREY, (*remarks, _LOSSY)
        white = picture.white
        choose = functools.partial(_two_colours, white, _ros_map_of(path))
        if self.transparent != "unknown":
            if threshold is None:
                return picture.classes_by(choose, paper), remarks
            return picture.classes(_darker(threshold, white), paper), remarks
        rule = choose(picture.colours(paper)) if threshold is None else _darker(threshold, white)
        as_unknown = UNKNOWN | (OCCUPIED if self.unknown == "occupied" else 0)

        def known(colours: Colours) -> NDArray[np.uint8]:
            return np.where(2 * colours[:, 3] < OPAQUE, np.uint8(as_unknown), rule(colours))

        return picture.classes(known), remarks


def _darker(threshold: float, white: int) -> Rule:
    def rule(colours: Colours) -> NDArray[np.uint8]:
        return (_luma(colours) < threshold * white * sum(_LUMA)).view(np.uint8)

    return rule


def _ros_map_of(path: Path) -> str:
    """A remark on a map of ROS next to its picture that may be meant instead; empty if there is none."""
    near = [path.with_suffix(suffix) for suffix in (".yaml", ".yml")]
    return next(
        (f"; or read {each.name}, which lies next to it, as a map of ROS" for each in near if is_file(each)), ""
    )


def _two_colours(white: int, other: str, colours: Colours) -> Rule:
    """The rule that the darker of a picture's two colours is occupied."""
    luma = _luma(colours)
    if len(colours) == 1:
        return _darker(_MID_GREY, white)
    if len(colours) > 2:
        raise MapError(
            f"it has {len(colours)} colours, and a bitmap map has two, the darker one occupied; give a threshold (0 to "
            "1, 0.5 for mid grey, as in --set world.threshold=0.5) to take every pixel darker than that for occupied"
            f"{other}"
        )
    if luma[0] == luma[1]:
        raise MapError("its two colours are equally bright, so neither is the darker, occupied one; make one black")
    between = math.fsum(luma) / (2.0 * white * sum(_LUMA))
    return _darker(between, white)


def _luma(colours: Colours) -> Ints32:
    """Brightness (n,) in thousandths of a channel's step."""
    red, green, blue = (colours[:, channel].astype(np.int32) * _LUMA[channel] for channel in range(3))
    return np.asarray(red + green + blue)
