"""Plans of a robot that navigates: on the map that it was given, and on what it saw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from amorsim.algorithms.cells import Cells, free_cells
from amorsim.algorithms.plans import find_plan
from amorsim.algorithms.speed_profile import pieces_of
from amorsim.array_types import Array, Bools
from amorsim.contracts import Beliefs, Plan, Planner, RobotModel, State
from amorsim.controllers.pursuit import turn_back
from amorsim.core.errors import ComponentError, ControllerError, PlanError
from amorsim.core.maps.estimated_map import estimated_map
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.kernels.avoidance.seen_window import Window

__all__ = [
    "PLACES",
    "STATUSES",
    "Answer",
    "Ways",
    "keep_searched",
    "lay_path",
    "no_path",
    "polyline",
    "turns_back_later",
]


STATUSES = ("found", "unreachable", "start_blocked", "goal_blocked", "budget", "refused")
PLACES = 192  # corners of a path
_SEARCHED = 1024  # places that are kept of what was searched
_AROUND = 3.0  # [m] of open ground around all that matters, without a map
_DETOUR = 1.3  # times the length of a narrow way that a way with room to turn may have
_TURN = 0.1  # [rad] between two points of a curve
_EXPLAINED = 0.3  # [m] from a known wall, what is seen is that wall
_STEP_OUT = 0.5  # [m] from the robot to the nearest place that a plan may start from


class Answer(NamedTuple):
    """The outcome of a plan."""

    status: str
    """One of `STATUSES`."""
    points: Array = np.empty((0, 2))
    """(M, 2) [m] of the path; none without one."""
    searched: Array = np.empty((0, 2))
    """(K, 2) [m] places; of two plans those of the one that was made last."""
    axle: Array = np.empty((0, 2))
    """(L, 2) [m] of the path of the trailer's axle; none without a trailer."""


class Ways(NamedTuple):
    """How robots of a group plan."""

    planner: Planner
    robot: RobotModel
    mapper: str
    """Name of the estimator on whose map they plan; empty: on the map that they were given."""
    wide: Array
    """(N,) [m] the reach of the footprint and what the avoider keeps free around it, or `narrow` if that is more."""
    reach: float
    """[m] the reach of the footprint, or `narrow` if that is more."""
    narrow: float
    """[m] of room to walls, at least."""
    mapped: dict[str, Beliefs]
    """The mapper's beliefs in this step, once they were looked up."""
    made: dict[tuple[int, bytes, bytes], Plan]
    """Plans with headings of this step on known maps, which robots that start alike in all replicas share."""

    @classmethod
    def of(
        cls, robot: RobotModel, planner: Planner, mapper: str, clearance: Array | float, least_clearance: float | None
    ) -> Ways:
        """The ways of these robots, whose avoiders keep a `clearance` [m], one or `(N, 1)`.

        Without a `least_clearance` [m], paths keep at least half the width of the footprint.
        """
        reach = float(robot.shape.reach)
        half = min(float(np.abs(robot.shape.outline[:, 1]).max()), reach)
        narrow = half if least_clearance is None else least_clearance
        room = np.zeros((robot.rows, 1)) + reach + clearance
        return cls(planner, robot, mapper, np.maximum(room[:, 0], narrow), max(reach, narrow), narrow, {}, {})

    def plan(self, pose: Array, goal: Array, window: Window, row: int, since: float) -> Answer:
        """The outcome of the plan from a robot's pose to its goal (2,) or (3,).

        Of the ways that keep different rooms from walls it is the widest that is hardly longer than the shortest.
        """
        if self.planner.plans_headings:
            return self._for_car(pose, goal, window, row, since)
        goal = goal[:2]
        world = self._world(self._known(row), pose, goal, window, row, since)
        found: dict[float, tuple[float, Array]] = {}
        status, searched = "unreachable", np.empty((0, 2))
        wide, least = float(self.wide[row]), float(np.hypot(*(goal - pose[:2])))
        for room in dict.fromkeys((wide, self.narrow, self.reach)):
            plan, points = self._with_room(world, pose, goal, room, row)
            status, searched = ("refused", searched) if plan is None else (plan.status, plan.searched)
            if plan is not None and status == "found":
                found[room] = (plan.length, points)
            if room == self.narrow:
                if room not in found:
                    break  # nor is there a way with more room
                least = found[room][0]
            if wide in found and found[wide][0] <= _DETOUR * least:
                break
        if not found:
            return Answer(status, searched=searched)
        least = min(length for length, _ in found.values())
        widest = max(room for room, (length, _) in found.items() if length <= _DETOUR * least)
        return Answer("found", found[widest][1], searched)

    def _known(self, row: int) -> Map | None:
        """The world as a robot knows it: the map that it was given, or that it has made."""
        if not self.mapper:
            return self.robot.map_of(row)
        if self.mapper not in self.mapped:
            self.mapped[self.mapper] = self.robot.beliefs[self.mapper]  # of all rows
        return estimated_map(self.mapped[self.mapper], row)

    def _for_car(self, pose: Array, goal: Array, window: Window, row: int, since: float) -> Answer:
        """As `plan`, with headings: the path's corners, and those of lines near its curves.

        Of what was seen, that counts which the known map does not explain. So walls do not grow by the errors of scan
        and estimate, of which a bay leaves no room.
        """
        known = self._known(row)
        new = None if known is None else free_cells(known, _EXPLAINED, side=max(known.resolution, window.side))
        world = self._world(known, pose, goal[:2], window, row, since, new)
        key = (id(world), pose.tobytes(), goal.tobytes())
        plan = self.made.get(key)
        if plan is None:
            try:
                plan = self._find(row, world, pose.tolist(), goal.tolist(), self.robot.shape)
            except PlanError:
                return Answer("refused")
            if world is known and not self.mapper:
                self.made[key] = plan
        if plan.status != "found":
            return Answer(plan.status, searched=plan.searched)
        axle = polyline(plan.trailer) if len(plan.trailer) else plan.points[:0]
        return Answer("found", polyline(plan.poses), plan.searched, axle)

    def _find(
        self, row: int, world: Map, start: Sequence[float], goal: Sequence[float], footprint: Shape | None
    ) -> Plan:
        """The planner's plan for a row; a fault is reported with the robot's name."""
        try:
            return find_plan(self.planner, world, start, goal, footprint)
        except ComponentError as error:
            name = self.robot.names[row] if self.robot.names else ""
            raise ControllerError(f"{self.robot.who(row)}: {error}", robot=name) from error.__cause__

    def _with_room(self, world: Map, pose: Array, goal: Array, room: float, row: int) -> tuple[Plan | None, Array]:
        """The plan, or None if it was refused, and the points of its path from the robot on."""
        start = (float(pose[0]), float(pose[1]))
        out = self._way_out(world, start, room)
        footprint = Shape.circle(room) if room > 1e-6 else None
        try:
            plan = self._find(row, world, out, (float(goal[0]), float(goal[1])), footprint)
        except PlanError:
            return None, np.empty((0, 2))
        if plan.status != "found" or out == start:
            return plan, plan.points
        return plan, np.concatenate(([start], plan.points))

    def _way_out(self, world: Map, start: tuple[float, float], room: float) -> tuple[float, float]:
        """The place nearest to the start from which a plan can begin; the start if there is none near."""
        side = getattr(self.planner, "cell", None)
        try:
            cells = free_cells(
                world, room, side=side, avoid_unknown=bool(getattr(self.planner, "avoid_unknown", False))
            )
        except PlanError:
            return start
        place = cells.cell_at(*start)
        if place is None or cells.free[place]:
            return start
        most = int(_STEP_OUT / cells.side) + 1
        row, col = divmod(place, cells.width)
        rows = np.arange(max(row - most, 0), min(row + most + 1, len(cells.free) // cells.width))
        cols = np.arange(max(col - most, 0), min(col + most + 1, cells.width))
        near = (rows[:, None] * cells.width + cols).ravel()
        near = near[cells.free[near] != 0]
        if not len(near):
            return start
        places = cells.places(near)
        x, y = places[np.argmin((places[:, 0] - start[0]) ** 2 + (places[:, 1] - start[1]) ** 2)].tolist()
        return x, y

    def _world(
        self,
        known: Map | None,
        pose: Array,
        goal: Array,
        window: Window,
        row: int,
        since: float,
        new: Cells | None = None,
    ) -> Map:
        """The map to plan on: what is known and what was seen since a time, only in free cells of `new`, if given."""
        size = window.seen.shape[1]
        up, across = np.nonzero(window.seen[row] >= since)
        corner = window.corner[row]
        # The cells of the world that stand there.
        col = corner[0] + (across - corner[0]) % size
        line = corner[1] + (up - corner[1]) % size
        places = (np.stack((col, line), axis=1) + 0.5) * window.side
        if new is not None:
            cell = [new.cell_at(*place) for place in places.tolist()]
            places = places[[one is not None and bool(new.free[one]) for one in cell]]
        if known is not None:
            if not len(places):
                return known
            side = max(known.resolution, window.side)
            cells = _cells_of(known, side).copy()
            origin = known.origin
        else:
            side = window.side
            both = np.stack((pose[:2], goal))
            low = np.floor((np.concatenate((both, places)).min(axis=0) - _AROUND) / side) * side
            high = np.concatenate((both, places)).max(axis=0) + _AROUND
            shape = np.ceil((high - low) / side).astype(int)
            cells = np.zeros((shape[1], shape[0]), np.uint8)
            origin = (float(low[0]), float(low[1]), 0.0)
        c, s = np.cos(origin[2]), np.sin(origin[2])
        off = places - np.array(origin[:2])
        i = np.floor((c * off[:, 1] - s * off[:, 0]) / side).astype(int)
        j = np.floor((c * off[:, 0] + s * off[:, 1]) / side).astype(int)
        inside = (i >= 0) & (j >= 0) & (i < cells.shape[0]) & (j < cells.shape[1])
        cells[i[inside], j[inside]] = 1
        return Map.from_array(cells, resolution=side, origin=origin)


# Maps never change, so their cells are looked up once.
_known: WeakKeyDictionary[Map, dict[float, npt.NDArray[np.uint8]]] = WeakKeyDictionary()


def _cells_of(world: Map, side: float) -> npt.NDArray[np.uint8]:
    """The cells of a map, 1 where occupied; do not change them."""
    kept = _known.setdefault(world, {})
    if side not in kept:
        kept[side] = world.to_array(resolution=side)
    return kept[side]


def no_path(pose: Array) -> State:
    """State for a path of each robot, at first the place where it stands."""
    rows = len(pose)
    path = np.zeros((rows, PLACES, 2))
    path[:, 0] = pose[:, :2]
    return {
        "path": path,
        "along": np.zeros((rows, PLACES)),
        "count": np.ones(rows, dtype=np.int64),
        "leg": np.zeros(rows, dtype=np.int64),
        "cut": np.zeros((rows, 1), dtype=bool),  # paths that end before their goals
        "searched": np.full((rows, _SEARCHED, 2), np.nan),
    }


def keep_searched(places: Array, row: int, state: State) -> None:
    """Write the searched places into the state, in order; if there are too many for it, every n-th."""
    kept = places[:: max(-(-len(places) // _SEARCHED), 1)]
    state["searched"][row] = np.nan
    state["searched"][row, : len(kept)] = kept


def lay_path(points: Array, row: int, state: State) -> None:
    """Put the corners of a path into the state; a path with too many ends before its goal."""
    corners = _corners(points)
    kept = corners[:PLACES]
    state["cut"][row] = len(corners) > PLACES
    steps = np.diff(kept, axis=0)
    state["path"][row, : len(kept)] = kept
    state["along"][row, : len(kept)] = np.concatenate(([0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))))
    state["count"][row] = len(kept)
    state["leg"][row] = 0


def turns_back_later(state: State) -> Bools:
    """Whether the path of each robot `(N, 1)` changes direction between where it is and its end."""
    legs = np.diff(state["path"], axis=1)
    point = np.arange(1, PLACES - 1)
    ahead = (point > state["leg"][:, None]) & (point < state["count"][:, None] - 1)
    return np.asarray((turn_back(legs[:, 1:], legs[:, :-1]) & ahead).any(axis=1, keepdims=True), dtype=np.bool_)


def polyline(poses: Array) -> Array:
    """Points (K, 2) of a path with headings (M, 3): where it turns about, and on curves where it has turned by so much.

    Lines between them stay near it: on an arc of radius r within r / 800. They are as many as a robot's path may have.
    """
    far = np.abs(pieces_of(poses).lengths) > 0.0
    poses = poses[np.concatenate(([True], far))]
    if len(poses) == 1:
        return np.ascontiguousarray(poses[:, :2])
    pieces = pieces_of(poses)
    ways = np.sign(pieces.lengths)
    turns_about = np.concatenate(([True], ways[1:] * ways[:-1] < 0.0, [True]))
    turned = np.concatenate(([0.0], np.cumsum(np.abs(pieces.turns))))
    turn = _TURN
    while True:
        bend = np.floor(turned / turn)
        kept = turns_about | np.concatenate(([False], bend[1:] > bend[:-1]))
        kept[:-1] |= turns_about[1:]  # so that the last line before it has the path's heading there
        # Where a curve begins and ends.
        straight = pieces.turns == 0.0
        kept[1:-1] |= straight[1:] != straight[:-1]
        if np.count_nonzero(kept) <= PLACES or turn > 1.0:
            return np.ascontiguousarray(poses[kept, :2])
        turn *= 1.5


def _corners(points: Array) -> Array:
    """The points of a path without those that lie straight between their neighbours, or repeat one."""
    if len(points) < 3:
        return points
    steps = np.diff(points, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    far = np.concatenate(([True], lengths > 1e-9))
    points = points[far]
    steps = np.diff(points, axis=0)
    if len(points) < 3:
        return points
    cross = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    before, after = np.hypot(*steps[:-1].T), np.hypot(*steps[1:].T)
    rounding = 4.0 * np.spacing(np.abs(points).max())  # [m] of a step, far from the origin
    turns = np.abs(cross) > 1e-9 * before * after + rounding * (before + after)
    turns |= (steps[:-1] * steps[1:]).sum(axis=1) < 0.0  # where it goes back on the same line
    return np.asarray(points[np.concatenate(([True], turns, [True]))])
