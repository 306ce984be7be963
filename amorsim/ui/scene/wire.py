"""Scenes as tables of plain values: a world and the bodies in it."""

from __future__ import annotations

from typing import NotRequired, TypedDict

__all__ = [
    "Channel",
    "Drawing",
    "Floor",
    "FloorPatch",
    "Image",
    "Kind",
    "Knowledge",
    "MapShape",
    "ObstacleShape",
    "Outline",
    "OutlineShape",
    "Recorded",
    "RobotEntry",
    "Scene",
    "SensorShape",
    "Still",
]


class Image(TypedDict):
    """A picture of a map; `name` is for the command ``image``. Occupied cells are black, free ones clear."""

    name: str
    extent: list[float]  # x0, y0, x1, y1 [m] in the map's frame


class MapShape(TypedDict):
    """A map to draw: lines, or a picture if it has none.

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
    """How readings are drawn; `style` is always there, and of the other keys those that the style needs.

    - ``beams``, ``cones``: values are ranges [m] along `bearings`.
    - ``things``: a table of what is seen at a ``range`` and a ``bearing``, with its ``id`` or its ``colour``, which is
      a place in `colours` and `names`.
    - ``glow``: a sector before each element, as strong as its value is between the two of `span`.
    - ``sticks``: a line before each element, as long as its value is between the two of `span`; where that has one
      alone, the largest of a reading is as long as can be.
    - ``contacts``: `lines` of the footprint for each value, which are drawn where it is not 0.
    - ``fix``: a place in the world ``x``, ``y``, with its ``heading`` if that is given.
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
    heading, one for each value, or none where a value is not a range.
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
    """The properties that robots of one kind share."""

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
    """The world as a robot knows it."""

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
    """Things in the world other than walls and bodies; robots may know of them or not."""

    landmarks: list[list[float]]  # x, y, radius [m]
    lights: list[list[float]]  # x, y [m]
    zones: list[list[list[float]]]  # the outline of each, x, y [m]
    patches: list[FloorPatch]  # markings and drops, the lowest first


class Recorded(TypedDict):
    """The page's description of a recorded run."""

    replica: int
    replicas: list[int]
    log: str  # the name of the log that it was made of, without anything true; empty for a simulation
    facts: list[list[str]]  # names and values
    lacks: list[str]  # sentences


class Scene(TypedDict):
    """Everything that does not change while a simulation runs. `map` and knowledge are places in `maps`.

    `map` is None if the world's map cannot be read, which happens only in a `Still`. `recorded` is there if a recorded
    run is shown.
    """

    version: int
    scenario: str
    dt: float
    duration: float
    seed: int
    maps: list[MapShape]
    map: int | None
    kinds: list[Kind]
    robots: list[RobotEntry]
    obstacles: list[ObstacleShape]
    floor: Floor
    recorded: NotRequired[Recorded]


class OutlineShape(TypedDict):
    """A robot or an obstacle of which only the outline and the pose could be read."""

    name: str
    footprint: Outline
    pose: list[float]  # x, y [m], heading [rad]


class Still(TypedDict):
    """A scenario at rest: what can be drawn of it without a simulation.

    `robots` and `obstacles` are the poses, x, y [m], heading [rad], of those in the scene; None where a body has none
    yet, since its start is drawn, or the map that it depends on is missing.
    """

    scene: Scene
    robots: list[list[float] | None]
    obstacles: list[list[float] | None]
    outlines: list[OutlineShape]
    extent: list[float]  # x0, y0, x1, y1 [m] of all of it
