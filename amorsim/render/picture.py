"""The picture of a run: the map, where the robots went, and where they believed they went."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw

from amorsim.array_types import Bools
from amorsim.core.arguments import whole
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.patches import Patch
from amorsim.render import marks
from amorsim.render.canvas import FINENESS, Canvas
from amorsim.render.labels import write_names
from amorsim.render.legend import Item, items_of
from amorsim.render.marks import COLOURS
from amorsim.render.obstacles import Thing, draw_thing
from amorsim.render.robot_paths import Points, RobotPath, finite, points_of
from amorsim.render.words import font, in_words, round_length, shortened

__all__ = ["LARGEST", "SMALLEST", "Page", "checked_size", "draw_map", "draw_run"]

SMALLEST = 240
"""Longer side [px] of the smallest picture: below, title and legend leave nothing to the map."""
LARGEST = 8192
"""Longer side [px] of the largest, which takes 3 GB while it is drawn."""
_GROWTH = 0.25  # of the map's longer side: how far beyond its edge a path is followed
_ROOM = 0.01  # likewise, around what is shown: walls at the map's edge are seen whole
_FAR = 1000.0  # likewise: beyond, places are as good as equal
_LABELS_UP_TO = 25  # robots: each has its label where it ended
_FULL_SIZE = 20  # robots that are drawn with lines and marks of full size


def checked_size(size: object) -> int:
    """The longer side [px] of a picture; a `ParameterError` for one that is none, or too small or large."""
    expected = f"at least {SMALLEST} pixels and at most {LARGEST}"
    pixels = whole(size, "size", expected, least=SMALLEST)
    if pixels > LARGEST:
        raise ParameterError("size", f"expected {expected}, got {pixels}")
    return pixels


def draw_map(map: Map, *, size: int = 1600, title: str = "") -> Image.Image:  # noqa: A002 - the field's word
    """A picture of a map alone, RGB, `size` pixels along its longer side; see `draw_run`."""
    return draw_run(map, (), size=size, title=title)


def draw_run(
    map: Map,  # noqa: A002 - the field's word
    paths: Sequence[RobotPath],
    *,
    zones: Sequence[ArrayLike] = (),
    patches: Sequence[Patch] = (),
    things: Sequence[Thing] = (),
    size: int = 1600,
    title: str = "",
) -> Image.Image:
    """A picture of a map and of robots' paths on it, RGB, `size` pixels along its longer side.

    The picture's edges are parallel to the map's, whatever its yaw. Walls are dark, true paths a solid line,
    estimated ones a dashed line, collisions crosses; zones of the floor, whose outlines (V, 2) [m] in the world are
    given, are hatched, over its `patches`, which are markings and drops; obstacles, landmarks and lamps have their
    colours; a ring marks where a robot started, a disc (within its outline, if given) where it ended, a diamond where
    it believed it ended. Paths that leave the map make the picture grow by up to a quarter of the map's longer side,
    and are cut off beyond.

    Raises
    ------
    ParameterError
        If `size` is less than 240 or more than 8192.
    """
    size = checked_size(size)
    page = Page(map, paths, [points_of(zone) for zone in zones], patches, things, size, title)
    page.draw_floor()
    page.draw_walls()
    page.draw_things()
    for path in paths:
        page.draw_lines(path)
    for path in paths:
        page.draw_marks(path)
    return page.finish()


class Page:
    """The sheet: a title above, the plot, a legend and a scale bar below."""

    def __init__(
        self,
        map_: Map,
        paths: Sequence[RobotPath],
        zones: Sequence[Points],
        patches: Sequence[Patch],
        things: Sequence[Thing],
        size: int,
        title: str,
    ) -> None:
        self._map = map_
        self._paths = paths
        self._zones = zones
        self._patches = patches
        self._things = things
        self._title = title
        self._unit = size / 1600  # [px] a line 1 px wide in a picture of 1600 px
        # Many paths and marks are drawn finer, or they would cover everything.
        self._pen = self._unit * min(1.0, max(0.35, math.sqrt(_FULL_SIZE / max(len(paths), 1))))
        self._margin = round(34 * self._unit) + 2
        self._line_height = max(16, round(40 * self._unit))
        self._font = font(0.62 * self._line_height)
        self._low, self._high = self._view()
        self._lay_out(size)
        self._canvas = Canvas(*self._size)

    def _lay_out(self, size: int) -> None:
        """Divide the sheet: the legend takes the lines that it needs, the plot the rest."""
        width, height = self._high - self._low
        top = self._margin + (round(1.3 * self._line_height) if self._title else 0)
        items = self.items()
        lines = 0
        self._legend: list[list[Item]] = [[]]
        # More lines make a smaller plot and a narrower page, so that the words may need more lines still.
        while lines < len(self._legend):
            lines = len(self._legend)
            bottom = round(1.5 * self._margin) + self._line_height * lines
            down, across = max(size - top - bottom, size // 4), size - 2 * self._margin
            self._scale = min(across / width, down / height)  # [px/m]
            plot_width, plot_height = (max(1, round(side * self._scale)) for side in (width, height))
            # Below a plot as narrow as a corridor there still has to be room for words.
            page_width = max(plot_width + 2 * self._margin, round(0.6 * size))
            self._bar = round_length(page_width / 7 / self._scale)
            bar_text = in_words(self._bar)
            bar_room = self._bar * self._scale + self._font.getlength(bar_text) + 1.5 * self._line_height
            self._legend = self._wrapped(items, page_width - 2 * self._margin, bar_room)
        self._size = (page_width, top + plot_height + bottom)
        left = (page_width - plot_width) // 2
        self._plot: tuple[int, int, int, int] = (left, top, left + plot_width, top + plot_height)

    def items(self) -> Sequence[Item]:
        """The entries of the legend."""
        return items_of(
            [path.name for path in self._paths if len(path.true) or len(path.estimated)],
            true=any(len(path.true) for path in self._paths),
            estimated=any(len(path.estimated) for path in self._paths),
            zones=len(self._zones),
            kinds={thing.kind for thing in self._things}
            | {"drop" if patch.is_drop else "marking" for patch in self._patches},
            hits=sum(len(path.collisions) for path in self._paths),
        )

    # ------------------------------------------------------------------------------------------ plot

    def draw_floor(self) -> None:
        """Paint the free area, and the area outside the map."""
        self._canvas.frame = self._plot
        self._canvas.rectangle(self._plot, COLOURS["outside"])
        (left, top), (right, bottom) = self._in_plot(np.array([(0.0, self._map.size[1]), (self._map.size[0], 0.0)]))
        self._canvas.rectangle((left, top, right, bottom), "white")

    def draw_walls(self) -> None:
        """Paint the occupied cells, over patches and zones of the floor."""
        canvas = self._canvas
        canvas.frame = self._plot
        left, bottom = self._in_plot(np.zeros((1, 2)))[0]
        fine = 1 / (self._scale * FINENESS)  # [m] side of a fine pixel
        pixels = self._map.to_array(resolution=fine)[::-1] != 0
        # A wall a millimetre thick would be but a breath of grey; cells that can be seen keep their size.
        lacking = max(0, round(2.4 * self._unit * FINENESS - max(1.0, self._map.resolution / fine)))
        # Rows begin at the lower edge; the last, on top, may stick out by a part of a pixel.
        top = bottom - (len(pixels) + lacking) / FINENESS
        pixels = _thickened(np.pad(pixels, lacking), lacking)
        for patch in self._patches:
            marks.draw_patch(canvas, patch, self._on_page(patch.points), self._scale, self._unit)
        for zone in self._zones:
            marks.draw_zone(canvas, self._on_page(zone), self._unit)
        canvas.mask(pixels, (left - lacking / FINENESS, top), COLOURS["wall"])

    def draw_things(self) -> None:
        """Paint obstacles, and over them landmarks and lamps."""
        self._canvas.frame = self._plot
        for thing in sorted(self._things, key=lambda thing: thing.kind != "obstacle"):
            place, outline = self._on_page(thing.place)[0], self._on_page(thing.outline)
            draw_thing(self._canvas, thing, place, outline, self._scale, self._unit)

    def draw_lines(self, path: RobotPath) -> None:
        """Paint a robot's paths, the estimated one over the true one."""
        self._canvas.frame = self._plot
        marks.draw_true_path(self._canvas, self._on_page(path.true), self._pen)
        marks.draw_estimated_path(self._canvas, self._on_page(path.estimated), self._pen)

    def draw_marks(self, path: RobotPath) -> None:
        """Paint where a robot began, ended, believed it ended, and ran into something."""
        canvas, unit = self._canvas, self._pen
        canvas.frame = self._plot
        true, estimated = self._on_page(finite(path.true)), self._on_page(finite(path.estimated))
        if len(true):
            marks.draw_start(canvas, true[0], unit)
        for part in path.parts:
            marks.draw_body(canvas, self._on_page(part), unit, path.colour)
        if path.outline is not None and len(path.outline) > 2 and np.all(np.isfinite(path.outline)):
            marks.draw_body(canvas, self._on_page(path.outline), unit, path.colour)
        if len(true):
            marks.draw_true_end(canvas, true[-1], unit)
        if len(estimated):
            marks.draw_estimated_end(canvas, estimated[-1], unit)
        # A robot that scrapes along a wall has thousands of them: one cross a pixel will do.
        for place in np.unique(np.round(self._on_page(finite(path.collisions))), axis=0):
            marks.draw_collision(canvas, place, unit)

    def _view(self) -> tuple[Points, Points]:
        """The corners (low, high) of the shown area, in the map's frame [m]."""
        size = np.asarray(self._map.size)
        seen = [np.array([(0.0, 0.0), self._map.size])]
        for path in self._paths:
            seen += [self._to_local(finite(path.true)), self._to_local(finite(path.estimated))]
        points = np.concatenate(seen)
        room, most = _ROOM * size.max(), _GROWTH * size.max()
        below, above = -points.min(axis=0), points.max(axis=0) - size
        return -np.minimum(below + room, most), size + np.minimum(above + room, most)

    def _to_local(self, points: Points) -> Points:
        """World metres to metres in the map's frame; values that are not finite become nan."""
        x, y, yaw = self._map.origin
        offsets = np.where(np.isfinite(points), points, np.nan)
        # Numbers of a run that went to pieces are brought to where they still are far away but can be drawn.
        far = _FAR * max(self._map.size)
        across, up = np.clip(offsets, (x - far, y - far), (x + far, y + far)).T - np.array([[x], [y]])
        cosine, sine = math.cos(yaw), math.sin(yaw)
        return np.stack((across * cosine + up * sine, up * cosine - across * sine), axis=1)

    def _in_plot(self, points: Points) -> Points:
        """Metres in the map's frame to pixels of the page."""
        left, top = self._plot[:2]
        columns = left + (points[:, 0] - self._low[0]) * self._scale
        rows = top + (self._high[1] - points[:, 1]) * self._scale
        return np.stack((columns, rows), axis=1)

    def _on_page(self, points: Points) -> Points:
        """World metres to pixels of the page."""
        return self._in_plot(self._to_local(points))

    # ----------------------------------------------------------------------------------------- words

    def finish(self) -> Image.Image:
        """The page, with its frame and words."""
        canvas = self._canvas
        canvas.frame = (0, 0, *self._size)
        left, top, right, bottom = self._plot
        canvas.line(
            np.array([(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], np.float64),
            COLOURS["faint"],
            1.2 * self._unit,
        )
        words = [*self._draw_legend(), self._draw_scale_bar(), *self._labels()]
        image = canvas.shown()
        pen = ImageDraw.Draw(image)
        for text, place, anchor in words:
            pen.text(place, text, COLOURS["text"], self._font, anchor=anchor)
        if self._title:
            large = font(0.85 * self._line_height)
            title = shortened(self._title, large, self._size[0] - 2 * self._margin)
            pen.text((self._margin, 0.55 * self._plot[1]), title, COLOURS["text"], large, anchor="lm")
        if 1 < len(self._paths) <= _LABELS_UP_TO:
            self._write_names(pen)
        return image

    def _write_names(self, pen: ImageDraw.ImageDraw) -> None:
        """A robot's name next to its final position."""
        marked = [self._on_page(finite(line)[-1:]) for path in self._paths for line in (path.true, path.estimated)]
        names = [(path.name, self._on_page(finite(path.true))[-1:]) for path in self._paths]
        edge = max(1, round(3 * self._unit))
        write_names(
            pen, names, np.concatenate(marked), within=self._plot, reach=16 * self._unit, edge=edge, font=self._font
        )

    def _labels(self) -> list[tuple[str, tuple[float, float], str]]:
        """The labels of things, with places and anchors."""
        left, top, right, bottom = self._plot
        labels = []
        for thing in self._things:
            (x, y) = self._on_page(thing.place)[0].tolist()
            reach = max(thing.radius * self._scale, 9 * self._unit)
            if thing.label and left < x < right and top < y < bottom:
                labels.append((thing.label, (x + reach, y - 0.5 * reach), "ls"))
        return labels

    def _sample_width(self, item: Item) -> float:
        if item.draw is None:
            return 0.0
        return (2.2 if item.text.endswith("path") else 0.9) * self._line_height

    def _item_width(self, item: Item) -> float:
        return self._sample_width(item) + float(self._font.getlength(item.text)) + 0.8 * self._line_height

    def _wrapped(self, items: Sequence[Item], width: float, reserved: float) -> list[list[Item]]:
        """The legend's lines, at most `width` [px] long, the first one less the reserved part; or of one item."""
        lines: list[list[Item]] = [[]]
        left = width - reserved
        for item in items:
            needed = self._item_width(item)
            if needed > left and lines[-1]:
                lines.append([])
                left = width
            lines[-1].append(item)
            left -= needed
        return lines

    def _line_middle(self, line: int) -> float:
        return self._plot[3] + 0.5 * self._margin + (line + 0.5) * self._line_height

    def _draw_legend(self) -> list[tuple[str, tuple[float, float], str]]:
        """Draw the samples; the words, with places and anchors, for the finished page."""
        words = []
        for number, line in enumerate(self._legend):
            x, y = float(self._margin), self._line_middle(number)
            for item in line:
                sample = self._sample_width(item)
                if item.draw is not None:
                    middle = np.array([x + sample / 2 - 0.15 * self._line_height, y])
                    item.draw(self._canvas, middle, self._unit)
                text = shortened(item.text, self._font, self._size[0] - 2 * self._margin)
                words.append((text, (x + sample, y), "lm"))
                x += self._item_width(item)
        return words

    def _draw_scale_bar(self) -> tuple[str, tuple[float, float], str]:
        """Draw a bar of a round length at the right; its length in words."""
        right, y = self._size[0] - self._margin, self._line_middle(0)
        left, tick = right - self._bar * self._scale, 0.2 * self._line_height
        bar = [
            (left, y - tick),
            (left, y + tick),
            (left, y),
            (right, y),
            (right, y - tick),
            (right, y + tick),
        ]
        self._canvas.line(np.array(bar), COLOURS["text"], 2.5 * self._unit)
        return in_words(self._bar), (left - 0.3 * self._line_height, y), "rm"


def _thickened(pixels: Bools, by: int) -> Bools:
    """The true pixels grown by a number of pixels along each axis, half of them on either side."""
    grown = pixels
    for axis in (0, 1):
        source = np.moveaxis(grown, axis, 0)
        grown = grown.copy()
        target = np.moveaxis(grown, axis, 0)
        for shift in range(1, by - by // 2 + 1):
            target[shift:] |= source[:-shift]
        for shift in range(1, by // 2 + 1):
            target[:-shift] |= source[shift:]
    return grown
