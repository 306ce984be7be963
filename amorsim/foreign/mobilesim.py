"""Maps of MobileSim and ARIA (``.map``): lines and points, with the robot's home, goals and forbidden areas."""

from __future__ import annotations

import array
import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import MapLoader, ScenarioDocument, ScenarioLoader
from amorsim.core.errors import MapError, ScenarioError
from amorsim.core.maps.cell_lines import extent_of
from amorsim.core.maps.map import Map
from amorsim.core.numbers import millimetres
from amorsim.core.parameters import parameter
from amorsim.foreign.robot_names import Names
from amorsim.foreign.text import NUMBER, Faults, is_binary, read_text

__all__ = ["MobileSim", "MobileSimMap", "RobotMap", "Thing", "read_robot_map"]

_MOST_BYTES = 50_000_000
_MOST_THINGS = 10_000
_MOST_CELLS = 100_000_000
_MOST_POINTS = 1_000_000  # that are written
_FARTHEST_MM = 1e9
_FIRST = re.compile(rb"(?:\xef\xbb\xbf)?\s*2D-Map")
_CAIRN = re.compile(r'Cairn:\s+(\S+)\s+(\S+)\s+(\S+)\s+(\S+)\s+"([^"]*)"\s+(\S+)\s+"([^"]*)"\s*(.*)')
_KNOWN = re.compile(r"(NumPoints|NumLines|Resolution|MinPos|MaxPos|LineMinPos|LineMaxPos|\w+AreSorted):")
_HOMES = ("RobotHome", "Dock")
_GOAL = 0.1  # [m] radius of the zone that stands for a goal
_LINE = 0.05  # [m] width of the zone that stands for a forbidden line
_ROOM = 1.0  # [m] around a home that lies outside the lines


class Thing(NamedTuple):
    """A *cairn* of a map, in metres and degrees: its type, pose and name, and two corners or ends, or none."""

    kind: str
    x: float
    y: float
    degrees: float
    name: str
    ends: tuple[float, float, float, float] | None
    line: int

    @property
    def centre(self) -> tuple[float, float]:
        """The middle between the ends; for an area in the frame of its corners, turned about the origin."""
        assert self.ends is not None
        x, y = (self.ends[0] + self.ends[2]) / 2, (self.ends[1] + self.ends[3]) / 2
        if self.is_line:
            return x, y
        turn = math.radians(self.degrees)
        return x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn)

    @property
    def is_line(self) -> bool:
        """Whether it is a line, from one end to the other."""
        return self.kind.endswith("Line")


@attrs.frozen(eq=False)
class RobotMap:
    """The content of a map of ARIA, in metres."""

    segments: Array  # (M, 4) x1 y1 x2 y2
    points: Array  # (P, 2)
    things: tuple[Thing, ...]
    resolution: float | None  # [m] between points
    bounds: Array  # (B, 2) corners of the map that its head names
    remarks: tuple[str, ...]

    @property
    def start(self) -> tuple[float, float, float] | None:
        """The robot's home, x, y [m] and heading [rad]: its first, or else a dock."""
        for kind in _HOMES:
            for thing in self.things:
                if thing.kind == kind:
                    return thing.x, thing.y, math.radians(thing.degrees)
        return None


def read_robot_map(path: Path) -> RobotMap:
    """The content of a map of MobileSim or ARIA.

    Raises
    ------
    ScenarioError
        If it is none, or with the line of each row that is broken.
    """
    reader = _Reader(path)
    for number, line in enumerate(read_text(path, _MOST_BYTES, "a map of MobileSim").splitlines(), start=1):
        if text := line.strip():
            reader.read(number, text)
    return reader.finish()


class _Reader:
    def __init__(self, path: Path) -> None:
        self._faults = Faults(path)
        self._section = ""
        self._rows = {"LINES": array.array("d"), "DATA": array.array("d")}
        self._counts: dict[str, float] = {}
        self._things: list[Thing] = []
        self._left_out: dict[str, None] = {}
        self._bounds = array.array("d")

    def read(self, number: int, text: str) -> None:
        """Read a line that is not empty."""
        if not self._section:
            if not text.startswith("2D-Map"):
                self._faults.add(number, f"expected 2D-Map in the first line, got {text[:40]!r}")
                self._faults.raise_if_any()
            self._section = "head"
        elif text in self._rows:
            self._section = text
        elif self._section == "head":
            self._head(number, text)
        else:
            count = 4 if self._section == "LINES" else 2
            self._rows[self._section].extend(self._metres(number, text.split(), count) or ())

    def _metres(self, line: int, words: list[str], count: int) -> list[float] | None:
        """So many numbers of millimetres, in metres."""
        found = self._numbers(line, words, count)
        return None if found is None else [number / 1000.0 for number in found]

    def _numbers(self, line: int, words: list[str], count: int) -> list[float] | None:
        """So many numbers."""
        if len(words) != count:
            self._faults.add(line, f"expected {count} numbers, got {len(words)}: {' '.join(words)[:60]!r}")
            return None
        found = []
        for word in words:
            value = float(word) if NUMBER.fullmatch(word) else math.nan
            if not abs(value) <= _FARTHEST_MM:
                self._faults.add(line, f"expected a number of at most {_FARTHEST_MM:g} mm, got {word[:40]!r}")
                return None
            found.append(value)
        return found

    def _head(self, line: int, text: str) -> None:
        key = text.partition(":")[0]
        if key == "Cairn":
            self._cairn(line, text)
        elif not _KNOWN.match(text):
            self._left_out[key.split()[0]] = None
        elif key.endswith("Pos"):
            self._bounds.extend(self._metres(line, text.partition(":")[2].split(), 2) or ())
        elif key in ("NumPoints", "NumLines", "Resolution"):
            words = text.partition(":")[2].split()
            found = self._numbers(line, words, 1)
            if found is not None:
                self._counts[key] = found[0]

    def _cairn(self, line: int, text: str) -> None:
        found = _CAIRN.fullmatch(text)
        if found is None:
            self._faults.add(
                line, 'expected Cairn: TYPE X Y TH "..." ICON "NAME", and X1 Y1 X2 Y2 for an area or a line'
            )
            return
        kind, x, y, degrees, _, _, name, rest = found.groups()
        place = self._numbers(line, [x, y, degrees], 3)
        ends = self._metres(line, rest.split(), 4) if rest else None
        if place is None or (rest and ends is None):
            return
        if len(self._things) == _MOST_THINGS:
            self._faults.add(line, f"expected at most {_MOST_THINGS} cairns")
            self._faults.raise_if_any()
        corners = None if ends is None else (ends[0], ends[1], ends[2], ends[3])
        self._things.append(Thing(kind, place[0] / 1000.0, place[1] / 1000.0, place[2], name, corners, line))

    def finish(self) -> RobotMap:
        """The map, once all is read."""
        if not self._section:
            self._faults.add(1, "expected 2D-Map in the first line, got nothing")
        self._faults.raise_if_any()
        segments = np.frombuffer(self._rows["LINES"], dtype=np.float64).reshape(-1, 4)
        points = np.frombuffer(self._rows["DATA"], dtype=np.float64).reshape(-1, 2)
        remarks = []
        for key, count in (("NumLines", len(segments)), ("NumPoints", len(points))):
            if key in self._counts and self._counts[key] != count:
                remarks.append(f"{key} says {self._counts[key]:g}, and there are {count}")
        if self._left_out:
            remarks.append(f"left out: {', '.join(list(self._left_out)[:20])}")
        bounds = np.frombuffer(self._bounds, dtype=np.float64).reshape(-1, 2)
        spacing = self._counts.get("Resolution", 0.0) / 1000.0
        return RobotMap(
            segments, points, tuple(self._things), spacing if spacing > 0.0 else None, bounds, tuple(remarks)
        )


@attrs.frozen(kw_only=True)
class MobileSimMap(MapLoader):
    """The walls of MobileSim's and ARIA's maps (``.map``): lines, and points of a cell each; the robot's home.

    Goals and areas are for the scenario loader of the same name.
    """

    extensions: ClassVar[tuple[str, ...]] = (".map",)

    resolution: float | None = parameter(
        None, unit="m", gt=0, help="side of a cell; without it that of the points, or 0.01 if there are lines alone"
    )

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file begins with ``2D-Map``."""
        return bool(_FIRST.match(head)) and not is_binary(head)

    def load(self, path: Path) -> Map:
        """The map of a file.

        Raises
        ------
        MapError
            If the file cannot be read, a row is broken, or there is nothing in it.
        """
        try:
            read = read_robot_map(path)
        except ScenarioError as error:
            raise MapError(str(error)) from error
        try:
            return self._map(read, path.stem)
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    @classmethod
    def save(cls, world: Map, path: Path) -> MobileSimMap:
        """Write the walls that a map was made from, or else a point for each occupied cell; see `amorsim.save_map`."""
        side, (left, bottom, yaw) = world.resolution, world.origin
        width, height = world.size
        farthest = max(map(abs, extent_of(world)))
        if farthest > _FARTHEST_MM / 1000.0:
            most = _FARTHEST_MM / 1000.0
            raise MapError(
                f"it reaches to {farthest:.7g} m from the origin; expected {most:g} m at most, as in MobileSim"
            )
        lines, points = world.segments, np.empty((0, 2))
        if lines is None:
            if yaw:
                raise MapError("a map of MobileSim has cells along x and y, and this map is turned")
            row, col = np.nonzero(world.to_array())
            if len(row) > _MOST_POINTS:
                raise MapError(f"it has {len(row)} occupied cells; expected {_MOST_POINTS} at most")
            lines = np.empty((0, 4))
            points = np.stack((left + (col + 0.5) * side, bottom + (row + 0.5) * side), axis=-1)
        text = ["2D-Map", f"LineMinPos: {millimetres(left)} {millimetres(bottom)}"]
        text += [f"LineMaxPos: {millimetres(left + width)} {millimetres(bottom + height)}", f"NumLines: {len(lines)}"]
        text += [f"NumPoints: {len(points)}", f"Resolution: {millimetres(side)}"]
        if world.start is not None:
            x, y, heading = world.start
            pose = f"{millimetres(x)} {millimetres(y)} {math.degrees(heading)!r}"
            text.append(f'Cairn: RobotHome {pose} "" ICON "Home"')
        for name, rows in (("LINES", lines), ("DATA", points)):
            text += [name, *(" ".join(map(millimetres, row)) for row in rows.tolist())]
        path.write_text("\n".join(text) + "\n", encoding="ascii", newline="\n")
        return cls(resolution=side)

    def _map(self, read: RobotMap, name: str) -> Map:
        side = self.resolution
        if side is None:
            side = min(max(read.resolution or 0.02, 0.005), 0.1) if len(read.points) else 0.01
        start = read.start
        corners = np.concatenate([read.segments.reshape(-1, 2), read.points, _corners(read.things), read.bounds])
        if start is not None and (not len(corners) or _is_outside(start, corners)):
            home = np.array(start[:2])
            corners = np.concatenate([corners, [home - _ROOM, home + _ROOM]])
        if not len(corners):
            raise MapError("there is neither a line nor a point in it")
        low, high = corners.min(axis=0), corners.max(axis=0)
        extent = (*low.tolist(), *high.tolist())
        if len(read.points) and float(np.prod((high - low) / side)) > _MOST_CELLS:
            raise MapError(f"more than {_MOST_CELLS:g} cells of {side:g} m; give a coarser resolution")
        lines = Map.from_segments(
            read.segments, resolution=side, extent=extent, start=start, warnings=read.remarks, name=name
        )
        if not len(read.points):
            return lines
        cells = lines.to_array()
        at = np.floor((read.points - np.array(lines.origin[:2])) / side).astype(np.int64)
        at = np.clip(at, 0, np.array(cells.shape[::-1]) - 1)
        cells[at[:, 1], at[:, 0]] = 1
        return Map.from_array(
            cells, resolution=side, origin=lines.origin, start=start, warnings=read.remarks, name=name
        )


def _corners(things: Iterable[Thing]) -> Array:
    """Places that the map must hold: the middles of areas and lines, and the places of goals."""
    places = [each.centre if each.ends else (each.x, each.y) for each in things if each.kind not in _HOMES]
    return np.array(places, dtype=np.float64).reshape(-1, 2)


def _is_outside(start: tuple[float, float, float], corners: Array) -> bool:
    at = np.array(start[:2])
    return bool((at < corners.min(axis=0)).any() or (at > corners.max(axis=0)).any())


@attrs.frozen(kw_only=True)
class MobileSim(ScenarioLoader):
    """Maps of MobileSim and ARIA (``.map``): a Pioneer 2DX wanders from the robot's home, or from where it fits.

    Forbidden areas and lines are zones, and so are goals: named places, which do nothing by themselves. Boxes of
    MobileSim (``Sim.BoxObstacle``) are obstacles.
    """

    extensions: ClassVar[tuple[str, ...]] = (".map",)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file begins with ``2D-Map``."""
        return MobileSimMap.sniff(head)

    def read(self, path: Path) -> ScenarioDocument:
        """The scenario of a map.

        Raises
        ------
        ScenarioError
            With the line of each row that is broken.
        """
        read = read_robot_map(path)
        names, zone_names = Names(), Names()
        rover = {"name": names.free("rover"), "model": "pioneer2dx", "controller": {"use": "wander"}}
        tables: dict[str, Any] = {"format": 1, "world": {"map": path.name, "use": "mobilesim"}, "robots": [rover]}
        left_out: dict[str, None] = {}
        lines: dict[str, int] = {}
        for thing in read.things:
            kind = "obstacles" if thing.kind.endswith("Obstacle") else "zones"
            table = _table(thing)
            if table is None:
                if thing.kind not in _HOMES:
                    left_out[thing.kind] = None
                continue
            things = tables.setdefault(kind, [])
            lines[f"{kind}.{len(things)}"] = thing.line
            free = names if kind == "obstacles" else zone_names
            things.append({"name": free.free(thing.name or thing.kind), **table})
        remarks = (f"cairns that are left out: {', '.join(list(left_out)[:20])}",) if left_out else ()
        return ScenarioDocument(tables=tables, remarks=remarks, lines=lines)


def _table(thing: Thing) -> dict[str, Any] | None:
    """Shape and pose of a goal, a line, an area or a box; None for other things."""
    if thing.ends is None:
        if not thing.kind.startswith("Goal"):
            return None
        return {"shape": {"circle": _GOAL}, "pose": _pose(thing.x, thing.y, thing.degrees)}
    x1, y1, x2, y2 = thing.ends
    length, width, degrees = abs(x2 - x1), abs(y2 - y1), thing.degrees
    if thing.is_line:
        length, width, degrees = math.hypot(x2 - x1, y2 - y1), _LINE, math.degrees(math.atan2(y2 - y1, x2 - x1))
    if min(length, width) < 1e-4:
        return None
    return {"shape": {"rectangle": [round(length, 9), round(width, 9)]}, "pose": _pose(*thing.centre, degrees)}


def _pose(x: float, y: float, degrees: float) -> dict[str, float]:
    return {"x": round(x, 9), "y": round(y, 9), "heading_deg": round(math.remainder(degrees, 360.0), 9)}
