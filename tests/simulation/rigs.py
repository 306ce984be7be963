"""Tractors with trailers, for tests of robots of several parts."""

from __future__ import annotations

from typing import Any

import numpy as np

import amorsim as am
from amorsim.controllers.manual import Manual
from amorsim.core.maps.map import Map
from tests import building

__all__ = ["least_gap", "rig", "tractor", "yard"]


def tractor(**changes: Any) -> am.drives.Tractor:
    """Its base point is 1.1 m ahead of the trailer's axle, and 1.5 m ahead of the trailer's rear."""
    given = {
        "wheel_radius_left": 0.1,
        "wheel_radius_right": 0.1,
        "track": 0.4,
        "rate_max": 1e3,
        "trailer_length": 0.8,
        "hitch_offset": 0.3,
        "hitch_max": 1.4,
        "trailer_width": 0.5,
        "trailer_front": 0.3,
        "trailer_rear": 0.4,
    }
    return am.drives.Tractor(**(given | changes))


def rig(name: str = "rig", x: float = 3.0, y: float = 3.0, heading: float = 0.0, **changes: Any) -> am.Robot:
    """A tractor half a metre square, driven by hand."""
    given: dict[str, Any] = {
        "name": name,
        "shape": am.Shape.rectangle(0.5, 0.5),
        "drive": tractor(),
        "controller": Manual(),
        "on_collision": "continue",
        "pose": am.Pose(x=x, y=y, heading=heading),
    }
    return am.Robot(**(given | changes))


def yard(*robots: am.Robot, side: float = 10.0, **changes: Any) -> am.Scenario:
    """Robots in a square room of cells of a centimetre."""
    given: dict[str, Any] = {"map": building.room(side, side, 0.01), "robots": robots, "dt": 0.1, "seed": 3}
    return am.Scenario(**(given | changes))


def least_gap(sim: am.Simulation) -> float:
    """Of all bodies and parts to walls, and to those that are of others [m]; at most 1 m."""
    world = sim._fleet.world
    one = np.ones(len(world.everyone))
    gaps, _ = world.wall_gaps(world.everyone, world.poses, one)
    a, b = world.pairs_within(world.poses, one)
    apart = world.body_gaps(a, world.poses[a], b, world.poses[b], np.ones(len(a)))
    return float(min(gaps.min(), apart.min(initial=1.0)))


def stone(name: str, x: float, y: float, radius: float = 0.1, **changes: Any) -> am.Obstacle:
    """A round obstacle."""
    return am.Obstacle(name=name, shape=am.Shape.circle(radius), pose=am.Pose(x=x, y=y), **changes)


def map_with(*walls: tuple[float, float, float, float], side: float = 10.0) -> Map:
    """The square room with more walls."""
    corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
    around = [(*a, *b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    return Map.from_segments(np.array([*around, *walls]), resolution=0.01)
