"""The models of a Stage world as things of a scenario: walls, robots, obstacles, landmarks and zones."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import shapely

from amorsim.core.errors import MapError
from amorsim.core.files.reading import is_file
from amorsim.foreign.stage.bitmaps import Cells, dark_pixels, dark_span, is_dark_near
from amorsim.foreign.stage.entities import Model, Value, World
from amorsim.foreign.stage.geometry import (
    Box,
    Spot,
    colour_of,
    moved,
    outline_of,
    polygons,
    pose_of,
    segments_of,
    size_of,
    spot_of,
)
from amorsim.foreign.stage.notes import Notes

__all__ = ["MOST_CELLS", "Body", "Mark", "Picture", "Plan", "plan_of"]

MOST_CELLS = 100_000_000
"""Most cells of a map with bitmaps."""

_RESOLUTION = 0.02  # [m], Stage's own
_MARGIN = 5.0  # [m] around the models of a world without a floor plan
_ROOM = 1.0  # [m] around what stands outside the floor plan
_FARTHEST = 1e6  # [m]
_MOST_BODIES = 10_000
_STATIC = ("model", "floorplan", "zone", "puck", "charger")
_OF_MODEL = frozenset(
    {
        "pose",
        "size",
        "origin",
        "bitmap",
        "boundary",
        "obstacle_return",
        "ranger_return",
        "laser_return",
        "fiducial_return",
    }
)


@attrs.frozen(kw_only=True, eq=False)
class Body:
    """A standing body, or a part of the floor: its area in the frame of a spot."""

    name: str
    area: Any
    spot: Spot
    colour: str | None
    height: float
    fiducial: int
    model: Model

    def world(self) -> Any:
        """The area in the world."""
        return moved(self.area, self.spot)


@attrs.frozen(kw_only=True, eq=False)
class Mark:
    """A model that can only be found by its fiducial."""

    id: int
    spot: Spot
    radius: float
    colour: str | None


@attrs.frozen(kw_only=True, eq=False)
class Picture:
    """A bitmap, and the box that it is stretched over."""

    dark: Cells
    box: Box


@attrs.define(eq=False)
class Plan:
    """The content of a world. `walls` are closed rings of points in the world; `remarks` are on the map alone."""

    resolution: float = _RESOLUTION
    extent: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    walls: list[list[tuple[float, float]]] = attrs.field(factory=list)
    pictures: list[Picture] = attrs.field(factory=list)
    robots: list[tuple[Model, Spot]] = attrs.field(factory=list)
    bodies: list[Body] = attrs.field(factory=list)
    marks: list[Mark] = attrs.field(factory=list)
    zones: list[Body] = attrs.field(factory=list)
    bitmaps: dict[Path, None] = attrs.field(factory=dict)
    remarks: list[str] = attrs.field(factory=list)

    @property
    def segments(self) -> list[tuple[float, float, float, float]]:
        """The sides of the walls."""
        return segments_of(self.walls)


def plan_of(world: World, notes: Notes, *, crop_bitmaps: bool, resolution: float | None) -> Plan:
    """The plan of a world's models; its faults are in the notes.

    Parameters
    ----------
    crop_bitmaps
        Whether the dark part of a bitmap alone fills the model's size, as in Stage, and not the whole bitmap.
    resolution
        Side of a cell [m], in place of the world's own.
    """
    planner = _Planner(world, notes, crop_bitmaps)
    planner.walk(world.models, Spot())
    planner.split()
    planner.measure(resolution)
    return planner.plan


class _Planner:
    def __init__(self, world: World, notes: Notes, crop_bitmaps: bool) -> None:
        self._world = world
        self._notes = notes
        self._crops = crop_bitmaps
        self._boxes: list[Box] = []
        self._read: dict[Path, Cells | None] = {}
        self.plan = Plan()

    def walk(self, models: Iterable[Model], at: Spot) -> None:
        """Put models that stand in a frame into the plan."""
        for model in models:
            if model.kind == "position":
                self.plan.robots.append((model, at.then(pose_of(model, self._notes))))
            elif model.kind in _STATIC:
                spot = at.then(pose_of(model, self._notes))
                self._static(model, spot)
                self.walk((each for each in model.inner if each.kind != "block"), spot)
            elif model.kind == "window":
                self._notes.remark_shown_only("window")
            elif model.kind != "block":
                self._notes.remark(
                    f"loose {model.kind}", f"a {model.kind} that no robot carries is left out", model.place
                )

    def _static(self, model: Model, spot: Spot) -> None:
        notes, values = self._notes, model.values
        notes.check_keys(model, _OF_MODEL)
        is_zone, is_floor = model.kind == "zone", model.kind == "floorplan"
        touches = notes.number(values, "obstacle_return", 0.0 if is_zone else 1.0) != 0.0
        seen = "laser_return" if "laser_return" in values and "ranger_return" not in values else "ranger_return"
        is_seen = notes.number(values, seen, -1.0 if is_zone else 1.0) >= 0.0
        length, width, height = size_of(model, notes)
        box = Box(spot.then(spot_of(model, "origin", notes)), length, width)
        is_wall = False
        if notes.number(values, "boundary", 1.0 if is_floor else 0.0):
            self._wall(box)
            is_wall = True
        if name := notes.text(values, "bitmap"):
            self._bitmap(name, values["bitmap"], box)
            is_wall = True
        if is_wall and not touches:
            notes.remark(
                "solid", f"the walls of {model.called} stop robots, though its obstacle_return is 0", model.place
            )
        if is_wall and not any(each.kind == "block" for each in model.inner):
            return
        area = outline_of(model, notes)
        if area is None:
            notes.remark("no area", f"{model.called} covers no area and is left out", model.place)
            return
        body = Body(
            name=notes.text(values, "name") or model.called,
            area=area,
            spot=spot,
            colour=colour_of(model, notes),
            height=height,
            fiducial=notes.count(values, "fiducial_return", 0, 2**31 - 1) if "fiducial_return" in values else 0,
            model=model,
        )
        if touches or is_seen:
            if touches is not is_seen:
                how = "seen by rangers, and is here" if touches else "touched, and is here"
                notes.remark(f"half {touches}", f"in Stage {model.called} cannot be {how}", model.place)
            self.plan.bodies.append(body)
        elif body.fiducial:
            radius = max(math.sqrt(area.area / math.pi), 1e-3)
            self.plan.marks.append(Mark(id=body.fiducial, spot=box.spot, radius=radius, colour=body.colour))
        else:
            self.plan.zones.append(body)

    def _wall(self, box: Box) -> None:
        self.plan.walls.append(box.corners())
        self._boxes.append(box)

    def _bitmap(self, name: str, value: Value, box: Box) -> None:
        self._boxes.append(box)
        path = _find(name, value.place.file, self._world.files[0])
        if path is None:
            self.plan.remarks.append(
                f"{value.place.file.name}:{value.place.line}: there is no bitmap {name!r}: nothing of it is in the map"
            )
            return
        self.plan.bitmaps[path] = None
        if path not in self._read:
            try:
                self._read[path] = dark_pixels(path)
            except MapError as error:
                self._notes.fault(value.place, f"bitmap: {error}")
                self._read[path] = None
        dark = self._read[path]
        if dark is None:
            return
        if min(box.width, box.height) <= 0.0:
            self._notes.fault(
                value.place, f"bitmap: the size it is stretched over, {box.width:g} x {box.height:g} m, is 0"
            )
            return
        if self._crops:
            dark = dark[dark_span(dark)]
        self.plan.pictures.append(Picture(dark=dark, box=box))

    def split(self) -> None:
        """Make walls of bodies that have holes or overlap others or a bitmap, since an obstacle must stand free."""
        plan = self.plan
        if len(plan.bodies) > _MOST_BODIES:
            place = plan.bodies[_MOST_BODIES].model.place
            self._notes.fault(place, f"there are {len(plan.bodies)} obstacles; expected {_MOST_BODIES} at most")
            return
        areas = [body.world() for body in plan.bodies]
        fixed = {i for i, area in enumerate(areas) if any(part.interiors for part in polygons(area))}
        fixed |= _overlapping(areas)
        if areas and plan.walls:
            rings = shapely.STRtree([shapely.LinearRing(ring) for ring in plan.walls])
            fixed |= {i for i, area in enumerate(areas) if len(rings.query(area, predicate="intersects"))}
        for i, area in enumerate(areas):
            near = (is_dark_near(each.dark, each.box, area.bounds, plan.resolution) for each in plan.pictures)
            if i not in fixed and any(near):
                fixed.add(i)
        for i in sorted(fixed):
            for part in polygons(areas[i]):
                plan.walls += [list(ring.coords)[:-1] for ring in (part.exterior, *part.interiors)]
        plan.bodies = [body for i, body in enumerate(plan.bodies) if i not in fixed]

    def measure(self, resolution: float | None) -> None:
        """Find how large the map is, and how fine."""
        plan, notes = self.plan, self._notes
        corners = [corner for box in self._boxes for corner in box.corners()]
        things = [area.bounds for area in map(Body.world, (*plan.bodies, *plan.zones))]
        things += [(*low, *high) for ring in plan.walls for low, high in [_bounds(ring)]]
        things += [(mark.spot.x, mark.spot.y, mark.spot.x, mark.spot.y) for mark in plan.marks]
        things += [(spot.x, spot.y, spot.x, spot.y) for _, spot in plan.robots]
        if corners:
            low, high = _bounds(corners)
            outside = [
                each
                for each in things
                if each[0] < low[0] or each[1] < low[1] or each[2] > high[0] or each[3] > high[1]
            ]
            low, high = _with(low, high, outside, _ROOM)
        elif things:
            low, high = _with((math.inf, math.inf), (-math.inf, -math.inf), things, _MARGIN)
            plan.remarks.append(
                f"the world has no floor plan: the map ends {_MARGIN:g} m beyond its models, with a wall"
            )
        else:
            raise MapError(f"{self._world.files[0]}: there is no model in it")
        if max(map(abs, (*low, *high))) > _FARTHEST:
            raise MapError(f"{self._world.files[0]}: its models are up to {max(map(abs, (*low, *high))):g} m away")
        plan.extent = (*low, *high)
        wanted = notes.number(self._world.values, "resolution", _RESOLUTION)
        if not wanted > 0.0:
            notes.fault(self._world.values["resolution"].place, f"resolution: expected a number > 0, got {wanted:g}")
            wanted = _RESOLUTION
        side = wanted if resolution is None else resolution
        cells = (high[0] - low[0]) * (high[1] - low[1]) / side**2
        if cells > MOST_CELLS and plan.pictures:
            if resolution is not None:
                raise MapError(
                    f"{cells:.3g} cells of {side:g} m; expected {MOST_CELLS:g} at most, so a coarser resolution"
                )
            side = _rounded(side * math.sqrt(cells / MOST_CELLS))
            plan.remarks.append(
                f"the resolution {wanted:g} m, which would be {cells:.3g} cells, is taken as {side:g} m; "
                "[world] resolution says another one"
            )
        plan.resolution = side


def _overlapping(areas: Sequence[Any]) -> set[int]:
    """The areas whose insides overlap another one's; touching does not count."""
    tree, them = shapely.STRtree(areas), np.array(areas, dtype=object)
    found = set()
    for i, area in enumerate(areas):
        near = tree.query(area)
        near = near[near != i]
        # Where many overlap, the first few are enough to know.
        parts = (near[:8], near[8:])
        if any(len(part) and shapely.relate_pattern(area, them[part], "T********").any() for part in parts):
            found.add(i)
    return found


def _find(name: str, file: Path, world: Path) -> Path | None:
    """A file that a line names: next to the file that it is in, or next to the world."""
    for neighbour in (file, world):
        path = Path(os.path.abspath(neighbour.parent / name))  # noqa: PTH100 - a link keeps the name that it was given
        if is_file(path):
            return path
    return None


def _bounds(points: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], tuple[float, float]]:
    xs, ys = zip(*points, strict=True)
    return (min(xs), min(ys)), (max(xs), max(ys))


def _with(
    low: tuple[float, float],
    high: tuple[float, float],
    things: Sequence[tuple[float, float, float, float]],
    room: float,
) -> tuple[tuple[float, float], tuple[float, float]]:
    for xmin, ymin, xmax, ymax in things:
        low = min(low[0], xmin - room), min(low[1], ymin - room)
        high = max(high[0], xmax + room), max(high[1], ymax + room)
    return low, high


def _rounded(side: float) -> float:
    """The smallest of 1, 2 and 5 times powers of ten that is not less."""
    power = 10.0 ** math.floor(math.log10(side))
    return next(number * power for number in (1.0, 2.0, 5.0, 10.0) if number * power >= side * (1 - 1e-9))
