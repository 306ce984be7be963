"""A camera that pans, tilts and zooms, and finds blobs of colour."""

from __future__ import annotations

import functools
import math
import types
from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np
from PIL import ImageColor

from amorsim.array_types import Array, Ints
from amorsim.contracts import Aim, Context, Draws, Drive, Sensor, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import compose, wrap_angle
from amorsim.kernels import elementary
from amorsim.sensors.slots import table_of

__all__ = ["Camera"]

_COLUMNS: Mapping[str, str] = types.MappingProxyType(
    {"colour": "id", "left": "px", "right": "px", "top": "px", "bottom": "px", "range": "m", "bearing": "rad"}
)


@attrs.frozen(kw_only=True)
class Camera(Sensor):
    """Blobs of colour in the image of a camera that pans, tilts and zooms, the nearest first, in a number of slots.

    Of each blob: which of ``colours`` it has, counted from 0; its first and last column and its first and last row, in
    pixels from the image's upper left; the distance to its nearest column [m]; the bearing of its middle from the
    mount's heading [rad], pan included. An empty slot reads -1 for the colour and inf for the rest.
    ``measured.reshape(-1, 7)`` is a table with a line for each slot.

    Each column is one ray through its middle. It shows the first thing that the ray meets: a wall (no colour), a robot,
    an obstacle or a landmark. Adjacent columns of one colour form one blob, even if they show several things. All
    pixels span equal angles, as in Stage's blob finder (not equal lengths on an image plane), so tilt only shifts rows.
    A thing stands on the ground and has its ``height``. It hides everything behind it, however low it is; walls hide
    everything.

    It takes commands: ``pan`` and ``tilt`` [rad], anticlockwise and upwards, and ``zoom``, from 0 for the widest view
    to 1 for the narrowest. The camera follows at its rates. Without a command it returns to 0.

    Parameters
    ----------
    width, height
        Of the image, in pixels.
    colours
        The colours it looks for, as names of CSS or '#rrggbb'.
    slots
        Number of blobs that a reading holds.
    fov, fov_min
        The horizontal field of view at zoom 0 and at zoom 1 [rad].
    range_max
        Longest range of the view [m].
    eye
        Height of the lens above the ground [m].
    """

    unit: ClassVar[str] = "mixed"
    channels: ClassVar[tuple[str, ...]] = ("pan", "tilt", "zoom")

    width: int = parameter(160, ge=1, le=10_000, static=True, help="columns of the image")
    height: int = parameter(120, ge=1, le=10_000, static=True, help="rows of the image")
    colours: tuple[str, ...] = parameter(
        ("red", "green", "blue", "yellow"), static=True, help="the colours it looks for, by names of CSS or '#rrggbb'"
    )
    slots: int = parameter(8, ge=1, le=10_000, static=True, help="how many blobs a reading has room for")
    fov: float = parameter(math.pi / 3.0, unit="rad", gt=0, le=2.0 * math.pi, help="horizontal field of view at zoom 0")
    fov_min: float = parameter(math.pi / 18.0, unit="rad", gt=0, le=2.0 * math.pi, help="the same at zoom 1")
    range_max: float = parameter(8.0, unit="m", gt=0, help="how far it sees")
    eye: float = parameter(0.3, unit="m", gt=0, help="height of the lens above the ground")
    pan_max: float = parameter(math.radians(100.0), unit="rad", ge=0, le=math.pi, help="how far it pans to either side")
    tilt_max: float = parameter(
        math.radians(30.0), unit="rad", ge=0, le=math.pi / 2.0, help="how far it tilts up and down"
    )
    pan_rate: float = parameter(math.radians(90.0), unit="rad/s", gt=0, help="how fast it pans and tilts")
    zoom_rate: float = parameter(0.5, unit="1/s", gt=0, help="how much of its range it zooms in a second")

    def __attrs_post_init__(self) -> None:
        for colour in self.colours:
            try:
                ImageColor.getrgb(colour)
            except ValueError:
                problem = f"expected names of colours in CSS, or '#rrggbb', got {colour!r}"
                raise ParameterError("colours", problem) from None
        if self.fov_min > self.fov:
            raise ParameterError("fov_min", f"expected no more than fov {self.fov!r}, got {self.fov_min!r}")

    def size(self, drive: Drive) -> int:
        """Seven values for each slot."""
        return len(_COLUMNS) * self.slots

    def columns(self) -> Mapping[str, str]:
        """Colour, columns and rows of the image, range and bearing."""
        return _COLUMNS

    def start(self, context: Context) -> State:
        """Pan [rad], tilt [rad] and zoom `(N, 3)`."""
        return {"head": np.zeros((context.rows, 3))}

    def actuate(self, command: Array, dt: float, state: State, draws: Draws) -> None:
        """Pan, tilt and zoom towards the command `(N, 3)`, as far as there is time."""
        pan_max, tilt_max, rate = np.asarray(self.pan_max), np.asarray(self.tilt_max), np.asarray(self.pan_rate)
        high = np.concatenate((pan_max, tilt_max, np.ones_like(pan_max)), axis=1)
        low = np.concatenate((-pan_max, -tilt_max, np.zeros_like(pan_max)), axis=1)
        most = np.concatenate((rate, rate, np.asarray(self.zoom_rate)), axis=1) * dt
        head = state["head"]
        state["head"] = head + np.clip(np.clip(command, low, high) - head, -most, most)

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Blobs, nearest first `(N, 7 * slots)`; for the noise chain also ``slot``, ``range`` and ``empty``."""
        pan, tilt, zoom = (state["head"][:, i : i + 1] for i in range(3))
        pixel = (self.fov + (self.fov_min - self.fov) * zoom) / self.width  # [rad]
        turned = np.zeros((view.rows, 3))
        turned[:, 2:] = pan
        middle = 0.5 * self.width - 0.5 - np.arange(self.width)  # of each column, from the image's middle leftwards
        ranges, things = view.look(compose(view.pose, turned), pixel * middle, np.asarray(self.range_max))
        known = _colour_indices(view.colours, self.colours)
        colour = np.where(things >= 0, known[things], -1)
        # Image rows from the thing's top down to the ground in front of it.
        high = np.where(things >= 0, view.heights[things], 0.0)
        away = np.where(np.isfinite(ranges), np.maximum(ranges, 1e-9), 1.0)
        upper = 0.5 * self.height - (elementary.arctan2(high - self.eye, away) - tilt) / pixel
        lower = 0.5 * self.height - (elementary.arctan2(0.0 - self.eye, away) - tilt) / pixel
        first = np.clip(np.floor(upper), 0, self.height - 1)
        last = np.clip(np.ceil(lower) - 1.0, 0, self.height - 1)
        colour = np.where((lower > 0.0) & (upper < self.height), colour, -1)
        found = _blobs(colour, ranges, first, last)
        bearing = pan[found.row, 0] + pixel[found.row, 0] * (
            0.5 * (self.width - 1.0) - 0.5 * (found.left + found.right)
        )
        lines = np.stack(
            (found.colour, found.left, found.right, found.top, found.bottom, found.range, wrap_angle(bearing)), axis=1
        )
        values = np.full((view.rows, self.slots, len(_COLUMNS)), np.inf)
        values[:, :, 0] = -1.0
        order = np.lexsort((found.left, found.range, found.row))
        row = found.row[order]
        place = np.arange(len(row)) - np.searchsorted(row, row)
        kept = place < self.slots
        values[row[kept], place[kept]] = lines[order][kept]
        return table_of(values, 5, (-1.0, *(np.inf,) * (len(_COLUMNS) - 1)))


@functools.lru_cache(maxsize=256)
def _colour_indices(things: tuple[str | None, ...], wanted: tuple[str, ...]) -> Ints:
    """The index of each thing's colour among the wanted ones, -1 for none; the last one is for no thing."""
    known = {ImageColor.getrgb(colour): i for i, colour in reversed(list(enumerate(wanted)))}
    return np.array([*(known.get(ImageColor.getrgb(c), -1) if c else -1 for c in things), -1], dtype=np.int64)


@attrs.frozen
class _Blobs:
    """Blobs of all rows, one after another `(Q,)`."""

    row: Ints
    colour: Ints
    left: Ints
    right: Ints
    top: Array
    bottom: Array
    range: Array


def _blobs(colour: Ints, ranges: Array, first: Array, last: Array) -> _Blobs:
    """Runs of one colour in the columns `(N, W)` of images; -1 is for no colour."""
    begins = colour >= 0
    begins[:, 1:] &= colour[:, 1:] != colour[:, :-1]
    ends = colour >= 0
    ends[:, :-1] &= colour[:, 1:] != colour[:, :-1]
    row, left = np.nonzero(begins)
    _, right = np.nonzero(ends)
    width = colour.shape[1]
    at = np.stack((row * width + left, row * width + right + 1), axis=1).ravel()

    def least(of: Array) -> Array:
        if not len(at):
            return np.empty(0)
        # Every second stretch lies between two runs. The extra index lets the last run end at the array's end.
        return np.asarray(np.minimum.reduceat(np.append(of.ravel(), np.inf), at)[::2])

    return _Blobs(row, colour[row, left], left, right, least(first), -least(-last), least(ranges))
