"""Maps of ROS's ``map_server``: a YAML file that names a picture of how likely each cell is occupied.

Keys (http://wiki.ros.org/map_server, nav2_map_server)::

    image: lab.pgm                   relative to the file, or next to it
    resolution: 0.05                 m a pixel
    origin: [-10.0, -10.0, 0.0]      x, y, yaw of the lower left corner of the lower left pixel
    negate: 0                        1: white is occupied
    occupied_thresh: 0.65            occupied above it
    free_thresh: 0.196               free below it
    mode: trinary                    or scale, or raw

The probability of a pixel is ``(255 - v) / 255``, where ``v`` is the mean of its channels. In the modes trinary and
raw, what lies between the thresholds is unknown. In the mode scale it is known to be nearer to one of the two, and
transparent pixels are unknown. In the mode raw, ``v`` is a percentage, and above 100 unknown.
"""

from __future__ import annotations

import codecs
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError
from amorsim.core.files.reading import is_file, read_bytes, reason
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.maps.pictures import OPAQUE, Colours, Picture, open_picture, refuse_too_many_pixels
from amorsim.maps.ros_yaml import MapYaml, parse_map_yaml
from amorsim.maps.unknown import OCCUPIED, UNKNOWN, map_of_classes, unknown_as

__all__ = ["Ros"]

_MOST_BYTES = 1_000_000  # of the YAML file
_SAVED = {"free": 254, "occupied": 0, "unknown": 205}  # grey values, as ROS's map_saver writes them
_FREE_BELOW, _OCCUPIED_ABOVE = 0.196, 0.65


@attrs.frozen(kw_only=True)
class Ros(MapLoader):
    """Maps of ROS (``.yaml`` with a picture): occupied, free and unknown cells by two thresholds.

    In the mode scale, a cell between the thresholds is occupied from half way on. Unlike `map_server`, the thresholds
    count in the mode raw too, of the percentage.
    """

    extensions: ClassVar[tuple[str, ...]] = (".yaml", ".yml")

    resolution: float | None = parameter(None, unit="m", gt=0, help="side of a pixel, in place of the file's")
    unknown: str = unknown_as()

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether lines of a file's first bytes begin with the keys for where the picture is, and how large."""
        lines = [line.split(b":")[0].strip() for line in head.splitlines()]
        return b"image" in lines and (b"resolution" in lines or b"origin" in lines)

    def load(self, path: Path) -> Map:
        """The map of a YAML file and the picture that it names.

        Raises
        ------
        MapError
            If one of them cannot be read or is damaged, or a value of the YAML file makes no sense.
        """
        about = _about(path)
        try:
            # The picture is let go before the map is made: it is as large as its classes.
            classes, remarks = self._read(about, path)
            return map_of_classes(
                classes,
                resolution=about.resolution if self.resolution is None else self.resolution,
                origin=about.origin,
                warnings=(*about.remarks, *remarks),
                name=path.stem,
            )
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    def _read(self, about: MapYaml, path: Path) -> tuple[NDArray[np.uint8], tuple[str, ...]]:
        """The class of each pixel, (rows, columns) from the bottom, and remarks."""
        image, remarks = _image_of(about, path)
        try:
            picture = open_picture(path.parent / image)
        except MapError as error:
            raise MapError(f"line {about.lines['image']}: image {about.image}: {error}") from error
        return _classes(picture, about, self.unknown == "occupied"), (*remarks, *picture.remarks)

    def companions(self, path: Path) -> Sequence[Path]:
        """The picture."""
        return (_image_of(_about(path), path)[0],)

    @classmethod
    def save(cls, world: Map, path: Path) -> Ros:
        """Write a map's cells as a YAML file and a PGM picture of the same name; see `amorsim.save_map`.

        Unknown cells are written as such. What they are to rays and bodies is an option of the loader, for all alike.
        """
        refuse_too_many_pixels(world)
        cells, unknown = world.to_array()[::-1] != 0, world.unknown_array()[::-1] != 0
        grey = np.where(cells, np.uint8(_SAVED["occupied"]), np.uint8(_SAVED["free"]))
        grey[unknown] = _SAVED["unknown"]
        picture = path.with_suffix(".pgm")
        Image.fromarray(grey).save(picture, "PPM")
        x, y, yaw = world.origin
        lines = (
            f"image: {_quoted(picture.name)}",
            "mode: trinary",
            f"resolution: {world.resolution!r}",
            f"origin: [{x!r}, {y!r}, {yaw!r}]",
            "negate: 0",
            f"occupied_thresh: {_OCCUPIED_ABOVE}",
            f"free_thresh: {_FREE_BELOW}",
        )
        path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
        return cls(unknown="occupied" if unknown.any() and cells[unknown].all() else "free")


def _quoted(name: str) -> str:
    """A text as YAML's single quotes hold it, whatever is in it."""
    return "'" + name.replace("'", "''") + "'"


def _about(path: Path) -> MapYaml:
    try:
        text = _decoded(read_bytes(path, _MOST_BYTES))
    except (OSError, ValueError) as error:
        raise MapError(f"{path}: cannot be read: {reason(error)}") from error
    try:
        return parse_map_yaml(text)
    except MapError as error:
        raise MapError(f"{path}: {error}") from error


def _decoded(data: bytes) -> str:
    """The text: UTF-16 if it begins with its mark, else UTF-8, else Latin 1, in which every byte is a letter."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _image_of(about: MapYaml, path: Path) -> tuple[Path, tuple[str, ...]]:
    """The picture, relative to the file's folder, and a remark if another one than the named one is taken.

    A picture next to the file goes before one that is named by its whole path, as ``map_saver`` does: the files may
    have been copied together.
    """
    image = Path(about.image)
    beside = Path(image.name if "\\" not in about.image else about.image.rpartition("\\")[2])
    named, near = path.parent / image, path.parent / beside
    if image == beside or not is_file(near):
        return image, ()
    if not is_file(named):
        return beside, (f"there is no {about.image}; {beside}, next to the file, is taken for it",)
    if not image.is_absolute():
        return image, ()
    return beside, () if named.samefile(near) else (f"{beside}, next to the file, is taken for {about.image}",)


def _classes(picture: Picture, about: MapYaml, unknown_is_occupied: bool) -> NDArray[np.uint8]:
    """The class of each pixel, (rows, columns) from the bottom."""
    as_unknown = np.uint8(UNKNOWN | (OCCUPIED if unknown_is_occupied else 0))
    low, high = about.free_thresh, about.occupied_thresh
    half = 0.5 * (low + high)

    def rule(colours: Colours) -> NDArray[np.uint8]:
        clear = colours[:, 3] < OPAQUE
        # In the mode trinary map_server takes opacity for one more channel of colour.
        with_opacity = about.mode == "trinary" and picture.has_opacity
        channels = colours[:, :3] * (255.0 / picture.white)
        total = channels.sum(axis=1) + (colours[:, 3] if with_opacity else 0.0)
        value = total / (4.0 if with_opacity else 3.0)
        value = 255.0 - value if about.negate else value
        is_unknown = np.zeros(len(colours), np.bool_)
        if about.mode == "raw":
            share = np.rint(value) / 100.0
            is_unknown |= share > 1.0
        else:
            share = (255.0 - value) / 255.0
        occupied = share > high
        if about.mode == "scale":
            is_unknown |= clear
            occupied = share >= half if high > low else occupied
        else:
            is_unknown |= ~occupied & ~(share < low)
        return np.where(is_unknown, as_unknown, np.where(occupied, np.uint8(OCCUPIED), np.uint8(0)))

    return picture.classes(rule)
