"""What the child process, the session and the window say to each other: scenes, frames, commands and answers.

A **scene** (JSON) is sent when a scenario is loaded: all that stays as it is while the simulation runs. A **frame**
(binary, see `amorsim.ui.simulator.packing`) is one moment. **Commands** are small tables ``{"do": NAME, ...}``; their
further keys are in `amorsim.ui.simulator.messages`. Each is answered by a table with ``ok``, and where that is false
with ``error``, a text for the user. Besides, answers have

| command | answer |
|---|---|
| ``state`` | `State` |
| ``scene`` | ``scene``: a `Scene` |
| ``parameters`` | ``parameters``: list of `ParameterForm`, ``chains``: list of `ChainForm`, ``targets``: list of \
`TargetForm`, ``sensors``: list of `SensorShape`, true |
| ``noises`` | ``choices``: list of `Choice` |
| ``add`` | ``path`` of the element |
| ``history`` | `History` |
| ``events`` | ``epoch``, ``events``: list of `EventLine`, ``next`` |
| ``image`` | ``png``: base64 |
| ``scrub`` | ``tick``, ``exact``, ``can_continue``, ``reason`` |
| ``step`` | ``tick``, ``steps`` |
| ``continue`` | ``tick`` |
| ``go_back`` | ``tick`` of the end of what the last ``continue`` left |
| ``drive`` | ``channels`` |
| ``set`` | ``value`` |
| ``places`` | ``project``, the folder's path; names in it that are free: ``run``, ``scenario`` |
| ``save_scenario`` | ``file`` |
| ``save_run`` | ``folder``, ``same`` |
| ``restart`` | ``again`` |
| ``controls`` | ``holder``, ``asking`` |
"""

from __future__ import annotations

from typing import Any, NotRequired, TypedDict

from amorsim.ui.forms.chains import ChainForm, ElementForm, TargetForm
from amorsim.ui.forms.description import Choice, FieldForm, Widget

__all__ = [
    "ChainForm",
    "Channel",
    "Choice",
    "Drawing",
    "ElementForm",
    "EventLine",
    "FieldForm",
    "Floor",
    "FloorPatch",
    "History",
    "Image",
    "Kind",
    "Knowledge",
    "MapShape",
    "ObstacleShape",
    "Outline",
    "ParameterForm",
    "Past",
    "RobotEntry",
    "Scene",
    "SensorShape",
    "State",
    "TargetForm",
    "Widget",
]

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
    colour: NotRequired[str]  # "#rrggbb"; one robot alone has none but its own


class ObstacleShape(TypedDict):
    """An obstacle, or after all of those a part of a robot."""

    name: str
    footprint: Outline
    moves: bool
    part_of: NotRequired[str]  # the robot whose part it is
    colour: NotRequired[str]  # "#rrggbb", where it has one of its own


class FloorPatch(TypedDict):
    """A line or an area on the floor, as `amorsim.core.patches.Patch`."""

    points: list[list[float]]  # x, y [m]
    width: float  # [m] of a line, 0 for an area
    colour: str  # "#rrggbb"


class Floor(TypedDict):
    """What there is in the world besides walls and bodies; robots may know of it or not."""

    landmarks: list[list[float]]  # x, y, radius [m]
    lights: list[list[float]]  # x, y [m]
    zones: list[list[list[float]]]  # the outline of each, x, y [m]
    patches: list[FloorPatch]  # markings and drops, the lowest first


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
    """A parameter of a part of a robot, as a form shows it while the simulation runs.

    `kind` is ``"systematic"`` (what is true differs from what the robot's software holds; `nominal` is what that
    holds, `true` what really is), ``"noise"`` (an element of a chain), ``"nominal"`` (the robot's software and, by its
    error, the truth), ``"controller"`` or ``"estimator"``. `low` and `high` bound what is allowed, `slider` what a
    slider is good for; it is empty where there is none. A value that is drawn is none, with `drawn` in words and
    `drawn_value` what was drawn. `fixed` says why the value cannot change now.
    """

    path: str
    group: str  # "drive", "sensors.laser", "ground", "controller" ...
    part: str  # the path of what it is a field of: "sensors.laser.noise.gaussian"
    label: str
    unit: str  # of `value`; "rad" and "rad/s" are best shown in degrees, "×" is a factor
    help: str
    type: str  # "float" or "int"
    widget: Widget
    low: float | None
    high: float | None
    is_open: list[bool]  # whether low and high themselves are left out
    slider: list[float]
    value: Any  # a number, or what else the widget shows
    scenario: Any  # what the scenario says
    is_changed: bool  # whether the scenario says something else
    is_added: bool  # whether it is of an element of noise that the scenario does not have
    fixed: str
    drawn: str
    drawn_value: float | None
    nominal: float | None
    true: float | None
    deviation: list[FieldForm]  # of a systematic error: its parts, each fixed or drawn
    kind: str
    origin: str  # of what the scenario says: "file", "model", "device", "default", "command line", or "" if not known
    source: str  # the same in words, with file and line


class EventLine(TypedDict):
    """Something that happened; `number` counts from 1 within an epoch."""

    number: int
    tick: int
    time: float
    kind: str  # as of `amorsim.Event`, and "started", "fault", "hang", "restarted", "saved", "continued", "note"
    robot: str
    text: str
    point: list[float] | None
    stack: NotRequired[str]  # of a fault in a user's controller


class State(TypedDict):
    """How the simulation stands."""

    ok: bool
    version: int
    epoch: int
    status: str  # "compiling", "paused", "running", "scrubbed", "fault", "hang", "restarting", "ended", "gone"
    tick: int
    newest: int
    time: float
    speed: float | None  # none: as fast as possible
    achieved: float
    selected: NotRequired[int]  # the robot that the window looks at
    by_hand: list[str]
    can_continue: bool
    reason: str  # why not
    fault: EventLine | None
    holder: NotRequired[str]  # the window that has the controls


class Past(TypedDict):
    """What else plots tell of a robot: since it was first looked at, or since the start where robots are few.

    `values` is a line of float64, little endian and in base64, for each tick: true and estimated pose (3 each),
    covariance (6), true and estimated twist (3 each), true and measured joint rates, true and measured values of all
    sensors of which only the first are told (as many as a line of its table has columns, or 8), and the least true
    and measured value of each sensor that has any.
    """

    ticks: list[int]
    values: str


class History(TypedDict):
    """Where a robot was and believed to be, and what else is known of its past, each of at most so many moments."""

    ok: bool
    epoch: int
    ticks: list[int]
    true: list[list[float]]  # x, y, heading
    estimated: list[list[float]]
    past: Past
