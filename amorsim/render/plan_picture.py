"""The picture of a plan: the map, the searched places, and the path."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from amorsim.contracts import Plan
from amorsim.core.arguments import check_kind, check_text, numbers
from amorsim.core.error_text import in_words
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError
from amorsim.core.shapes import Shape
from amorsim.render import marks
from amorsim.render.canvas import FINENESS, Canvas
from amorsim.render.legend import Item
from amorsim.render.picture import Page, checked_size

__all__ = ["draw_plan"]

Points = NDArray[np.float64]

_SHADES = ("#dbe9fb", "#cadefa", "#b7d2f8", "#a3c5f5", "#8fb7f1")  # of what was searched first to last
_LINK = "#7fa6dc"
_PATH = "#d1242f"
_BODY = "#f4c7c3"
_MOST_OUTLINES = 60


def draw_plan(
    world: Map,
    plan: Plan,
    start: Sequence[float],
    goal: Sequence[float],
    *,
    footprint: Shape | None = None,
    size: int = 1600,
    title: str = "",
) -> Image.Image:
    """A picture of a plan on its map, RGB, `size` pixels along its longer side.

    What was searched is shaded blue, from light (first) to dark (last), with the lines between the places searched, if
    the planner has them. The path is red, with the footprint along it; a ring marks the start, a disc the goal.

    Raises
    ------
    ParameterError
        If `size` is less than 240 or more than 8192, or something is not what it is to be.
    """
    check_kind(world, Map, "world", "a Map, as am.load_map('room.wld')")
    check_kind(plan, Plan, "plan", "a Plan, as a planner's plan() returns")
    for name, place in (("start", start), ("goal", goal)):
        if len(numbers(place, name, ("N",))) not in (2, 3):
            raise ParameterError(name, f"expected (x, y) or (x, y, heading), got {in_words(place)}")
    if footprint is not None:
        check_kind(footprint, Shape, "footprint", "a Shape, as am.Shape.circle(0.25)")
    size = checked_size(size)
    check_text(title, "title")
    page = _PlanPage(world, plan, start, goal, footprint, size, title)
    page.draw_floor()
    page.draw_searched()
    page.draw_walls()
    page.draw_links()
    page.draw_path()
    return page.finish()


class _PlanPage(Page):
    def __init__(
        self,
        world: Map,
        plan: Plan,
        start: Sequence[float],
        goal: Sequence[float],
        footprint: Shape | None,
        size: int,
        title: str,
    ) -> None:
        self._plan = plan
        self._ends = (start, goal)
        self._footprint = footprint
        super().__init__(world, (), (), (), (), size, title)

    def items(self) -> Sequence[Item]:
        """The entries of the legend."""
        plan = self._plan
        shown = [
            (True, Item("start", _draw_start)),
            (True, Item("goal", _draw_goal)),
            (len(plan.poses) > 1, Item("path", _path_sample)),
            (len(plan.searched) > 0, Item(f"{plan.expanded} searched", _searched_sample)),
        ]
        return [item for is_shown, item in shown if is_shown]

    def draw_searched(self) -> None:
        """Shade the places that were searched."""
        self._canvas.frame = self._plot
        left, top, right, bottom = self._plot
        places = self._plan.searched
        if len(places) == 0:
            return
        side = max(_spacing(self._to_local(places)) * self._scale * FINENESS, 2.0)
        rows, columns = (bottom - top) * FINENESS, (right - left) * FINENESS
        fine = (self._on_page(places) - (left, top)) * FINENESS
        for shade, piece in zip(_SHADES, np.array_split(fine, len(_SHADES)), strict=True):
            low = np.clip(np.round(piece - 0.5 * side).astype(int), 0, (columns, rows))
            high = np.clip(np.round(piece + 0.5 * side).astype(int), 0, (columns, rows))
            # Each square adds 1 to a sum over rows and columns where it begins, and takes it back where it ends.
            changes = np.zeros((rows + 1, columns + 1), np.int32)
            for xs, ys, by in ((low, low, 1), (high, low, -1), (low, high, -1), (high, high, 1)):
                np.add.at(changes, (ys[:, 1], xs[:, 0]), by)
            inside = changes.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0
            self._canvas.mask(inside, (left, top), shade)

    def draw_links(self) -> None:
        """Draw the lines between places that were searched."""
        self._canvas.frame = self._plot
        if len(self._plan.links):
            ends = [self._on_page(self._plan.links[:, columns]) for columns in (slice(0, 2), slice(2, 4))]
            self._canvas.segments(np.concatenate(ends, axis=1), _LINK, 1.2 * self._unit)

    def draw_path(self) -> None:
        """Draw the path, the footprint along it, start and goal."""
        plan, canvas, unit = self._plan, self._canvas, self._unit
        canvas.frame = self._plot
        if self._footprint is not None:
            for pose in _spread(plan.poses, 1.2 * self._footprint.reach):
                outline = self._on_page(_placed(self._footprint.outline, pose))
                canvas.line(np.concatenate((outline, outline[:1])), _BODY, 1.6 * unit)
        if len(plan.poses):
            canvas.line(self._on_page(plan.points), _PATH, 4.0 * unit)
        if len(plan.trailer):
            canvas.line(self._on_page(plan.trailer[:, :2]), marks.COLOURS["faint"], 2.0 * unit)
        start, goal = (self._on_page(np.array([end[:2]], np.float64)) for end in self._ends)
        _draw_start(canvas, start[0], unit)
        _draw_goal(canvas, goal[0], unit)


def _draw_start(canvas: Canvas, place: Points, unit: float) -> None:
    canvas.line(place[np.newaxis], _PATH, 19 * unit)
    canvas.line(place[np.newaxis], "white", 10 * unit)


def _draw_goal(canvas: Canvas, place: Points, unit: float) -> None:
    canvas.line(place[np.newaxis], "white", 20 * unit)
    canvas.line(place[np.newaxis], _PATH, 15 * unit)


def _path_sample(canvas: Canvas, place: Points, unit: float) -> None:
    canvas.line(place + np.array([(-34.0, 0.0), (34.0, 0.0)]) * unit, _PATH, 4.0 * unit)


def _searched_sample(canvas: Canvas, place: Points, unit: float) -> None:
    for number, shade in enumerate(_SHADES):
        left = place[0] + (number - 2.5) * 5.0 * unit
        canvas.rectangle((left, place[1] - 11 * unit, left + 5.0 * unit, place[1] + 11 * unit), shade)


def _spacing(places: Points) -> float:
    """The side [m] of the squares that places are middles of: the least step between two of them along an axis."""
    steps = [np.diff(np.unique(np.round(places[:, axis], 9))) for axis in (0, 1)]
    found = [float(step[step > 1e-6].min()) for step in steps if (step > 1e-6).any()]
    return min(found) if found else 0.0


def _spread(poses: Points, spacing: float) -> Points:
    """The first and the last of some poses, and those between that are `spacing` [m] apart along the path."""
    if len(poses) < 3:
        return poses
    legs = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    along = np.concatenate(([0.0], np.cumsum(legs)))
    spacing = max(spacing, along[-1] / _MOST_OUTLINES, 1e-9)
    wanted = np.arange(0.0, along[-1], spacing)
    chosen = np.unique(np.concatenate((np.searchsorted(along, wanted), [len(poses) - 1])))
    kept: Points = poses[chosen]
    return kept


def _placed(outline: Points, pose: Points) -> Points:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.stack(
        (pose[0] + c * outline[:, 0] - s * outline[:, 1], pose[1] + s * outline[:, 0] + c * outline[:, 1]), 1
    )
