"""Rooms in which many look about at once, and what shapely says of all their lines of sight together.

What `sight` does for one who looks, line by line, with shapely's functions of arrays: fast enough for 1e5 cases.
"""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import shapely

import amorsim as am
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape
from amorsim.scenario.spec import Landmark, Obstacle, Pose
from tests.building import robot, scenario
from tests.sensors.sight import SHAPES, placed

CELL = 0.1  # [m]
GRAZE = 1e-9  # [m] a line so near to something is in doubt, and not judged


@attrs.frozen(eq=False)
class Crowd:
    """A room; bodies, the robots first; landmarks. Each has `marks` of its own, which are numbers from 1 on.

    `poses` `(B, 3)` are the bodies', `places` `(B + L, 2)` and `radius` `(B + L,)` those of all marks.
    """

    sim: am.Simulation
    viewers: int
    poses: np.ndarray
    places: np.ndarray
    radius: np.ndarray
    outlines: np.ndarray  # of bodies, and the discs of landmarks that have a colour; round corners are chords
    cores: np.ndarray  # of bodies, before they are rounded
    rounding: np.ndarray  # (B,) by how much [m]
    walls: shapely.Geometry
    blocks: np.ndarray  # that the walls consist of

    def tables(self, columns: int) -> np.ndarray:
        """The true readings of all viewers `(V, slots, columns)`."""
        return np.array(
            [self.sim.robot(f"r{i:02d}").readings["eye"].true.reshape(-1, columns) for i in range(self.viewers)]
        )


def random_crowd(
    seed: int,
    sensor: am.Sensor,
    viewers: int = 40,
    others: int = 20,
    landmarks: int = 40,
    size: float = 12.0,
    colours: tuple[str, ...] = (),
    disc: tuple[float, float] = (0.0, 0.2),
) -> Crowd:
    """A room by number, in which all bodies and landmarks have marks, and colours in order if there are any."""
    random = np.random.default_rng(seed)
    side = round(size / CELL)
    cells = np.zeros((side, side), dtype=bool)
    strips = [(0, 0, 1, side), (side - 1, 0, 1, side), (0, 0, side, 1), (0, side - 1, side, 1)]
    for _ in range(8):
        row, col = random.integers(5, side - 10, 2).tolist()
        strips.append((row, col, *((2, 15) if random.uniform() < 0.5 else (15, 2))))
    for row, col, rows, cols in strips:
        cells[row : row + rows, col : col + cols] = True
    row, col, rows, cols = np.array(strips).T
    blocks = shapely.box(col * CELL, row * CELL, (col + cols) * CELL, (row + rows) * CELL)
    walls = shapely.union_all(blocks)
    shapely.prepare(walls)
    bodies: list[tuple[Shape, Pose]] = []
    ground: list[shapely.Geometry] = []
    while len(bodies) < viewers + others:
        shape = SHAPES[int(random.integers(len(SHAPES)))]
        x, y = random.uniform(0.5, size - 0.5, 2)
        pose = Pose(x=x, y=y, heading=random.uniform(-math.pi, math.pi))
        own = placed(shape, pose, 1e-3, quad_segs=16)
        if not walls.intersects(own) and not shapely.intersects(own, ground).any():
            bodies.append((shape, pose))
            ground.append(own)
    spots = random.uniform(0.2, size - 0.2, (landmarks, 2))
    for i in range(0, landmarks, 2):  # every second one in or about a wall
        xmin, ymin, xmax, ymax = random.choice(blocks).bounds
        spots[i] = random.uniform((xmin - 0.1, ymin - 0.1), (xmax + 0.1, ymax + 0.1))
    marks = [
        Landmark(
            id=len(bodies) + i + 1,
            x=x,
            y=y,
            radius=random.uniform(*disc),
            colour=colours[len(bodies) + i] if colours else None,
        )
        for i, (x, y) in enumerate(spots.tolist())
    ]
    robots = []
    obstacles = []
    for i, (shape, pose) in enumerate(bodies):
        given: dict[str, Any] = {"shape": shape, "pose": pose, "fiducial": i + 1}
        given["colour"] = colours[i] if colours else None
        if i < viewers:
            robots.append(robot(name=f"r{i:02d}", sensors={"eye": sensor}, estimators={}, **given))
        else:
            obstacles.append(Obstacle(name=f"o{i:02d}", **given))
    world = Map.from_array(cells, resolution=CELL)
    poses = np.array([(pose.x, pose.y, pose.heading) for _, pose in bodies])
    return Crowd(
        sim=am.Simulation(scenario(*robots, map=world, obstacles=obstacles, landmarks=marks)),
        viewers=viewers,
        poses=poses,
        places=np.concatenate((poses[:, :2], [(mark.x, mark.y) for mark in marks])),
        radius=np.array([0.0] * len(bodies) + [mark.radius for mark in marks]),
        outlines=np.array(
            [placed(shape, pose, quad_segs=32) for shape, pose in bodies]
            + [shapely.Point(mark.x, mark.y).buffer(mark.radius, quad_segs=32) for mark in marks if colours]
        ),
        cores=np.array([placed(shape, pose, -shape.radius) for shape, pose in bodies]),
        rounding=np.array([shape.radius for shape, _ in bodies]),
        walls=walls,
        blocks=blocks,
    )


def lines_of_sight(crowd: Crowd, viewer: np.ndarray, mark: np.ndarray) -> np.ndarray:
    """From each viewer to its mark `(Q,)`: to where a carrier or a landmark's disc begins, or a bare point is."""
    eyes = crowd.poses[viewer, :2]
    to = crowd.places[mark] - eyes
    away = np.hypot(*to.T)
    end = away - crowd.radius[mark]
    carried = mark < len(crowd.poses)
    whole = shapely.linestrings(np.stack((eyes, crowd.places[mark]), axis=1))
    into = shapely.intersection(crowd.outlines[mark[carried]], whole[carried])
    surface = shapely.distance(into, shapely.points(eyes[carried]))  # nan where the line meets its outline nowhere
    end[carried] = np.fmin(end[carried], surface)
    stop = eyes + to * (np.maximum(end, 0.0) / away)[:, None]
    return shapely.linestrings(np.stack((eyes, stop), axis=1))


def are_free(crowd: Crowd, lines: np.ndarray, viewer: np.ndarray, mark: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whether lines of sight `(Q,)` meet neither walls nor a third body; and whether that is beyond doubt."""
    sure = crowd.walls.buffer(-GRAZE, join_style="mitre")
    touched = crowd.walls.buffer(GRAZE, join_style="mitre")
    shapely.prepare(sure)
    shapely.prepare(touched)
    hidden = shapely.intersects(sure, lines)
    free = ~shapely.intersects(touched, lines)
    line, body = shapely.STRtree(crowd.cores).query(lines, predicate="dwithin", distance=crowd.rounding.max() + 0.01)
    third = (body != viewer[line]) & (body != mark[line])
    line, body = line[third], body[third]
    gap = shapely.distance(lines[line], crowd.cores[body]) - crowd.rounding[body]
    # A line through a body without rounding is at distance 0 from it: how much of it is inside tells.
    sharp = (crowd.rounding[body] == 0.0) & (gap <= 0.0)
    gap[sharp] = -shapely.length(shapely.intersection(lines[line[sharp]], crowd.cores[body[sharp]]))
    hidden[line[gap < -GRAZE]] = True
    free[line[gap <= GRAZE]] = False
    return free, free != hidden


def bearings_of(crowd: Crowd, viewer: np.ndarray, places: np.ndarray) -> np.ndarray:
    """In what direction from the viewers' headings places `(Q, 2)` are [rad], in [-pi, pi]."""
    to = places - crowd.poses[viewer, :2]
    off = np.arctan2(to[:, 1], to[:, 0]) - crowd.poses[viewer, 2]
    return np.arctan2(np.sin(off), np.cos(off))


def first_met(crowd: Crowd, viewer: int, angles: np.ndarray, range_max: float) -> np.ndarray:
    """Which thing rays of a viewer meet first, at angles [rad] in the world; -1 for a wall or none."""
    x, y = crowd.poses[viewer, :2]
    ends = np.stack((x + range_max * np.cos(angles), y + range_max * np.sin(angles)), axis=1)
    rays = shapely.linestrings(np.stack((np.broadcast_to([x, y], ends.shape), ends), axis=1))
    eye = shapely.Point(x, y)
    everything = np.concatenate((crowd.outlines, crowd.blocks))
    ray, thing = shapely.STRtree(everything).query(rays, predicate="intersects")
    ray, thing = ray[thing != viewer], thing[thing != viewer]
    away = shapely.distance(shapely.intersection(everything[thing], rays[ray]), eye)
    nearest_last = np.argsort(-away, kind="stable")
    sees = np.full(len(rays), -1)
    sees[ray[nearest_last]] = thing[nearest_last]
    return np.where(sees < len(crowd.outlines), sees, -1)


def in_the_open(crowd: Crowd, viewer: np.ndarray, thing: np.ndarray) -> np.ndarray:
    """Whether nothing else, wall or thing, reaches between each viewer and what it looks at `(Q,)`."""
    between = shapely.convex_hull(shapely.union(shapely.points(crowd.poses[viewer, :2]), crowd.outlines[thing]))
    free = ~shapely.intersects(crowd.walls, between)
    pair, other = shapely.STRtree(crowd.outlines).query(between, predicate="intersects")
    third = (other != viewer[pair]) & (other != thing[pair])
    free[pair[third]] = False
    return free
