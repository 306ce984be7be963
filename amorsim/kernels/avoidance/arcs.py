"""How long a body may keep a twist before it meets a point: exact, along arcs of circles.

A body is a box whose corners a disc about the base point may cut, with some room around it: all places within the room
of a rectangle, and no farther from the base point than the reach and the room. A disc is a rectangle without sides. The
body's frame has x ahead. Under a constant twist the body goes round a centre, so in its frame every point goes round
that centre the other way, and meets the body where its circle meets the outline.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from amorsim.array_types import Array
from amorsim.kernels.compile import part

__all__ = ["Box", "distance_to_box", "free_time", "keep_room"]


_STRAIGHT = 1e-6  # [1/m] arcs of less curvature count as straight: over 10 m they differ by 0.05 mm
_SPARE = 1e-9  # [rad] that a point may have passed by rounding
_LEAST = 1e-4  # [m] that the body keeps from a point that is within its margin already


class Box(NamedTuple):
    """A rectangle in a body's frame [m]: its least and greatest x, its least and greatest y; and the disc around it."""

    rear: float
    front: float
    right: float
    left: float
    reach: float
    """[m] from the base point, beyond which nothing is of the body; inf for a whole rectangle."""


@part
def distance_to_box(x: float, y: float, box: Box) -> float:
    """How far [m] a point is from a box, at least: from its rectangle or from its disc, whichever is farther."""
    dx = max(box.rear - x, x - box.front, 0.0)
    dy = max(box.right - y, y - box.left, 0.0)
    return max(math.sqrt(dx * dx + dy * dy), math.sqrt(x * x + y * y) - box.reach)


@part
def keep_room(points: Array, box: Box, room: float, nearer_than: float, out: Array) -> int:
    """Copy the points (2, p) nearer than `nearer_than` [m] to the rectangle into `out` (3, p); returns their number.

    The third number of each is the radius about the rectangle that must not meet it: `room` [m], or a little less than
    the point's present distance if that is smaller, so that a body may leave what is too near.
    """
    count = 0
    for n in range(points.shape[1]):
        x = points[0, n]
        y = points[1, n]
        if not (abs(x) < math.inf and abs(y) < math.inf):
            continue
        gap = distance_to_box(x, y, box)
        if gap <= nearer_than:
            out[0, count] = x
            out[1, count] = y
            out[2, count] = max(0.0, min(room, gap - _LEAST))
            count += 1
    return count


@part
def _turn_between(px: float, py: float, fx: float, fy: float) -> float:
    """The angle [rad], 0 or more, by which p turns clockwise about the origin to the direction of f."""
    angle = math.atan2(py * fx - px * fy, px * fx + py * fy)
    return angle if angle >= -_SPARE else angle + 2.0 * math.pi


@part
def _turn_until(x: float, y: float, room: float, radius: float, box: Box) -> float:
    """The angle [rad] by which a body turns left about (0, radius) before its rounded box meets a point; inf if never.

    The point is not in the box.
    """
    py = y - radius
    square = x * x + py * py
    best = math.inf
    most = box.reach + room
    # Where its circle meets the rectangle's sides and corners within the disc, or the disc within the rectangle.
    for side in range(2):
        fx = box.front + room if side == 0 else box.rear - room
        if square >= fx * fx:
            h = math.sqrt(square - fx * fx)
            for sign in range(2):
                fy = h if sign == 0 else -h
                if box.right - radius <= fy <= box.left - radius and _is_within(fx, fy + radius, most):
                    best = min(best, _turn_between(x, py, fx, fy))
        fy = (box.left + room if side == 0 else box.right - room) - radius
        if square >= fy * fy:
            h = math.sqrt(square - fy * fy)
            for sign in range(2):
                fx = h if sign == 0 else -h
                if box.rear <= fx <= box.front and _is_within(fx, fy + radius, most):
                    best = min(best, _turn_between(x, py, fx, fy))
    way = math.sqrt(square)
    if way == 0.0:
        return best
    is_disc = box.front == box.rear and box.left == box.right
    for corner in range(0 if room == 0.0 else 1 if is_disc else 4):
        cx = box.front if corner % 2 == 0 else box.rear
        cy = (box.left if corner < 2 else box.right) - radius
        bend = _bend(square, way, cx, cy, room)
        if bend >= 0.0:
            c = math.cos(bend)
            s = math.sin(bend)
            for sign in range(2):
                fx = c * cx - s * cy if sign == 0 else c * cx + s * cy
                fy = s * cx + c * cy if sign == 0 else c * cy - s * cx
                # Both are scaled to the point's circle.
                far = way / math.sqrt(cx * cx + cy * cy)
                if _is_within(fx * far, fy * far + radius, most):
                    best = min(best, _turn_between(x, py, fx, fy))
    bend = _bend(square, way, 0.0, -radius, most) if most < math.inf else -1.0
    if bend >= 0.0:
        c = math.cos(bend)
        s = math.sin(bend)
        for sign in range(2):
            fx = s * way if sign == 0 else -s * way
            fy = -c * way
            dx = max(box.rear - fx, fx - box.front, 0.0)
            dy = max(box.right - fy - radius, fy + radius - box.left, 0.0)
            if dx * dx + dy * dy <= room * room:
                best = min(best, _turn_between(x, py, fx, fy))
    return best


@part
def _is_within(x: float, y: float, most: float) -> bool:
    """Whether (x, y) is at most `most` [m] from the base point."""
    return x * x + y * y <= most * most


@part
def _bend(square: float, way: float, cx: float, cy: float, room: float) -> float:
    """The angle [rad] from the direction of (cx, cy) to where the circle of radius `way` meets that of `room` about it.

    -1 if they do not meet. `square` is that of `way`.
    """
    far = math.sqrt(cx * cx + cy * cy)
    if far == 0.0 or not abs(way - room) <= far <= way + room:
        return -1.0
    return math.acos(min(1.0, max(-1.0, (square + far * far - room * room) / (2.0 * way * far))))


@part
def _way_until(x: float, y: float, room: float, box: Box) -> float:
    """The way [m] straight ahead before a rounded box meets a point; inf if never. The point is not in the box."""
    beside = max(box.right - y, y - box.left, 0.0)
    if beside >= room and not (room == 0.0 and beside == 0.0):
        return math.inf
    edge = box.front + math.sqrt(max(room * room - beside * beside, 0.0))
    most = box.reach + room
    if most < math.inf:
        if abs(y) >= most:
            return math.inf
        edge = min(edge, math.sqrt(most * most - y * y))
    way = x - edge
    return way if way >= -1e-9 else math.inf


@part
def free_time(points: Array, count: int, v: float, w: float, box: Box, enough: float, least: float) -> float:
    """For how long [s] a body may keep a twist (v [m/s], w [rad/s]) before it meets the first of `count` points.

    `points` (3, p) are from `keep_room`. Returns no more than `enough`. A result below `least` may be too long: the
    search ends there.
    """
    if v == 0.0 and w == 0.0:
        return enough
    # Backwards is forwards in a mirror, and a turn to the right is one to the left in another.
    flip_x = -1.0 if v < 0.0 else 1.0
    flip_y = -1.0 if w * flip_x < 0.0 else 1.0
    front = box.front if flip_x > 0.0 else -box.rear
    rear = box.rear if flip_x > 0.0 else -box.front
    left = box.left if flip_y > 0.0 else -box.right
    right = box.right if flip_y > 0.0 else -box.left
    shape = Box(rear, front, right, left, box.reach)
    speed = abs(v)
    rate = abs(w)
    found = enough
    if rate <= _STRAIGHT * speed:
        for n in range(count):
            x = points[0, n] * flip_x
            y = points[1, n] * flip_y
            if distance_to_box(x, y, shape) <= 0.0:
                return 0.0
            found = min(found, max(_way_until(x, y, points[2, n], shape), 0.0) / speed)
            if found < least:
                return found
        return found
    radius = speed / rate
    # The ring that the body sweeps, and points that are out of it.
    low = max(right - radius, radius - left, 0.0)
    if right <= radius <= left:
        low = 0.0
    beside = max(rear, -front, 0.0)
    inner = math.sqrt(low * low + beside * beside)
    wide = max(abs(left - radius), abs(right - radius))
    long = max(abs(front), abs(rear))
    outer = min(math.sqrt(wide * wide + long * long), radius + box.reach)
    within = min(math.sqrt(long * long + max(abs(left), abs(right)) ** 2), box.reach)
    # How far about the centre the body lies ahead of the base point, and behind it.
    whole = 2.0 * math.pi
    is_outside = left < radius
    lead = max(math.atan2(front, radius - left), math.atan2(front, radius - right))
    lag = min(math.atan2(rear, radius - left), math.atan2(rear, radius - right))
    for n in range(count):
        x = points[0, n] * flip_x
        y = points[1, n] * flip_y
        room = points[2, n]
        py = y - radius
        square = x * x + py * py
        least_way = max(inner - room, 0.0)
        most_way = outer + room
        if square > most_way * most_way or square < least_way * least_way:
            continue
        # Farther than the base point comes until then, and the body reaches.
        far = speed * found + within + room
        if x * x + y * y > far * far:
            continue
        if is_outside:
            # The body's foremost place has farther to turn than it does.
            ahead = math.atan2(x, -py) - lead - 0.5 * math.pi * room / inner
            if ahead > rate * found or (ahead < lag - lead - math.pi * room / inner and ahead + whole > rate * found):
                continue
        if distance_to_box(x, y, shape) <= 0.0:
            return 0.0
        found = min(found, max(_turn_until(x, y, room, radius, shape), 0.0) / rate)
        if found < least:
            return found
    return found
