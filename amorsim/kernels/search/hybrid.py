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

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.search.curves import reeds_shepp_words
from amorsim.kernels.search.moves import Drive, Room, go, price

__all__ = ["FOUND", "GOING_ON", "MOVES", "Course", "Forest", "expand_poses"]

Ints32 = NDArray[np.int32]

GOING_ON, FOUND, NONE_LEFT, FULL = 0, 1, 2, 3
MOVES = 10
"""From each pose: five bends, forwards and backwards."""
LEADS = 7
"""Ways to come to the goal: straight to it, or by a straight run of one of three lengths, forwards or backwards."""


class Course(NamedTuple):
    """Where the goal is, and how far it is at least."""

    goal: Array  # (3,)
    to_go: Array  # (n,) [m] of the cells of a field, along eight directions; empty if there is none
    width: int
    side: float  # [m]
    cell: float  # [m] of the lattice
    headings: int
    hitch_cell: float  # [rad]
    words: Array  # scratch (48, 5, 2)
    order: Array  # scratch (48,)


class Forest(NamedTuple):
    """The poses reached, the lattice that holds the best of each of its cells, and the queue."""

    pose: Array  # (n, 4) x, y [m], heading, hitch [rad]
    cost: Array  # (n,)
    parent: Ints32  # (n,)
    move: Array  # (n, 2) the bend and the length [m] of the move that led there
    key: Array  # (n,) of the queue
    heap: Ints32  # (n,) its poses
    slots: Ints32  # (m,) hash table of poses + 1 by their cell of the lattice; m is a power of two
    names: Ints  # (m,) the cells
    order: Ints32  # (n,) the poses expanded
    last: Array  # (6, 2) the moves from the last pose to the goal
    used: Ints  # (4,) poses, entries of the queue, poses expanded, the last pose before `last`


@part
def _words(drive: Drive, course: Course, x: float, y: float, heading: float, lead: float) -> int:
    """Write the curves to the place from which `lead` [m] straight ahead is the goal; returns their number."""
    gx = course.goal[0] - lead * math.cos(course.goal[2])
    gy = course.goal[1] - lead * math.sin(course.goal[2])
    c, s = math.cos(heading), math.sin(heading)
    dx, dy = (gx - x) / drive.radius, (gy - y) / drive.radius
    return int(reeds_shepp_words(c * dx + s * dy, c * dy - s * dx, course.goal[2] - heading, course.words))


@part
def _to_go(drive: Drive, course: Course, room: Room, x: float, y: float, heading: float) -> float:
    """An estimate of the cost from a pose to the goal: the larger of a curve without walls and a way without turns."""
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
    """The slot of a cell of the lattice, or the free slot for it."""
    mask = forest.slots.shape[0] - 1
    # Neighbouring names are spread over the table; nothing here is larger than 63 bits.
    at = (((name & 0xFFFFFFFF) * 0x2545F491 + (name >> 32) * 0x9E3779B1) >> 20) & mask
    while forest.slots[at] != 0 and forest.names[at] != name:
        at = (at + 1) & mask
    return int(at)


@part
def _push(forest: Forest, node: int, key: float) -> None:
    """Put a pose into the queue, a binary heap, by its key: the estimated cost of a path through it."""
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
                total += price(drive, course.words[i, k, 0], length, before)
                before = length
        if lead != 0.0:
            total += price(drive, 0.0, lead, before)
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
            is_free, nx, ny, nh, hitch = go(room, drive, nx, ny, nh, hitch, bend, length)
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
    """Expand poses until one leads to the goal, none is left, `most` are expanded, or there is no more room.

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
            is_free, nx, ny, nh, nb = go(room, drive, x, y, heading, hitch, bend, length)
            if not is_free:
                continue
            cost = forest.cost[node] + price(drive, bend, length, forest.move[node, 1])
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
