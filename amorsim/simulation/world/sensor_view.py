"""The view that sensors and motions have of the world: the truth of their own replica, read-only."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import BodyStates, Directions, Emissions, FloorPoints, Lights, Neighbours, Sightings
from amorsim.core.errors import ComponentError
from amorsim.core.execution.workers import Workers, in_turn
from amorsim.core.shapes import Shape
from amorsim.kernels.kinematics import poses
from amorsim.kernels.number_checks import all_indices
from amorsim.kernels.raycast import cones
from amorsim.simulation.world.bumper_contacts import find_touched
from amorsim.simulation.world.directions import Table, cone_bearings, cone_directions, directions_of
from amorsim.simulation.world.in_sight import bind_look, bind_walls, find_landmarks, look_about, normals_at
from amorsim.simulation.world.neighbourhood import neighbours_of
from amorsim.simulation.world.world import CONE_WORK, World

__all__ = ["GroupView"]


_NO_RAYS: Ints = np.empty(0, dtype=np.int64)  # for calls that do not need which ray is the nearest


class GroupView:
    """The world as the sensors of a group see it (`amorsim.contracts.View`)."""

    def __init__(self, world: World, rows: Ints, dt: float) -> None:
        self.rows = len(rows)
        self.dt = dt
        self._world = world
        self._bodies = rows  # the global body of each row
        self._bearings: dict[bytes, Table] = {}
        # The body that carries each ray's origin, and its replica, by the number of origins per row.
        self._carriers: dict[int, tuple[Ints, Ints]] = {}
        self.tick: Ints = np.zeros((self.rows, 1), dtype=np.int64)
        self.body_pose: Array = np.zeros((self.rows, 3))
        self.twist: Array = np.zeros((self.rows, 3))
        self.joints: Array = np.zeros((self.rows, 0))
        self.joint_rates: Array = np.zeros((self.rows, 0))
        self.free: Array = np.ones((self.rows, 1))
        self.mount: Array = np.zeros((self.rows, 3))  # of the sensor in use, set by `use` like its name
        self.sensor = ""
        self._pose: Array | None = None

    @property
    def has_company(self) -> bool:
        """Whether there are other bodies; see `amorsim.contracts.View.has_company`."""
        return self._world.has_company

    @property
    def names(self) -> Sequence[str]:
        """The names of the rows' robots or obstacles."""
        return [self._world.name(body) for body in self._bodies.tolist()]

    @property
    def workers(self) -> Workers:
        """The threads that share the rows of long work."""
        return self._world.workers

    def use(self, mount: Array, sensor: str = "") -> None:
        """Look from true mounts `(N, 3)`, as the sensor of a name."""
        self.mount, self.sensor, self._pose = mount, sensor, None

    @property
    def pose(self) -> Array:
        """The true poses `(N, 3)` of the sensor's mount in the world."""
        if self._pose is None:
            self._pose = np.empty((self.rows, 3))
            poses.compose(self.body_pose, self.mount, self._pose)
        return self._pose

    def cast(
        self,
        origins: Array,
        bearings: Array,
        range_max: Array,
        traversal: str = "exact",
        bodies: bool = True,
        row: Ints | None = None,
    ) -> Array:
        """Distances [m] to the nearest wall or other body; see `amorsim.contracts.View.cast`."""
        out = np.empty((len(origins), np.shape(bearings)[-1] if np.ndim(bearings) else 0))
        self.bind_cast(origins, bearings, range_max, out, traversal, bodies, row)()
        return out

    def bind_cast(
        self,
        origins: Array,
        bearings: Array | Directions,
        range_max: Array,
        out: Array,
        traversal: str = "exact",
        bodies: bool = True,
        row: Ints | None = None,
    ) -> Callable[[], None]:
        """A function that casts into `out`; see `amorsim.contracts.View.bind_cast`."""
        own, replica = self._carried("cast", origins, row)
        if isinstance(bearings, Directions):
            _check_bearings("cast", bearings.cos, origins)
            directions: Table = bearings
        else:
            _check_bearings("cast", bearings, origins)
            directions = self._table(bearings)
        beams = origins, *directions, self._limits("cast", range_max, origins, row), out
        walls = bind_walls(self._world, replica, *beams, traversal, directions is bearings)
        if not (bodies and self._world.has_company):
            return walls
        return in_turn([walls, self._world.bind_cast(own, replica, *beams)])

    def _table(self, bearings: Array) -> Table:
        """Cosines and sines of the bearings; those of a scan that is the same for all rows are cached."""
        if len(bearings) > 1:
            if not (bearings == bearings[0]).all():
                return directions_of(bearings)
            bearings = bearings[:1]
        key = bearings.tobytes()
        table = self._bearings.get(key)
        if table is None:
            if len(self._bearings) > 64:
                self._bearings.clear()
            table = self._bearings[key] = directions_of(bearings)
        return table

    def bodies(self) -> BodyStates:
        """All bodies of each row's replica; see `amorsim.contracts.View.bodies`."""
        world = self._world
        replica = world.replica_index[self._bodies]
        return BodyStates(
            poses=world.poses.reshape(-1, world.count, 3)[replica],
            twists=world.twists.reshape(-1, world.count, 3)[replica],
            reach=world.bodies.reach[: world.count],
            own=self._bodies % world.count,
            is_robot=world.is_robot,
            owner=world.owner[: world.count],
        )

    def neighbours(self, range_max: Array, ahead: Array | float = 0.0) -> Neighbours:
        """The bodies near each row; see `amorsim.contracts.View.neighbours`."""
        limits = self._at_least_zero("range_max", range_max), self._at_least_zero("ahead", ahead)
        return neighbours_of(self._world, self._bodies, *limits)

    def _at_least_zero(self, name: str, values: Any) -> Array:
        """One number >= 0 for each row `(N,)`, from `(N, 1)` or one for all."""
        array = np.asarray(values, dtype=np.float64)
        if array.shape not in ((), (1, 1), (self.rows, 1)) or not (array >= 0.0).all():
            raise ComponentError(
                f"view.neighbours: {name}: expected numbers >= 0, one or ({self.rows}, 1), got {_in_words(values)}"
            )
        return self._per_row(array)

    def landmarks(self, slots: int, range_max: Array, half_angle: Array) -> Sightings:
        """The nearest marks in sight; see `amorsim.contracts.View.landmarks`."""
        reach, angle = self._per_row(range_max), self._per_row(half_angle)
        return find_landmarks(self._world, self._bodies, self.pose, slots, reach, angle)

    def look(
        self, origins: Array, bearings: Array, range_max: Array, landmarks: bool = True, row: Ints | None = None
    ) -> tuple[Array, Ints]:
        """The first things that beams hit; see `amorsim.contracts.View.look`."""
        own, _ = self._carried("look", origins, row)
        _check_bearings("look", bearings, origins)
        limits = self._limits("look", range_max, origins, row)
        return look_about(self._world, own, origins, bearings, limits, landmarks)

    def bind_look(
        self, origins: Array, bearings: Array, limits: Array, out: Array, thing: Ints, nearest: Array | None = None
    ) -> Callable[[], None]:
        """A function that looks into `out` and `thing`; see `amorsim.contracts.View.bind_look`."""
        own, _ = self._carried("bind_look", origins)
        _check_bearings("bind_look", bearings, origins)
        return bind_look(self._world, own, origins, *self._table(bearings), limits, out, thing, nearest)

    def normals(self, origins: Array, bearings: Array, bodies: Ints, row: Ints | None = None) -> Array:
        """The normals of bodies where beams enter them; see `amorsim.contracts.View.normals`."""
        own, _ = self._carried("normals", origins, row)
        _check_bearings("normals", bearings, origins)
        count, shape = self._world.count, (len(origins), np.shape(bearings)[1])
        if not _are_indices(bodies, shape, -1, count):
            raise ComponentError(
                f"view.normals: bodies: expected the body that each beam enters, as `look` gives them, an int64 array "
                f"{shape} of numbers from -1 to {count - 1}, got {_in_words(bodies)}"
            )
        return normals_at(self._world, own, origins, bearings, bodies)

    def touches(self, zones: Sequence[Shape], which: Ints) -> Bools:
        """Whether zones touch something; see `amorsim.contracts.View.touches`."""
        return find_touched(self._world, self._bodies, zones, which)

    @property
    def shape(self) -> Shape:
        """The footprint of the rows' bodies."""
        return self._world.shapes[int(self._bodies[0]) % self._world.count]

    @property
    def colours(self) -> tuple[str | None, ...]:
        """The colours of all things."""
        return self._world.surroundings.colours

    @property
    def heights(self) -> Array:
        """The heights of all things."""
        return self._world.surroundings.heights

    def floor(self, places: Array) -> FloorPoints:
        """Properties of the floor at places; see `amorsim.contracts.View.floor`."""
        if not isinstance(places, np.ndarray) or places.shape[:1] + places.shape[2:] != (self.rows, 2):
            raise ComponentError(
                f"view.floor: places: expected places in the world, an array ({self.rows}, k, 2) [m], got "
                f"{_in_words(places)}"
            )
        return self._world.surroundings.floor.at(places)

    def lights(self) -> Lights:
        """All lamps; see `amorsim.contracts.View.lights`."""
        return self._world.surroundings.lights

    def emissions(self, medium: str) -> Emissions:
        """The emitters of a medium; see `amorsim.contracts.View.emissions`."""
        copies: Any = (array.copy() for array in self.bind_emissions(medium)())
        return Emissions(*copies)

    def bind_emissions(self, medium: str) -> Callable[[], Emissions]:
        """A function that returns the emitters; see `amorsim.contracts.View.bind_emissions`."""
        world, sensor = self._world, self.sensor
        replica, own_body = world.replica_index[self._bodies], self._bodies[:, None]
        # Of one row in each replica, the arrays need no selection.
        which: Any = slice(None) if np.array_equal(replica, np.arange(world.replicas)) else replica

        def emissions() -> Emissions:
            emitted = world.emissions[medium]
            body = emitted.body[which]
            return Emissions(
                poses=emitted.poses[which],
                half_angle=emitted.half_angle[which],
                fired=emitted.fired[which],
                own=(body == own_body) & (emitted.sensor == sensor),
                time=emitted.time[which],
                body=body % world.count,
            )

        return emissions

    def cone(self, origins: Array, half_angle: Array, range_max: Array, traversal: str = "exact") -> Array:
        """The nearest return in a cone; see `amorsim.contracts.View.cone`."""
        self._carried("cone", origins)
        out = np.empty((self.rows, len(origins) // self.rows))
        self.bind_cone(origins, half_angle, range_max, out, traversal)()
        return out

    def bind_cone(
        self,
        origins: Array,
        half_angle: Array,
        range_max: Array,
        out: Array,
        traversal: str = "exact",
        wall: tuple[Array, Array] | None = None,
    ) -> Callable[[], None]:
        """A function that writes the nearest returns into `out`; see `amorsim.contracts.View.bind_cone`."""
        own, replica = self._carried("cone", origins)
        per_row = len(origins) // self.rows
        limits, nearest = self._per_origin(range_max, per_row), out.reshape(-1)
        widths = list(_by_width(half_angle, per_row))
        if traversal == "bresenham":
            if wall is not None:
                raise ComponentError("view.cone: wall: expected None where the traversal is 'bresenham'")
            return in_turn([self._bind_bresenham(origins, angle, limits, nearest, which) for angle, which in widths])

        def of_width(angle: float, which: Any) -> Callable[[], None]:
            here, found = origins[which], nearest[which]  # copies, if there are cones of other widths
            beams = here, angle, *cone_directions(angle), limits[which], found
            calls = [self._bind_cone_walls(replica[which], *beams, which, wall)]
            if self._world.has_company:
                calls.append(self._world.bind_hear(own[which], replica[which], *beams))
            if len(widths) > 1:
                calls.insert(0, lambda: np.take(origins, which, axis=0, out=here))
                calls.append(lambda: np.put(nearest, which, found))
            return in_turn(calls)

        return in_turn([of_width(angle, which) for angle, which in widths])

    def _bind_bresenham(
        self, origins: Array, angle: float, limits: Array, nearest: Array, which: Any
    ) -> Callable[[], None]:
        """A function that writes the nearest of the rays in cones of one width into `nearest[which]`."""
        bearings = cone_bearings(angle)
        ranges = np.empty((len(origins), bearings.shape[1]))
        cast = self.bind_cast(origins, bearings, limits[:, None], ranges, "bresenham")

        def nearest_of_all() -> None:
            cast()
            nearest[which] = ranges.min(axis=1)[which]

        return nearest_of_all

    def nearest_wall(self, origins: Array, half_angle: Array, range_max: Array) -> tuple[Array, Array]:
        """Bearing and range of the nearest wall in a cone; see `amorsim.contracts.View.nearest_wall`."""
        self._carried("nearest_wall", origins)
        shape = self.rows, len(origins) // self.rows
        bearing, out = np.empty(shape), np.empty(shape)
        self.bind_nearest_wall(origins, half_angle, range_max, bearing, out)()
        return bearing, out

    def bind_nearest_wall(
        self, origins: Array, half_angle: Array, range_max: Array, bearing: Array, out: Array
    ) -> Callable[[], None]:
        """A function that writes bearings and ranges; see `amorsim.contracts.View.bind_nearest_wall`."""
        _, replica = self._carried("nearest_wall", origins)
        per_row = len(origins) // self.rows
        limits = self._per_origin(range_max, per_row)

        def of_width(angle: float, which: Any) -> Callable[[], None]:
            here = origins[which]  # a copy, if there are cones of other widths
            beams = here, angle, *cone_directions(angle), limits[which], np.empty(len(here))
            cast = self._bind_cone_walls(replica[which], *beams, which, (bearing, out))
            return in_turn([lambda: np.copyto(here, origins[which]), cast])

        return in_turn([of_width(angle, which) for angle, which in _by_width(half_angle, per_row)])

    def _per_row(self, values: Array) -> Array:
        """One number for each row `(N,)`, from `(N, 1)` or one for all; a copy, as kernels need writable arrays."""
        if np.shape(values) == (self.rows, 1):
            return np.array(values[:, 0])
        return np.array(np.broadcast_to(values, (self.rows, 1))[:, 0])

    def _per_origin(self, values: Array, per_row: int) -> Array:
        """One number for each of a row's origins."""
        each = self._per_row(values)
        return each if per_row == 1 else np.repeat(each, per_row)

    def _limits(self, asked: str, range_max: Array, origins: Array, row: Ints | None) -> Array:
        """One limit for each origin `(M,)`, from one for each origin, for each row, or for all."""
        if np.shape(range_max) == (len(origins), 1):
            return np.array(range_max[:, 0])
        if row is not None:
            raise ComponentError(
                f"view.{asked}: range_max: with `row`, expected an array ({len(origins)}, 1) [m], one for each origin, "
                f"got {_in_words(range_max)}"
            )
        return self._per_origin(range_max, len(origins) // self.rows)

    def _bind_cone_walls(
        self,
        replica: Ints,
        origins: Array,
        half_angle: float,
        cos_b: Array,
        sin_b: Array,
        limits: Array,
        out: Array,
        which: Any,
        wall: tuple[Array, Array] | None,
    ) -> Callable[[], None]:
        """A function that writes the nearest walls `(Q,)` in cones of one width into `out`.

        If `wall` is given, their bearings and ranges are also written into `which` of its arrays.
        """
        terrain = self._world.terrain
        ray = _NO_RAYS if wall is None else np.empty(len(out), dtype=np.int64)

        def prepare(a: int, b: int) -> Callable[[], None]:
            calls: list[Callable[[], None]] = []
            for map_, rows in terrain.between(replica, a, b):
                walls = *map_.grid, *map_.segment_index, *map_.origin
                beams = origins[rows], half_angle, cos_b, sin_b, limits[rows]
                calls.append(functools.partial(cones.cast_cones, *walls, *beams, out[rows], ray[rows]))
            return in_turn(calls)

        cast = self._world.workers.bind(len(origins), CONE_WORK, prepare)
        if wall is None:
            return cast
        bearing, ranges = (array.reshape(-1) for array in wall)
        bearings = cone_bearings(half_angle)[0]

        def cast_and_tell() -> None:
            cast()
            bearing[which] = bearings[ray]
            ranges[which] = out

        return cast_and_tell

    def _carried(self, asked: str, origins: Array, row: Ints | None = None) -> tuple[Ints, Ints]:
        """The body that carries each origin, and its replica; of origins in turn, or of those of a `row` `(M,)`.

        Raises a clear error for a component's wrong origins, before a kernel raises an unclear one, or none.
        """
        if not isinstance(origins, np.ndarray) or origins.ndim != 2 or origins.shape[1] != 3:
            raise ComponentError(
                f"view.{asked}: origins: expected poses in the world, an array (N * m, 3) such as view.pose, "
                f"got {_in_words(origins)}"
            )
        if row is not None:
            if not _are_indices(row, (len(origins),), 0, self.rows):
                raise ComponentError(
                    f"view.{asked}: row: expected the row of each origin, an int64 array ({len(origins)},) of numbers "
                    f"from 0 to {self.rows - 1}, got {_in_words(row)}"
                )
            own = self._bodies[row]
            return own, self._world.replica_index[own]
        per_row, over = divmod(len(origins), self.rows)
        if over:
            raise ComponentError(
                f"view.{asked}: origins: expected as many for each of {self.rows} rows, got {len(origins)}; `row` says "
                "which is whose"
            )
        known = self._carriers.get(per_row)
        if known is None:
            own = np.repeat(self._bodies, per_row)
            known = self._carriers[per_row] = own, self._world.replica_index[own]
        return known


def _by_width(half_angle: Array, per_row: int) -> Iterator[tuple[float, Any]]:
    """Each half angle [rad] of `(N, 1)`, or one for all, with an index of the cones `(N * per_row,)` that have it."""
    widths = np.ravel(half_angle)
    widest = float(widths[0])
    if len(widths) == 1 or (widths == widest).all():
        yield widest, slice(None)
        return
    of_cone = np.repeat(widths, per_row)
    for angle in np.unique(widths):
        yield float(angle), np.flatnonzero(of_cone == angle)


def _check_bearings(asked: str, bearings: Any, origins: Array) -> None:
    if not isinstance(bearings, np.ndarray) or bearings.ndim != 2 or len(bearings) not in (1, len(origins)):
        raise ComponentError(
            f"view.{asked}: bearings: expected an array (1, k) or ({len(origins)}, k) [rad], got {_in_words(bearings)}"
        )


def _are_indices(values: Any, shape: tuple[int, ...], first: int, end: int) -> bool:
    """Whether these are an array of that shape, of whole numbers from `first` to `end` - 1."""
    if not isinstance(values, np.ndarray) or values.dtype != np.int64 or values.shape != shape:
        return False
    return all_indices(values.ravel() - first, end - first)


def _in_words(value: Any) -> str:
    return f"an array of shape {value.shape}" if isinstance(value, np.ndarray) else f"{value!r:.60}"
