"""A scenario as frozen objects: from a file, or built by a script.

Names are checked here, numbers by the fields themselves; whatever needs the map (is the start free?) is checked when
a simulation is made of it.
"""

from __future__ import annotations

import collections
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Controller, Drive, Estimator, Motion, Mount, Noise, Recorder, Sensor, Task, parameter
from amorsim.controllers.user import UserController
from amorsim.core.arguments import is_list
from amorsim.core.display import in_notebook
from amorsim.core.distributions import Distribution
from amorsim.core.error_text import in_words
from amorsim.core.errors import ComponentError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import ParameterError, check_value, describe
from amorsim.core.shapes import Shape
from amorsim.estimators.user import UserEstimator
from amorsim.motions.user import UserMotion
from amorsim.plugins.checks import check_name
from amorsim.scenario.floor import Drop, Floor, Marking
from amorsim.scenario.initial_belief import InitialBelief
from amorsim.scenario.kidnapping import Kidnapping
from amorsim.scenario.kinds import by_name, check_colour, is_a, many
from amorsim.scenario.knowledge import Knowledge
from amorsim.scenario.named_places import first_place
from amorsim.scenario.pose import Pose
from amorsim.scenario.random_start import RandomStart
from amorsim.scenario.reading.columns import column_problem, not_for_sensors
from amorsim.scenario.surroundings import Landmark, Light

__all__ = [
    "Deviation",
    "Distribution",
    "Drop",
    "Floor",
    "InitialBelief",
    "Kidnapping",
    "Landmark",
    "Light",
    "Marking",
    "MountedSensor",
    "NoiseElement",
    "Obstacle",
    "Pose",
    "Recording",
    "Robot",
    "Scenario",
    "Zone",
]

_SHAPE, _POSE, _START = "am.Shape.circle(0.2)", "am.Pose(x=1.0)", "am.RandomStart()"


def _check_name(_: Any, attribute: Any, value: Any) -> None:
    if problem := check_name(value):
        raise ParameterError(attribute.name, problem)


Number = float | Distribution


def _check_number(_: Any, attribute: Any, value: Any) -> None:
    if value is None and attribute.name == "value":
        return
    if not isinstance(value, Distribution):
        check_value(attrs.evolve(describe(Pose)["x"], name=attribute.name, unit=""), value)


@attrs.frozen(kw_only=True)
class Deviation:
    """How a true value differs from its nominal one: ``nominal * scale + add``, or `value` in its place.

    Each may be drawn; `per` sets whether every replica draws its own, or the study one for all.
    """

    scale: Number = attrs.field(default=1.0, validator=_check_number)
    add: Number = attrs.field(default=0.0, validator=_check_number)
    value: Number | None = attrs.field(default=None, validator=_check_number)
    per: str = parameter("replica", choices=("replica", "study"), help="who draws: each replica, or the study once")

    def __attrs_post_init__(self) -> None:
        if self.value is not None and (self.scale, self.add) != (1.0, 0.0):
            takes = "value takes the place of the nominal one; None is not a value"
            raise ParameterError("value", f"expected either value, or scale and add: {takes}")

    @property
    def is_drawn(self) -> bool:
        """Whether a part of it is drawn at random."""
        return any(isinstance(part, Distribution) for part in (self.scale, self.add, self.value))


@attrs.frozen(kw_only=True)
class NoiseElement:
    """An element of a noise chain, with a name that is unique in it (its draws depend on the name).

    `column` is which of its sensor's columns it is for, where the sensor has any (`Sensor.columns`); without it, all.
    """

    name: str = attrs.field(validator=_check_name)
    noise: Noise
    column: str = ""


def _chain(given: Iterable[NoiseElement | Noise]) -> tuple[NoiseElement, ...]:
    """The chain of the given elements; bare ones are named after their classes, numbered where a name repeats."""
    made: list[NoiseElement] = []
    if not is_list(given):
        raise ParameterError(
            "noise", f"expected a list of noises, as [am.noise.Gaussian(std=0.01)], got {in_words(given)}"
        )
    for element in given:
        if not isinstance(element, (Noise, NoiseElement)):
            raise ParameterError("noise", f"expected a list of noises, got one with {in_words(element)}")
        if isinstance(element, Noise):
            name = type(element).__name__.lower()
            count = sum(other.name.partition("_")[0] == name for other in made)
            made.append(NoiseElement(name=f"{name}_{count + 1}" if count else name, noise=element))
        else:
            made.append(element)
    names = [element.name for element in made]
    for name in names:
        if names.count(name) > 1:
            raise ParameterError("noise", f"two elements of the chain are called {name!r}; names must differ")
    return tuple(made)


@attrs.frozen(kw_only=True)
class MountedSensor:
    """A sensor on a robot: the device, where it sits, how often it reads, and what it does to the quantity."""

    sensor: Sensor = attrs.field(validator=is_a(Sensor, "am.sensors.Laser(...)"))
    mount: Mount = attrs.field(factory=Mount, validator=is_a(Mount, "am.Mount(x=0.1)"))
    rate: float | None = parameter(None, unit="Hz", gt=0, help="readings a second; none: one every step")
    latency: float = parameter(0.0, unit="s", ge=0, le=60, live=False, help="until a reading arrives")
    noise: tuple[NoiseElement, ...] = attrs.field(default=(), converter=_chain)

    def __attrs_post_init__(self) -> None:
        for element in self.noise:
            if element.noise.for_ground:
                raise ParameterError("noise", f"{element.name}: {not_for_sensors(type(element.noise))}")
            problem = column_problem(self.sensor, type(element.noise), element.column)
            if problem:
                raise ParameterError("noise", f"{element.name}: column: {problem}")


def _mounted(sensors: Mapping[str, Sensor | MountedSensor]) -> dict[str, MountedSensor]:
    if not isinstance(sensors, Mapping):
        raise ParameterError(
            "sensors", f"expected a dict by names, as {{'laser': am.sensors.Laser()}}, got {sensors!r}"
        )
    for name in sensors:
        if problem := check_name(name):
            raise ParameterError("sensors", problem)
    return {
        name: given if isinstance(given, MountedSensor) else MountedSensor(sensor=given)
        for name, given in sensors.items()
    }


def _check_errors(_: Any, __: Any, value: Any) -> None:
    if not isinstance(value, Mapping):
        raise ParameterError(
            "errors", f"expected a dict by paths, as {{'drive.track': Deviation(scale=1.02)}}, got {in_words(value)}"
        )
    for path, deviation in value.items():
        if not isinstance(deviation, Deviation):
            raise ParameterError(
                "errors", f"{path}: expected a Deviation, as in Deviation(scale=1.02), got {in_words(deviation)}"
            )


def _controller(given: Controller | Callable[..., Any] | None) -> Controller | None:
    if given is None or isinstance(given, Controller):
        return given
    if not callable(given) or (isinstance(given, type) and issubclass(given, Controller)):
        raise ParameterError("controller", f"expected a controller, a function or a class, got {in_words(given)}")
    return UserController(source="", function=given)


def _estimators(given: Any) -> Any:
    if not isinstance(given, Mapping):
        return given  # refused by name afterwards
    return {name: _estimator(estimator) for name, estimator in given.items()}


def _estimator(given: Any) -> Any:
    is_plain = isinstance(given, type) and not issubclass(given, Estimator)
    return UserEstimator(source="", function=given) if is_plain else given


def _kidnappings(given: Iterable[Kidnapping]) -> tuple[Kidnapping, ...]:
    return many("kidnappings", Kidnapping, given)


@attrs.frozen(kw_only=True, eq=False)
class Robot:
    """A robot: nominal parameters, how the true ones differ (`errors`), and its software.

    Parameters
    ----------
    pose
        Where it starts; without it, at the map's start or at the free place with most room.
    start
        In place of a pose: drawn at random.
    initial_belief
        What it knows of that pose.
    kidnappings
        When it is carried elsewhere.
    errors
        `Deviation` by path: ``"drive.track"``, ``"sensors.laser.mount.heading"``, ``"pose.x"`` ...
    ground
        Noise between wheels and ground: a chain through which each step's travel [m] of every rolling joint goes,
        where encoders cannot see it.
    controller
        A component, or a function ``f(readings, estimate, clock)`` of one robot, or a class with such a `command`.
    estimators
        By name; the first is the one that the controller gets. Each is a component, or a class of one robot with such
        an `update` (`amorsim.estimators.user.UserEstimator`).
    on_collision
        ``"end"`` ends the controller at the first collision, ``"continue"`` lets it go on.
    """

    name: str = attrs.field(default="robot", validator=_check_name)
    model: str = ""
    shape: Shape = attrs.field(validator=is_a(Shape, _SHAPE))
    drive: Drive = attrs.field(validator=is_a(Drive, "am.drives.Differential(...)"))
    sensors: dict[str, MountedSensor] = attrs.field(factory=dict, converter=_mounted)
    ground: tuple[NoiseElement, ...] = attrs.field(default=(), converter=_chain)
    estimators: dict[str, Estimator] = attrs.field(
        factory=dict,
        converter=_estimators,
        validator=by_name(Estimator, "am.estimators.DeadReckoning()"),
    )
    controller: Controller | None = attrs.field(default=None, converter=_controller)
    on_collision: str = parameter("end", choices=("end", "continue"), help="what a collision does to the controller")
    errors: dict[str, Deviation] = attrs.field(factory=dict, validator=_check_errors)
    pose: Pose | None = attrs.field(default=None, validator=is_a(Pose, _POSE, optional=True))
    start: RandomStart | None = attrs.field(default=None, validator=is_a(RandomStart, _START, optional=True))
    initial_belief: InitialBelief = attrs.field(
        factory=InitialBelief, validator=is_a(InitialBelief, "am.InitialBelief(kind='gaussian', std=0.3)")
    )
    kidnappings: tuple[Kidnapping, ...] = attrs.field(default=(), converter=_kidnappings)
    knowledge: Knowledge = attrs.field(factory=Knowledge, validator=is_a(Knowledge, "am.Knowledge(map=...)"))
    fiducial: int = parameter(0, ge=0, le=2**31 - 1, help="what is written on the mark that it carries; 0: none")
    height: float = parameter(0.3, unit="m", gt=0, help="above the ground, to its top; for cameras")
    colour: str | None = parameter(None, help="a name of CSS or '#rrggbb', for cameras and pictures")

    _repr_mimebundle_ = in_notebook

    def __repr__(self) -> str:
        software = [*self.estimators, *([type(self.controller).__name__] if self.controller else ())]
        parts = [self.model or type(self.drive).__name__, *self.sensors, *software]
        return f"<Robot {self.name!r}: {', '.join(parts)}>"

    def __attrs_post_init__(self) -> None:
        check_colour(self.colour)
        if self.pose is not None and self.start is not None:
            raise ParameterError("start", "expected either a pose or a start at random, got both")
        if self.initial_belief.kind == "nothing" and not self.estimators:
            raise ParameterError(
                "initial_belief",
                "a robot that knows nothing of its start needs an estimator that finds it; it has none",
            )


def _motion(given: Motion | Callable[..., Any] | None) -> Motion | None:
    if given is None or isinstance(given, Motion):
        return given
    if not callable(given) or (isinstance(given, type) and issubclass(given, Motion)):
        raise ParameterError("motion", f"expected a motion, a function or a class, got {in_words(given)}")
    return UserMotion(source="", function=given)


@attrs.frozen(kw_only=True, eq=False)
class Obstacle:
    """A body that is not a robot: it stands, or moves as its motion proposes.

    A motion is a component, or a function ``f(obstacle)`` that gives a velocity, or a class with such a `velocity`
    (`amorsim.motions.user.UserMotion`). Without a `pose` the obstacle starts where its motion begins, such as at the
    first waypoint, or else at the origin; with a `start`, where that is drawn.
    """

    name: str = attrs.field(validator=_check_name)
    shape: Shape = attrs.field(validator=is_a(Shape, _SHAPE))
    motion: Motion | None = attrs.field(default=None, converter=_motion)
    pose: Pose = attrs.field(validator=is_a(Pose, _POSE))
    start: RandomStart | None = attrs.field(default=None, validator=is_a(RandomStart, _START, optional=True))
    fiducial: int = parameter(0, ge=0, le=2**31 - 1, help="what is written on the mark that it carries; 0: none")
    height: float = parameter(1.0, unit="m", gt=0, help="above the ground, to its top; for cameras")
    colour: str | None = parameter(None, help="a name of CSS or '#rrggbb', for cameras and pictures")

    @pose.default
    def _begin(self) -> Pose:
        try:
            place = None if self.motion is None else first_place(self.motion)
        except ComponentError as error:
            raise ParameterError("motion", f"{type(self.motion).__name__}: {error}") from error.__cause__
        return Pose() if place is None else Pose(x=place[0], y=place[1], heading=place[2])

    def __attrs_post_init__(self) -> None:
        check_colour(self.colour)


def _check_zone_shape(_: Any, attribute: Any, value: Any) -> None:
    is_circle = len(value.vertices) == 1 and len(value.vertices[0]) == 1
    if value.radius and not is_circle:
        raise ParameterError(attribute.name, "expected a circle, a rectangle or a polygon without rounding")


@attrs.frozen(kw_only=True, eq=False)
class Zone:
    """A part of the floor, which does something of its own to the wheels that roll over it.

    Parameters
    ----------
    shape
        A circle or a polygon, in the frame of `pose`.
    ground
        A chain as of `Robot.ground`, through which goes what each rolling joint travels within the zone, after the
        robot's own.
    """

    name: str = attrs.field(validator=_check_name)
    shape: Shape = attrs.field(validator=[is_a(Shape, _SHAPE), _check_zone_shape])
    pose: Pose = attrs.field(factory=Pose, validator=is_a(Pose, _POSE))
    ground: tuple[NoiseElement, ...] = attrs.field(default=(), converter=_chain)

    @property
    def outline(self) -> Array:
        """Vertices [m] of its border in the world `(V, 2)`, anticlockwise."""
        c, s = math.cos(self.pose.heading), math.sin(self.pose.heading)
        x, y = self.shape.outline.T
        return np.stack((self.pose.x + c * x - s * y, self.pose.y + s * x + c * y), axis=1)


def _recorders(given: Iterable[Recorder]) -> tuple[Recorder, ...]:
    return many("also", Recorder, given)  # type: ignore[type-abstract]


@attrs.frozen(kw_only=True)
class Recording:
    """The recording of a run; `also` are recorders in addition to that of the text files, which every run has."""

    sensors: str = parameter("auto", choices=("auto", "all", "none"), help="sensor files; auto: up to 32 replicas only")
    picture: bool = parameter(True, help="whether a picture of the map and the paths is drawn at the end")
    also: tuple[Recorder, ...] = attrs.field(default=(), converter=_recorders)


def _robots(given: Iterable[Robot]) -> tuple[Robot, ...]:
    return many("robots", Robot, given)


def _obstacles(given: Iterable[Obstacle]) -> tuple[Obstacle, ...]:
    return many("obstacles", Obstacle, given)


def _landmarks(given: Iterable[Landmark]) -> tuple[Landmark, ...]:
    return many("landmarks", Landmark, given)


def _lights(given: Iterable[Light]) -> tuple[Light, ...]:
    return many("lights", Light, given)


def _zones(given: Iterable[Zone]) -> tuple[Zone, ...]:
    return many("zones", Zone, given)


_is_task = is_a(Task, "am.tasks.PointGoal()", optional=True)


@attrs.frozen(kw_only=True, eq=False)
class Scenario:
    """A world, the robots in it, and how time runs.

    `task` is what a learner is to do in it, by `amorsim.learning`; a run takes no notice of it.
    `source` is the file it was read from, `resolved` the tables in it with all models and defaults filled in and files
    named (what a run's folder keeps); both are none for a scenario built in Python. `remarks` list what was left out of
    another program's file.
    """

    map: Map = attrs.field(validator=is_a(Map, "am.load_map('room.wld')"))
    robots: tuple[Robot, ...] = attrs.field(converter=_robots)
    obstacles: tuple[Obstacle, ...] = attrs.field(default=(), converter=_obstacles)
    landmarks: tuple[Landmark, ...] = attrs.field(default=(), converter=_landmarks)
    lights: tuple[Light, ...] = attrs.field(default=(), converter=_lights)
    zones: tuple[Zone, ...] = attrs.field(default=(), converter=_zones)
    floor: Floor = attrs.field(factory=Floor, validator=is_a(Floor, "am.Floor(markings=[...])"))
    dt: float = parameter(0.1, unit="s", ge=1e-6, le=10, help="length of a step")
    duration: float = parameter(60.0, unit="s", gt=0, le=1e9, help="simulated time of a run")
    seed: int = parameter(0, ge=0, le=2**63 - 1, help="of all random draws")
    recording: Recording = attrs.field(factory=Recording)
    task: Task | None = attrs.field(default=None, validator=_is_task)
    source: Path | None = None
    resolved: Mapping[str, Any] | None = None
    remarks: tuple[str, ...] = ()

    _repr_mimebundle_ = in_notebook

    def __repr__(self) -> str:
        name, (width, height) = self.source.stem if self.source else "", self.map.size
        names = [robot.name for robot in self.robots] + [obstacle.name for obstacle in self.obstacles]
        things, more = ", ".join(map(repr, names[:6])), len(names) - 6
        return (
            f"<Scenario {name!r}: {things}{f' and {more} more' if more > 0 else ''} in {self.map.name!r} ({width:g} x "
            f"{height:g} m), {self.duration:g} s in steps of {self.dt:g} s, seed {self.seed}>"
        )

    def __attrs_post_init__(self) -> None:
        if not self.robots:
            raise ParameterError("robots", "a scenario needs one robot at least")
        names = [robot.name for robot in self.robots] + [obstacle.name for obstacle in self.obstacles]
        for name, count in collections.Counter(names).items():
            if count > 1:
                raise ParameterError("robots", f"two robots or obstacles are called {name!r}; names must differ")
        for name, count in collections.Counter(zone.name for zone in self.zones).items():
            if count > 1:
                raise ParameterError("zones", f"two zones are called {name!r}; names must differ")
