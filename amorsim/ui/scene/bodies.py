"""Bodies and the floor as they are drawn."""

from __future__ import annotations

from collections.abc import Iterable

from PIL import ImageColor

from amorsim.core.shapes import Shape
from amorsim.scenario.floor import Floor as ScenarioFloor
from amorsim.scenario.spec import Landmark, Light, Zone
from amorsim.ui.scene.wire import Floor, ObstacleShape, Outline

__all__ = ["body_of", "floor_of", "outline_of", "rgb"]


def rgb(name: str) -> str:
    """A colour as "#rrggbb"."""
    return "#{:02x}{:02x}{:02x}".format(*ImageColor.getrgb(name)[:3])


def body_of(name: str, shape: Shape, colour: str | None, *, moves: bool = True) -> ObstacleShape:
    """An obstacle, or a part of a robot, as it is drawn."""
    body: ObstacleShape = {"name": name, "footprint": outline_of(shape), "moves": moves}
    if colour is not None:
        body["colour"] = rgb(colour)
    return body


def outline_of(shape: Shape) -> Outline:
    """A footprint as it is drawn."""
    if shape.vertices == (((0.0, 0.0),),):
        return {"circle": shape.radius}
    return {"polygon": shape.outline.tolist()}


def floor_of(
    landmarks: Iterable[Landmark], lights: Iterable[Light], zones: Iterable[Zone], floor: ScenarioFloor
) -> Floor:
    """The things in the world besides walls and bodies."""
    return {
        "landmarks": [[mark.x, mark.y, mark.radius] for mark in landmarks],
        "lights": [[light.x, light.y] for light in lights],
        "zones": [zone.outline.tolist() for zone in zones],
        "patches": [
            {"points": patch.points.tolist(), "width": patch.width, "colour": rgb(patch.colour)}
            for patch in floor.patches
        ],
    }
