"""What a plugin author reads: the kinds of component, what each is given and what it gives back.

A component is an ``attrs.frozen(kw_only=True)`` class whose fields are its parameters (`parameter`). It is written
once, over **rows**: a row is one robot in one replica of the scenario. In the engine its fields hold arrays: a number
is `(N, 1)`, so that ``values * self.scale`` broadcasts over `(N, k)`; see `amorsim.core.rows.stack`. Static fields
(`parameter(static=True)`), texts and flags stay plain, for they are equal in all rows of a group.

A component keeps nothing on itself. What changes from step to step lives in ``state``, the dict of row-first arrays
that `start` returned: write into its arrays, or put arrays of the same shape and dtype in their places. The engine
owns it, copies it for a snapshot, and resets single rows of it.

Bits must not depend on how many rows there are: use elementwise NumPy, `amorsim.core.poses`, or a kernel, never
``@``, ``dot`` or a sum over the rows. `amorsim.testing.check_component` tries all of this.
"""

from __future__ import annotations

import abc
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
    "Noise",
    "NoiseStep",
    "ObstacleFrame",
    "Part",
    "Recorder",
    "RobotModel",
    "RunInfo",
    "Sensor",
    "SensorModel",
    "Sightings",
    "State",
    "View",
    "parameter",
]

Array = npt.NDArray[np.float64]
State = dict[str, npt.NDArray[Any]]


# ------------------------------------------------------------------------------------- what components are given


@attrs.frozen(kw_only=True)
class SensorModel:
    """A sensor as the robot's software holds it: its nominal parameters, where it is mounted, how often it reads."""

    name: str
    sensor: Sensor
    mount: Mount
    size: int  # values in a reading
    rate: float | None  # [Hz], None for every step


@attrs.frozen(kw_only=True)
class RobotModel:
    """What a robot knows of itself and was told: nominal parameters throughout, for N rows. Never the truth."""

    rows: int
    dt: float  # [s]
    drive: Drive
    shape: Shape
    sensors: Mapping[str, SensorModel]
    channels: tuple[str, ...]  # of a command: the drive's, then "<sensor>.<channel>" of each device that takes commands
    map: Map | None = None  # `knowledge.map` of the scenario
    landmarks: Array | None = None  # (L, 2) [m], `knowledge.landmarks` of the scenario
    landmark_ids: npt.NDArray[np.int64] | None = None  # (L,) of the same, 0 where the robot was told none
    names: Sequence[str] = ()  # of the rows' robots, for messages

    def who(self, row: int) -> str:
        """The robot of a row, as a message calls it."""
        return f"robot {self.names[row]!r}" if self.names else f"row {row}"


@attrs.frozen(kw_only=True)
class Context:
    """What `start` is given: how many rows, the step, the nominal robot, and where the robot was told it stands.

    There are no draws at the start: what begins at random is drawn at the first call, where `elapsed` is 0.
    """

    rows: int
    dt: float  # [s]
    robot: RobotModel  # an obstacle's motion has none, and must not ask
    pose: Array  # (N, 3) [m, m, rad]
    size: int = 0  # values in a sample: for a sensor, and for the elements of a chain
    names: Sequence[str] = ()  # of the rows' robots or obstacles, for messages


class Clock(NamedTuple):
    """The time of each row: `tick` (N, 1), `time` (N, 1) [s], and the step `dt` [s]."""

    tick: npt.NDArray[np.int64]
    time: Array
    dt: float


class Measurement(NamedTuple):
    """A reading as the robot has it: the measured values `(N, k)`, from when they are, and whether they are new."""

    measured: Array
    stamp: npt.NDArray[np.int64]  # (N, 1), the tick that the values are of; -1 before there are any
    age: Array  # (N, 1) [s], since that tick
    fresh: npt.NDArray[np.bool_]  # (N, 1), whether they arrived in this step


class Estimate(NamedTuple):
    """What the robot believes of its pose: `pose` (N, 3) [m, m, rad] and `covariance` (N, 3, 3)."""

    pose: Array
    covariance: Array


class Aim(NamedTuple):
    """How a sensor's beams are bent before it looks: an angle [rad] added to each beam's bearing `(N, k)`, or none.

    And when each looks, from this tick on `(N, k)` [s], at most 0; none for all at the tick. An element of a chain
    adds to what it is given (``aim._replace``); a sensor without beams heeds neither.
    """

    bearing: Array | None = None
    time: Array | None = None


class Emission(NamedTuple):
    """What a sensor fires into its medium, from e emitters, each with a cone."""

    poses: Array  # (N, e, 3) where each stands in the world, and looks
    half_angle: Array  # (N, e) [rad] of its cone
    fired: npt.NDArray[np.bool_]  # (N, e) whether it fires at this tick
    time: Array | None = None  # (N, e) [s] from the tick on, when it fires; none for all at the tick


class Emissions(NamedTuple):
    """Every emitter of a medium (ultrasound ...) in each row's replica; e of them, the same in all replicas."""

    poses: Array  # (N, e, 3) where it stands in the world, and looks
    half_angle: Array  # (N, e) [rad] of its cone
    fired: npt.NDArray[np.bool_]  # (N, e) whether it fires at this tick
    own: npt.NDArray[np.bool_]  # (N, e) whether it is of the row's own sensor; in the order in which this told them
    time: Array  # (N, e) [s] from the tick on, when it fires
    body: npt.NDArray[np.int64]  # (N, e) which body carries it, of those that `View.bodies` tells


class BodyStates(NamedTuple):
    """All bodies of each row's replica, robots, obstacles and parts of robots, the row's own among them; B of them."""

    poses: Array  # (N, B, 3) true, in the world
    twists: Array  # (N, B, 3) [m/s, m/s, rad/s] over the last step, in each body's frame
    reach: Array  # (B,) [m] from a body's base point to the farthest point of its footprint
    own: npt.NDArray[np.int64]  # (N,) which of them is the row's own
    is_robot: npt.NDArray[np.bool_]  # (B,) a robot or a part of one; the others are obstacles
    owner: npt.NDArray[np.int64]  # (B,) the robot's body that a part belongs to; of all others, the body itself


class Lights(NamedTuple):
    """The lamps of the world, the same in all replicas; M of them."""

    places: Array  # (M, 2) [m] in the world
    intensity: Array  # (M,) [cd]


class FloorPoints(NamedTuple):
    """What the floor is like at k places of each row."""

    reflectance: Array  # (N, k) the part of the light that it returns, 0 to 1; 0 in a drop
    depth: Array  # (N, k) [m] how much deeper it lies than the floor that robots roll on; 0 but in a drop


class Sightings(NamedTuple):
    """Marks in sight of each row, the nearest first, in a fixed number of slots m; and slots that are empty."""

    range: Array  # (N, m) [m] to the mark's place, inf where the slot is empty
    bearing: Array  # (N, m) [rad] from the heading of the one who looks, in [-pi, pi]; inf
    id: npt.NDArray[np.int64]  # (N, m) what is written on it, 1 and up; -1


class View(Protocol):
    """All that a sensor or a motion may ask of the world, for its N rows: the truth, read-only."""

    rows: int
    dt: float
    tick: npt.NDArray[np.int64]  # (N, 1)
    body_pose: Array  # (N, 3) true pose of the robot's base
    twist: Array  # (N, 3) [m/s, m/s, rad/s] mean true velocity over the last step, in the body's frame
    joints: Array  # (N, j) true positions of the drive's joints
    joint_rates: Array  # (N, j)
    free: (
        Array  # (N, 1) of a motion: what part of the last displacement was free; 1 at first, and where none was wanted
    )

    mount: Array  # (N, 3) true pose of the sensor's mount on the body

    @property
    def names(self) -> Sequence[str]:
        """What the rows' robots or obstacles are called, for messages."""

    @property
    def pose(self) -> Array:
        """True pose `(N, 3)` of the sensor's mount in the world; of the body, for a motion."""

    def cast(
        self, origins: Array, bearings: Array, range_max: Array, traversal: str = "exact", bodies: bool = True
    ) -> Array:
        """Distances [m] `(N * m, k)` to the nearest wall or other body along beams from `origins`, inf for none.

        A robot sees neither itself nor its own parts. `origins` `(N * m, 3)` are world poses, m for each row in turn;
        `bearings` `(1, k)` or `(N * m, k)` are relative to them; `range_max` `(N, 1)`, or `(N * m, 1)`, of each
        origin. With `traversal` ``"bresenham"`` walls are looked for along the cells of Bresenham's line, as the
        original AMORsim does, and distances are between the centres of cells. Without `bodies`, walls alone count.
        """

    def cone(self, origins: Array, half_angle: Array, range_max: Array, traversal: str = "exact") -> Array:
        """The nearest return [m] `(N, m)` within a cone about each of `origins` `(N * m, 3)`, inf for none.

        The least over rays at both edges of the cone and at most 0.05 degrees apart; `half_angle` [rad] `(N, 1)`.
        """

    def bodies(self) -> BodyStates:
        """Where all bodies of each row's replica are, and how they move."""

    def landmarks(self, slots: int, range_max: Array, half_angle: Array) -> Sightings:
        """The nearest marks in sight of the sensor's mount: landmarks, and other bodies that carry a fiducial.

        Within `range_max` [m] and `half_angle` [rad] to either side of the mount's heading, both `(N, 1)`. One is in
        sight if the line to it meets nothing before: no wall, no body but the row's own, its parts and what carries it.
        """

    @property
    def shape(self) -> Shape:
        """The footprint of the rows' bodies."""

    @property
    def colours(self) -> tuple[str | None, ...]:
        """Of all things, the bodies of a replica in order, and after them the landmarks: the colour, or none."""

    @property
    def heights(self) -> Array:
        """How high each of them is `(B + L,)` [m]."""

    def look(
        self, origins: Array, bearings: Array, range_max: Array, landmarks: bool = True
    ) -> tuple[Array, npt.NDArray[np.int64]]:
        """What beams meet first: the distances [m] `(N * m, k)` as of `cast`, and which thing, -1 for a wall or none.

        Things are the bodies of the replica, in order, and after them those landmarks that have a colour and a size;
        without `landmarks`, bodies alone, and the distances are those of `cast`.
        """

    def normals(self, origins: Array, bearings: Array, bodies: npt.NDArray[np.int64]) -> Array:
        """Directions [rad] `(N * m, k)` in the world of the outward normals where beams enter bodies; nan elsewhere.

        `bodies` `(N * m, k)` is what `look` gave for these beams without landmarks.
        """

    def touches(self, zones: Sequence[Shape], which: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        """Whether zones of the rows' bodies, in the bodies' frames, overlap a wall or another body `(N, s)`.

        `which` `(N, s)` says which of `zones` each is.
        """

    def floor(self, places: Array) -> FloorPoints:
        """What the floor is like at places `(N, k, 2)` [m] in the world: its markings and its drops."""

    def lights(self) -> Lights:
        """All lamps, whether they are in sight or not: `cast` tells."""

    def emissions(self, medium: str) -> Emissions:
        """Who fires at this tick, of all sensors whose `medium` it is; for sensors, not for motions."""


# -------------------------------------------------------------------------------------------- kinds of component


class Component:
    """What all kinds share."""

    def start(self, context: Context) -> State:
        """The state at the start of an episode: arrays whose first axis is the row. None is kept unless asked for."""
        return {}


@attrs.frozen(kw_only=True)
class Joint:
    """A joint of a drive: a wheel or a steering axis. `rolls` where it turns along the ground."""

    name: str
    rolls: bool = True


class Part(NamedTuple):
    """A rigid body that a drive moves beside the robot's own: a trailer, a boom. Its shape is in its own frame."""

    name: str
    shape: Shape


class Drive(Component, abc.ABC):
    """How joints follow commands, and how a body moves as its joints go from one position to another.

    The engine moves the true body with the true parameters and the wheels' travel over the ground; an estimator calls
    `displacement` with the nominal ones and what the encoders said.
    """

    # Both may be properties, where static fields decide what is there.
    joints: ClassVar[tuple[Joint, ...]]
    channels: ClassVar[tuple[str, ...]]  # of a command, in order; joint rates [rad/s] or positions [rad]
    # What there is of the robot beside its own footprint; a property, too, where static fields decide.
    parts: ClassVar[tuple[Part, ...]] = ()

    @abc.abstractmethod
    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """Joints `(N, j)` [rad] and their rates [rad/s] a step later, under limits, as `command` `(N, c)` asks."""

    @abc.abstractmethod
    def twist(self, before: Array, after: Array) -> Array:
        """The body's motion (forward [m], left [m], turn [rad]) `(N, 3)` over a step in which joints go so.

        For a drive whose path is not that of a constant twist: the mean one, and `displacement` overridden.
        """

    @abc.abstractmethod
    def command_for(self, twist: Array, joints: Array) -> Array:
        """The command `(N, c)` that makes the body move with `twist` `(N, 3)` [m/s, m/s, rad/s], or nearest to it."""

    @abc.abstractmethod
    def rolling_radius(self) -> Array:
        """Metres of travel over the ground per radian, of each joint that rolls, `(N, r)`."""

    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        """The body's displacement `(N, 3)`, in its frame before, in closed form, at a fraction `(N, 1)` of the step."""
        return exponential(self.twist(before, after), fraction)

    def between(self, before: Array, after: Array, fraction: Array) -> Array:
        """The joints `(N, j)` after a stop at `fraction`; moving to them makes `displacement` to that fraction."""
        return before + (after - before) * fraction

    def travel(self, before: Array, after: Array) -> Array:
        """Bounds on the path `(N, 2)`: a part f of the step covers at most f times this length [m] and turning [rad].

        A drive that moves unevenly within a step must bound its fastest part. Contact is found by these.
        """
        twist = self.twist(before, after)
        return np.stack((np.sqrt(twist[:, 0] ** 2 + twist[:, 1] ** 2), np.abs(twist[:, 2])), axis=1)

    def contacts(self, joints: Array) -> Array:
        """Where each joint that rolls touches the ground `(N, r, 2)` [m], in the body's frame.

        There it feels zones of the floor. By default all touch it at the base point.
        """
        return np.zeros((len(joints), sum(joint.rolls for joint in self.joints), 2))

    def follow(self, joints: Array, displacement: Array) -> Array:
        """The joints `(N, j)` once passive ones have followed what the body really did, after contact."""
        return joints

    def part_poses(self, joints: Array) -> Array:
        """Where the `parts` are `(N, p, 3)`, in the body's frame, while the joints are so."""
        return np.zeros((len(joints), 0, 3))

    def part_travel(self, before: Array, after: Array) -> Array:
        """Bounds on the parts' paths in the world `(N, p, 2)` [m, rad], as `travel` gives the body's.

        At a fraction f the joints are ``follow(between(before, after, f), displacement(before, after, f))``, and the
        parts where `part_poses` has them then. Told too low, parts pass through walls; too high only costs time.
        """
        return np.zeros((len(before), 0, 2))

    def heading_offset(self, joints: Array) -> Array | None:
        """Which way is ahead `(N, 1)` [rad], in the body's frame, for whoever drives it; None: the way it looks.

        Told by a drive whose wheels steer apart from the body; the turn of a twist is then that of the course.
        """
        return None

    def curvature_max(self) -> Array | None:
        """The sharpest curve that it can drive `(N, 1)` [1/m]; None for a drive that turns in place."""
        return None

    def top_speeds(self) -> Array | None:
        """Fastest speed [m/s] and turn [rad/s], and how fast each may change [m/s^2, rad/s^2], `(N, 4)`.

        inf for no limit; None where a drive does not say.
        """
        return None


class Sensor(Component, abc.ABC):
    """What an ideal device would read. Mounting, rate, latency and noise belong to every sensor, outside its class."""

    unit: ClassVar[str]  # of the values: "m", "rad", "rad/s", "count" ...
    medium: ClassVar[str] = ""  # what it fires into, where others may hear it: "ultrasound" ...; or a static field
    channels: ClassVar[tuple[str, ...]] = ()  # of its own commands, where it takes any: ("pan", "tilt")

    @abc.abstractmethod
    def size(self, drive: Drive) -> int:
        """How many values a reading has, on a robot with this drive. Fixed by static parameters alone."""

    @abc.abstractmethod
    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """The ideal reading `(N, k)`, and by name what the chain may need of it (incidence ...), each `(N, k)`."""

    def columns(self) -> Mapping[str, str]:
        """Names and units of what the values are in turn, where they are not all of one quantity in `unit`.

        With c columns, value i is in column i modulo c: a reading is a table of lines one after another, ``{"range":
        "m", "bearing": "rad"}`` a range, a bearing, a range ... The same for all of a class with the same static
        parameters. An element of the chain says which `column` it is for.
        """
        return {}

    def bearings(self) -> Array | None:
        """Where each value looks [rad], `(1, k)` or `(N, k)` from the mount's heading; for range sensors."""
        return None

    def actuate(self, command: Array, dt: float, state: State, draws: Draws) -> None:
        """Follow the command `(N, c)` of its own `channels` for a step; where that leads is kept in `state`."""

    def emit(self, view: View, state: State) -> Emission | None:
        """What it fires into its `medium`; asked of all sensors that have one before any senses."""
        return None


class Noise(Component):
    """One element of a chain, which a device's values go through in order; at least one method is overridden.

    One that is `for_ground` belongs between wheels and ground, in `Robot.ground` or in a zone: its values are travels,
    and sensors refuse it.
    """

    for_ground: ClassVar[bool] = False

    def aim(self, aim: Aim, elapsed: Array, state: State, draws: Draws) -> Aim:
        """Where the device really looks, before it senses."""
        return aim

    def steps(self) -> Sequence[NoiseStep]:
        """What the element does, as steps that a kernel takes; none where `corrupt` is written in Python.

        A chain takes the steps of neighbouring elements in one call, so an element that is all steps costs next to
        nothing. Leave `corrupt` as it is: it takes the same steps.
        """
        return ()

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """What becomes of the values `(N, k)`; `elapsed` `(N, 1)` [s] since the sample before (0 at the first)."""
        program = NoiseProgram([values.shape[1]], [[(step, draws) for step in self.steps()]])
        return program.apply(np.ravel(values)).reshape(values.shape)

    def slide(self, motion: Array, elapsed: Array, state: State, draws: Draws) -> Array:
        """How far the body slides in a step `(N, 3)` [m, m, rad], in addition to the `motion` that its wheels make.

        Both are (forward, left, turn) in the body's frame, `(N, 3)`; the slide is spread evenly over the step. For
        the `ground` of a robot or a zone, where it is called after `corrupt`. Encoders do not see it.
        """
        return np.zeros_like(motion)

    def delay(self, elapsed: Array, state: State, draws: Draws) -> Array:
        """How much later than its sensor's latency a reading arrives `(N, 1)` [s]; earlier where negative.

        Those of a chain add up. The engine lets none arrive before it was taken, nor overtake one taken earlier.
        """
        return np.zeros_like(elapsed)

    def longest_delay(self) -> Array:
        """What `delay` never exceeds `(N, 1)` [s]; to be given wherever `delay` is, and fixed while a run lasts."""
        return np.zeros((1, 1))


class Estimator(Component, abc.ABC):
    """What the robot makes of its readings. It has the nominal robot and what it was told, never the world."""

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
        """The estimate after this step's readings; `elapsed` `(N, 1)` [s] since the one before (0 at the start)."""


class Controller(Component, abc.ABC):
    """What the robot does: readings and estimate in, a command out. A plain function of one robot serves too."""

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
        """The command `(N, c)`: ``robot.channels`` in order, or the drive's alone, which leaves devices at 0."""

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The places in the world that it is told to drive to: the field that tells each ("waypoints.2"), x, y [m].

        Asked of the controller as it was made; ``amorsim check`` remarks on those where nobody gets.
        """
        return ()


class Motion(Component, abc.ABC):
    """How an obstacle wants to move; the engine says what part of it was free (``view.free``)."""

    @abc.abstractmethod
    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """The wanted displacement `(N, 3)` of this step, in the obstacle's own frame."""

    def default_start(self) -> tuple[float, float, float] | None:
        """Where an obstacle starts that is told no pose (x [m], y [m], heading [rad]), or none: at the origin.

        Asked of the motion as it was made, before there are rows.
        """
        return None

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The places in the world that it is told to move to, as of `Controller.goal_points`."""
        return ()


class MapLoader(abc.ABC):
    """Reads maps of one format; its fields are the options of `amorsim.load_map`."""

    extensions: ClassVar[tuple[str, ...]]  # with the dot, lower case

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file that begins with `head` is of this format; asked where the extension does not tell."""
        return False

    @abc.abstractmethod
    def load(self, path: Path) -> Map:
        """The map in a file; `MapError` names what is wrong with it, and the line where there is one."""

    def companions(self, path: Path) -> Sequence[Path]:
        """The other files that `load` reads for this one, such as the picture that it names.

        A run's folder gets copies of all of them, in the same places relative to each other, so a file has to name
        its companions relative to itself. `MapError` where the file cannot be read.
        """
        return ()

    @classmethod
    def save(cls, world: Map, path: Path) -> MapLoader:
        """Write a map into a file of this format, where that can be done; returns the loader that reads it again.

        Companions are written next to it, and named relative to it: all of them move to where they belong when they
        are whole. `amorsim.save_map` reads the file again and sees whether the cells are the same.
        """
        raise MapError(f"maps cannot be written as {' or '.join(cls.extensions)}")


class Frame(NamedTuple):
    """One step of one group of robots, as recorders get it: truth included. Arrays are not to be changed."""

    names: Sequence[str]  # of each row
    replica: npt.NDArray[np.int64]  # (N,)
    tick: npt.NDArray[np.int64]  # (N,)
    time: Array  # (N,) [s]
    true_pose: Array  # (N, 3)
    true_twist: Array  # (N, 3) mean over the step, in the body's frame
    joint_names: Sequence[str]
    joint_rates: Array  # (N, j) true, mean over the step
    estimates: Mapping[str, Estimate]  # the controller's is the first
    readings: Mapping[str, tuple[Array, Measurement]]  # true values, and the robot's reading
    channels: Sequence[str]
    command: Array  # (N, c)
    robot: RobotModel  # the nominal one
    parts: Sequence[str] = ()  # the names of each robot's
    part_pose: Array = np.empty((0, 0, 3))  # (N, p, 3) true, where there are any


class ObstacleFrame(NamedTuple):
    """One step of one group of obstacles, as recorders get it. Arrays are not to be changed."""

    names: Sequence[str]  # of each row
    replica: npt.NDArray[np.int64]  # (N,)
    tick: npt.NDArray[np.int64]  # (N,)
    time: Array  # (N,) [s]
    true_pose: Array  # (N, 3)
    true_twist: Array  # (N, 3) mean over the step, in the body's frame
    moves: bool  # whether they have a motion


class RunInfo(NamedTuple):
    """What a recorder is told of a run before its first step."""

    folder: Path  # exists, and is the run's own
    dt: float  # [s]
    replicas: Sequence[int]
    with_sensors: bool  # whether sensors are to be written


class Recorder(abc.ABC):
    """Writes a run down while it goes: an ``attrs.define(kw_only=True)`` class, for it has files to keep open."""

    def fresh(self) -> Recorder:
        """Another with the same parameters, which no run has opened yet: each run has one of its own."""
        again: Recorder = attrs.evolve(cast(Any, self))
        return again

    @abc.abstractmethod
    def open(self, run: RunInfo, frames: Sequence[Frame]) -> None:
        """Begin; `frames` are those of tick 0, with the first readings, and are to be written too."""

    @abc.abstractmethod
    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        """Take a step: a frame for each group, and the events (`amorsim.simulation.events.Event`) since the last."""

    def write_obstacles(self, frames: Sequence[ObstacleFrame]) -> None:
        """Take where the obstacles are, a frame for each group; called after `open` and after each `write`."""
        return

    @abc.abstractmethod
    def close(self) -> None:
        """End; also called when a run is broken off, or when it could not begin and `open` was never called."""
