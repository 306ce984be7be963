"""Scenarios from Stage worlds."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import attrs

from amorsim.contracts import ScenarioDocument, ScenarioLoader
from amorsim.core.errors import Fault, MapError, ScenarioError
from amorsim.core.parameters import parameter
from amorsim.foreign.robot_names import Names
from amorsim.foreign.stage.entities import Model, World, read_world
from amorsim.foreign.stage.geometry import Spot, moved, neat, polygons, vertices
from amorsim.foreign.stage.notes import Notes
from amorsim.foreign.stage.plan import Body, Plan, plan_of
from amorsim.foreign.stage.robots import RobotOptions, read_robot
from amorsim.foreign.stage.sensors import SensorOptions
from amorsim.foreign.stage.tokens import looks_like_stage

__all__ = ["Stage"]

Table = dict[str, Any]

_OF_WORLD = frozenset({"resolution", "interval_sim", "quit_time"})
_MOST_ROBOTS = 20_000


@attrs.frozen(kw_only=True)
class Stage(ScenarioLoader):
    """Worlds of Player/Stage (``.world``): models become walls, robots, obstacles, landmarks and zones.

    A ``position`` is a robot: ``diff``, ``car`` and ``omni`` drives, rangers as lasers or rings of sonars, bumpers and
    fiducial finders. Blob finders, grippers and what only Stage's window shows are left out. Bitmaps and boundaries are
    walls; other models are obstacles, or walls if they overlap something. A model that is neither touched nor seen is
    a landmark if it has a ``fiducial_return``, else a zone.
    """

    extensions: ClassVar[tuple[str, ...]] = (".world",)

    crop_bitmaps: bool = parameter(
        False, help="whether the dark part alone of a bitmap fills the model's size, as in Stage, and not all of it"
    )
    noise_as_variance: bool = parameter(
        False,
        help="whether a ranger's constant noise is its variance, as in Stage, and not its standard deviation",
    )
    sonar_as_ray: bool = parameter(
        False, help="whether a sensor of one sample sees along a single ray, as in Stage, and not in a cone of its fov"
    )
    other_controllers: str = parameter(
        "wander", choices=("wander", "none"), help="what robots do whose ctrl is a program for Stage; none: stand still"
    )

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file's first bytes may be those of a world of Stage."""
        return looks_like_stage(head)

    def read(self, path: Path) -> ScenarioDocument:
        """The scenario of a world.

        Raises
        ------
        ScenarioError
            With the file and the line of all that is wrong.
        """
        world, notes = read_world(path), Notes()
        try:
            plan = plan_of(world, notes, crop_bitmaps=self.crop_bitmaps, resolution=None)
        except MapError as error:
            raise ScenarioError([Fault(file="", path="", message=str(error))]) from None
        notes.check_keys_of_world(world.values, _OF_WORLD)
        writer = _Writer(self, path, world, plan, notes)
        tables = writer.tables()
        notes.raise_if_any()
        return ScenarioDocument(tables=tables, remarks=notes.remarks, lines=writer.lines)


class _Writer:
    def __init__(self, loader: Stage, path: Path, world: World, plan: Plan, notes: Notes) -> None:
        self._path, self._world, self._plan, self._notes = path, world, plan, notes
        self._crops = loader.crop_bitmaps
        self._options = RobotOptions(
            sensors=SensorOptions(noise_as_variance=loader.noise_as_variance, sonar_as_ray=loader.sonar_as_ray),
            other_controllers=loader.other_controllers,
        )
        self._names = Names()
        self._same: dict[Any, bytes] = {}  # what is alike in robots, by the content of their models
        self.lines: dict[str, int] = {}

    def tables(self) -> Table:
        """The whole scenario."""
        notes, values, plan = self._notes, self._world.values, self._plan
        interval = notes.number(values, "interval_sim", 100.0) / 1000.0
        duration = notes.number(values, "quit_time", 60.0)
        if not 1e-6 <= interval <= 10.0:
            notes.fault(
                values["interval_sim"].place, f"interval_sim: expected 0.001 to 10000 ms, got {1000 * interval:g}"
            )
            interval = 0.1
        world: Table = {"map": self._path.name, "use": "stage"}
        if self._crops:
            world["crop_bitmaps"] = True
        simulation: Table = {"dt": neat(interval)}
        if duration > 0.0:
            simulation["duration"] = neat(duration)
        tables: Table = {"format": 1, "world": world, "simulation": simulation, "robots": list(self._robots(interval))}
        if not tables["robots"]:
            notes.remark("no robots", "the world has no robot: a Pioneer 2DX wanders in it")
            tables["robots"] = [
                {"name": self._names.free("rover"), "model": "pioneer2dx", "controller": {"use": "wander"}}
            ]
        if obstacles := list(self._obstacles()):
            tables["obstacles"] = obstacles
        if plan.marks:
            tables["landmarks"] = [
                {"id": mark.id, "x": neat(mark.spot.x), "y": neat(mark.spot.y), "radius": neat(mark.radius)}
                | ({} if mark.colour is None else {"colour": mark.colour})
                for mark in plan.marks
            ]
        if plan.zones:
            names = Names()
            tables["zones"] = [
                {"name": names.free(body.name), **_place_of(body.spot, part)}
                for body in plan.zones
                for part in polygons(body.area)
            ]
        return tables

    def _robots(self, interval: float) -> Iterator[Table]:
        robots = self._plan.robots
        if len(robots) > _MOST_ROBOTS:
            self._notes.fault(
                robots[_MOST_ROBOTS][0].place, f"there are {len(robots)} robots; expected {_MOST_ROBOTS} at most"
            )
            return
        for number, (model, spot) in enumerate(robots):
            name = self._names.free(self._notes.text(model.values, "name") or model.called)
            if model.place.file == self._world.files[0]:
                self.lines[f"robots.{number}"] = model.place.line
            yield {"name": name, "pose": spot.table(), **self._robot(model, interval)}

    def _robot(self, model: Model, interval: float) -> Table:
        """All of a robot but its name and its pose; read once for all with the same content, each with a copy."""
        said = model.said_but("name", "pose")
        if said not in self._same:
            self._same[said] = pickle.dumps(read_robot(model, interval, self._notes, self._options))
        table: Table = pickle.loads(self._same[said])
        return table

    def _obstacles(self) -> Iterator[Table]:
        number = 0
        for body in self._plan.bodies:
            for part in polygons(body.area):
                if body.model.place.file == self._world.files[0]:
                    self.lines[f"obstacles.{number}"] = body.model.place.line
                number += 1
                yield self._obstacle(body, part)

    def _obstacle(self, body: Body, part: Any) -> Table:
        table = {"name": self._names.free(body.name), **_place_of(body.spot, part), "height": neat(body.height)}
        if body.colour is not None:
            table["colour"] = body.colour
        if body.fiducial:
            table["fiducial"] = body.fiducial
        return table


def _place_of(spot: Spot, part: Any) -> Table:
    """Shape and pose of a part of a body, its base point in the part's middle."""
    middle = part.centroid
    points = vertices(moved(part, Spot(-middle.x, -middle.y)))
    return {"shape": {"polygon": points}, "pose": spot.then(Spot(middle.x, middle.y)).table()}
