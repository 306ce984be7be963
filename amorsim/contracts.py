"""The contracts for plugin authors: the kinds of component, their inputs and their outputs.

A component is an ``attrs.frozen(kw_only=True)`` class whose fields are its parameters (`parameter`). It is written
once, over **rows**: a row is one robot in one replica of the scenario. In the engine its fields hold arrays: a number
is `(N, 1)`, so that ``values * self.scale`` broadcasts over `(N, k)`; see `amorsim.core.rows.stack`. Static fields
(`parameter(static=True)`), texts and flags stay plain, because they are equal in all rows of a group.

A component stores nothing on itself. What changes from step to step lives in ``state``, the dict of row-first arrays
that `start` returned: write into its arrays, or replace them by arrays of the same shape and dtype. The engine owns
the state, copies it for a snapshot, and resets single rows of it.

Results must not depend on the number of rows, to the bit: use elementwise NumPy, `amorsim.core.poses`, or a kernel,
never ``@``, ``dot`` or a sum over the rows. `amorsim.testing.check_component` tests all of this.
"""

from __future__ import annotations

import abc
import math
import types
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Protocol, cast

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.core.draws import Draws
from amorsim.core.errors import MapError
from amorsim.core.map import Map
from amorsim.core.noise_steps import NoiseProgram, NoiseStep
from amorsim.core.parameters import parameter
from amorsim.core.poses import Mount, exponential
from amorsim.core.shapes import Shape

__all__ = [
    "Aim",
    "Beliefs",
    "BodyStates",
    "Clock",
    "Context",
    "Controller",
    "Draws",
    "Drive",
    "Emission",
    "Emissions",
    "Estimate",
    "Estimator",
    "FloorPoints",
    "Frame",
    "Joint",
    "Lights",
    "MapLoader",
    "Measurement",
    "Motion",
    "Mount",
    "Neighbours",
    "Noise",
    "NoiseStep",
    "ObstacleFrame",
    "Part",
    "Plan",
    "Planner",
    "Recorder",
    "RobotModel",
    "RunInfo",
    "ScenarioDocument",
    "ScenarioLoader",
    "Sensor",
    "SensorModel",
    "Sightings",
    "State",
    "View",
    "WorldGenerator",
    "parameter",
]

Array = npt.NDArray[np.float64]
State = dict[str, npt.NDArray[Any]]
Beliefs = Mapping[str, npt.NDArray[Any]]
"""What an estimator believes besides the pose: arrays by name, first axis the row; nan where there is nothing."""


# ------------------------------------------------------------------------------------- what components are given


@attrs.frozen(kw_only=True)
class SensorModel:
    """A sensor as the robot's software knows it: its nominal parameters, mount and rate."""

    name: str
    sensor: Sensor
    mount: Mount
    size: int  # values in a reading
    rate: float | None  # [Hz], None for every step


@attrs.frozen(kw_only=True)
class RobotModel:
    """What N robots know of themselves and their world: nominal parameters and knowledge, never the truth."""

    rows: int
    dt: float  # [s]
    drive: Drive
    shape: Shape
    sensors: Mapping[str, SensorModel]
    channels: tuple[str, ...]  # of a command: the drive's, then "<sensor>.<channel>" of each device that takes commands
    map: Map | None = None  # `knowledge.map` of the scenario
    landmarks: Array | None = None  # (L, 2) [m], `knowledge.landmarks` of the scenario
    landmark_ids: npt.NDArray[np.int64] | None = None  # (L,) their ids, 0 for a landmark without one
    names: Sequence[str] = ()  # the rows' robots, for messages

    def who(self, row: int) -> str:
        """The name of a row's robot, for messages."""
        return f"robot {self.names[row]!r}" if self.names else f"row {row}"


@attrs.frozen(kw_only=True)
class Context:
    """The input of `start`: the number of rows, the step, the nominal robot, and the start pose that the robot knows.

    Nothing can be drawn here: draw random initial values at the first call, where `elapsed` is 0.
    """

    rows: int
    dt: float  # [s]
    robot: RobotModel  # an obstacle's motion has none and must not use it
    pose: Array  # (N, 3) [m, m, rad]
    size: int = 0  # values in a sample, for a sensor and the elements of its chain
    names: Sequence[str] = ()  # the rows' robots or obstacles, for messages


class Clock(NamedTuple):
    """The time of each row: `tick` (N, 1), `time` (N, 1) [s], and the step `dt` [s]."""

    tick: npt.NDArray[np.int64]
    time: Array
    dt: float


class Measurement(NamedTuple):
    """A reading as the robot receives it: the measured values `(N, k)`, their tick and age, and if they are new."""

    measured: Array
    stamp: npt.NDArray[np.int64]  # (N, 1), the tick of the values; -1 before the first arrive
    age: Array  # (N, 1) [s], since that tick
    fresh: npt.NDArray[np.bool_]  # (N, 1), whether they arrived in this step


class Estimate(NamedTuple):
    """An estimate of the robot's pose: `pose` (N, 3) [m, m, rad] and `covariance` (N, 3, 3)."""

    pose: Array
    covariance: Array


class Aim(NamedTuple):
    """Offsets of a sensor's beams: an angle [rad] added to each beam's bearing `(N, k)`, or None.

    `time` `(N, k)` [s] is when each beam is measured relative to this tick, at most 0; None: all at the tick.
    An element of a chain adds to the aim that it is given (``aim._replace``). A sensor without beams ignores both.
    """

    bearing: Array | None = None
    time: Array | None = None


class Emission(NamedTuple):
    """What a sensor emits into its medium: e emitters, each with a cone."""

    poses: Array  # (N, e, 3) pose of each emitter in the world; its cone points along the heading
    half_angle: Array  # (N, e) [rad] of its cone
    fired: npt.NDArray[np.bool_]  # (N, e) whether it fires at this tick
    time: Array | None = None  # (N, e) [s] when it fires, relative to the tick; None: all at the tick


class Emissions(NamedTuple):
    """All e emitters of a medium (ultrasound ...) in each row's replica, the same in all replicas."""

    poses: Array  # (N, e, 3) pose of each emitter in the world; its cone points along the heading
    half_angle: Array  # (N, e) [rad] of its cone
    fired: npt.NDArray[np.bool_]  # (N, e) whether it fires at this tick
    own: npt.NDArray[np.bool_]  # (N, e) whether it belongs to the row's own sensor, in the order of its `emit`
    time: Array  # (N, e) [s] when it fires, relative to the tick
    body: npt.NDArray[np.int64]  # (N, e) the body that carries it, an index into `View.bodies`


class BodyStates(NamedTuple):
    """All B bodies of each row's replica: robots, obstacles and parts of robots, including the row's own body."""

    poses: Array  # (N, B, 3) true, in the world
    twists: Array  # (N, B, 3) [m/s, m/s, rad/s] over the last step, in each body's frame
    reach: Array  # (B,) [m] from a body's base point to the farthest point of its footprint
    own: npt.NDArray[np.int64]  # (N,) the index of the row's own body
    is_robot: npt.NDArray[np.bool_]  # (B,) a robot or a part of one; the others are obstacles
    owner: npt.NDArray[np.int64]  # (B,) the robot's body that a part belongs to; of all others, the body itself


class Neighbours(NamedTuple):
    """The bodies near each row, K in all: row after row, in order of body within a row.

    `poses` to `owner` cover all T bodies of all replicas; `own` and `body` are indices into them. To sum values for
    each row, use ``np.add.at(total, near.row, values)``: it adds in this order for any number of rows.
    """

    own: npt.NDArray[np.int64]  # (N,) the row's own body
    first: npt.NDArray[np.int64]  # (N + 1,) row n's neighbours are first[n]:first[n + 1] of the K
    body: npt.NDArray[np.int64]  # (K,) the neighbour's body
    poses: Array  # (T, 3) true, in the world
    twists: Array  # (T, 3) [m/s, m/s, rad/s] over the last step, in each body's frame
    reach: Array  # (T,) [m] from a body's base point to the farthest point of its footprint
    is_robot: npt.NDArray[np.bool_]  # (T,) a robot or a part of one; the others are obstacles
    owner: npt.NDArray[np.int64]  # (T,) the robot's body that a part belongs to; of all others, the body itself

    @property
    def row(self) -> npt.NDArray[np.int64]:
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
    id: npt.NDArray[np.int64]  # (N, m) the mark's id, 1 and up; -1 where empty


class View(Protocol):
    """The true world as sensors and motions may query it, for N rows; read-only."""

    rows: int
    dt: float
    tick: npt.NDArray[np.int64]  # (N, 1)
    body_pose: Array  # (N, 3) true pose of the robot's base
    twist: Array  # (N, 3) [m/s, m/s, rad/s] mean true velocity over the last step, in the body's frame
    joints: Array  # (N, j) true positions of the drive's joints
    joint_rates: Array  # (N, j)
    free: (
        Array  # (N, 1) for motions: the fraction of the last displacement that was free; 1 at first and where it was 0
    )

    mount: Array  # (N, 3) true pose of the sensor's mount on the body

    @property
    def names(self) -> Sequence[str]:
        """The names of the rows' robots or obstacles, for messages."""

    @property
    def pose(self) -> Array:
        """True pose `(N, 3)` of the sensor's mount in the world; for a motion, of the body."""

    def cast(
        self, origins: Array, bearings: Array, range_max: Array, traversal: str = "exact", bodies: bool = True
    ) -> Array:
        """Distances [m] `(N * m, k)` to the nearest wall or other body along beams from `origins`, inf for none.

        A robot sees neither itself nor its own parts. `origins` `(N * m, 3)` are world poses, m for each row in turn.
        `bearings` `(1, k)` or `(N * m, k)` are relative to them. `range_max` is `(N, 1)`, or `(N * m, 1)` for each
        origin. With `traversal` ``"bresenham"``, walls are searched along the cells of Bresenham's line, as in the
        original AMORsim, and distances are between the centres of cells. Without `bodies`, only walls count.
        """

    def cone(self, origins: Array, half_angle: Array, range_max: Array, traversal: str = "exact") -> Array:
        """The nearest return [m] `(N, m)` within a cone at each of `origins` `(N * m, 3)`, inf for none.

        It is the minimum over rays at most 0.05 degrees apart, both edges included; `half_angle` [rad] is `(N, 1)`.
        """

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
        self, origins: Array, bearings: Array, range_max: Array, landmarks: bool = True
    ) -> tuple[Array, npt.NDArray[np.int64]]:
        """Distances [m] `(N * m, k)` as from `cast`, and the thing that each beam hits first: -1 for a wall or nothing.

        Things are the bodies of the replica, in order, then those landmarks that have a colour and a size.
        Without `landmarks`, things are bodies only, and the distances are those of `cast`.
        """

    def normals(self, origins: Array, bearings: Array, bodies: npt.NDArray[np.int64]) -> Array:
        """Directions [rad] `(N * m, k)` in the world of the outward normals where beams enter bodies; nan elsewhere.

        `bodies` `(N * m, k)` comes from `look` for the same beams, without landmarks.
        """

    def touches(self, zones: Sequence[Shape], which: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        """Whether zones of the rows' bodies, in the bodies' frames, overlap a wall or another body `(N, s)`.

        `which` `(N, s)` holds indices into `zones`.
        """

    def floor(self, places: Array) -> FloorPoints:
        """Properties of the floor, with its markings and drops, at places `(N, k, 2)` [m] in the world."""

    def lights(self) -> Lights:
        """All lamps, in sight or not; `cast` finds out which are."""

    def emissions(self, medium: str) -> Emissions:
        """The emitters of all sensors with this `medium`, and which fire at this tick; for sensors, not motions."""


# -------------------------------------------------------------------------------------------- kinds of component


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

    @abc.abstractmethod
    def command_for(self, twist: Array, joints: Array) -> Array:
        """The command `(N, c)` that moves the body with `twist` `(N, 3)` [m/s, m/s, rad/s], or as close as possible."""

    @abc.abstractmethod
    def rolling_radius(self) -> Array:
        """Travel over the ground per turn [m/rad] of each joint that rolls, `(N, r)`."""

    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        """The body's displacement `(N, 3)`, in its frame before, in closed form, at a fraction `(N, 1)` of the step."""
        return exponential(self.twist(before, after), fraction)

    def between(self, before: Array, after: Array, fraction: Array) -> Array:
        """The joints `(N, j)` after a stop at `fraction`; moving to them displaces the body as `displacement` says."""
        return before + (after - before) * fraction

    def travel(self, before: Array, after: Array) -> Array:
        """Bounds on the path `(N, 2)`: a part f of the step covers at most f times this length [m] and turning [rad].

        The search for contact uses them. A drive that moves unevenly within a step must bound its fastest part.
        """
        twist = self.twist(before, after)
        return np.stack((np.sqrt(twist[:, 0] ** 2 + twist[:, 1] ** 2), np.abs(twist[:, 2])), axis=1)

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

    @abc.abstractmethod
    def size(self, drive: Drive) -> int:
        """The number of values in a reading on a robot with this drive; it depends on static parameters only."""

    @abc.abstractmethod
    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """The ideal reading `(N, k)`, and by name what else the chain may need (incidence ...), each `(N, k)`."""

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
        """What it emits into its `medium`; called for all sensors that have one before any sensor senses."""
        return None


class Noise(Component):
    """One element of a noise chain, which a device's values pass in order. Override at least one method.

    An element with `for_ground` acts between wheels and ground, in `Robot.ground` or in a zone: its values are travels,
    and sensors reject it.
    """

    for_ground: ClassVar[bool] = False

    def aim(self, aim: Aim, elapsed: Array, state: State, draws: Draws) -> Aim:
        """The device's true aim, before it senses."""
        return aim

    def steps(self) -> Sequence[NoiseStep]:
        """What the element does, as steps for a kernel; empty if `corrupt` is written in Python.

        A chain runs the steps of neighbouring elements in one call, so an element made of steps costs next to
        nothing. Do not override `corrupt` then: it runs the same steps.
        """
        return ()

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The corrupted values `(N, k)`; `elapsed` `(N, 1)` [s] since the previous sample (0 at the first)."""
        program = NoiseProgram([values.shape[1]], [[(step, draws) for step in self.steps()]])
        return program.apply(np.ravel(values)).reshape(values.shape)

    def slide(self, motion: Array, elapsed: Array, state: State, draws: Draws) -> Array:
        """The body's slide in a step `(N, 3)` [m, m, rad], in addition to the `motion` that its wheels make.

        Both are (forward, left, turn) in the body's frame, `(N, 3)`; the slide is spread evenly over the step. It is
        used in the `ground` of a robot or a zone, and called after `corrupt`. Encoders do not see it.
        """
        return np.zeros_like(motion)

    def delay(self, elapsed: Array, state: State, draws: Draws) -> Array:
        """Delay `(N, 1)` [s] of a reading in addition to its sensor's latency; negative: it arrives earlier.

        The delays of a chain add up. No reading arrives before it was taken or overtakes one taken earlier.
        """
        return np.zeros_like(elapsed)

    def longest_delay(self) -> Array:
        """Upper bound `(N, 1)` [s] of `delay`; override both together. It must not change during a run."""
        return np.zeros((1, 1))


class Estimator(Component, abc.ABC):
    """Estimates the robot's pose from its readings, the nominal robot and its knowledge, never from the true world."""

    @abc.abstractmethod
    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The estimate after this step's readings; `elapsed` `(N, 1)` [s] since the previous one (0 at the start)."""

    def beliefs(self, state: State) -> Beliefs:
        """What else it believes after the last update: innovations, verdicts of gates, biases ...; nothing by default.

        Called only when a recorder or a viewer asks, once a step at most, so compute here what `update` does not need.
        Names and shapes are the same in every step: (N, ...), of float64, int64 or bool, first axis the row. Values are
        finite, or nan where there is nothing. Return arrays that later steps do not write into. Do not change `state`.
        """
        return {}

    def sources(self) -> Sequence[tuple[str, str, str]]:
        """What it uses: a sensor or another source, what that says about the state, and how far it is trusted.

        Called on the estimator as specified, before stacking; ``amorsim check`` prints it as a table.
        """
        return ()


class Controller(Component, abc.ABC):
    """Computes a command from readings and estimate. A plain function for one robot works as well."""

    @abc.abstractmethod
    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)`: all of ``robot.channels`` in order, or only the drive's, which leaves devices at 0."""

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The goals of the controller in the world: the field of each ("waypoints.2"), x and y [m].

        Called on the controller as specified, before stacking; ``amorsim check`` reports goals that are out of reach.
        """
        return ()


class Motion(Component, abc.ABC):
    """How an obstacle wants to move; ``view.free`` is the fraction of it that was free."""

    @abc.abstractmethod
    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """The displacement `(N, 3)` that is wanted in this step, in the obstacle's own frame."""

    def default_start(self) -> tuple[float, float, float] | None:
        """Start (x [m], y [m], heading [rad]) of an obstacle that is given no pose; None: the origin.

        Called on the motion as specified, before there are rows.
        """
        return None

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The goals of the motion in the world, as in `Controller.goal_points`."""
        return ()


class MapLoader(abc.ABC):
    """Reads maps of one format; its fields are the options of `amorsim.load_map`."""

    extensions: ClassVar[tuple[str, ...]]  # with the dot, lower case

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file that begins with `head` has this format; called if the extension does not decide."""
        return False

    @abc.abstractmethod
    def load(self, path: Path) -> Map:
        """The map in a file. Raises `MapError`, which names the fault and, where possible, the line."""

    def companions(self, path: Path) -> Sequence[Path]:
        """The other files that `load` reads for this one, such as the picture that it names.

        A run's folder gets copies of all of them, in the same places relative to each other, so a file must name its
        companions relative to itself. Raises `MapError` if the file cannot be read.
        """
        return ()

    @classmethod
    def save(cls, world: Map, path: Path) -> MapLoader:
        """Write a map to a file of this format, if the loader can; returns the loader that reads it again.

        Companions are written next to it and named relative to it: all files move to their final place once they are
        complete. `amorsim.save_map` reads the file back and checks that the cells are the same.
        """
        raise MapError(f"maps cannot be written as {' or '.join(cls.extensions)}")


class WorldGenerator(abc.ABC):
    """Generates worlds: its fields are the parameters that stand beside ``generate`` in a scenario's map."""

    @abc.abstractmethod
    def generate(self, draws: Draws) -> Map:
        """A world, with a free place for the robot as its `start`.

        All that is random comes from `draws`, which has one row, so that the same seed gives the same cells on every
        machine: leave out sines and the like, whose last bits differ. It must end, so bound all tries. Raises
        `MapError` if the parameters admit no world; the message says which of them to change.
        """


@attrs.frozen(kw_only=True)
class ScenarioDocument:
    """What another program's file says, as a scenario's own file would say it.

    Parameters
    ----------
    tables
        The tables of a scenario: ``{"format": 1, "world": {...}, "robots": [...], ...}``, angles in degrees. Relative
        paths start at the file's folder. The map is usually the same file again, read by a map loader.
    remarks
        What was left out or changed, a sentence each.
    lines
        The line of the file that says what is at a path: ``{"robots.0": 12}``; messages about faults show it.
    """

    tables: dict[str, Any]
    remarks: tuple[str, ...] = ()
    lines: Mapping[str, int] = attrs.field(factory=dict)


class ScenarioLoader(abc.ABC):
    """Reads scenarios from another program's files; its fields are options, as in ``--set loader.crop_bitmaps=true``.

    A loader only reads: it runs no program that a file names.
    """

    extensions: ClassVar[tuple[str, ...]]  # with the dot, lower case

    @classmethod
    @abc.abstractmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file of one of the extensions that begins with `head` has this format; else it is no scenario."""

    @abc.abstractmethod
    def read(self, path: Path) -> ScenarioDocument:
        """The scenario in a file. Raises `ScenarioError` with the file and the line of each fault."""


@attrs.frozen(kw_only=True, eq=False)
class Plan:
    """The answer of a planner: a path from start to goal, or the reason why there is none."""

    status: str
    """``"found"``, ``"unreachable"``, ``"start_blocked"``, ``"goal_blocked"``, or ``"budget"`` if the planner's budget
    was used up before it had an answer."""
    poses: Array = attrs.field(factory=lambda: np.empty((0, 3)))
    """(M, 3) [m, m, rad] in the world: the corners of the path, from start to goal, joined by straight lines.

    The heading is that of the line to the next pose; at the goal the one asked for, or else that of the last line. No
    poses without a path.
    """
    length: float = math.inf
    """Length of the path [m]; inf without one."""
    cost: float = math.inf
    """What the planner minimised, along this path; inf without one."""
    expanded: int = 0
    """How many cells or states the planner took up."""
    searched: Array = attrs.field(factory=lambda: np.empty((0, 2)))
    """(K, 2) [m] in the world: the places it took up, in order, for pictures."""
    message: str = ""
    """Why there is no path, in a sentence; empty if there is one."""

    @property
    def points(self) -> Array:
        """The places of the poses (M, 2) [m]."""
        return self.poses[:, :2]


class Planner(abc.ABC):
    """Finds a path on a map: a pure function of map, start, goal, footprint and its own parameters.

    The map is one that a robot was given or made, never the true world. A planner works at a cell size of its own, has
    a budget, so that it always comes to an end, and can be interrupted with Ctrl-C.
    """

    @abc.abstractmethod
    def plan(
        self, world: Map, start: Sequence[float], goal: Sequence[float], *, footprint: Shape | None = None
    ) -> Plan:
        """The plan for a robot with this footprint from `start` to `goal`, each (x, y) or (x, y, heading) [m, rad].

        Without a footprint the robot is a point. Places in walls or outside the map give a status. Raises `PlanError`
        if start or goal are not such numbers, or if the map has more cells than the planner can take.
        """


class Frame(NamedTuple):
    """One step of one group of robots for recorders, truth included. Do not change the arrays."""

    names: Sequence[str]  # of each row
    replica: npt.NDArray[np.int64]  # (N,)
    tick: npt.NDArray[np.int64]  # (N,)
    time: Array  # (N,) [s]
    true_pose: Array  # (N, 3)
    true_twist: Array  # (N, 3) mean over the step, in the body's frame
    joint_names: Sequence[str]
    joint_rates: Array  # (N, j) true, mean over the step
    estimates: Mapping[str, Estimate]  # the first is the controller's
    readings: Mapping[str, tuple[Array, Measurement]]  # true values, and the robot's measurement
    channels: Sequence[str]
    command: Array  # (N, c)
    robot: RobotModel  # the nominal one
    parts: Sequence[str] = ()  # names of each robot's parts
    part_pose: Array = np.empty((0, 0, 3))  # (N, p, 3) true, if there are parts
    # Of the estimators that have any, by name. Computed when first looked up, which must be in the frame's own step.
    beliefs: Mapping[str, Beliefs] = types.MappingProxyType({})


class ObstacleFrame(NamedTuple):
    """One step of one group of obstacles for recorders. Do not change the arrays."""

    names: Sequence[str]  # of each row
    replica: npt.NDArray[np.int64]  # (N,)
    tick: npt.NDArray[np.int64]  # (N,)
    time: Array  # (N,) [s]
    true_pose: Array  # (N, 3)
    true_twist: Array  # (N, 3) mean over the step, in the body's frame
    moves: bool  # whether they have a motion


class RunInfo(NamedTuple):
    """What a recorder knows of a run before its first step."""

    folder: Path  # exists, and belongs to this run only
    dt: float  # [s]
    replicas: Sequence[int]
    with_sensors: bool  # whether to write sensors


class Recorder(abc.ABC):
    """Records a run as it goes: an ``attrs.define(kw_only=True)`` class, because it keeps files open."""

    def fresh(self) -> Recorder:
        """A new recorder with the same parameters, not yet opened: each run has its own."""
        again: Recorder = attrs.evolve(cast(Any, self))
        return again

    @abc.abstractmethod
    def open(self, run: RunInfo, frames: Sequence[Frame]) -> None:
        """Begin a run; write `frames` too: they are those of tick 0, with the first readings."""

    @abc.abstractmethod
    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        """Record a step: a frame for each group, and the events (`amorsim.simulation.events.Event`) since the last."""

    def write_obstacles(self, frames: Sequence[ObstacleFrame]) -> None:
        """Record the obstacles, a frame for each group; called after `open` and after each `write`."""
        return

    @abc.abstractmethod
    def close(self) -> None:
        """End the run; also called when a run is aborted, or when it could not begin and `open` was never called."""
