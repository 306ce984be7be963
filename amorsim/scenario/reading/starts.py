"""Where bodies start, in documents: each by itself, many on a grid or at random; and whether that is free."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import attrs
import numpy as np
import shapely

from amorsim.array_types import Array
from amorsim.core.execution.memory import too_large
from amorsim.core.maps.footprint_room import outside, overlap_with_others, overlap_with_walls, wall_gaps
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.shapes import Shape, pack
from amorsim.kernels.collision.footprints import body_gaps
from amorsim.plugins.checks import check_name
from amorsim.scenario.initial_belief import InitialBelief
from amorsim.scenario.needs import least_bytes, most_room
from amorsim.scenario.parts import parts_at
from amorsim.scenario.random_start import RandomStart
from amorsim.scenario.reading.bodies import read_pose, read_shape
from amorsim.scenario.reading.faults import FaultCollector, Node, shown
from amorsim.scenario.reading.fields import read_component
from amorsim.scenario.spec import Obstacle, Pose, Robot

__all__ = ["MOST", "GridStart", "Placed", "check_starts", "placed", "read_series", "series_names", "series_of"]

Body = TypeVar("Body", Robot, Obstacle)

MOST = 1_000_000
"""The largest `count` of a table."""
_KINDS = ("random", "grid", "poses")
_EXPECTED = "expected { random = 'anywhere' or a box ... }, { grid = [x, y], spacing = ... } or { poses = [...] }"


@attrs.frozen(kw_only=True)
class GridStart:
    """Starts on a grid, row by row from its lower left corner, along x first."""

    grid: tuple[float, float] = parameter(unit="m", frame="world", help="x, y of the first")
    spacing: float = parameter(unit="m", gt=0, help="from one to the next, along x and along y")
    columns: int | None = parameter(None, gt=0, help="how many in a row; none: about as many as there are rows")
    heading: float = parameter(0.0, unit="rad", help="where all of them look")

    def columns_of(self, count: int) -> int:
        """How many of a number of bodies stand in one row."""
        return self.columns or math.ceil(math.sqrt(count))

    def pose(self, number: int, count: int) -> Pose:
        """The pose of body number 0, 1, ... of a number of them."""
        row, column = divmod(number, self.columns_of(count))
        x, y = self.grid
        return Pose(x=x + column * self.spacing, y=y + row * self.spacing, heading=self.heading)


@attrs.frozen
class Placed:
    """Where a body stands, and the table that sets it."""

    name: str
    shape: Shape
    pose: Pose
    node: Node
    is_one: bool  # of a table without `count`
    part: str = ""  # of the robot of that name


def placed(node: Node, bodies: Sequence[Robot] | Sequence[Obstacle]) -> list[Placed]:
    """Where the bodies of a table stand, if it sets that; of a faulty table as far as it can be read."""
    is_one = "count" not in node
    if not bodies and is_one and {"pose", "shape"} <= set(node.value):
        alone = FaultCollector(node.book.source(node.path))  # the faults of these two are reported already
        shape, pose = (read(Node(node.value[key], (*node.path, key), alone)) for key, read in _READ.items())
        if isinstance(shape, Shape) and isinstance(pose, Pose):
            return [Placed(str(node.value.get("name", "it")), shape, pose, node, is_one)]
    found = []
    for body in bodies:
        if body.start is None and body.pose is not None:
            found.append(Placed(body.name, body.shape, body.pose, node, is_one))
            if isinstance(body, Robot):
                found += [
                    Placed(body.name, part.shape, pose, node, is_one, part.name)
                    for part, pose in parts_at(body.drive, body.pose)
                ]
    return found


_READ: dict[str, Callable[[Node], Shape | Pose | None]] = {"shape": read_shape, "pose": read_pose}


def series_names(name: str, count: int) -> list[str]:
    """The names of the bodies of a table with `count`: its own with a number, of as many digits in all of them."""
    digits = len(str(count))
    return [f"{name}{i:0{digits}d}" for i in range(count)]


def read_series(node: Node, body: Body | None, world: Map | None) -> list[Body]:
    """The bodies that a table with `count` and `start` means, of the one it was read as; none after faults.

    Where the table could not be read as a body, the faults of its `count` and `start` are reported all the same.
    """
    if not node.is_table:
        return []
    before = node.book.count
    count = _count(node.child("count"), body) if "count" in node else None
    poses: list[Pose] = []
    start = None
    if "start" in node:
        if "pose" in node:
            node.child("start").fault("expected either a pose or a start, got both")
        child = node.child("start")
        kinds = [kind for kind in _KINDS if child.is_table and kind in child]
        if len(kinds) != 1:
            is_pose = child.is_table and "x" in child and "y" in child
            hint = ". Of one robot at one place, write pose = { ... }" if is_pose else ""
            child.fault(f"{_EXPECTED}, got {shown(child.value)}{hint}")
        elif kinds[0] == "random":
            start = read_component(RandomStart, child)
            if start is not None and world is not None and body is not None:
                _check_room(node, body, start, count or 1, world)
        elif kinds[0] == "grid":
            grid = read_component(GridStart, child)
            if grid is not None and (world is None or _is_on_map(node, grid, count or 1, world)):
                poses = [grid.pose(i, count or 1) for i in range(count or 1)]
        else:
            poses = _poses(child, count or 1)
    elif count is not None and count > 1:
        node.child("start").fault(f"missing; {count} of them cannot start at one place; {_EXPECTED}")
    if body is None or node.book.count > before:
        return []
    names = [body.name]
    if count is not None:
        names = series_names(body.name, count)
        if problem := check_name(names[-1]):
            node.child("name").fault(problem)
            return []
    elif "start" not in node:
        return [body]
    if start is not None:
        return [attrs.evolve(body, name=name, start=start) for name in names]
    if not poses:  # one alone, numbered
        return [attrs.evolve(body, name=name) for name in names]
    return [attrs.evolve(body, name=name, pose=pose) for name, pose in zip(names, poses, strict=True)]


def _count(node: Node, body: Robot | Obstacle | None) -> int | None:
    if type(node.value) is not int or not 1 <= node.value <= MOST:
        node.fault(f"expected a whole number >= 1 and <= {MOST}, got {shown(node.value)}")
        return None
    if body is not None and (problem := too_large(node.value, least_bytes(body))):
        node.fault(f"{node.value} of them {problem}")
        return None
    return node.value


def _check_room(node: Node, body: Robot | Obstacle, start: RandomStart, count: int, world: Map) -> None:
    """Adds a fault if the bodies together are larger than the area they start in, before any of them is made."""
    room = most_room(world, start, body.shape.reach)
    if count * body.shape.area > room:
        where = "on the map" if start.box is None else "in their box"
        node.child("count").fault(
            f"{count} of them cover {count * body.shape.area:.4g} m2, and there are {room:.4g} m2 {where} at most: "
            f"expected {int(room / body.shape.area)} at the very most, or smaller ones, or more room"
        )


def _is_on_map(node: Node, grid: GridStart, count: int, world: Map) -> bool:
    """Whether the corners of a grid are on the map; a fault names the one that is not, and why."""
    columns = min(count, grid.columns_of(count))
    last = count - 1
    for number in dict.fromkeys((0, columns - 1, last - last % columns, last)):
        pose = grid.pose(number, count)
        if problem := outside(world, pose.x, pose.y):
            node.child("start").fault(
                f"number {number} of the {count} would stand at ({pose.x:.3f}, {pose.y:.3f}) m: that {problem}; "
                "expected fewer, a smaller spacing or another number of columns"
            )
            return False
    return True


def _poses(node: Node, count: int) -> list[Pose]:
    node.refuse_unknown(("poses",))
    child = node.child("poses")
    if not child.expect_list("a list of poses [{ x, y, heading_deg }, ...]"):
        return []
    if len(child.value) != count:
        child.fault(f"expected a pose for each of the {count}, got {len(child.value)}")
        return []
    return [pose for item in child.items() if (pose := read_pose(item)) is not None]


def series_of(bodies: Sequence[Body]) -> Iterator[list[Body]]:
    """The bodies in order, those of one table with `count` together: numbered, and alike except for names and poses."""
    at = 0
    while at < len(bodies):
        first = bodies[at]
        stem = first.name.rstrip("0123456789")
        digits = len(first.name) - len(stem)
        series = [first]
        if digits and int(first.name[-digits:]) == 0 and check_name(stem) == "":
            for number in range(1, len(bodies) - at):
                other = bodies[at + number]
                if other.name != f"{stem}{number:0{digits}d}" or not _are_alike(first, other):
                    break
                series.append(other)
            if len(str(len(series))) != digits:
                series = [first]
        yield series
        at += len(series)


def _are_alike(one: Body, other: Body) -> bool:
    """Whether two bodies are the same but for name and pose; their parts the same objects."""
    for field in attrs.fields(type(one)):
        if field.name in ("name", "pose"):
            continue
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, dict):
            if a.keys() != b.keys() or any(a[key] is not b[key] for key in a):
                return False
        elif a is not b and not (isinstance(a, (str, int, float, RandomStart, InitialBelief, tuple)) and a == b):
            return False
    return True


def check_starts(world: Map, fixed: Sequence[Placed]) -> None:
    """A fault for each body that starts in a wall or in another body, at the table that sets its start."""
    if not fixed:
        return
    poses = np.array([(item.pose.x, item.pose.y, item.pose.heading) for item in fixed])
    shapes = [item.shape for item in fixed]
    wrong: list[tuple[Placed, str]] = []
    gaps, where = wall_gaps(world, shapes, poses)
    for i in np.flatnonzero(gaps < 0.0).tolist():
        wrong.append((fixed[i], overlap_with_walls(world, poses[i, 0], poses[i, 1], where[i], _what(fixed[i]))))
    _check_overlaps(fixed, shapes, poses, wrong)
    _tell(wrong)


def _check_overlaps(
    fixed: Sequence[Placed], shapes: Sequence[Shape], poses: Array, wrong: list[tuple[Placed, str]]
) -> None:
    reach = np.array([shape.reach for shape in shapes])
    boxes = shapely.box(*(poses[:, :2] - reach[:, None]).T, *(poses[:, :2] + reach[:, None]).T)
    a, b = shapely.STRtree(boxes).query(boxes)
    first, second = a[a < b], b[a < b]
    if not len(first):
        return
    order = np.lexsort((second, first))
    first, second = first[order].astype(np.int64), second[order].astype(np.int64)
    out = np.empty(len(first))
    body_gaps(pack(shapes), first, poses[first], second, poses[second], np.zeros(len(first)), out)
    overlapped: dict[str, tuple[Placed, dict[str, None]]] = {}
    for i in np.flatnonzero(out < 0.0).tolist():
        one, other = fixed[int(first[i])], fixed[int(second[i])]
        if one.name != other.name:
            overlapped.setdefault(other.name, (other, {}))[1][one.name] = None
    wrong += [(other, overlap_with_others(list(names))) for other, names in overlapped.values()]


def _tell(wrong: Sequence[tuple[Placed, str]]) -> None:
    """A fault for each; of a table with `count` the first, and how many there are."""
    series: dict[tuple[str, ...], dict[str, None]] = {}
    for item, _ in wrong:
        series.setdefault(item.node.path, {})[item.name] = None
    for item, message in wrong:
        names = series[item.node.path]
        if item.is_one:
            _fault(item, message)
        elif item.name in names:
            if len(names) > 1:
                message = f"{message}; {len(names)} of the {item.node.value['count']} do not stand free"
            _fault(item, message)
            names.clear()


def _what(item: Placed) -> str:
    return f"its {item.part}" if item.part else "the footprint"


def _fault(item: Placed, message: str) -> None:
    """A fault where the pose is set, be it the file or a setting of the command line."""
    node = item.node
    if "start" in node:
        node.child("start").fault(message if item.is_one else f"{item.name}: {message}")
        return
    pose = node.child("pose")
    if "pose" not in node:
        message = f"missing, and {message}"
    source = node.book.source(pose.path)
    if pose.is_table:
        for _, number in pose.children():
            if node.book.source(number.path) is not source:
                number.fault(message)
                return
    pose.fault(message)
