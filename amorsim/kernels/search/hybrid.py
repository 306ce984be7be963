"""Hybrid A*: a search over poses of a car, and of the trailer that it may draw, that are reached by arcs.

After D. Dolgov, S. Thrun and others, "Path planning for autonomous vehicles in unknown semi-structured environments",
IJRR 29, 2010. A cell of the lattice holds one exact pose, so that the car does reach all poses of a path. From time to
time a curve of Reeds and Shepp is tried from where the search is to the goal.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.collision.clearance import map_gap
from amorsim.kernels.collision.footprints import Bodies
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.grid.grid import Grid
from amorsim.kernels.kinematics.trailer import hitch_after
from amorsim.kernels.search.curves import moved, reeds_shepp_words

__all__ = [
    "FOUND",
    "GOING_ON",
    "MOVES",
    "Course",
    "Drive",
    "Forest",
    "Room",
    "expand_poses",
    "is_clear",
    "price_of",
    "trailer_along",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

GOING_ON, FOUND, NONE_LEFT, FULL = 0, 1, 2, 3
MOVES = 10
"""From each pose: five bends, forwards and backwards."""
LEADS = 7
"""Ways to come to the goal: straight to it, or by a straight run of one of three lengths, forwards or backwards."""


class Room(NamedTuple):
    """The walls, and the bodies that must not touch them: the car, and the trailer if there is one."""

    grid: Grid
    origin_x: float
    origin_y: float
    yaw: float
    bodies: Bodies
    clearance: float  # [m]
    spacing: float  # [m] of the poses that are tested
    edges: Floats  # scratch, as in `map_gap`
    nearest: Floats  # scratch (3,)
    pose: Floats  # scratch (3,)


class Drive(NamedTuple):
    """How the car moves, and what its moves cost."""

    radius: float  # [m]
    step: float  # [m] of a move
    trailer_length: float  # [m], 0 without a trailer
    hitch_offset: float  # [m]
    hitch_max: float  # [rad]
    backward: float  # cost of a metre backwards
    switch: float  # cost of a change of direction
    bend: float  # added to the cost of a metre on an arc
    hitch_end: float  # [rad] hitch angle at the goal at most
    place_end: float  # [m] from the goal at which a trailer's plan may end
    heading_end: float  # [rad] likewise


class Course(NamedTuple):
    """Where the goal is, and how far it is at least."""

    goal: Floats  # (3,)
    to_go: Floats  # (n,) [m] of the cells of a field, along eight directions; empty if there is none
    width: int
    side: float  # [m]
    cell: float  # [m] of the lattice
    headings: int
    hitch_cell: float  # [rad]
    words: Floats  # scratch (48, 5, 2)
    order: Floats  # scratch (48,)


class Forest(NamedTuple):
    """The poses reached, the lattice that holds the best of each of its cells, and the queue."""

    pose: Floats  # (n, 4) x, y [m], heading, hitch [rad]
    cost: Floats  # (n,)
    parent: Ints  # (n,)
    move: Floats  # (n, 2) the bend and the length [m] of the move that led there
    key: Floats  # (n,) of the queue
    heap: Ints  # (n,) its poses
    slots: Ints  # (m,) hash table of poses + 1 by their cell of the lattice; m is a power of two
    names: NDArray[np.int64]  # (m,) the cells
    order: Ints  # (n,) the poses expanded
    last: Floats  # (6, 2) the moves from the last pose to the goal
    used: NDArray[np.int64]  # (4,) poses, entries of the queue, poses expanded, the last pose before `last`


@part
def trailer_pose(
    x: float, y: float, heading: float, hitch: float, length: float, offset: float
) -> tuple[float, float, float]:
    """The pose (x, y [m], heading [rad]) of the trailer's axle, behind a car at a pose in the world.

    `hitch` [rad] is the car's heading less the trailer's, `length` [m] from the hitch to the axle, and `offset` [m]
    from the car's base point back to the hitch.
    """
    back = heading - hitch
    return (
        x - offset * math.cos(heading) - length * math.cos(back),
        y - offset * math.sin(heading) - length * math.sin(back),
        back,
    )


@part
def _gap(room: Room, body: int, x: float, y: float, heading: float) -> float:
    """Signed gap [m], as in `map_gap`, of a body (0 the car, 1 the trailer) at a pose in the world [m, rad]."""
    room.pose[0], room.pose[1], room.pose[2] = x, y, heading
    map_gap(
        room.grid,
        room.origin_x,
        room.origin_y,
        room.yaw,
        room.bodies,
        body,
        room.pose,
        room.clearance,
        room.edges,
        room.nearest,
    )
    return float(room.nearest[0])


@part
def _is_clear(room: Room, drive: Drive, x: float, y: float, heading: float, hitch: float) -> bool:
    """Whether car and trailer at a pose in the world [m, rad], with a hitch angle [rad], are free."""
    if not _gap(room, 0, x, y, heading) >= room.clearance:
        return False
    if drive.trailer_length == 0.0:
        return True
    if abs(hitch) >= drive.hitch_max:
        return False
    tx, ty, back = trailer_pose(x, y, heading, hitch, drive.trailer_length, drive.hitch_offset)
    return _gap(room, 1, tx, ty, back) >= room.clearance


@kernel
def is_clear(room: Room, drive: Drive, x: float, y: float, heading: float, hitch: float) -> bool:
    """Whether car and trailer keep the clearance to all walls, and the hitch its limit."""
    return _is_clear(room, drive, x, y, heading, hitch)


@part
def _go(
    room: Room, drive: Drive, x: float, y: float, heading: float, hitch: float, bend: float, length: float
) -> tuple[bool, float, float, float, float]:
    """Whether a move is free, and the pose and hitch at its end."""
    pieces = max(1, math.ceil(abs(length) / room.spacing))
    part_length = length / pieces
    part_turn = bend / drive.radius * part_length
    nx, ny, nh = x, y, heading
    for k in range(1, pieces + 1):
        ahead = length * (k / pieces)
        nx, ny, nh = moved(x, y, heading, ahead, bend / drive.radius * ahead)
        if drive.trailer_length > 0.0:
            hitch = hitch_after(
                hitch, part_length, part_turn, drive.trailer_length, drive.hitch_offset, drive.hitch_max
            )
        if not _is_clear(room, drive, nx, ny, nh, hitch):
            return False, nx, ny, nh, hitch
    return True, nx, ny, nh, hitch


@part
def _price(drive: Drive, bend: float, length: float, before: float) -> float:
    """What a move costs after one of length `before`, whose sign is its direction."""
    metres = abs(length)
    cost = metres * (drive.backward if length < 0.0 else 1.0)
    if bend != 0.0:
        cost += drive.bend * metres
    if before * length < 0.0:
        cost += drive.switch
    return cost


@part
def _words(drive: Drive, course: Course, x: float, y: float, heading: float, lead: float) -> int:
    """Write the curves to the place from which a straight run `lead` [m] comes to the goal; returns how many."""
    gx = course.goal[0] - lead * math.cos(course.goal[2])
    gy = course.goal[1] - lead * math.sin(course.goal[2])
    c, s = math.cos(heading), math.sin(heading)
    dx, dy = (gx - x) / drive.radius, (gy - y) / drive.radius
    return int(reeds_shepp_words(c * dx + s * dy, c * dy - s * dx, course.goal[2] - heading, course.words))


@part
def _to_go(drive: Drive, course: Course, room: Room, x: float, y: float, heading: float) -> float:
    """What it costs from a pose to the goal, about: the longer of a curve without walls and a way without turns."""
    count = _words(drive, course, x, y, heading, 0.0)
    least = math.inf
    for i in range(count):
        total = 0.0
        for k in range(5):
            total += abs(course.words[i, k, 1])
        least = min(least, total * drive.radius)
    c, s = math.cos(room.yaw), math.sin(room.yaw)
    dx, dy = x - room.origin_x, y - room.origin_y
    col = math.floor((c * dx + s * dy) / course.side)
    row = math.floor((c * dy - s * dx) / course.side)
    at = (row + 1) * course.width + col + 1
    if 0 <= at < course.to_go.shape[0]:
        field = course.to_go[at]
        if field < math.inf:
            # Longer than a straight way by 8 % at most: a search that is a little greedy takes up far fewer poses.
            least = max(least, field - 2.0 * course.side)
    return least


@part
def _cell_name(course: Course, x: float, y: float, heading: float, hitch: float) -> int:
    """The name of the cell of the lattice that holds a pose [m, rad] and a hitch angle [rad]."""
    col = math.floor(x / course.cell) & 0xFFFFF
    row = math.floor(y / course.cell) & 0xFFFFF
    turn = math.floor(heading / (2.0 * math.pi) * course.headings + 0.5) % course.headings
    fold = (math.floor(hitch / course.hitch_cell + 0.5) + 64) & 127 if course.hitch_cell > 0.0 else 0
    return int((((col << 20) | row) << 17) | (turn << 7) | fold)


@part
def _slot(forest: Forest, name: int) -> int:
    """The slot of a cell of the lattice, or the free one where it belongs."""
    mask = forest.slots.shape[0] - 1
    # Neighbouring names are spread over the table; nothing here is larger than 63 bits.
    at = (((name & 0xFFFFFFFF) * 0x2545F491 + (name >> 32) * 0x9E3779B1) >> 20) & mask
    while forest.slots[at] != 0 and forest.names[at] != name:
        at = (at + 1) & mask
    return int(at)


@part
def _push(forest: Forest, node: int, key: float) -> None:
    """Put a pose into the queue, a binary heap, by its key: about what a path through it costs."""
    at = forest.used[1]
    forest.used[1] = at + 1
    while at > 0:
        above = (at - 1) >> 1
        if forest.key[above] <= key:
            break
        forest.key[at] = forest.key[above]
        forest.heap[at] = forest.heap[above]
        at = above
    forest.key[at] = key
    forest.heap[at] = node


@part
def _pop(forest: Forest) -> int:
    """The pose with the least key, taken out of a queue that is not empty."""
    first = forest.heap[0]
    size = forest.used[1] - 1
    forest.used[1] = size
    if size > 0:
        key, node = forest.key[size], forest.heap[size]
        at = 0
        while True:
            below = 2 * at + 1
            if below >= size:
                break
            if below + 1 < size and forest.key[below + 1] < forest.key[below]:
                below += 1
            if key <= forest.key[below]:
                break
            forest.key[at] = forest.key[below]
            forest.heap[at] = forest.heap[below]
            at = below
        forest.key[at] = key
        forest.heap[at] = node
    return int(first)


@part
def _shoot(room: Room, drive: Drive, course: Course, forest: Forest, node: int, lead: float, tries: int) -> float:
    """Try curves from a pose to the goal, cheapest first; the cost of the first free one, written to `last`, or inf."""
    x, y, heading, start_hitch = (
        forest.pose[node, 0],
        forest.pose[node, 1],
        forest.pose[node, 2],
        forest.pose[node, 3],
    )
    count = _words(drive, course, x, y, heading, lead)
    for i in range(count):
        before = forest.move[node, 1]
        total = 0.0
        for k in range(5):
            length = course.words[i, k, 1] * drive.radius
            if length != 0.0:
                total += _price(drive, course.words[i, k, 0], length, before)
                before = length
        if lead != 0.0:
            total += _price(drive, 0.0, lead, before)
        course.order[i] = total
    for _ in range(min(tries, count)):
        best = 0
        for i in range(1, count):
            if course.order[i] < course.order[best]:
                best = i
        cost = course.order[best]
        if cost == math.inf:
            return math.inf
        course.order[best] = math.inf
        nx, ny, nh, hitch = x, y, heading, start_hitch
        is_free = True
        for k in range(6):
            bend = course.words[best, k, 0] if k < 5 else 0.0
            length = course.words[best, k, 1] * drive.radius if k < 5 else lead
            forest.last[k, 0] = bend
            forest.last[k, 1] = length
            if length == 0.0:
                continue
            is_free, nx, ny, nh, hitch = _go(room, drive, nx, ny, nh, hitch, bend, length)
            if not is_free:
                break
        if is_free and (drive.trailer_length == 0.0 or abs(hitch) <= drive.hitch_end):
            return float(cost)
    forest.last[:] = 0.0
    return math.inf


@part
def _is_near(drive: Drive, course: Course, forest: Forest, node: int) -> bool:
    """Whether a pose with a trailer is as good as the goal."""
    dx, dy = forest.pose[node, 0] - course.goal[0], forest.pose[node, 1] - course.goal[1]
    turn = forest.pose[node, 2] - course.goal[2]
    turn = abs(math.atan2(math.sin(turn), math.cos(turn)))
    near = dx * dx + dy * dy <= drive.place_end * drive.place_end
    return bool(near and turn <= drive.heading_end and abs(forest.pose[node, 3]) <= drive.hitch_end)


@part
def _leads_to_goal(room: Room, drive: Drive, course: Course, forest: Forest, node: int, left: float) -> bool:
    """Whether a curve from a pose to the goal is free; `left` is the least that it costs."""
    # Far from the goal a curve is rarely free, and is tried less often.
    every = max(1, int(left / (2.0 * drive.radius)))
    if forest.used[2] % every != 0:
        return False
    lead = 0.0
    if drive.trailer_length > 0.0:
        # A straight run draws a trailer straight. Backwards, it keeps straight one that is. One of them at a time.
        turn = (forest.used[2] // every) % LEADS
        lead = drive.trailer_length * (0.0, 1.0, 2.0, 4.0, -1.0, -2.0, -4.0)[turn]
    return _shoot(room, drive, course, forest, node, lead, 4) < math.inf


@kernel
def expand_poses(room: Room, drive: Drive, course: Course, forest: Forest, most: int) -> int:
    """Expand poses until one of them leads to the goal, none is left, `most` are, or there is no room for more.

    The first pose, at its cost of 0, is in the queue before the first call.
    """
    used = forest.used
    for _ in range(most):
        if used[1] == 0:
            return NONE_LEFT
        if used[0] + MOVES > forest.cost.shape[0]:
            return FULL
        left = forest.key[0]
        node = _pop(forest)
        left -= forest.cost[node]
        x, y, heading, hitch = forest.pose[node, 0], forest.pose[node, 1], forest.pose[node, 2], forest.pose[node, 3]
        slot = _slot(forest, _cell_name(course, x, y, heading, hitch))
        if forest.slots[slot] not in (0, node + 1):  # a better pose of the same cell came later
            continue
        forest.order[used[2]] = node
        used[2] += 1
        if drive.trailer_length > 0.0 and _is_near(drive, course, forest, node):
            forest.last[:] = 0.0
            used[3] = node
            return FOUND
        if _leads_to_goal(room, drive, course, forest, node, left):
            used[3] = node
            return FOUND
        for k in range(MOVES):
            bend = 0.5 * (k // 2) - 1.0
            length = drive.step if k % 2 == 0 else -drive.step
            is_free, nx, ny, nh, nb = _go(room, drive, x, y, heading, hitch, bend, length)
            if not is_free:
                continue
            cost = forest.cost[node] + _price(drive, bend, length, forest.move[node, 1])
            name = _cell_name(course, nx, ny, nh, nb)
            slot = _slot(forest, name)
            held = forest.slots[slot]
            if held != 0 and forest.cost[held - 1] <= cost:
                continue
            new = used[0]
            used[0] = new + 1
            forest.pose[new, 0], forest.pose[new, 1] = nx, ny
            forest.pose[new, 2], forest.pose[new, 3] = nh, nb
            forest.cost[new] = cost
            forest.parent[new] = node
            forest.move[new, 0], forest.move[new, 1] = bend, length
            forest.slots[slot] = new + 1
            forest.names[slot] = name
            _push(forest, new, cost + _to_go(drive, course, room, nx, ny, nh))
    return GOING_ON if used[1] > 0 else NONE_LEFT


@kernel
def price_of(drive: Drive, moves: Floats) -> float:
    """What moves cost one after the other, (k, 2) bend and length [m]."""
    total = 0.0
    before = 0.0
    for k in range(moves.shape[0]):
        if moves[k, 1] != 0.0:
            total += _price(drive, moves[k, 0], moves[k, 1], before)
            before = moves[k, 1]
    return total


@kernel
def trailer_along(poses: Floats, length: float, offset: float, limit: float, out: Floats) -> None:
    """Write the poses (M, 3) of a trailer's axle along those of its tractor, which lie on arcs; straight at first."""
    hitch = 0.0
    for i in range(poses.shape[0]):
        x, y, heading = poses[i, 0], poses[i, 1], poses[i, 2]
        if i > 0:
            dx, dy = x - poses[i - 1, 0], y - poses[i - 1, 1]
            turn = heading - poses[i - 1, 2]
            half = 0.5 * turn
            middle = poses[i - 1, 2] + half
            chord = dx * math.cos(middle) + dy * math.sin(middle)
            ahead = chord if half == 0.0 else chord * half / math.sin(half)
            hitch = hitch_after(hitch, ahead, turn, length, offset, limit)
        out[i, 0], out[i, 1], out[i, 2] = trailer_pose(x, y, heading, hitch, length, offset)
