"""What the child process, the session and the window say to each other: scenes, frames, commands and answers.

A **scene** (JSON) is sent when a scenario is loaded: all that stays as it is while the simulation runs. A **frame**
(binary, see `pack_frame`) is one moment. **Commands** are small tables ``{"do": NAME, ...}``; each is answered by a
table with ``ok``, and where that is false with ``error``, a text for the user.

| command | further keys | answer | needs the controls |
|---|---|---|---|
| ``state`` | | `State` | |
| ``scene`` | | ``scene``: a `Scene` | |
| ``select`` | ``robot`` | | |
| ``parameters`` | ``robot`` | ``parameters``: list of `ParameterForm`, ``sensors``: list of `SensorShape`, true | |
| ``history`` | ``robot``, ``max_points`` | `History` | |
| ``events`` | ``after`` (0: all) | ``epoch``, ``events``: list of `EventLine`, ``next`` | |
| ``image`` | ``name`` | ``png``: base64 | |
| ``run``, ``pause`` | | | yes |
| ``step`` | ``steps`` (1) | | yes |
| ``speed`` | ``factor``, or null for as fast as possible | | yes |
| ``reset`` | | | yes |
| ``scrub`` | ``tick``, or null for the end | ``tick``, ``exact``, ``can_continue``, ``reason`` | yes |
| ``continue`` | ``tick`` (where it was scrubbed to) | ``tick`` | yes |
| ``hand_over`` | ``robot``, ``to``: ``"hand"`` or ``"controller"`` | | yes |
| ``drive`` | ``robot``, ``forward`` [m/s], ``left`` [m/s], ``turn`` [rad/s] (0 where not given) | | yes |
| ``command`` | ``robot``, ``channels``: a number each | | yes |
| ``stop`` | ``robot``, or none for all driven by hand | | yes |
| ``set`` | ``robot``, ``path``, ``value`` | ``value`` | yes |
| ``restore`` | ``robot``, ``path`` or none for all | | yes |
| ``save_scenario`` | ``name`` (of a file in the project's folder, ``.toml``) | ``file`` | yes |
| ``save_run`` | ``name`` (of a folder in the project's folder) or none | ``folder``, ``same`` | yes |
| ``restart`` | ``without``: robots that go over to the hand, or none | | yes |
| ``controls`` | ``want``: ``"take"``, ``"ask"``, ``"give"``, with ``to`` a window | ``holder`` | |

Angles are radians, and robots are named by name, or by their place in the scene's list.
"""

from __future__ import annotations

import enum
import struct
from collections.abc import Sequence
from typing import Any, NamedTuple, NotRequired, TypedDict

import numpy as np
import numpy.typing as npt

__all__ = [
    "FRAME_HEADER",
    "MAGIC",
    "Channel",
    "Drawing",
    "Dynamic",
    "EventLine",
    "Floor",
    "FrameFlag",
    "History",
    "Image",
    "Kind",
    "Knowledge",
    "MapShape",
    "ObstacleShape",
    "Outline",
    "ParameterForm",
    "RobotEntry",
    "RobotFlag",
    "Scene",
    "Selected",
    "SensorShape",
    "State",
    "pack_frame",
    "unpack_frame",
    "with_flags",
]

Array = npt.NDArray[np.float64]

# ---------------------------------------------------------------------------------------------------------- scenes


class Image(TypedDict):
    """A picture of a map; `name` is what the command ``image`` takes. Occupied cells are black, free ones clear."""

    name: str
    extent: list[float]  # x0, y0, x1, y1 [m] in the map's frame


class MapShape(TypedDict):
    """A map as it is drawn: lines, or a picture where there are none.

    The map's frame has its origin at `origin` and is turned by its heading; `segments` are in the world already.
    """

    name: str
    origin: list[float]  # x, y [m], heading [rad] of the lower left corner in the world
    size: list[float]  # width, height [m] in the map's frame
    extent: list[float]  # x0, y0, x1, y1 [m] of all of it in the world
    segments: list[list[float]] | None  # x0, y0, x1, y1 [m] in the world
    image: Image | None


class Outline(TypedDict, total=False):
    """A footprint in its body's frame: a circle about the base point, or a polygon."""

    circle: float  # radius [m]
    polygon: list[list[float]]  # x, y [m]


class Channel(TypedDict):
    """A channel of a drive's command, or of a device that takes commands."""

    name: str
    unit: str
    low: float | None
    high: float | None


class Drawing(TypedDict, total=False):
    """How readings are drawn; `style` always says which of these it is, and of the rest it has what it needs.

    - ``beams``, ``cones``: values are ranges [m] along `bearings`.
    - ``things``: a table of what is seen at a ``range`` and a ``bearing``, with its ``id`` or its ``colour``, which is
      a place in `colours` and `names`.
    - ``glow``: a sector before each element, as strong as its value is between the two of `span`.
    - ``sticks``: a line before each element, as long as its value is between the two of `span`; where that has one
      alone, the largest of a reading is as long as can be.
    - ``contacts``: `lines` of the footprint for each value, which are drawn where it is not 0.
    - ``fix``: a place in the world ``x``, ``y``, with its ``heading`` where that is told.
    - ``needle``: a heading in the world.
    """

    style: str
    half_angle: float  # [rad] of a sector, to either side
    reach: float  # [m] of a sector
    span: list[float]  # readings of nothing and of the most
    lines: list[list[list[float]]]  # x0, y0, x1, y1 [m] in the robot's frame
    colours: list[str]  # "#rrggbb"
    names: list[str]


class SensorShape(TypedDict):
    """A sensor as it is drawn, by its nominal parameters; in an answer to ``parameters``, by its true ones.

    `mounts` has one pose (x, y, heading) in the robot's frame, or one for each value; `bearings` are from the mount's
    heading, one for each value, or none where a value is no range.
    """

    name: str
    kind: str  # as registered: "laser", "sonar", "compass" ...
    unit: str
    columns: list[list[str]]  # name and unit of what values are in turn, where they are not all in `unit`
    size: int
    mounts: list[list[float]]
    bearings: list[float] | None
    range_max: float | None
    half_angle: float | None  # [rad] of a cone
    drawing: Drawing | None  # none for what is in numbers alone


class Kind(TypedDict):
    """What robots of one kind have in common."""

    model: str
    drive: str  # as registered
    footprint: Outline
    wheels: list[list[float]]  # x, y [m], heading [rad], radius [m] of each that can be drawn
    channels: list[Channel]
    joints: list[str]
    twist: list[float]  # forward [m/s], left [m/s], turn [rad/s]: the fastest of each that it is good for, nominally
    sensors: list[SensorShape]
    estimators: list[str]


class Knowledge(TypedDict):
    """What a robot was told of the world."""

    map: int | None  # a place in the scene's `maps`
    landmarks: list[list[float]]


class RobotEntry(TypedDict):
    """A robot: `kind` is a place in the scene's `kinds`."""

    name: str
    kind: int
    controller: str  # "" for none; a file's name and the function's where it is a user's
    knowledge: Knowledge


class ObstacleShape(TypedDict):
    """An obstacle."""

    name: str
    footprint: Outline
    moves: bool


class Floor(TypedDict):
    """What there is in the world besides walls and bodies; robots may know of it or not."""

    landmarks: list[list[float]]  # x, y, radius [m]
    lights: list[list[float]]  # x, y [m]
    zones: list[list[list[float]]]  # the outline of each, x, y [m]


class Scene(TypedDict):
    """All that stays as it is while a simulation runs. `map` and knowledge are places in `maps`."""

    version: int
    scenario: str
    dt: float
    duration: float
    seed: int
    maps: list[MapShape]
    map: int
    kinds: list[Kind]
    robots: list[RobotEntry]
    obstacles: list[ObstacleShape]
    floor: Floor


# ---------------------------------------------------------------------------------------------------------- answers


class ParameterForm(TypedDict):
    """A parameter that may be changed while the simulation runs, as a form shows it.

    `kind` is ``"systematic"`` (what is true differs from what the robot's software holds; `nominal` is what that
    holds, `true` what really is), ``"noise"`` (an element of a chain), ``"nominal"`` (the robot's software and, by its
    error, the truth), ``"controller"`` or ``"estimator"``. `low` and `high` bound what is allowed, `slider` what a
    slider is good for. A value that is drawn is none, with `drawn` in words.
    """

    path: str
    group: str  # "drive", "sensors.laser", "ground", "controller" ...
    label: str
    unit: str  # of `value`; "rad" and "rad/s" are best shown in degrees, "×" is a factor
    help: str
    type: str  # "float" or "int"
    low: float | None
    high: float | None
    is_open: list[bool]  # whether low and high themselves are left out
    slider: list[float]
    value: float | None
    scenario: float | None  # what the scenario says
    drawn: str
    nominal: float | None
    true: float | None
    kind: str


class EventLine(TypedDict):
    """Something that happened; `number` counts from 1 within an epoch."""

    number: int
    tick: int
    time: float
    kind: str  # as of `amorsim.Event`, and "started", "fault", "hang", "restarted", "saved", "note"
    robot: str
    text: str
    point: list[float] | None
    stack: NotRequired[str]  # of a fault in a user's controller


class State(TypedDict):
    """How the simulation stands."""

    ok: bool
    version: int
    epoch: int
    status: str  # "loading", "paused", "running", "scrubbed", "fault", "hang", "restarting", "ended", "gone"
    tick: int
    newest: int
    time: float
    speed: float | None  # none: as fast as possible
    achieved: float
    selected: int
    by_hand: list[str]
    can_continue: bool
    reason: str  # why not
    fault: EventLine | None
    holder: NotRequired[str]  # the window that has the controls


class History(TypedDict):
    """Where a robot was and believed to be, thinned to at most so many points."""

    ok: bool
    epoch: int
    ticks: list[int]
    true: list[list[float]]  # x, y, heading
    estimated: list[list[float]]


# ----------------------------------------------------------------------------------------------------------- frames

MAGIC = b"amf1"

# magic, scene version, frame number, epoch; time; speed asked (inf: as fast as possible), achieved; tick, newest tick;
# flags, events; robots R, obstacles O; selected robot, its values V; sensors S, joints J; channels C, oldest tick.
FRAME_HEADER = struct.Struct("<4sIIIdffIIIIIIiIIIII")
_NUMBER_AT, _FLAGS_AT = 8, 40


class FrameFlag(enum.IntFlag):
    """How the simulation stands in a frame."""

    RUNNING = 1
    ENDED = 2  # the scenario's duration is over
    SCRUBBED = 4  # this is the past
    FAULT = 8  # a controller raised an error; it waits
    HANG = 16  # no sign of life
    LOADING = 32  # compiling, replaying
    POSES_ONLY = 64  # of this moment of the past only poses are known; the readings are nan


class RobotFlag(enum.IntFlag):
    """How a robot stands in a frame."""

    TOUCHING = 1
    ENDED = 2  # its controller has ended
    BY_HAND = 4


class Selected(NamedTuple):
    """What a frame tells of the selected robot alone."""

    true: Array  # (V,) the sensors' true values, in the scene's order
    measured: Array  # (V,)
    age: Array  # (S,) [s]
    true_rates: Array  # (J,) [rad/s]
    measured_rates: Array  # (J,) nan where nothing measures them
    true_twist: Array  # (3,)
    estimated_twist: Array  # (3,)
    command: Array  # (C,)


class Dynamic(NamedTuple):
    """A moment: what `pack_frame` makes a frame of."""

    version: int
    number: int
    epoch: int
    time: float
    speed: float
    achieved: float
    tick: int
    newest: int
    oldest: int
    flags: int
    events: int
    selected_robot: int
    true_pose: Array  # (R, 3)
    estimated_pose: Array  # (R, 3)
    covariance: Array  # (R, 6) xx, xy, xh, yy, yh, hh
    obstacle_pose: Array  # (O, 3)
    robot_flags: npt.NDArray[np.uint8]  # (R,)
    selected: Selected


def pack_frame(moment: Dynamic) -> bytes:
    """The bytes of a frame, little endian: `FRAME_HEADER` (80 bytes), then

    - float64, of the selected robot: true values (V), measured values (V), ages (S), true joint rates (J), measured
      ones (J), true twist (3), estimated twist (3), command (C);
    - float32: true poses (R, 3), estimated poses (R, 3), covariances (R, 6), obstacles' poses (O, 3);
    - uint8: a `RobotFlag` for each robot (R).

    A thousand robots are 49 kB.
    """
    selected = moment.selected
    header = FRAME_HEADER.pack(
        MAGIC,
        moment.version,
        moment.number,
        moment.epoch,
        moment.time,
        moment.speed,
        moment.achieved,
        moment.tick,
        moment.newest,
        moment.flags,
        moment.events,
        len(moment.true_pose),
        len(moment.obstacle_pose),
        moment.selected_robot,
        len(selected.true),
        len(selected.age),
        len(selected.true_rates),
        len(selected.command),
        moment.oldest,
    )
    exact = np.concatenate(selected).astype("<f8")
    drawn = (moment.true_pose, moment.estimated_pose, moment.covariance, moment.obstacle_pose)
    poses = np.concatenate([part.reshape(-1) for part in drawn]).astype("<f4")
    return header + exact.tobytes() + poses.tobytes() + moment.robot_flags.astype(np.uint8).tobytes()


def unpack_frame(data: bytes) -> Dynamic:
    """What `pack_frame` packed, as the window's script reads it.

    Raises
    ------
    ValueError
        If these are not the bytes of a frame.
    """
    if len(data) < FRAME_HEADER.size or data[:4] != MAGIC:
        raise ValueError(f"expected a frame, which begins with {MAGIC!r}, got {data[:4]!r}")
    (_, version, number, epoch, time, speed, achieved, tick, newest, flags, events, *rest) = FRAME_HEADER.unpack_from(
        data
    )
    robots, obstacles, selected, values, sensors, joints, channels, oldest = rest
    sizes = (values, values, sensors, joints, joints, 3, 3, channels)
    start = FRAME_HEADER.size
    exact = np.frombuffer(data, "<f8", sum(sizes), start).astype(float)
    start += exact.nbytes
    drawn = (robots * 3, robots * 3, robots * 6, obstacles * 3)
    poses = np.frombuffer(data, "<f4", sum(drawn), start)
    start += poses.nbytes
    if len(data) != start + robots:
        raise ValueError(f"expected a frame of {start + robots} bytes, got {len(data)}")
    true, estimated, covariance, obstacle = _parts(poses.astype(float), drawn)
    return Dynamic(
        version=version,
        number=number,
        epoch=epoch,
        time=time,
        speed=speed,
        achieved=achieved,
        tick=tick,
        newest=newest,
        oldest=oldest,
        flags=flags,
        events=events,
        selected_robot=selected,
        true_pose=true.reshape(-1, 3),
        estimated_pose=estimated.reshape(-1, 3),
        covariance=covariance.reshape(-1, 6),
        obstacle_pose=obstacle.reshape(-1, 3),
        robot_flags=np.frombuffer(data, np.uint8, robots, start).copy(),
        selected=Selected(*_parts(exact, sizes)),
    )


def _parts(whole: Array, sizes: Sequence[int]) -> list[Array]:
    return np.split(whole, np.cumsum(sizes)[:-1])


def with_flags(data: bytes, number: int, flags: int) -> bytes:
    """The same frame under another number and with other flags: for a session whose child no longer answers."""
    changed: Any = bytearray(data)
    struct.pack_into("<I", changed, _NUMBER_AT, number)
    struct.pack_into("<I", changed, _FLAGS_AT, flags)
    return bytes(changed)
