"""The messages between the child process, the session and the window: scenes, frames, commands and answers.

A **scene** (JSON, see `amorsim.ui.scene.wire`) is sent when a scenario is loaded: all that stays as it is while the
simulation runs. A **frame** (binary, see `amorsim.ui.simulator.frames.packing`) is one moment. **Commands** are small
tables ``{"do": NAME, ...}``; their further keys are in `amorsim.ui.simulator.frames.messages`. Each is answered by a
table with ``ok``, and where that is false with ``error``, a text for the user. Besides, answers have

| command | answer |
|---|---|
| ``state`` | `State` |
| ``scene`` | ``scene``: a `Scene` |
| ``parameters`` | ``parameters``: list of `ParameterForm`, ``chains``: list of `ChainForm`, ``targets``: list of \
`TargetForm`, ``sensors``: list of `SensorShape`, true, ``components``: kind and name of what a part is, by its path |
| ``manual`` | ``manual``: `Manual` |
| ``noises`` | ``choices``: list of `Choice` |
| ``add`` | ``path`` of the element |
| ``history`` | `History` |
| ``events`` | ``epoch``, ``events``: list of `EventLine`, ``next`` |
| ``image`` | ``png``: base64 |
| ``mapped`` | ``mapped``: list of `Mapped`, ``epoch``, ``tick`` |
| ``intended`` | ``intended``: `Intended`, ``epoch``, ``tick`` |
| ``scrub`` | ``tick``, ``exact``, ``can_continue``, ``reason`` |
| ``step`` | ``tick``, ``steps`` |
| ``continue`` | ``tick`` |
| ``replica`` | ``scene``: a `Scene`, of the replica |
| ``go_back`` | ``tick`` of the end of the course of events that is taken up again |
| ``futures`` | ``epoch``, ``number`` of the course played, ``can_go_back`` to others, ``others``: list of `Future` |
| ``drive`` | ``channels`` |
| ``set`` | ``value`` |
| ``places`` | ``project``, the folder's path; names in it that are free: ``run``, ``scenario`` |
| ``save_scenario`` | ``file`` |
| ``page`` | ``page``: HTML |
| ``save_run`` | ``folder``, ``same`` |
| ``restart`` | ``again`` |
| ``reload`` | ``path`` of the page to go to: of the new simulation, or of the faults of the file |
| ``controls`` | ``holder``, ``asking`` |
"""

from __future__ import annotations

from typing import Any, NotRequired, TypedDict

from amorsim.ui.forms.chains import ChainForm, ElementForm, TargetForm
from amorsim.ui.forms.description import FieldForm, Widget

__all__ = [
    "ChainForm",
    "ChangedParameter",
    "ElementForm",
    "EventLine",
    "FieldForm",
    "Future",
    "History",
    "Intended",
    "IntendedArc",
    "IntendedVelocities",
    "Mapped",
    "MappedCells",
    "ParameterForm",
    "Past",
    "State",
    "TargetForm",
    "Widget",
]


class ParameterForm(TypedDict):
    """A parameter of a part of a robot, as a form shows it while the simulation runs.

    `kind` is ``"systematic"`` (what is true differs from what the robot's software holds; `nominal` is what that
    holds, `true` what really is), ``"noise"`` (an element of a chain), ``"nominal"`` (the robot's software and, by its
    error, the truth), ``"controller"`` or ``"estimator"``. `low` and `high` bound what is allowed, `slider` what a
    slider is good for; it is empty where there is none. A value that is drawn is none, with `drawn` in words and
    `drawn_value` what was drawn. `fixed` is the reason why the value cannot change now.
    """

    path: str
    group: str  # "drive", "sensors.laser", "ground", "controller", "controller.planner" ...
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
    scenario: Any  # its value in the scenario
    is_changed: bool  # whether the scenario has another value
    is_added: bool  # whether it is of an element of noise that the scenario does not have
    fixed: str
    drawn: str
    drawn_value: float | None
    nominal: float | None
    true: float | None
    deviation: list[FieldForm]  # of a systematic error: its parts, each fixed or drawn
    kind: str
    origin: str  # of the scenario's value: "file", "model", "device", "default", "command line", or "" if not known
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
    is_told: NotRequired[bool]  # the same contact as the line before, of the other body


class MappedCells(TypedDict):
    """A picture of a map that an estimator has drawn: the more probable a wall, the more opaque."""

    extent: list[float]  # xmin, ymin, xmax, ymax [m] of what was seen, in the world
    png: str  # base64


class Mapped(TypedDict):
    """The map of an estimator, in the world [m]; parts that it has no belief of are missing.

    `scan` are the points of the last scan that was matched, `poses` the nodes of a pose graph, and `edges` pairs of
    their places.
    """

    estimator: str
    map: MappedCells | None
    scan: list[list[float]] | None
    poses: list[list[float]] | None
    edges: list[list[int]] | None


class IntendedArc(TypedDict):
    """A way that a controller compared: points in the world [m], from the robot on."""

    points: list[list[float]]
    worth: float  # from 0, the worst, to 1, the best; -1: refused, as the robot could not stop before what it sees
    taken: bool


class IntendedVelocities(TypedDict):
    """The bodies that a controller knows of, and the velocities that lead into them, in the robot's frame.

    `others` are x, y [m], vx, vy [m/s] and radius [m] of each. `borders` are of half-planes of velocities: a point and
    a direction, what is permitted to its left. `cones` are of velocities that lead into another: apex, and the
    directions of the right and the left side. `speed` [m/s] is the robot's top speed, `twist` its v [m/s] and
    w [rad/s] by its own account.
    """

    speed: float
    twist: list[float]
    others: list[list[float]]
    borders: list[list[float]]
    cones: list[list[float]]


class Intended(TypedDict):
    """The intentions of a controller in the last step; null where it has no such belief.

    `path` and `searched` are places in the world [m]. `blocked` are sectors around the robot, the first from behind
    anticlockwise, `bearing` the direction taken [rad] from its heading, if there is one. `ways` are directions [rad]
    from its heading, and how far the way is free in each [m].
    """

    pose: list[float]  # where the robot believes to be, with the heading in which its drive goes ahead
    path: list[list[float]] | None
    searched: list[list[float]] | None
    arcs: list[IntendedArc] | None
    blocked: list[bool] | None
    bearing: list[float] | None
    ways: list[list[float]] | None
    velocities: IntendedVelocities | None


class State(TypedDict):
    """The state of the simulation."""

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
    damage: NotRequired[str]  # what is wrong with the files of a recorded run
    holder: NotRequired[str]  # the window that has the controls
    changed: NotRequired[bool]  # whether the scenario's file, or one that it names, is another one by now
    moved: NotRequired[str]  # the page of the simulation that took this one's place


class Past(TypedDict):
    """The further values of a robot in plots: since it was first looked at, or since the start where robots are few.

    `values` is a line of float64, little endian and in base64, for each tick: true and estimated pose (3 each),
    covariance (6), true and estimated twist (3 each), true and measured joint rates, true and measured values of all
    sensors, of which only the first are sent (as many as a line of its table has columns, or 8), and the least true
    and measured value of each sensor that has any.
    """

    ticks: list[int]
    values: str


class History(TypedDict):
    """A robot's true and estimated path, and what else is known of its past."""

    ok: bool
    epoch: int
    ticks: list[int]
    true: list[list[float | None]]  # x, y, heading; None where it is not known, as in a log
    estimated: list[list[float]]
    past: Past


class ChangedParameter(TypedDict):
    """A parameter of a robot that was set while the simulation ran, and the value set last."""

    path: str
    value: Any


class Future(TypedDict):
    """A course of events that was left by going on from its past: a robot's path in it, as in `History`."""

    number: int  # of all courses, from 1
    since: int  # the last tick that it shares with the one that is played
    newest: int  # its last tick
    changes: list[ChangedParameter]  # of the robot, after the courses parted
    ticks: list[int]
    true: list[list[float]]
    estimated: list[list[float]]
    past: Past
