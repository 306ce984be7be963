"""Moving pictures: where robots and obstacles truly are, step by step, as a GIF or a video."""

from __future__ import annotations

import functools
import io
import itertools
import math
from collections.abc import Sequence
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from amorsim.core.errors import RunError
from amorsim.core.files.atomic_files import write_bytes
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.patches import Patch
from amorsim.render.marks import COLOURS
from amorsim.render.video import write_video
from amorsim.render.words import font, in_words, round_length

__all__ = ["Animation", "Shown"]

Points = NDArray[np.float64]

FINENESS = 2  # fine pixels along the side of a shown one
SMALLEST = 120  # [px]
COLOURS_MAX = 32
TRAIL = 8.0  # [s] that a robot leaves behind it
TRAILS_UP_TO = 30  # robots
_MARGIN = 8  # [px]
_FOOT = 26  # [px] for words

_ROBOT, _ROBOT_EDGE, _TRAIL = "#9bd4be", COLOURS["true"], "#cfe9df"
_OBSTACLE, _OBSTACLE_EDGE = "#f0c9a0", "#a8652a"


@attrs.frozen(kw_only=True, eq=False)
class Shown:
    """A body in an animation: its outline (V, 2) [m] in its own frame, and its style.

    A part of a robot is drawn as one, beneath it, without a trail and a line ahead.
    """

    outline: Points
    is_robot: bool
    colour: str | None = None
    is_part: bool = False


class Animation:
    """Collects where bodies are, and draws it all at the end.

    Parameters
    ----------
    map
        What is drawn beneath; the picture's edges are parallel to the map's.
    bodies
        What moves, in the order of the poses.
    patches
        Markings and drops of the floor, the lowest first.
    size
        Longer side of the picture [px].

    Raises
    ------
    ParameterError
        If `size` is less than 120.
    """

    def __init__(
        self,
        map: Map,  # noqa: A002 - the field's word
        bodies: Sequence[Shown],
        *,
        patches: Sequence[Patch] = (),
        size: int = 480,
    ) -> None:
        if size < SMALLEST:
            raise ParameterError("size", f"expected at least {SMALLEST} pixels, got {size}")
        self._map = map
        self._bodies = list(bodies)
        self._patches = list(patches)
        width, height = map.size
        self._scale = min((size - 2 * _MARGIN) / width, (size - _MARGIN - _FOOT) / height)  # [px/m]
        self._plot = _MARGIN, _MARGIN, round(width * self._scale), round(height * self._scale)
        # Below a plot as narrow as a corridor there still has to be room for words.
        self._size = max(self._plot[2] + 2 * _MARGIN, SMALLEST), self._plot[3] + _MARGIN + _FOOT
        self._times: list[float] = []
        self._poses: list[Points] = []

    def __len__(self) -> int:
        return len(self._times)

    def add(self, time: float, poses: Points) -> None:
        """Take where the bodies are `(B, 3)` at a time [s]: a frame. A body at nan is not drawn."""
        self._times.append(time)
        self._poses.append(np.array(poses, dtype=np.float64))

    def frame(self, number: int) -> Image.Image:
        """A frame as it is shown, RGB."""
        return self._draw(self._background, number)

    def save(self, path: str | Path, speed: float = 1.0) -> None:
        """Write the frames as a GIF that repeats; `speed` is how much faster than the simulated time it runs.

        Raises
        ------
        RunError
            If there is no frame, or the file cannot be written.
        """
        if not self._times:
            raise RunError(f"{path}: there is nothing to show, not even one frame")
        background = self._background
        few = sorted({0, len(self) // 2, len(self) - 1})
        sample = Image.new("RGB", (self._size[0], self._size[1] * len(few)))
        for row, number in enumerate(few):
            sample.paste(self._draw(background, number), (0, row * self._size[1]))
        palette = sample.quantize(COLOURS_MAX, dither=Image.Dither.NONE)
        colours = palette.getpalette() or []
        lightest = max(range(0, len(colours) - 2, 3), key=lambda i: sum(colours[i : i + 3]))
        palette.putpalette([*colours[:lightest], 255, 255, 255, *colours[lightest + 3 :]])
        # Without dither, and with one palette for all, what stands still costs nothing.
        frames = [
            self._draw(background, number).quantize(palette=palette, dither=Image.Dither.NONE)
            for number in range(len(self))
        ]
        # GIFs count in hundredths; rounded, but never so that they add up.
        shown = [round(100.0 * (time - self._times[0]) / speed) for time in self._times]
        durations = [10 * max(2, after - before) for before, after in itertools.pairwise(shown)] + [1000]
        made = io.BytesIO()
        frames[0].save(made, "GIF", save_all=True, append_images=frames[1:], duration=durations, loop=0, optimize=False)
        write_bytes(path, made.getvalue())

    def save_video(self, path: str | Path, rate: float) -> None:
        """Write the frames as an MP4, `rate` of them a second.

        Raises
        ------
        RunError
            If there is no frame, ffmpeg is missing, or the file cannot be written.
        """
        if not self._times:
            raise RunError(f"{path}: there is nothing to show, not even one frame")
        background = self._background
        write_video(Path(path), (self._draw(background, number) for number in range(len(self))), rate)

    @functools.cached_property
    def _background(self) -> Image.Image:
        """Floor, walls and scale bar, in fine pixels."""
        left, top, width, height = (FINENESS * side for side in self._plot)
        image = Image.new("RGB", (FINENESS * self._size[0], FINENESS * self._size[1]), "white")
        fine = 1.0 / (self._scale * FINENESS)
        cells = self._map.to_array(resolution=fine)[::-1][-height:, :width] != 0
        # A wall a millimetre thick is a fine pixel; it is to be seen.
        thick = cells.copy()
        thick[1:] |= cells[:-1]
        thick[:, 1:] |= cells[:, :-1]
        pen = ImageDraw.Draw(image)
        for patch in self._patches:
            self._draw_patch(pen, patch)
        image.paste(COLOURS["wall"], (left, top + height - len(thick)), Image.fromarray(thick))
        bar = round_length(0.25 * self._size[0] / self._scale)
        y, end = (self._size[1] - 0.5 * _FOOT) * FINENESS, left + bar * self._scale * FINENESS
        tick = 4 * FINENESS
        for line in ((left, y, end, y), (left, y - tick, left, y + tick), (end, y - tick, end, y + tick)):
            pen.line(line, COLOURS["text"], FINENESS)
        pen.text((end + 3 * tick, y), in_words(bar), COLOURS["text"], font(12 * FINENESS), anchor="lm")
        return image

    def _draw_patch(self, pen: ImageDraw.ImageDraw, patch: Patch) -> None:
        points = [(x, y) for x, y in self._fine(patch.points).tolist()]
        if patch.width == 0.0:
            pen.polygon(points, patch.colour)
            return
        width = max(round(patch.width * self._scale * FINENESS), FINENESS)
        pen.line(points, patch.colour, width, joint="curve")

    def _draw(self, background: Image.Image, number: int) -> Image.Image:
        image = background.copy()
        pen = ImageDraw.Draw(image)
        now, poses = self._times[number], self._poses[number]
        robots = [i for i, body in enumerate(self._bodies) if body.is_robot and not body.is_part]
        if len(robots) <= TRAILS_UP_TO:
            first = next(i for i in range(number + 1) if self._times[i] >= now - TRAIL)
            for i in robots:
                places = np.array([frame[i, :2] for frame in self._poses[first : number + 1]])
                trail = self._fine(places[np.isfinite(places).all(axis=1)])
                if len(trail) > 1:
                    pen.line([*map(tuple, trail.tolist())], _TRAIL, 3 * FINENESS)
        order = sorted(range(len(self._bodies)), key=lambda i: (self._bodies[i].is_robot, not self._bodies[i].is_part))
        for i in order:
            body = self._bodies[i]
            x, y, heading = poses[i]
            if math.isnan(x + y + heading):
                continue
            c, s = math.cos(heading), math.sin(heading)
            turned = np.column_stack(
                (
                    x + c * body.outline[:, 0] - s * body.outline[:, 1],
                    y + s * body.outline[:, 0] + c * body.outline[:, 1],
                )
            )
            fill, edge = (_ROBOT, _ROBOT_EDGE) if body.is_robot else (_OBSTACLE, _OBSTACLE_EDGE)
            pen.polygon([*map(tuple, self._fine(turned).tolist())], body.colour or fill, edge)
            if body.is_robot and not body.is_part:
                ahead = self._fine(np.array([[x, y], [x + c * 0.3, y + s * 0.3]]))
                reach = self._scale * FINENESS * float(np.abs(body.outline).max())
                tip = ahead[0] + (ahead[1] - ahead[0]) / (0.3 * self._scale * FINENESS) * reach
                pen.line([tuple(ahead[0].tolist()), tuple(tip.tolist())], edge, FINENESS)
        words = f"{now:.1f} s"
        right, y = (self._size[0] - _MARGIN) * FINENESS, (self._size[1] - 0.5 * _FOOT) * FINENESS
        pen.text((right, y), words, COLOURS["text"], font(13 * FINENESS), anchor="rm")
        return image.reduce(FINENESS)

    def _fine(self, points: Points) -> Points:
        """World metres to fine pixels."""
        x, y, yaw = self._map.origin
        across, up = points[:, 0] - x, points[:, 1] - y
        c, s = math.cos(yaw), math.sin(yaw)
        left, top, _, height = self._plot
        columns = left + (across * c + up * s) * self._scale
        rows = top + height - (up * c - across * s) * self._scale
        return np.column_stack((columns, rows)) * FINENESS
