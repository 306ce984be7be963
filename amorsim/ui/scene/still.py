"""The scene of a scenario that can be read in part only: drawn without a simulation, and without any user's code."""

from __future__ import annotations

from collections.abc import Iterable

from amorsim.core.shapes import Shape
from amorsim.scenario.parts import parts_at
from amorsim.scenario.reading.partial import Outline, Partial
from amorsim.scenario.spec import Obstacle, Pose, Robot
from amorsim.ui.scene.bodies import body_of, floor_of, outline_of
from amorsim.ui.scene.drawn_robots import RobotShapes
from amorsim.ui.scene.maps import MapShapes
from amorsim.ui.scene.wire import ObstacleShape, OutlineShape, RobotEntry, Scene, Still

__all__ = ["StillBuilder"]

_NOTHING = [0.0, 0.0, 12.0, 8.0]  # m, what is seen of a world in which nothing stands: room for some rooms


class StillBuilder:
    """The scene at rest of a scenario as far as it can be read, and the pictures of its maps.

    Robots are drawn by their nominal parameters: the true ones may be drawn at random, which only a simulation does.

    Parameters
    ----------
    partial
        What can be read, as `amorsim.Document.partial` gives it.
    name
        The scenario's name, as it is shown.
    """

    def __init__(self, partial: Partial, name: str, version: int = 1) -> None:
        self._maps = MapShapes()
        world = None if partial.map is None else self._maps.add(partial.map)
        robots = RobotShapes(partial.robots, self._maps)
        entries: list[RobotEntry] = []
        poses: list[Pose | None] = []
        bodies: list[tuple[ObstacleShape, Pose | None]] = [
            (
                body_of(one.name, one.shape, one.colour, moves=one.motion is not None),
                None if one.start is not None else one.pose,
            )
            for one in sorted(partial.obstacles, key=lambda obstacle: obstacle.name)
        ]
        outlines = list(partial.outlines)
        for robot in partial.robots:
            try:
                entry, parts = robots.entry(robot), _parts(robot, robots)
            except Exception:  # of a plugin's drive or sensor, and no reason to show nothing
                outlines += _outline(robot)
                continue
            entries.append(entry)
            poses.append(robot.pose)
            bodies += parts
        scene: Scene = {
            "version": version,
            "scenario": name,
            "dt": partial.dt,
            "duration": partial.duration,
            "seed": partial.seed,
            "map": world,
            "robots": entries,
            "maps": self._maps.shapes,
            "kinds": robots.kinds,
            "obstacles": [body for body, _ in bodies],
            "floor": floor_of(partial.landmarks, partial.lights, partial.zones, partial.floor),
        }
        self.still: Still = {
            "scene": scene,
            "robots": [_numbers(pose) for pose in poses],
            "obstacles": [_numbers(pose) for _, pose in bodies],
            "outlines": [_outline_shape(outline) for outline in outlines],
            "extent": _extent(scene, partial, outlines),
        }

    def picture(self, name: str) -> bytes:
        """The PNG that a map's shape names; raises as `MapShapes.picture`."""
        return self._maps.picture(name)


def _parts(robot: Robot, robots: RobotShapes) -> list[tuple[ObstacleShape, Pose | None]]:
    """The parts of a robot, with their poses."""
    shapes = robots.parts(robot)
    if robot.pose is None:
        return [(shape, None) for shape in shapes]
    return [(shape, pose) for shape, (_, pose) in zip(shapes, parts_at(robot.drive, robot.pose), strict=True)]


def _outline(robot: Robot) -> list[Outline]:
    return [] if robot.pose is None else [Outline(name=robot.name, shape=robot.shape, pose=robot.pose)]


def _numbers(pose: Pose | None) -> list[float] | None:
    return None if pose is None else [pose.x, pose.y, pose.heading]


def _outline_shape(outline: Outline) -> OutlineShape:
    pose = outline.pose
    return {
        "name": outline.name,
        "footprint": outline_of(outline.shape),
        "pose": [pose.x, pose.y, pose.heading],
    }


def _extent(scene: Scene, partial: Partial, outlines: Iterable[Outline]) -> list[float]:
    """The box to show: the map, or without one all things in the world."""
    if scene["map"] is not None:
        return scene["maps"][scene["map"]]["extent"]
    bodies: list[Robot | Obstacle | Outline] = [*partial.robots, *partial.obstacles, *outlines]
    boxes = [_box(body.pose, body.shape) for body in bodies if body.pose is not None]
    floor = scene["floor"]
    points = [*floor["landmarks"], *floor["lights"]]
    for outline in (*floor["zones"], *(patch["points"] for patch in floor["patches"])):
        points += outline
    boxes += [[x, y, x, y] for x, y, *_ in points]
    if not boxes:
        return _NOTHING
    left, low, right, high = zip(*boxes, strict=True)
    return [min(left) - 1.0, min(low) - 1.0, max(right) + 1.0, max(high) + 1.0]


def _box(pose: Pose, shape: Shape) -> list[float]:
    reach = shape.reach
    return [pose.x - reach, pose.y - reach, pose.x + reach, pose.y + reach]
