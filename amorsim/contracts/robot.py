"""The parts of a robot, drives and sensors, and the model that it has of itself."""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts.binding import DriveBinding, SensorBinding, simple_form_first
from amorsim.contracts.values import Aim, Beliefs, State
from amorsim.contracts.view import Emission, View
from amorsim.core.draws import Draws
from amorsim.core.maps.map import Map
from amorsim.core.poses import Mount, exponential
from amorsim.core.shapes import Shape

__all__ = ["Component", "Context", "Drive", "Joint", "Part", "RobotModel", "Sensor", "SensorModel"]


class Component:
    """The base of all kinds that have a state."""

    def start(self, context: Context) -> State:
        """The state at the start of an episode: arrays whose first axis is the row; empty by default."""
        return {}


@attrs.frozen(kw_only=True)
class Joint:
    """A joint of a drive: a wheel or a steering axis. `rolls` is true for a wheel that turns along the ground."""

    name: str
    rolls: bool = True


class Part(NamedTuple):
    """A rigid body of a robot in addition to its base: a trailer, a boom. Its shape is in its own frame."""

    name: str
    shape: Shape


# A drive's methods in the simple form, and those that bind them to the engine's arrays.
_BOUND_BY = {
    "advance": "bind",
    "twist": "bind_twist",
    "displacement": "bind_displacement",
    "travel": "bind_travel",
}


class Drive(Component, abc.ABC):
    """How joints follow commands, and how a body moves as its joints move.

    The engine moves the true body with the true parameters and the wheels' travel over the ground. An estimator calls
    `displacement` with the nominal parameters and the encoders' readings.
    """

    # Both may be properties that depend on static fields.
    joints: ClassVar[tuple[Joint, ...]]
    channels: ClassVar[tuple[str, ...]]  # of a command, in order; joint rates [rad/s] or positions [rad]
    # Further bodies of the robot; this may be a property as well.
    parts: ClassVar[tuple[Part, ...]] = ()

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        simple_form_first(cls, _BOUND_BY, Drive)

    def bind(self, at: DriveBinding) -> Callable[[], None]:
        """The function that each step calls: it moves the joints, and writes what `advance` returns into ``at.out``.

        By default it calls `advance`; override it, too, for joints that move by a kernel on the engine's own arrays.
        """

        def advance() -> None:
            copies = at.joints.copy(), at.joint_rates.copy(), at.command.copy()
            at.answer(*self.advance(*copies, at.dt, at.state, at.draws))

        return advance

    @abc.abstractmethod
    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """Joints `(N, j)` [rad] and their rates [rad/s] a step later, under `command` `(N, c)` within the limits."""

    @abc.abstractmethod
    def twist(self, before: Array, after: Array) -> Array:
        """The body's motion (forward [m], left [m], turn [rad]) `(N, 3)` in a step from `before` to `after`.

        A drive whose path is not that of a constant twist returns the mean twist and overrides `displacement`.
        """

    def bind_twist(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        """A function that writes `twist` `(N, 3)` into `out`, for joints in arrays that keep their place.

        By default it calls `twist`; override it, too, for a drive that moves by a kernel. The same holds for
        `bind_displacement` and `bind_travel`. The engine moves the true bodies with these functions, and estimators
        reckon with them.
        """
        return lambda: np.copyto(out, self.twist(before, after))

    @property
    def goes_on_arcs(self) -> bool:
        """Whether the path of a step is an arc of a circle: that of the twist, as `displacement` is not overridden."""
        return type(self).displacement is Drive.displacement

    @abc.abstractmethod
    def command_for(self, twist: Array, joints: Array) -> Array:
        """The command `(N, c)` that moves the body with `twist` `(N, 3)` [m/s, m/s, rad/s], or as close as possible."""

    @abc.abstractmethod
    def rolling_radius(self) -> Array:
        """Travel over the ground per turn [m/rad] of each joint that rolls, `(N, r)`."""

    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        """The body's displacement `(N, 3)`, in its frame before, in closed form, at a fraction `(N, 1)` of the step."""
        return exponential(self.twist(before, after), fraction)

    def bind_displacement(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        """A function that writes the `displacement` `(N, 3)` of the whole step into `out`; see `bind_twist`."""
        whole = np.ones((len(out), 1))
        return lambda: np.copyto(out, self.displacement(before, after, whole))

    def between(self, before: Array, after: Array, fraction: Array) -> Array:
        """The joints `(N, j)` after a stop at `fraction`; moving to them displaces the body as in `displacement`."""
        return before + (after - before) * fraction

    def travel(self, before: Array, after: Array) -> Array:
        """Bounds on the path `(N, 2)`: a part f of the step covers at most f times this length [m] and turning [rad].

        The search for contact uses them. A drive that moves unevenly within a step must bound its fastest part.
        """
        twist = self.twist(before, after)
        return np.stack((np.sqrt(twist[:, 0] ** 2 + twist[:, 1] ** 2), np.abs(twist[:, 2])), axis=1)

    def bind_travel(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        """A function that writes `travel` `(N, 2)` into `out`; see `bind_twist`."""
        return lambda: np.copyto(out, self.travel(before, after))

    def contacts(self, joints: Array) -> Array:
        """Where each joint that rolls touches the ground `(N, r, 2)` [m], in the body's frame.

        Zones of the floor act there. By default all joints touch at the base point.
        """
        return np.zeros((len(joints), sum(joint.rolls for joint in self.joints), 2))

    def follow(self, joints: Array, displacement: Array) -> Array:
        """The joints `(N, j)` after passive ones have followed the body's actual `displacement` `(N, 3)`."""
        return joints

    def part_poses(self, joints: Array) -> Array:
        """Poses of the `parts` `(N, p, 3)` in the body's frame, for these joints."""
        return np.zeros((len(joints), 0, 3))

    def part_travel(self, before: Array, after: Array) -> Array:
        """Bounds on the parts' paths in the world `(N, p, 2)` [m, rad], as `travel` gives the body's.

        At a fraction f the joints are ``follow(between(before, after, f), displacement(before, after, f))``, and the
        parts are at their `part_poses`. Bounds that are too low let parts pass through walls; too high cost only time.
        """
        return np.zeros((len(before), 0, 2))

    def heading_offset(self, joints: Array) -> Array | None:
        """The direction of travel `(N, 1)` [rad] in the body's frame; None: the body's heading.

        For drives whose wheels steer independently of the body; the turn of a twist is then that of the course.
        """
        return None

    def curvature_max(self) -> Array | None:
        """The largest curvature that the drive can follow `(N, 1)` [1/m]; None for a drive that turns in place."""
        return None

    def top_speeds(self) -> Array | None:
        """Limits of speed [m/s], turn [rad/s] and their rates of change [m/s^2, rad/s^2], `(N, 4)`.

        inf for no limit; None if the drive does not know its limits.
        """
        return None


class Sensor(Component, abc.ABC):
    """The reading of an ideal device. Mount, rate, latency and noise are set for any sensor, outside its class."""

    unit: ClassVar[str]  # of the values: "m", "rad", "rad/s", "count" ...
    medium: ClassVar[str] = ""  # what it emits into, for others to hear: "ultrasound" ...; or a static field
    channels: ClassVar[tuple[str, ...]] = ()  # of its own commands, if it takes any: ("pan", "tilt")

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        simple_form_first(cls, {"sense": "bind", "emit": "bind_emit"}, Sensor)

    @abc.abstractmethod
    def size(self, drive: Drive) -> int:
        """The number of values in a reading on a robot with this drive; it depends on static parameters only."""

    @abc.abstractmethod
    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """The ideal reading `(N, k)`, and by name what else the chain may need (incidence ...), each `(N, k)`."""

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """The function that each step calls: it senses, and writes the ideal reading into ``at.out``.

        By default it calls `sense`. Override it, too, for a sensor that runs as a kernel on the engine's own arrays.
        It is called again when parameters change and when an episode begins.
        """

        def sense() -> None:
            values, side = self.sense(at.look(), Aim() if at.aim is None else at.aim(), at.state, at.draws)
            at.answer(values, side)

        return sense

    def columns(self) -> Mapping[str, str]:
        """Names and units of the columns of a reading, if its values are not all one quantity in `unit`.

        With c columns, value i belongs to column i modulo c: ``{"range": "m", "bearing": "rad"}`` means a range, a
        bearing, a range ... All sensors of a class with the same static parameters have the same columns. An element
        of the chain names the `column` that it acts on.
        """
        return {}

    def bearings(self) -> Array | None:
        """The bearing [rad] of each value, `(1, k)` or `(N, k)`, from the mount's heading; for range sensors."""
        return None

    def actuate(self, command: Array, dt: float, state: State, draws: Draws) -> None:
        """Follow the command `(N, c)` of its own `channels` for a step; the result goes into `state`."""

    def emit(self, view: View, state: State) -> Emission | None:
        """Its emission into its `medium`; called for all sensors that have one before any sensor senses."""
        return None

    def bind_emit(self, at: SensorBinding) -> Callable[[], Emission | None]:
        """The function of its emission that each step calls. By default it calls `emit`.

        It may return one `Emission` at every step, whose arrays keep their place.
        """
        return lambda: self.emit(at.look(), at.state)


@attrs.frozen(kw_only=True)
class SensorModel:
    """A sensor as the robot's software knows it: its nominal parameters, mount and rate."""

    name: str
    sensor: Sensor
    mount: Mount
    size: int  # values in a reading
    rate: float | None  # [Hz], None for every step; the lowest where rows have different rates
    rates: Sequence[float | None] = ()  # (N,) [Hz] of each row, if rows have different rates; else empty

    def rate_of(self, row: int) -> float | None:
        """The rate [Hz] of a row's sensor, or None for every step."""
        return self.rates[row] if self.rates else self.rate


@attrs.frozen(kw_only=True)
class RobotModel:
    """The model that N robots have of themselves and their world: nominal parameters and knowledge, never the truth."""

    rows: int
    dt: float  # [s]
    drive: Drive
    shape: Shape
    sensors: Mapping[str, SensorModel]
    channels: tuple[str, ...]  # of a command: the drive's, then "<sensor>.<channel>" of each device that takes commands
    map: Map | None = None  # `knowledge.map` of the scenario, if all rows know the same; see `map_of`
    landmarks: Array | None = None  # (L, 2) [m], `knowledge.landmarks` of the scenario
    landmark_ids: Ints | None = None  # (L,) their ids, 0 for a landmark without one
    names: Sequence[str] = ()  # the rows' robots, for messages
    maps: Sequence[Map | None] = ()  # (N,) what each row knows, if replicas have different maps; else empty
    beliefs: Mapping[str, Beliefs] = attrs.field(factory=dict, eq=False)
    """The present beliefs of its estimators, by name, as `Estimator.beliefs` returns them; computed when looked up."""

    def map_of(self, row: int) -> Map | None:
        """The map that a row's robot knows, or None."""
        return self.maps[row] if self.maps else self.map

    def who(self, row: int) -> str:
        """The name of a row's robot, for messages."""
        return f"robot {self.names[row]!r}" if self.names else f"row {row}"


@attrs.frozen(kw_only=True)
class Context:
    """The input of `start`: the number of rows, the step, the nominal robot, and what the robot knows of its start.

    `pose` and `covariance` are the robot's ``initial_belief``; of a robot that knows nothing of its start, the pose is
    nan.

    Nothing can be drawn here: draw random initial values at the first call, where `elapsed` is 0.
    """

    rows: int
    dt: float  # [s]
    robot: RobotModel  # an obstacle's motion has none and must not use it
    pose: Array  # (N, 3) [m, m, rad], as the robot believes; nan if it knows nothing of its start
    size: int = 0  # values in a sample, for a sensor and the elements of its chain
    names: Sequence[str] = ()  # the rows' robots or obstacles, for messages
    covariance: Array | None = None  # (N, 3, 3) of that pose; None: it is exact
