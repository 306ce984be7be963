"""Random scenes in which somebody looks about, and what shapely says of their lines of sight."""

from __future__ import annotations

import math

import attrs
import numpy as np
import shapely
from shapely import affinity

import amorsim as am
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.scenario.spec import Landmark, Obstacle, Pose
from amorsim.simulation.simulation import Simulation
from tests.building import robot, scenario

SHAPES = [
    Shape.circle(0.3),
    Shape.rectangle(0.8, 0.3),
    Shape.polygon([(-0.4, -0.3), (0.5, 0.0), (-0.4, 0.3)]),
    Shape.polygon([(-0.4, -0.4), (0.4, -0.4), (0.4, -0.1), (-0.1, -0.1), (-0.1, 0.4), (-0.4, 0.4)]),
    Shape.polygon([(-0.2, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)], rounding=0.1),
]
SIZE = 8.0  # [m] of the room
CELL = 0.1  # [m]
HAIR = 1e-7  # [m] a line of sight so near to something is in doubt, and not judged


@attrs.frozen(eq=False)
class Scene:
    """A room with some walls of whole cells, a robot that looks, bodies and marks."""

    sim: Simulation
    pose: np.ndarray
    walls: shapely.Geometry  # of cells, that lines must not enter
    bodies: dict[str, shapely.Geometry]
    obstacles: list[Obstacle]
    landmarks: list[Landmark]


def placed(shape: Shape, pose: Pose, grow: float = 0.0, quad_segs: int = 400) -> shapely.Geometry:
    """A footprint in the world; a quarter of a round corner has `quad_segs` chords."""
    kinds = {1: shapely.Point, 2: shapely.LineString}
    cores = shapely.union_all([kinds.get(len(part), shapely.Polygon)(part) for part in shape.parts])
    whole = cores.buffer(shape.radius + grow, quad_segs=quad_segs) if shape.radius + grow > 0.0 else cores
    turned = affinity.rotate(whole, pose.heading, origin=(0, 0), use_radians=True)
    return affinity.translate(turned, pose.x, pose.y)


def random_scene(seed: int, sensor: am.Sensor, bodies: int = 8, marks: int = 6, quad_segs: int = 400) -> Scene:
    """A scene by number; every second body carries a mark."""
    random = np.random.default_rng(seed)
    cells = np.zeros((int(SIZE / CELL),) * 2, dtype=bool)
    cells[[0, -1], :] = cells[:, [0, -1]] = True
    for _ in range(5):
        row, col = random.integers(5, 70, 2)
        rows, cols = (2, 20) if random.uniform() < 0.5 else (20, 2)
        cells[row : row + rows, col : col + cols] = True
    boxes = [shapely.box(c * CELL, r * CELL, (c + 1) * CELL, (r + 1) * CELL) for r, c in np.argwhere(cells)]
    walls = shapely.union_all(boxes)
    taken = [walls]
    placed_bodies: list[tuple[Shape, Pose]] = []
    while len(placed_bodies) < bodies + 1:
        shape = SHAPES[int(random.integers(len(SHAPES)))]
        x, y = random.uniform(0.5, SIZE - 0.5, 2)
        pose = Pose(x=x, y=y, heading=random.uniform(-math.pi, math.pi))
        ground = placed(shape, pose, 1e-3)
        if not any(ground.intersects(other) for other in taken):
            taken.append(ground)
            placed_bodies.append((shape, pose))
    (shape, pose), others = placed_bodies[0], placed_bodies[1:]
    obstacles = [
        Obstacle(name=f"body{i}", shape=its, pose=at, fiducial=(i % 2) * (100 + i))
        for i, (its, at) in enumerate(others)
    ]
    landmarks = [
        Landmark(id=i + 1, x=x, y=y, radius=random.uniform(0.0, 0.2))
        for i, (x, y) in enumerate(random.uniform(0.2, SIZE - 0.2, (marks, 2)))
    ]
    one = robot(shape=shape, pose=pose, sensors={"eye": sensor}, estimators={}, fiducial=77)
    world = Map.from_array(cells, resolution=CELL)
    sim = am.Simulation(scenario(one, map=world, obstacles=obstacles, landmarks=landmarks))
    return Scene(
        sim=sim,
        pose=np.array([pose.x, pose.y, pose.heading]),
        walls=walls,
        bodies={o.name: placed(o.shape, o.pose, quad_segs=quad_segs) for o in obstacles},
        obstacles=obstacles,
        landmarks=landmarks,
    )
