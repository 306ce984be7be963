"""Moves of a car on arcs, and of its trailer: where they lead, whether they are free, and their costs."""

from __future__ import annotations

import math
from typing import NamedTuple

from amorsim.array_types import Array
from amorsim.kernels.collision.clearance import map_gap
from amorsim.kernels.collision.footprints import Bodies
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.grid.grid import Grid
from amorsim.kernels.kinematics.trailer import hitch_after
from amorsim.kernels.search.curves import moved

__all__ = ["Drive", "Room", "go", "is_clear", "price", "price_of", "trailer_along"]


class Room(NamedTuple):
    """The walls, and the bodies that must not touch them: the car, and its trailer if it has one."""

    grid: Grid
    origin_x: float
    origin_y: float
    yaw: float
    bodies: Bodies
    clearance: float  # [m]
    spacing: float  # [m] of the poses that are tested
    edges: Array  # scratch, as in `map_gap`
    nearest: Array  # scratch (3,)
    pose: Array  # scratch (3,)


class Drive(NamedTuple):
    """The moves of the car, and their costs."""

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


@part
def _trailer_pose(
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
    tx, ty, back = _trailer_pose(x, y, heading, hitch, drive.trailer_length, drive.hitch_offset)
    return _gap(room, 1, tx, ty, back) >= room.clearance


@kernel
def is_clear(room: Room, drive: Drive, x: float, y: float, heading: float, hitch: float) -> bool:
    """Whether car and trailer keep the clearance to all walls, and the hitch its limit."""
    return _is_clear(room, drive, x, y, heading, hitch)


@part
def go(
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
def price(drive: Drive, bend: float, length: float, before: float) -> float:
    """The cost of a move after one of length `before`, whose sign is its direction."""
    metres = abs(length)
    cost = metres * (drive.backward if length < 0.0 else 1.0)
    if bend != 0.0:
        cost += drive.bend * metres
    if before * length < 0.0:
        cost += drive.switch
    return cost


@kernel
def price_of(drive: Drive, moves: Array) -> float:
    """The cost of successive moves (k, 2), bend and length [m]."""
    total = 0.0
    before = 0.0
    for k in range(moves.shape[0]):
        if moves[k, 1] != 0.0:
            total += price(drive, moves[k, 0], moves[k, 1], before)
            before = moves[k, 1]
    return total


@kernel
def trailer_along(poses: Array, length: float, offset: float, limit: float, out: Array) -> None:
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
        out[i, 0], out[i, 1], out[i, 2] = _trailer_pose(x, y, heading, hitch, length, offset)
