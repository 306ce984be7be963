"""Robots, obstacles and landmarks of a scenario as models of a Stage world, and what Stage cannot hold of them.

The models are such that the scenario loader of Stage reads them as what they were.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from amorsim.foreign.stage.robots import RADIUS, STEERING, TRACK
from amorsim.foreign.stage.write_sensors import list_of, number_of, written_sensors

__all__ = ["stage_models"]

Table = Mapping[str, Any]

_DRIVES = {"differential": "diff", "mecanum": "omni", "ackermann": "car"}
_CORNERS = 32  # of the polygon that a circle is read as
_DISC = _CORNERS / 2.0 * math.sin(2.0 * math.pi / _CORNERS) / math.pi  # its share of the circle's area


class _Lost:
    """What is lost, and for which robots; the same loss of many robots is one line."""

    def __init__(self) -> None:
        self._whose: dict[str, list[str]] = {}

    def add(self, whose: str, what: str) -> None:
        """Note a loss."""
        self._whose.setdefault(what, []).append(whose)

    def lines(self) -> list[str]:
        """A sentence for each kind of loss, with the names of the first three robots."""
        found = []
        for what, whose in self._whose.items():
            names = list(dict.fromkeys(whose))
            more = f" and {len(names) - 3} more" if len(names) > 3 else ""
            found.append(f"{', '.join(names[:3])}{more}: {what}")
        return found


def stage_models(tables: Table) -> tuple[str, list[str]]:
    """The models of a scenario's resolved tables as statements of Stage, without the map; and what is lost, in words.

    Every body must have a pose.
    """
    lost, parts = _Lost(), []
    simulation = tables.get("simulation", {})
    parts.append(f"interval_sim {number_of(1000.0 * simulation.get('dt', 0.1))}\n")
    if simulation.get("duration"):
        parts.append(f"quit_time {number_of(simulation['duration'])}\n")
    for robot in _each(tables.get("robots", ())):
        parts.append(_robot(robot, lost))
    for obstacle in _each(tables.get("obstacles", ())):
        parts.append(_obstacle(obstacle, lost))
    for mark in tables.get("landmarks", ()):
        parts.append(_landmark(mark, lost))
    for zone in tables.get("zones", ()):
        lost.add(f"zone {zone.get('name', '')!r}", "what a zone does is left out; its area is written")
        lines = [*_footprint(zone["shape"], zone, lost, "zone"), f"pose {_pose(zone.get('pose', {}))}"]
        parts.append(_model("zone", [f'name "{zone["name"]}"' if "name" in zone else "", *lines]))
    for key, what in (("lights", "lamps"), ("floor", "the floor's markings and drops")):
        if tables.get(key):
            lost.add("the world", f"{what} are left out")
    return "\n".join(parts), lost.lines()


def _each(bodies: Iterable[Table]) -> Iterator[Table]:
    """Bodies one by one, also those that are in one table with the pose of each."""
    for body in bodies:
        if "count" not in body:
            yield body
            continue
        digits = len(str(body["count"] - 1))
        for k, pose in enumerate(body["start"]["poses"]):
            yield {**body, "name": f"{body['name']}{k:0{digits}d}", "pose": pose}


def _robot(robot: Table, lost: _Lost) -> str:
    who = f"robot {robot['name']!r}"
    drive = robot["drive"]
    lines = [f'name "{robot["name"]}"', f"pose {_pose(robot['pose'])}", *_footprint(robot["shape"], robot, lost, who)]
    length, width = _size(robot["shape"])
    lines += _drive(drive, length, width, lost, who)
    if robot.get("controller", {}).get("use") == "wander":
        lines.append('ctrl "wander"')
        lost.add(who, "Stage's wander goes at its own speed")
    elif robot.get("controller"):
        lost.add(who, f"the controller {robot['controller']['use']!r} is left out: it stands still")
    lines += _marks(robot)
    lines += written_sensors(robot.get("sensors", {}), lambda what: lost.add(who, what))
    for name, estimator in robot.get("estimators", {}).items():
        if estimator["use"] != "dead_reckoning":
            lost.add(who, f"the estimator {name!r} ({estimator['use']}) is left out")
    for key, what in (
        ("errors", "true values that differ from nominal ones"),
        ("ground", "effects of the ground"),
        ("knowledge", "what it knows: map and landmarks"),
        ("initial_belief", "what it knows of its start"),
        ("kidnappings", "kidnappings"),
    ):
        if robot.get(key):
            lost.add(who, f"left out: {what}")
    if robot.get("on_collision", "end") != "continue":
        lost.add(who, "it goes on after a collision, as in Stage")
    return _model("position", lines)


def _drive(drive: Table, length: float, width: float, lost: _Lost, who: str) -> list[str]:
    use = drive["use"]
    kind = _DRIVES.get(use, "diff")
    if use not in _DRIVES:
        lost.add(who, f"the drive {use!r} is written as a diff")
    radii = [value for key, value in drive.items() if key.startswith("wheel_radius")]
    radius, track, base = (radii or [RADIUS * length])[0], drive.get("track", TRACK * width), drive.get("wheelbase")
    read = RADIUS * length, TRACK * width, TRACK * length if kind == "omni" else base
    if any(abs(value - read[0]) > 1e-9 for value in radii) or abs(track - read[1]) > 1e-9:
        lost.add(who, "Stage has no wheels: their radius and track are read back as shares of the body's size")
    elif kind == "omni" and base is not None and abs(base - read[2]) > 1e-9:
        lost.add(who, "the wheelbase of an omni is read back as a share of the body's length")
    speed = math.radians(drive.get("rate_max_deg", 0.0)) * radius
    change = math.radians(drive.get("acceleration_max_deg") or 0.0) * radius
    # Turning in place at most as fast as neither the wheels nor those that are read back can turn the body.
    arm = 0.5 * (max(track, read[1]) + (max(base or 0.0, read[2] or 0.0) if kind == "omni" else 0.0))
    aside = 1.0 if kind == "omni" else 0.0
    turn, push = (math.degrees(each / max(arm, 1e-6)) for each in (speed, change))
    if kind == "car":
        turn = drive["steering_max_deg"]
        if turn > STEERING:
            lost.add(who, f"a car of Stage steers by {STEERING:g} degrees at most")
    lines = [f'drive "{kind}"', f"velocity_bounds {_bounds(speed, aside * speed, turn)}"]
    if change:
        lines.append(f"acceleration_bounds {_bounds(change, aside * change, push)}")
    else:
        lost.add(who, "its acceleration is not bounded; Stage's is read back as 1 m/s^2")
    if kind == "car":
        lines.append(f"wheelbase {number_of(base or length)}")
    if drive.get("lag") or drive.get("steering_lag"):
        lost.add(who, "the lag of its motors is left out")
    return lines


def _bounds(ahead: float, aside: float, turn: float) -> str:
    pairs = ((-each, each) for each in (ahead, aside, 0.0, turn))
    return list_of(number for pair in pairs for number in pair)


def _obstacle(obstacle: Table, lost: _Lost) -> str:
    who = f"obstacle {obstacle['name']!r}"
    if motion := obstacle.get("motion"):
        lost.add(who, f"its motion ({motion['use']}) is left out: it stands still")
    lines = [f'name "{obstacle["name"]}"', f"pose {_pose(obstacle.get('pose', {}))}"]
    return _model("model", [*lines, *_footprint(obstacle["shape"], obstacle, lost, who), *_marks(obstacle)])


def _landmark(mark: Table, lost: _Lost) -> str:
    radius = mark.get("radius", 0.0)
    if radius < 1e-3:
        lost.add(f"landmark {mark['id']}", "its radius is read back as 1 mm")
    side = 2.0 * max(radius, 1e-3) / math.sqrt(_DISC)
    lines = [f"pose {_pose(mark)}", f"size {list_of((side, side, mark.get('height', 1.0)))}", 'shape "circle"']
    lines += [f"fiducial_return {mark['id']}", "obstacle_return 0", "ranger_return -1"]
    if mark.get("height", 0.3) != 0.3:
        lost.add(f"landmark {mark['id']}", "its height is left out")
    return _model("model", [*lines, *_colour(mark)])


def _marks(body: Table) -> list[str]:
    mark = [f"fiducial_return {body['fiducial']}"] if body.get("fiducial") else []
    return [*mark, *_colour(body)]


def _colour(body: Table) -> list[str]:
    colour = body.get("colour")
    return [f'color "{colour}"'] if colour else []


def _footprint(shape: Table, body: Table, lost: _Lost, who: str) -> list[str]:
    """Size, origin and blocks, from which Stage makes the same polygon about the same base point."""
    length, width = _size(shape)
    height = body.get("height", 1.0)
    if shape.get("rounding"):
        lost.add(who, "its round corners are left out")
    if "circle" in shape:
        lost.add(who, f"its circle is read back as a polygon of {_CORNERS} corners")
        place = (shape.get("x", 0.0), shape.get("y", 0.0), 0.0, 0.0)
        return [f"size {list_of((length, width, height))}", f"origin {list_of(place)}", 'shape "circle"']
    points = _points(shape)
    xs, ys = zip(*points, strict=True)
    middle = 0.5 * (min(xs) + max(xs)), 0.5 * (min(ys) + max(ys))
    lines = [f"size {list_of((length, width, height))}", f"origin {list_of((*middle, 0.0, 0.0))}"]
    corners = "".join(f"    point[{k}] {list_of(point)}\n" for k, point in enumerate(points))
    return [*lines, f"block\n  (\n    points {len(points)}\n{corners}    z {list_of((0.0, height))}\n  )"]


def _points(shape: Table) -> list[tuple[float, float]]:
    if "rectangle" in shape:
        length, width = (0.5 * side for side in shape["rectangle"][:2])
        return [(-length, -width), (length, -width), (length, width), (-length, width)]
    return [(float(x), float(y)) for x, y in shape["polygon"]]


def _size(shape: Table) -> tuple[float, float]:
    if "circle" in shape:
        return 2.0 * shape["circle"], 2.0 * shape["circle"]
    xs, ys = zip(*_points(shape), strict=True)
    return max(xs) - min(xs), max(ys) - min(ys)


def _pose(table: Table) -> str:
    return list_of((table.get("x", 0.0), table.get("y", 0.0), 0.0, table.get("heading_deg", 0.0)))


def _model(kind: str, lines: Iterable[str]) -> str:
    return f"{kind}\n(\n" + "".join(f"  {line}\n" for line in lines if line) + ")\n"
