"""The true world as sensors and motions may query it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.core.shapes import Shape

__all__ = [
    "BodyStates",
    "Directions",
    "Emission",
    "Emissions",
    "FloorPoints",
    "Lights",
    "Neighbours",
    "Sightings",
    "View",
]


class Directions(NamedTuple):
    """Bearings of beams, in place of angles: arrays that keep their place, and may change from call to call."""

    cos: Array  # (1 or M, k)
    sin: Array


class Emission(NamedTuple):
    """A sensor's emission into its medium: e emitters, each with a cone."""

    poses: Array  # (N, e, 3) pose of each emitter in the world; its cone points along the heading
    half_angle: Array  # (N, e) [rad] of its cone
    fired: Bools  # (N, e) whether it fires at this tick
    time: Array | None = None  # (N, e) [s] when it fires, relative to the tick; None: all at the tick


class Emissions(NamedTuple):
    """All e emitters of a medium (ultrasound ...) in each row's replica, the same in all replicas."""

    poses: Array  # (N, e, 3) pose of each emitter in the world; its cone points along the heading
    half_angle: Array  # (N, e) [rad] of its cone
    fired: Bools  # (N, e) whether it fires at this tick
    own: Bools  # (N, e) whether it belongs to the row's own sensor, in the order of its `emit`
    time: Array  # (N, e) [s] when it fires, relative to the tick
    body: Ints  # (N, e) the body that carries it, an index into `View.bodies`


class BodyStates(NamedTuple):
    """All B bodies of each row's replica: robots, obstacles and parts of robots, including the row's own body."""

    poses: Array  # (N, B, 3) true, in the world
    twists: Array  # (N, B, 3) [m/s, m/s, rad/s] over the last step, in each body's frame
    reach: Array  # (B,) [m] from a body's base point to the farthest point of its footprint
    own: Ints  # (N,) the index of the row's own body
    is_robot: Bools  # (B,) a robot or a part of one; the others are obstacles
    owner: Ints  # (B,) the robot's body that a part belongs to; of all others, the body itself


class Neighbours(NamedTuple):
    """The bodies near each row, K in all: row after row, in order of body within a row.

    `poses` to `owner` cover all T bodies of all replicas; `own` and `body` are indices into them. To sum values for
    each row, use ``np.add.at(total, near.row, values)``: it adds in this order for any number of rows.
    """

    own: Ints  # (N,) the row's own body
    first: Ints  # (N + 1,) row n's neighbours are first[n]:first[n + 1] of the K
    body: Ints  # (K,) the neighbour's body
    poses: Array  # (T, 3) true, in the world
    twists: Array  # (T, 3) [m/s, m/s, rad/s] over the last step, in each body's frame
    reach: Array  # (T,) [m] from a body's base point to the farthest point of its footprint
    is_robot: Bools  # (T,) a robot or a part of one; the others are obstacles
    owner: Ints  # (T,) the robot's body that a part belongs to; of all others, the body itself

    @property
    def row(self) -> Ints:
        """The row of each neighbour `(K,)`."""
        return np.repeat(np.arange(len(self.own)), np.diff(self.first))


class Lights(NamedTuple):
    """The M lamps of the world, the same in all replicas."""

    places: Array  # (M, 2) [m] in the world
    intensity: Array  # (M,) [cd]


class FloorPoints(NamedTuple):
    """Properties of the floor at k places of each row."""

    reflectance: Array  # (N, k) the fraction of light that it reflects, 0 to 1; 0 in a drop
    depth: Array  # (N, k) [m] below the floor that robots drive on; 0 outside drops


class Sightings(NamedTuple):
    """Marks in sight of each row, the nearest first, in m slots; slots that are left over are empty."""

    range: Array  # (N, m) [m] to the mark's place, inf where the slot is empty
    bearing: Array  # (N, m) [rad] from the heading of the sensor's mount, in [-pi, pi]; inf where empty
    id: Ints  # (N, m) the mark's id, 1 and up; -1 where empty


class View(Protocol):
    """The true world as sensors and motions may query it, for N rows; read-only."""

    rows: int
    dt: float
    tick: Ints  # (N, 1)
    body_pose: Array  # (N, 3) true pose of the robot's base
    twist: Array  # (N, 3) [m/s, m/s, rad/s] mean true velocity over the last step, in the body's frame
    joints: Array  # (N, j) true positions of the drive's joints
    joint_rates: Array  # (N, j)
    free: (
        Array  # (N, 1) for motions: the fraction of the last displacement that was free; 1 at first and where it was 0
    )

    mount: Array  # (N, 3) true pose of the sensor's mount on the body

    @property
    def has_company(self) -> bool:
        """Whether there are robots or obstacles other than the row's own."""

    @property
    def names(self) -> Sequence[str]:
        """The names of the rows' robots or obstacles, for messages."""

    @property
    def pose(self) -> Array:
        """True pose `(N, 3)` of the sensor's mount in the world; for a motion, of the body."""

    def cast(
        self,
        origins: Array,
        bearings: Array,
        range_max: Array,
        traversal: str = "exact",
        bodies: bool = True,
        row: Ints | None = None,
    ) -> Array:
        """Distances [m] `(M, k)` to the nearest wall or other body along beams from `origins` `(M, 3)`, inf for none.

        Parameters
        ----------
        origins
            World poses, M / N for each row in turn.
        bearings
            `(1, k)` or `(M, k)` [rad] from the origins' headings.
        range_max
            `(N, 1)`, or `(M, 1)` for each origin [m].
        traversal
            With ``"bresenham"``, walls are searched along the cells of Bresenham's line, as in the original AMORsim,
            and distances are between the centres of cells.
        bodies
            Without them, only walls count. A robot sees neither itself nor its own parts.
        row
            The row `(M,)` of each origin, if rows have different numbers of them; `range_max` is `(M, 1)` then.
        """

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
        """A function that writes what `cast` returns into `out` `(M, k)`, each time it is called; for `Sensor.bind`.

        It keeps `origins`, `out` and `Directions`, which must keep their place, and takes the other arguments as they
        are now.
        """

    def cone(self, origins: Array, half_angle: Array, range_max: Array, traversal: str = "exact") -> Array:
        """The nearest return [m] `(N, m)` within a cone at each of `origins` `(N * m, 3)`, inf for none.

        It is the minimum over rays at most 0.05 degrees apart, both edges included; `half_angle` [rad] is `(N, 1)`.
        """

    def bind_cone(
        self,
        origins: Array,
        half_angle: Array,
        range_max: Array,
        out: Array,
        traversal: str = "exact",
        wall: tuple[Array, Array] | None = None,
    ) -> Callable[[], None]:
        """A function that writes what `cone` returns into `out` `(N, m)`, as `bind_cast` does for `cast`.

        Into the two arrays of `wall` `(N, m)` it also writes what `nearest_wall` returns: for an exact traversal, and
        for less than the two searches take.
        """

    def nearest_wall(self, origins: Array, half_angle: Array, range_max: Array) -> tuple[Array, Array]:
        """Bearing [rad] and range [m] `(N, m)` of the nearest wall within a cone at each of `origins` `(N * m, 3)`.

        It is the first of the least over the rays that `cone` takes; bearings are from the origins' headings. Where no
        wall is within `range_max` [m] `(N, 1)`, the bearing is that of the first ray, and the range inf. `half_angle`
        [rad] is `(N, 1)`.
        """

    def bind_nearest_wall(
        self, origins: Array, half_angle: Array, range_max: Array, bearing: Array, out: Array
    ) -> Callable[[], None]:
        """A function that writes what `nearest_wall` returns into `bearing` and `out`, as `bind_cast` for `cast`."""

    def bodies(self) -> BodyStates:
        """Poses and twists of all bodies of each row's replica; `neighbours` is faster if there are many."""

    def neighbours(self, range_max: Array, ahead: Array | float = 0.0) -> Neighbours:
        """The bodies near each row, from a spatial hash: the cost grows with the bodies nearby, not with all bodies.

        A row's own body and its own parts are not neighbours.

        Parameters
        ----------
        range_max
            The largest distance [m] `(N, 1)` from the row's base point to a body's circle (`reach`).
        ahead
            A time [s], a number or `(N, 1)`. Bodies that could come within `range_max` in that time at their present
            speeds are neighbours as well.

        Raises
        ------
        ComponentError
            If either is not a number >= 0 for each row.
        """

    def landmarks(self, slots: int, range_max: Array, half_angle: Array) -> Sightings:
        """The nearest marks in sight of the sensor's mount: landmarks, and other bodies that carry a fiducial.

        They lie within `range_max` [m] and `half_angle` [rad] to either side of the mount's heading, both `(N, 1)`. A
        mark is in sight if no wall or body blocks the line to it; the row's body, its parts and the carrier never do.
        """

    @property
    def shape(self) -> Shape:
        """The footprint of the rows' bodies."""

    @property
    def colours(self) -> tuple[str | None, ...]:
        """The colour, or None, of each thing: the bodies of a replica in order, then the landmarks."""

    @property
    def heights(self) -> Array:
        """The height [m] of each thing `(B + L,)`, in the order of `colours`."""

    def look(
        self,
        origins: Array,
        bearings: Array,
        range_max: Array,
        landmarks: bool = True,
        row: Ints | None = None,
    ) -> tuple[Array, Ints]:
        """Distances [m] `(M, k)` as from `cast`, and the thing that each beam hits first: -1 for a wall or nothing.

        `range_max` and `row` are as in `cast`. Things are the bodies of the replica, in order, then those landmarks
        that have a colour and a size. Without `landmarks`, things are bodies only, and the distances those of `cast`.
        """

    def bind_look(
        self,
        origins: Array,
        bearings: Array,
        limits: Array,
        out: Array,
        thing: Ints,
        nearest: Array | None = None,
    ) -> Callable[[], None]:
        """A function that writes what `look` returns without landmarks into `out` and `thing` `(M, k)`.

        It keeps `origins`, and the `limits` `(M,)` [m] of their beams, too: a limit below 0 leaves an origin out, whose
        beams then have any range and thing. If hits nearer than `nearest` `(M, k)` [m] do not matter, give that, too:
        beams that are sure to hit a wall sooner then have the range 0 and the thing -1, and need not be cast.
        """

    def normals(
        self,
        origins: Array,
        bearings: Array,
        bodies: Ints,
        row: Ints | None = None,
    ) -> Array:
        """Directions [rad] `(M, k)` in the world of the outward normals where beams enter bodies; nan elsewhere.

        `bodies` `(M, k)` comes from `look` for the same beams, without landmarks; `row` is as there.
        """

    def touches(self, zones: Sequence[Shape], which: Ints) -> Bools:
        """Whether zones of the rows' bodies, in the bodies' frames, overlap a wall or another body `(N, s)`.

        `which` `(N, s)` holds indices into `zones`.
        """

    def floor(self, places: Array) -> FloorPoints:
        """Properties of the floor, with its markings and drops, at places `(N, k, 2)` [m] in the world."""

    def lights(self) -> Lights:
        """All lamps, in sight or not; `cast` finds out which are."""

    def emissions(self, medium: str) -> Emissions:
        """The emitters of all sensors with this `medium`, and which fire at this tick; for sensors, not motions."""

    def bind_emissions(self, medium: str) -> Callable[[], Emissions]:
        """A function that returns `emissions` for the sensor that binds it, in arrays of the engine's own."""
