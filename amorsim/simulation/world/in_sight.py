"""Visibility in a world: lines of sight to marks, and the first thing that a ray hits."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts import Sightings
from amorsim.core.execution.workers import in_turn
from amorsim.kernels.raycast import beyond, body_normals, bresenham, rays, scans
from amorsim.kernels.raycast import visibility as sight
from amorsim.simulation.world.directions import directions_of
from amorsim.simulation.world.world import World

__all__ = ["bind_look", "bind_walls", "find_landmarks", "look_about", "normals_at"]


_FEW = 20  # beams of different directions; for fewer, sorting costs more than it saves
_AHEAD, _STRAIGHT = np.ones((1, 1)), np.zeros((1, 1))  # cosine and sine of the bearing of one beam
_SPARE = 4  # marks tested beyond the number of slots, because some are hidden


def find_landmarks(world: World, own: Ints, eyes: Array, slots: int, range_max: Array, half_angle: Array) -> Sightings:
    """The nearest marks in sight of sensors at `eyes` `(N, 3)` on bodies `own` `(N,)`.

    `range_max` [m] and `half_angle` [rad] are `(N,)`; see `amorsim.contracts.View.landmarks`.
    """
    rows, eyes = len(own), np.ascontiguousarray(eyes)
    found = Sightings(
        np.full((rows, slots), np.inf), np.full((rows, slots), np.inf), np.full((rows, slots), -1, dtype=np.int64)
    )
    around = world.surroundings
    if not len(around.ids):
        return found
    replica, places, carrier = world.replica_index[own], *_marks(world)
    first, mark, distance, bearing = _within_reach(world, own, eyes, range_max, half_angle, replica, places, carrier)
    count = len(mark)
    room, pair, looker = np.full(rows, slots), np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    lines, need = np.empty((count, 3)), np.empty(count)
    given = eyes, replica, own, places, around.radius, first, mark, distance
    # In a crowd the nearest marks fill most slots. So the first pass tests a few, each further one twice as many.
    done, most = 0, slots + _SPARE
    while tested := sight.lines_to_marks(*given, done, most, room, pair, looker, lines, need):
        which = pair[:tested]
        free, met = look_along(world, looker[:tested], lines[:tested], _AHEAD, _STRAIGHT, distance[which])
        pairs = first, mark, distance, bearing, replica, carrier, around.ids
        sight.take_marks(*pairs, which, need, free, met, room, found.range, found.bearing, found.id)
        done, most = done + most, 2 * most
    return found


def _marks(world: World) -> tuple[Array, Ints]:
    """The places of all marks in each replica `(R, F, 2)`, and the bodies that carry them, -1 for none `(R, F)`."""
    around = world.surroundings
    replicas, fixed, carried = len(world.first) - 1, len(around.landmarks), len(around.carriers)
    places = np.empty((replicas, fixed + carried, 2))
    places[:, :fixed] = around.landmarks
    carrier = np.full((replicas, fixed + carried), -1, dtype=np.int64)
    if carried:
        carrier[:, fixed:] = world.first[:-1, None] + around.carriers
        places[:, fixed:] = world.poses[carrier[:, fixed:], :2]
    return places, carrier


def _within_reach(
    world: World,
    own: Ints,
    eyes: Array,
    range_max: Array,
    half_angle: Array,
    replica: Ints,
    places: Array,
    carrier: Ints,
) -> tuple[Ints, Ints, Array, Array]:
    """Pairs of a row and a mark: where each row's begin; the mark, distance [m], bearing from the heading [rad]."""
    first = np.empty(len(own) + 1, dtype=np.int64)
    room = max(4 * len(own) + 64, world.marks_near)
    while True:
        mark, distance, bearing = np.empty(room, dtype=np.int64), np.empty(room), np.empty(room)
        given = eyes, range_max, half_angle, replica, own, places, carrier
        count = sight.marks_near(*given, first, mark, distance, bearing)
        if count <= room:
            break
        room = count
    world.marks_near = count + count // 4  # a guess for the next call
    return first, mark[:count], distance[:count], bearing[:count]


def look_about(
    world: World, own: Ints, origins: Array, bearings: Array, range_max: Array, landmarks: bool = True
) -> tuple[Array, Ints]:
    """Distances [m] `(Q, k)` to the first hit of rays, inf for none; and the thing hit, -1 for a wall or none.

    Things are the bodies of a replica, in order, then the landmarks. Only landmarks with a colour are seen, or none
    at all.
    """
    cos_b, sin_b = directions_of(bearings)
    ranges = np.empty((len(origins), bearings.shape[1]))
    things = np.empty(ranges.shape, dtype=np.int64)
    bind_look(world, own, origins, cos_b, sin_b, range_max, ranges, things)()
    if not landmarks:
        return ranges, things
    around = world.surroundings
    radius = np.where([colour is not None for colour in around.colours[world.count :]], around.radius, 0.0)
    if (radius > 0.0).any():
        sight.look_at_discs(
            np.ascontiguousarray(origins),
            np.array(np.broadcast_to(cos_b, ranges.shape)),
            np.array(np.broadcast_to(sin_b, ranges.shape)),
            range_max,
            around.landmarks,
            radius,
            world.count,
            ranges,
            things,
        )
    return ranges, things


def bind_look(
    world: World,
    own: Ints,
    origins: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    ranges: Array,
    things: Ints,
    nearest: Array | None = None,
) -> Callable[[], None]:
    """A function that writes what beams hit first, as `look_about` does without landmarks.

    All arrays keep their place, and the bearings their values. With `nearest` `(Q, k)` [m], beams that are sure to end
    sooner get the range 0.
    """
    replica = world.replica_index[own]
    if nearest is None:
        walls = bind_walls(world, replica, origins, cos_b, sin_b, range_max, ranges)
    else:
        walls = _bind_beyond(world, replica, origins, cos_b, sin_b, nearest, range_max, ranges)
    things.fill(-1)
    if not world.has_company:
        return walls
    first = world.first[replica, None]
    bodies = world.bind_cast(own, replica, origins, cos_b, sin_b, range_max, ranges, things)

    def look() -> None:
        walls()
        things.fill(-1)
        bodies()
        # Bodies by their numbers within the replica; what is none stays below 0.
        np.subtract(things, first, out=things)
        np.maximum(things, -1, out=things)

    return look


def _bind_beyond(
    world: World,
    replica: Ints,
    origins: Array,
    cos_b: Array,
    sin_b: Array,
    nearest: Array,
    range_max: Array,
    out: Array,
) -> Callable[[], None]:
    """A function like that of `bind_walls`, but it writes 0 for beams sure to end nearer than `nearest` (Q, k) [m]."""

    def prepare(first: int, end: int) -> Callable[[], None]:
        calls: list[Callable[[], None]] = []
        for map_, rows in world.terrain.between(replica, first, end):
            mine = rows if len(cos_b) > 1 else slice(None)
            walls = *map_.grid, *map_.segment_index, *map_.origin
            beams = origins[rows], cos_b[mine], sin_b[mine], nearest[rows], range_max[rows], out[rows]
            calls.append(functools.partial(beyond.cast_beyond, *walls, *beams))
        return in_turn(calls)

    return world.workers.bind(len(origins), cos_b.shape[1], prepare)


def normals_at(world: World, own: Ints, origins: Array, bearings: Array, bodies: Ints) -> Array:
    """Directions [rad] `(Q, k)` of the normals where rays enter bodies of their replicas; nan where `bodies` is -1."""
    first = world.first[world.replica_index[own]]
    which = np.where(bodies >= 0, first[:, None] + bodies, -1)
    out = np.empty(which.shape)
    body_normals.normals_of(
        world.bodies,
        world.poses,
        world.edge_rows,
        np.ascontiguousarray(origins),
        np.array(np.broadcast_to(bearings, which.shape)),
        which,
        out,
    )
    return out


def look_along(
    world: World, own: Ints, lines: Array, cos_b: Array, sin_b: Array, range_max: Array
) -> tuple[Array, Ints]:
    """Distances [m] `(Q, k)` to the first hit of beams from `lines` `(Q, 3)`, inf for none; and the body, -1 for none.

    `cos_b` and `sin_b` `(1 or Q, k)` belong to the beams' bearings; `range_max` is `(Q,)`; `own` `(Q,)` is not seen.
    """
    ranges = np.empty((len(lines), cos_b.shape[1]))
    met = np.full(ranges.shape, -1, dtype=np.int64)
    replica = world.replica_index[own]

    bind_walls(world, replica, lines, cos_b, sin_b, range_max, ranges)()
    if world.has_company:
        world.bind_cast(own, replica, lines, cos_b, sin_b, range_max, ranges, met)()
    return ranges, met


def bind_walls(
    world: World,
    replica: Ints,
    origins: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    out: Array,
    traversal: str = "exact",
    bearings_change: bool = False,
) -> Callable[[], None]:
    """A function that writes the distances [m] `(Q, k)` to the walls along beams into `out`, each time it is called.

    `replica` `(Q,)` is the replica of each origin; the other arguments are those of `rays.cast`. All arrays keep their
    place, and the bearings their values unless `bearings_change`.
    """
    is_scan = traversal != "bresenham" and cos_b.shape[1] > 1 and (len(cos_b) == 1 or cos_b.shape[1] >= _FEW)
    sorted_scan = scans.unsorted_beams(len(origins), *cos_b.shape) if is_scan else ()

    def prepare(first: int, end: int) -> Callable[[], None]:
        calls: list[Callable[[], None]] = []
        for map_, rows in world.terrain.between(replica, first, end):
            mine = rows if len(cos_b) > 1 else slice(None)
            ends = range_max[rows], out[rows]
            if is_scan:
                walls = *map_.grid, *map_.segment_index, *map_.origin
                beams: Any = *walls, origins[rows], *(part[mine] for part in sorted_scan), *ends
                calls.append(functools.partial(scans.cast_scans, *beams))
            else:
                cast = bresenham.bresenham_cast if traversal == "bresenham" else rays.cast
                given = map_.grid, *map_.origin, origins[rows], cos_b[mine], sin_b[mine], *ends
                calls.append(functools.partial(cast, *given))
        return in_turn(calls)

    walls = world.workers.bind(len(origins), out.shape[1], prepare)
    if not is_scan:
        return walls
    sort = functools.partial(scans.sort_beams, cos_b, sin_b, *sorted_scan)
    if bearings_change:
        return in_turn([sort, walls])
    sort()
    return walls
