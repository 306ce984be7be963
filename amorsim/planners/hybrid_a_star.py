"""Hybrid A*: paths of cars, forwards and backwards, with a trailer as well."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from amorsim.algorithms.cells import free_cells
from amorsim.array_types import Array
from amorsim.contracts import Plan
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError, parameter
from amorsim.core.shapes import Shape, pack
from amorsim.kernels.search.curves import MOST_WORDS, trace_word
from amorsim.kernels.search.field import new_wave, spread
from amorsim.kernels.search.hybrid import FOUND, GOING_ON, MOVES, Course, Forest, expand_poses
from amorsim.kernels.search.moves import Drive, Room, is_clear, price_of, trailer_along
from amorsim.planners.on_cells import are_joined
from amorsim.planners.on_poses import Ends, PosePlanner, Query

__all__ = ["HybridAStar"]


_AT_A_TIME = 100  # poses, some milliseconds, so that Ctrl-C is noticed
_WAVE_AT_A_TIME = 100_000
_SHOWN = 200  # radii over the spacing of poses in a plan
_MOST_GUIDE = 1_000_000  # cells of the field of distances


@attrs.frozen(kw_only=True)
class HybridAStar(PosePlanner):
    """A path that a car can drive, forwards and backwards, with a trailer as well, by hybrid A*.

    It searches a lattice of places and headings by arcs and straight lines, each from the exact pose at which the car
    arrived, and tries curves of Reeds and Shepp to the goal. What it minimises is `Plan.cost`: the length, where a
    metre backwards costs `backward`, a change of direction `switch`, and a metre on an arc `bend` more. The path is
    usually near the cheapest, not always the cheapest.

    The plan of a car ends at the goal. That of a trailer ends within 0.1 m and 5 degrees of it, or at it, with the
    trailer within `hitch_end` of straight; at the start the trailer is straight behind.

    After D. Dolgov, S. Thrun and others, "Path planning for autonomous vehicles in unknown semi-structured
    environments", IJRR 29, 2010.
    """

    budget: int = parameter(50_000, ge=0, le=1_000_000, help="poses expanded at most")
    cell: float | None = parameter(
        None, unit="m", gt=0, help="side of the lattice's cells; without it a sixth of the radius"
    )
    headings: int = parameter(72, ge=8, le=1024, help="headings of the lattice")
    backward: float = parameter(1.5, ge=1, help="cost of a metre backwards")
    switch: float = parameter(1.0, ge=0, help="cost of a change of direction")
    bend: float = parameter(0.05, ge=0, help="added to the cost of a metre on an arc")
    trailer_length: float | None = parameter(
        None, unit="m", gt=0, help="from the hitch to the trailer's axle; without it there is no trailer"
    )
    hitch_offset: float = parameter(0.0, unit="m", help="how far behind the car's base point the hitch is")
    hitch_max: float = parameter(1.0, unit="rad", gt=0, le=math.pi, help="how far the hitch turns to either side")
    hitch_end: float = parameter(0.05, unit="rad", gt=0, help="largest hitch angle at the goal")
    trailer_width: float = parameter(1.0, unit="m", gt=0, help="width of the trailer's outline")
    trailer_front: float = parameter(0.5, unit="m", help="how far its outline goes ahead of the trailer's axle")
    trailer_rear: float = parameter(0.5, unit="m", help="how far its outline goes behind the trailer's axle")

    def __attrs_post_init__(self) -> None:
        if self.trailer_front + self.trailer_rear < 1e-3:
            problem = f"expected 1 mm more than {-self.trailer_front!r}, behind its front, got {self.trailer_rear!r}"
            raise ParameterError("trailer_rear", problem)

    def plan(
        self, world: Map, start: Sequence[float], goal: Sequence[float], *, footprint: Shape | None = None
    ) -> Plan:
        """The plan for a car with this footprint; see `amorsim.Planner.plan`.

        Without a heading, start and goal have that of the line between them.
        """
        query, ends = self.query(world, start, goal, footprint)
        drive = self._drive()
        room = self._room(query)
        for name, pose in zip(("start", "goal"), ends, strict=True):
            blocked = query.blocked(name, pose)
            if blocked is not None:
                return blocked
            if not is_clear(room, drive, *pose, 0.0):
                message = f"at the {name} the trailer, straight behind, overlaps a wall or is too near to one"
                return Plan(status=f"{name}_blocked", message=message)
        if self.budget == 0:
            return Plan(status="budget", message="the budget of 0 poses was used up")
        guide = _Guide.of(query, ends, self._side)
        if guide.no_way:
            return Plan(status="unreachable", message=guide.no_way)
        plan = self._searched(room, drive, guide, ends)
        if plan.status == "unreachable" and (narrow := query.narrow_place(ends)):
            plan = attrs.evolve(plan, message=f"{plan.message}; {narrow}")
        return plan

    @property
    def _side(self) -> float:
        return self.radius / 6.0 if self.cell is None else self.cell

    def _drive(self) -> Drive:
        return Drive(
            radius=self.radius,
            step=1.5 * self._side,
            trailer_length=self.trailer_length or 0.0,
            hitch_offset=self.hitch_offset,
            hitch_max=self.hitch_max,
            backward=self.backward,
            switch=self.switch,
            bend=self.bend,
            hitch_end=self.hitch_end,
            place_end=0.1,
            heading_end=math.radians(5.0),
        )

    def _room(self, query: Query) -> Room:
        shapes = [query.shape]
        spacing = self.spacing(query.shape.reach)
        if self.trailer_length is not None:
            length = self.trailer_front + self.trailer_rear
            trailer = Shape.rectangle(length, self.trailer_width, x=0.5 * (self.trailer_front - self.trailer_rear))
            shapes.append(trailer)
            # The hitch moves by so much for a metre of the car, and turns the trailer about its axle.
            hitch = 1.0 + abs(self.hitch_offset) / self.radius
            spacing = min(spacing, self.clearance / (hitch * (1.0 + trailer.reach / self.trailer_length)))
        bodies = pack(shapes)
        return Room(
            grid=query.world.grid,
            origin_x=query.world.origin[0],
            origin_y=query.world.origin[1],
            yaw=query.world.origin[2],
            bodies=bodies,
            clearance=self.clearance,
            spacing=spacing,
            edges=np.empty((len(bodies.vertices), 5)),
            nearest=np.empty(3),
            pose=np.empty(3),
        )

    def _searched(self, room: Room, drive: Drive, guide: _Guide, ends: Ends) -> Plan:
        course = Course(
            goal=np.array(ends[1]),
            to_go=guide.to_go,
            width=guide.width,
            side=guide.side,
            cell=self._side,
            headings=self.headings,
            hitch_cell=math.radians(10.0) if self.trailer_length is not None else 0.0,
            words=np.zeros((MOST_WORDS, 5, 2)),
            order=np.empty(MOST_WORDS),
        )
        forest = _new_forest(ends[0], MOVES * self.budget + 1)
        status = GOING_ON
        while status == GOING_ON and forest.used[2] < self.budget:
            status = expand_poses(room, drive, course, forest, min(_AT_A_TIME, self.budget - int(forest.used[2])))
        expanded = forest.order[: forest.used[2]]
        searched = forest.pose[expanded, :2]
        links = np.concatenate((forest.pose[forest.parent[expanded[1:]], :2], searched[1:]), axis=1)
        if status != FOUND:
            message = (
                f"the budget of {self.budget} poses was used up"
                if status == GOING_ON
                else f"no arcs of radius {self.radius:g} m lead from start to goal with {self.clearance:g} m to the "
                f"walls, as far as a lattice of {self._side:.3g} m and {self.headings} headings can tell"
            )
            kind = "budget" if status == GOING_ON else "unreachable"
            return Plan(status=kind, expanded=len(searched), searched=searched, links=links, message=message)
        moves = _moves(forest)
        poses = _trace(moves, ends[0], self.radius)
        if self.trailer_length is None:
            poses[-1] = ends[1]
        trailer = np.empty((0, 3))
        if self.trailer_length is not None:
            trailer = np.empty_like(poses)
            trailer_along(poses, self.trailer_length, self.hitch_offset, self.hitch_max, trailer)
        return Plan(
            status="found",
            poses=poses,
            length=math.fsum(np.abs(moves[:, 1]).tolist()),
            cost=price_of(drive, moves),
            expanded=len(searched),
            searched=searched,
            links=links,
            trailer=trailer,
        )


@attrs.frozen
class _Guide:
    """The distances of cells to the goal, for a disc within the footprint, or why there is no way even for that."""

    to_go: Array
    width: int
    side: float
    no_way: str = ""

    @classmethod
    def of(cls, query: Query, ends: Ends, cell: float) -> _Guide:
        """The guide to a goal.

        Every footprint holds a disc about its base point. If no free cells lead from start to goal even for the disc,
        less what cells may hide, there is no path.
        """
        world = query.world
        inner = query.inner
        width, height = world.size
        least = math.sqrt(width * height / _MOST_GUIDE)
        side = max(world.resolution, least, min(cell, 0.25 * inner) if inner > 0.0 else cell)
        # A place in a free cell may be nearer to a wall by the cell's diagonal, and a coarse wall thicker by another.
        hidden = math.sqrt(2.0) * side * (1.0 if side == world.resolution else 2.0)
        cells = free_cells(world, max(inner - hidden, 0.0), side=side)
        first, last = (cells.cell_at(*pose[:2]) for pose in ends)
        assert first is not None  # or they would be blocked
        assert last is not None
        if not (cells.free[first] and cells.free[last]):
            return cls(np.zeros(0), cells.width, side)
        is_proof = side == world.resolution or inner > hidden
        if not are_joined(cells.free, cells.width, first, last):
            no_way = query.narrow_place(ends, is_proven=True) if is_proof else ""
            return cls(np.zeros(0), cells.width, side, no_way)
        wave = new_wave(cells.free, last)
        while spread(wave, cells.width, _WAVE_AT_A_TIME) == GOING_ON:
            pass
        return cls(wave.to_go * side, cells.width, side)


def _new_forest(start: tuple[float, float, float], room: int) -> Forest:
    slots = 1 << math.ceil(math.log2(2 * room + 2))
    forest = Forest(
        pose=np.empty((room, 4)),
        cost=np.empty(room),
        parent=np.empty(room, np.int32),
        move=np.empty((room, 2)),
        key=np.empty(room),
        heap=np.empty(room, np.int32),
        slots=np.zeros(slots, np.int32),
        names=np.empty(slots, np.int64),
        order=np.empty(room, np.int32),
        last=np.zeros((6, 2)),
        used=np.array([1, 1, 0, 0]),
    )
    forest.pose[0] = (*start, 0.0)
    forest.cost[0] = 0.0
    forest.parent[0] = -1
    forest.move[0] = 0.0
    forest.key[0] = 0.0
    forest.heap[0] = 0
    return forest


def _moves(forest: Forest) -> Array:
    """The moves (k, 2) from start to goal, bend and length [m]; equal ones in turn are one."""
    node = int(forest.used[3])
    found: list[list[float]] = []
    while node > 0:
        found.append(forest.move[node].tolist())
        node = int(forest.parent[node])
    merged: list[list[float]] = []
    for bend, length in [*found[::-1], *forest.last.tolist()]:
        if length == 0.0:
            continue
        if merged and merged[-1][0] == bend and merged[-1][1] * length > 0.0:
            merged[-1][1] += length
        else:
            merged.append([bend, length])
    return np.array(merged).reshape(-1, 2)


def _trace(moves: Array, start: tuple[float, float, float], radius: float) -> Array:
    spacing = radius / _SHOWN
    word = moves / (1.0, radius)
    out = np.empty((int(np.ceil(np.abs(moves[:, 1]) / spacing).sum()) + len(moves) + 1, 3))
    return out[: trace_word(*start, word, radius, spacing, out)]
