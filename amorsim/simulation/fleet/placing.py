"""Starts drawn at random: free of walls and of all other bodies, from the seed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.core.distributions import STUDY
from amorsim.core.draws import Draws, stream_key
from amorsim.core.errors import Fault, MapError, ScenarioError
from amorsim.core.maps.free_places import free_places
from amorsim.core.poses import compose
from amorsim.scenario.needs import most_room
from amorsim.scenario.random_start import RandomStart
from amorsim.scenario.spec import Obstacle, Pose, Robot
from amorsim.simulation.contact.moved_parts import with_parts
from amorsim.simulation.world.world import World

__all__ = ["Areas", "draw_starts", "draw_starts_again", "with_start"]


TRIES = 1000
_LOOKS = (64, 96, 128, 192, 256, 384, 512)  # tries after which `_is_hopeless` is checked
_FAR = 1e7  # [m] where bodies without a place wait; none overlap there


def with_start(body: Robot | Obstacle, pose: Array) -> Robot | Obstacle:
    """A robot or obstacle with the pose that was drawn for it."""
    x, y, heading = pose.tolist()
    return attrs.evolve(body, pose=Pose(x=x, y=y, heading=heading), start=None)


def draw_starts(
    world: World,
    bodies: Sequence[Robot | Obstacle],
    given: Array,
    seed: int,
    replicas: Sequence[int],
    source: str,
) -> Array:
    """Poses `(T, 3)` of all bodies in all replicas: `given` `(R, B, 3)`, or drawn for those that start at random.

    Each try of a body is a pure function of seed, name, replica, episode and the try's number. All bodies try at once.
    A body that overlaps a wall or a placed body tries again; of two that overlap each other, the later by name does. So
    a replica depends only on its own bodies. Starts drawn once for the study come first.

    Raises
    ------
    ScenarioError
        If some find no place in `TRIES` tries, or cannot be expected to.
    """
    starts = [body.start for body in bodies]
    whole: Array = np.zeros((len(replicas), world.count, 3))
    whole[:, : world.named] = given
    poses = whole.reshape(-1, 3)
    if not any(starts):
        return poses
    too_many = _too_many(world, bodies, source)
    if too_many:
        raise ScenarioError(too_many)
    own = np.zeros(world.count - world.named, dtype=bool)  # parts have no start of their own
    placed = np.tile(np.concatenate(([start is None for start in starts], own)), len(replicas))[world.owner]
    inside = with_parts(world, bodies, replicas, seed)
    _put_parts(world, poses, inside)
    tries = 0
    for per in ("study", "replica"):
        chosen = np.array([start is not None and start.per == per for start in starts])
        if chosen.any():
            numbers = [STUDY] * len(replicas) if per == "study" else list(replicas)
            every = np.tile(np.concatenate((chosen, own)), len(replicas))
            first = np.zeros(len(replicas), dtype=np.int64)
            tries = max(tries, _draw(world, bodies, every, numbers, first, seed, poses, placed, inside))
    lost = np.flatnonzero(~placed & (world.owner == world.everyone))
    if len(lost):
        raise ScenarioError(_no_room(world, bodies, lost, tries, source))
    return poses


def draw_starts_again(
    world: World,
    bodies: Sequence[Robot | Obstacle],
    poses: Array,
    seed: int,
    replicas: Sequence[int],
    episodes: Ints,
    which: Bools,
    areas: Areas,
    source: str,
) -> Array:
    """Start poses `(T, 3)`, drawn for `episodes` `(R,)` in the replicas marked in `which`, elsewhere as in `poses`.

    Starts that are drawn once for the study stay as they are.

    Raises
    ------
    ScenarioError
        If some find no place.
    """
    own = np.zeros(world.count - world.named, dtype=bool)
    drawn = np.concatenate(([body.start is not None and body.start.per == "replica" for body in bodies], own))
    chosen = (which[:, None] & drawn).reshape(-1)
    poses, placed = poses.copy(), ~chosen[world.owner]
    inside = with_parts(world, bodies, replicas, seed)
    tries = _draw(world, bodies, chosen, list(replicas), episodes, seed, poses, placed, inside, areas)
    lost = np.flatnonzero(~placed & (world.owner == world.everyone))
    if len(lost):
        raise ScenarioError(_no_room(world, bodies, lost, tries, source))
    return poses


def _draw(
    world: World,
    bodies: Sequence[Robot | Obstacle],
    chosen: Bools,
    numbers: Sequence[int],
    episodes: Ints,
    seed: int,
    poses: Array,
    placed: Bools,
    inside: Array,
    areas: Areas | None = None,
) -> int:
    """Find places for the chosen bodies `(T,)`, into `poses` and `placed`; returns the number of tries.

    `inside` are the poses of parts in their robots' frames.
    """
    count, total, owner = world.count, len(placed), world.owner
    keys = np.array([stream_key(seed, body.name, "start") for body in bodies], dtype=np.uint64)
    clearance = np.zeros((len(numbers), count))
    clearance[:, : world.named] = [0.0 if body.start is None else body.start.clearance for body in bodies]
    clearance = clearance.reshape(-1)[owner]
    areas = Areas(world, [body.start for body in bodies]) if areas is None else areas
    left: list[Ints] = []  # bodies without a place in each replica, before each try
    for attempt in range(TRIES):
        todo = np.flatnonzero(chosen & ~placed)
        left.append(np.bincount(todo // count, minlength=len(numbers)))
        if not len(todo) or (attempt in _LOOKS and _is_hopeless(left)):
            return attempt
        counter = np.zeros((len(todo), 3), dtype=np.uint32)
        counter[:, 0] = np.asarray(numbers)[todo // count]
        counter[:, 1] = episodes[todo // count]
        counter[:, 2] = attempt
        tries = areas.poses(todo % count, todo // count, Draws(keys[todo % count], counter).uniform(4))
        poses[todo] = tries
        _put_parts(world, poses, inside)
        candidates = np.zeros(total, dtype=bool)
        candidates[todo] = True
        tried = np.flatnonzero(candidates[owner])
        gaps, _ = world.wall_gaps(tried, poses[tried], clearance[tried])
        candidates[owner[tried[~(gaps >= clearance[tried])]]] = False
        candidates = candidates[owner]
        present = placed | candidates
        spread = np.column_stack((_FAR + 4.0 * world.bodies.reach.max() * np.arange(total), np.zeros((total, 2))))
        where = np.where(present[:, None], poses, spread)
        a, b = world.pairs_within(where, clearance)
        meets = present[a] & present[b] & (candidates[a] | candidates[b])
        a, b = a[meets], b[meets]
        wanted = np.maximum(clearance[a], clearance[b])
        near = world.body_gaps(a, where[a], b, where[b], wanted) < wanted
        a, b = owner[a[near]], owner[b[near]]
        later, earlier = np.maximum(a, b), np.minimum(a, b)
        candidates[np.where(candidates[later], later, earlier)] = False
        placed |= candidates[owner]
    return TRIES


def _is_hopeless(left: Sequence[Ints]) -> bool:
    """Whether some bodies will not find a place; `left` are those without one in each replica `(R,)` before each try.

    Free places get fewer, so a future try places at most as many as the tries of the latter half so far did on average,
    with four standard deviations of their count and ten added. Each replica is judged by itself.
    """
    made = len(left) - 1
    late = made // 2
    found = left[made - late] - left[made]
    at_best = found + 4.0 * np.sqrt(found + 1.0) + 10.0
    return bool((at_best * (TRIES - made) < left[made] * late).any())


def _too_many(world: World, bodies: Sequence[Robot | Obstacle], source: str) -> list[Fault]:
    """A fault for each kind of start whose bodies together are larger than the area given to them."""
    alike: dict[RandomStart, list[int]] = {}
    for i, body in enumerate(bodies):
        if body.start is not None:
            alike.setdefault(body.start, []).append(i)
    faults = []
    for start, members in alike.items():
        area = math.fsum(bodies[i].shape.area for i in members)
        reach = max(bodies[i].shape.reach for i in members)
        room = min(most_room(map_, start, reach) for map_ in world.terrain.maps)
        if area > room:
            faults.append(
                _fault(
                    bodies[members[0]],
                    source,
                    f"the {len(members)} that start at random {_where(start)} cover {area:.4g} m2, and there are "
                    f"{room:.4g} m2 at most",
                )
            )
    return faults


def _where(start: RandomStart) -> str:
    return "on the map" if start.box is None else "in the box {:g}, {:g}, {:g}, {:g} m".format(*start.box)


def _fault(first: Robot | Obstacle, source: str, message: str) -> Fault:
    kind = "robots" if isinstance(first, Robot) else "obstacles"
    return Fault(
        file=source,
        path=f"{kind}.{first.name}.start",
        message=f"{message}; expected more room, fewer or smaller bodies, or less clearance",
    )


def _put_parts(world: World, poses: Array, inside: Array) -> None:
    """Set the poses of the parts, in place, from their poses `inside` the frames of their robots."""
    if world.has_parts:
        poses[world.parts] = compose(poses[world.owner[world.parts]], inside[world.parts])


class Areas:
    """The area where each body may start: its box, or any free cell of a coarse view of its replica's map."""

    def __init__(self, world: World, starts: Sequence[RandomStart | None]) -> None:
        self._boxes = np.full((len(starts), 4), np.nan)
        self._heading = np.full(len(starts), np.nan)
        for i, start in enumerate(starts):
            if start is not None and start.heading is not None:
                self._heading[i] = start.heading
            if start is not None and start.box is not None:
                self._boxes[i] = start.box
        self._of_replica = world.terrain.of_replica
        self._first = np.zeros(len(world.terrain.maps), dtype=np.int64)  # of each map's places
        self._count = np.zeros_like(self._first)
        self._side = np.zeros(len(self._first))
        self._turn = np.array([(math.cos(map_.origin[2]), math.sin(map_.origin[2])) for map_ in world.terrain.maps])
        self._places: Array = np.empty((0, 2))
        if any(start is not None and start.box is None for start in starts):
            try:
                found = [free_places(map_) for map_ in world.terrain.maps]
            except MapError as error:
                raise ScenarioError([Fault(file="", path="world.map", message=str(error))]) from None
            self._count[:] = [len(places) for places, _ in found]
            self._first[1:] = np.cumsum(self._count)[:-1]
            self._side[:] = [side for _, side in found]
            self._places = np.concatenate([places for places, _ in found])

    def poses(self, which: Ints, replica: Ints, uniform: Array) -> Array:
        """Poses `(Q, 3)` for bodies number `which` `(Q,)` in replicas of these indices, from four uniform numbers."""
        box = self._boxes[which]
        x = box[:, 0] + uniform[:, 0] * (box[:, 2] - box[:, 0])
        y = box[:, 1] + uniform[:, 1] * (box[:, 3] - box[:, 1])
        if len(self._places):
            map_ = self._of_replica[replica]
            count = self._count[map_]
            number = np.minimum((uniform[:, 3] * count).astype(np.int64), count - 1)
            anywhere = np.isnan(box[:, 0])
            cell = self._places[self._first[map_] + number]
            side, (cosine, sine) = self._side[map_], self._turn[map_].T
            across, up = (uniform[:, 0] - 0.5) * side, (uniform[:, 1] - 0.5) * side
            x = np.where(anywhere, cell[:, 0] + cosine * across - sine * up, x)
            y = np.where(anywhere, cell[:, 1] + sine * across + cosine * up, y)
        heading = np.where(np.isnan(self._heading[which]), (2.0 * uniform[:, 2] - 1.0) * math.pi, self._heading[which])
        return np.column_stack((x, y, heading))


def _no_room(world: World, bodies: Sequence[Robot | Obstacle], lost: Ints, tries: int, source: str) -> list[Fault]:
    """A fault for each kind of start for which some body found no place, in the first replica where that happened."""
    first = lost[lost // world.count == lost[0] // world.count] % world.count
    early = "" if tries == TRIES else ", and too few in the last of them for any hope"
    faults = []
    for start in dict.fromkeys(bodies[i].start for i in first.tolist()):
        names = [bodies[i].name for i in first.tolist() if bodies[i].start == start]
        alike = sum(body.start == start for body in bodies)
        assert start is not None
        some = ", ".join(names[:3]) + (" ..." if len(names) > 3 else "")
        message = f"{len(names)} of {alike} that start at random {_where(start)} found no free place in {tries} tries"
        one = next(bodies[i] for i in first.tolist() if bodies[i].name == names[0])
        faults.append(_fault(one, source, f"{message} ({some}){early}"))
    return faults
