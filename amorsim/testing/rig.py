"""The small world that components are tried in: 64 robots, each in a replica of its own, over a few steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts import (
    Aim,
    Clock,
    Context,
    Draws,
    Drive,
    Estimate,
    Measurement,
    Mount,
    RobotModel,
    Sensor,
    SensorModel,
)
from amorsim.core.maps.map import Map
from amorsim.core.poses import compose, logarithm
from amorsim.core.rows import stack, take
from amorsim.core.shapes import Shape
from amorsim.drives.differential import Differential
from amorsim.scenario.reading.worlds import start_of
from amorsim.scenario.spec import Drop, Floor, Landmark, Light, Marking, Obstacle, Pose, Scenario
from amorsim.sensors.compass import Compass
from amorsim.sensors.encoder import Encoder
from amorsim.sensors.gyro import Gyro
from amorsim.sensors.laser import Laser
from amorsim.sensors.sonar import Sonar
from amorsim.simulation.world.marks_and_lamps import Surroundings
from amorsim.simulation.world.sensor_view import GroupView
from amorsim.simulation.world.world import World
from amorsim.testing.variants import variants

__all__ = ["DT", "ROWS", "STEPS", "Rig", "Session", "bent"]


ROWS = 64
STEPS = 6
DT = 0.1  # [s]

_BODY = Shape.circle(0.2)
_POST = Shape.circle(0.15)
_BOX = Shape.rectangle(0.6, 0.4)


def _hall() -> Map:
    walls = [(0, 0, 12, 0), (12, 0, 12, 8), (12, 8, 0, 8), (0, 8, 0, 0), (3, 6.5, 5, 7), (9, 1, 9.5, 3)]
    return Map.from_segments(np.array(walls, dtype=np.float64), resolution=0.05)


def _sensors() -> dict[str, Sensor]:
    ring = tuple(Mount(x=0.1, heading=heading) for heading in (-1.5, -0.5, 0.5, 1.5))
    return {
        "encoder": Encoder(counts_per_revolution=1000.0),
        "laser": Laser(beams=31),
        "sonar": Sonar(elements=ring, half_angle=0.03),
        "compass": Compass(),
        "gyro": Gyro(),
    }


def _surroundings(landmarks: Array) -> Surroundings:
    """Marks of all kinds and some lamps; in colours, but for the robot."""
    places = enumerate(landmarks.tolist(), start=1)
    marks = [Landmark(id=i, x=x, y=y, radius=0.02 * i, colour="blue" if i % 2 else None) for i, (x, y) in places]
    lights = [Light(x=2.0, y=2.0), Light(x=6.0, y=4.0, intensity=3.0)]
    robot = Obstacle(name="robot", shape=_BODY)
    post = Obstacle(name="post", shape=_POST, fiducial=9, colour="red")
    box = Obstacle(name="box", shape=_BOX, colour="green", height=0.5)
    return Surroundings.of((robot, post, box), marks, lights, floor=_floor())


def _floor() -> Floor:
    """Stripes a hand wide, so that a sensor is sometimes above one and sometimes not, with drops between them."""
    stripes = [Marking(points=((0.0, 0.2 * i), (12.0, 0.2 * i)), width=0.1, reflectance=0.02 * i) for i in range(40)]
    drops = [Drop(shape=Shape.rectangle(0.1, 8.0), pose=Pose(x=0.5 * i, y=4.0), depth=0.02 * i) for i in range(1, 24)]
    return Floor(markings=stripes, drops=drops)


class Rig:
    """Robots whose drives follow given commands, with the readings of their sensors and their known start poses.

    Everything is the same each time. The input of a row depends only on its number; rows beyond 64 repeat the first.

    Parameters
    ----------
    drive
        Of all robots, each with slightly other parameters; a differential drive by default.
    sensors
        By name, in addition to (or in place of) an encoder, a laser of 31 beams, a sonar ring of four, a compass and
        a gyro, called ``encoder``, ``laser``, ``sonar``, ``compass`` and ``gyro``.
    scene
        A scenario in place of the hall with a post, a box, marks and lamps: its map, obstacles, landmarks and lights.
        Its robots set where the 64 start, in turn, a few centimetres and degrees apart, and the first their shape.
    """

    def __init__(
        self,
        drive: Drive | None = None,
        sensors: Mapping[str, Sensor] | None = None,
        scene: Scenario | None = None,
    ) -> None:
        if drive is None:
            drive = Differential(wheel_radius_left=0.1, wheel_radius_right=0.1, track=0.35, rate_max=15.0)
        random = np.random.default_rng(1)
        self.specified = drive
        self.drive: Drive = stack(variants(drive, ROWS))
        self.map = _hall() if scene is None else scene.map
        self.keys = random.integers(0, 2**63, ROWS).astype(np.uint64)
        self.commands = random.uniform(-6.0, 6.0, (STEPS + 1, ROWS, len(drive.channels)))
        self.sensors = {**_sensors(), **(sensors or {})}
        self.stacked = {name: stack(variants(sensor, ROWS)) for name, sensor in self.sensors.items()}
        self.mounts = stack(variants(Mount(x=0.05, y=0.01, heading=0.02), ROWS))
        self.landmarks = random.uniform(1.0, 7.0, (5, 2))
        self.starts = random.uniform((4.0, 3.0, -3.0), (8.0, 5.0, 3.0), (ROWS, 3))
        posts, boxes = random.uniform(0.5, 7.5, (2, ROWS, 3))
        self.names: tuple[str, ...] = ("robot", "post", "box")
        self.shapes: tuple[Shape, ...] = (_BODY, _POST, _BOX)
        self.others = np.stack((posts, boxes), axis=1)  # (64, o, 3) poses of the other bodies
        if scene is None:
            self.surroundings = _surroundings(self.landmarks)
        else:
            self._set_scene(scene, random.uniform(-1.0, 1.0, (ROWS, 3)))
        self._drive_about()
        self.readings = self._read()
        spread = random.normal(0.0, 0.02, (STEPS + 1, ROWS, 3))
        self.estimates = self.poses + spread

    def _set_scene(self, scene: Scenario, spread: Array) -> None:
        """Put the robots into a scenario's world; `spread` `(64, 3)` from -1 to 1 puts them apart."""
        first, obstacles = scene.robots[0], scene.obstacles
        poses = [robot.pose or start_of(scene.map, robot) for robot in scene.robots]
        places = np.array([[pose.x, pose.y, pose.heading] for pose in poses])
        self.starts = places[np.arange(ROWS) % len(places)] + spread * (0.05, 0.05, 0.1)
        self.landmarks = np.array([[mark.x, mark.y] for mark in scene.landmarks]).reshape(-1, 2)
        self.names = (first.name, *(obstacle.name for obstacle in obstacles))
        self.shapes = (first.shape, *(obstacle.shape for obstacle in obstacles))
        stand = [[one.pose.x, one.pose.y, one.pose.heading] for one in obstacles]
        self.others = np.tile(np.array(stand).reshape(1, -1, 3), (ROWS, 1, 1))
        self.surroundings = Surroundings.of((first, *obstacles), scene.landmarks, scene.lights)

    def _drive_about(self) -> None:
        """Joints, rates, poses and twists of every row at every step; walls have no effect here."""
        joints = np.zeros((ROWS, len(self.drive.joints)))
        rates, pose = np.zeros_like(joints), self.starts
        one = np.ones((ROWS, 1))
        draws = self.draws(np.arange(ROWS))
        state = dict(self.drive.start(Context(rows=ROWS, dt=DT, robot=self._model({}, np.arange(ROWS)), pose=pose)))
        track = [(joints, rates, pose, np.zeros((ROWS, 3)))]
        for t in range(STEPS):
            before = joints
            joints, rates = self.drive.advance(before, rates, self.commands[t].copy(), DT, state, draws)
            moved = self.drive.displacement(before, joints, one)
            pose = compose(pose, moved)
            joints = self.drive.follow(joints, moved)
            track.append((joints, rates, pose, logarithm(moved) / DT))
        self.joints, self.rates, self.poses, self.twists = (np.array(column) for column in zip(*track, strict=True))

    def _read(self) -> dict[str, Array]:
        """The ideal reading of each sensor, `(steps + 1, 64, k)`."""
        every = np.arange(ROWS)
        view, draws = self.view(every), self.draws(every)
        context = Context(rows=ROWS, dt=DT, robot=self._model({}, every), pose=self.starts)
        found = {}
        for name, sensor in self.stacked.items():
            size = self.sensors[name].size(self.specified)
            state = dict(sensor.start(Context(rows=ROWS, dt=DT, robot=context.robot, pose=self.starts, size=size)))
            values = []
            for t in range(STEPS + 1):
                self.set_view(view, every, t)
                values.append(sensor.sense(view, Aim(), state, draws)[0])
            found[name] = np.array(values)
        return found

    def draws(self, rows: Ints) -> Draws:
        """Random numbers of rows, at tick 0; they do not depend on the other rows."""
        counter = np.zeros((len(rows), 3), dtype=np.uint32)
        counter[:, 0] = rows % ROWS
        return Draws(self.keys[rows % ROWS], counter)

    def _model(self, sensors: Mapping[str, SensorModel], rows: Ints) -> RobotModel:
        return RobotModel(
            rows=len(rows),
            dt=DT,
            names=[f"robot_{row}" for row in rows],
            drive=take(self.drive, rows % ROWS),
            shape=self.shapes[0],
            sensors=sensors,
            channels=self.drive.channels,
            map=self.map,
            landmarks=self.landmarks.copy(),
            landmark_ids=np.arange(1, 1 + len(self.landmarks)),
        )

    def robot(self, rows: Ints) -> RobotModel:
        """The model that rows have of themselves."""
        models = {
            name: SensorModel(
                name=name,
                sensor=take(sensor, rows % ROWS),
                mount=take(self.mounts, rows % ROWS),
                size=self.readings[name].shape[2],
                rate=None,
            )
            for name, sensor in self.stacked.items()
        }
        return self._model(models, rows)

    def view(self, rows: Ints) -> GroupView:
        """A view of the world for rows; `set_view` puts it to a step."""
        world = World(self.map, self.names, self.shapes, len(rows), robots=1, surroundings=self.surroundings)
        return GroupView(world, np.arange(len(rows), dtype=np.int64) * len(self.names), DT)

    def set_view(self, view: GroupView, rows: Ints, t: int) -> None:
        """Put a view to step `t`, with arrays of its own."""
        rows = rows % ROWS
        bodies = np.concatenate((self.poses[t][rows, None], self.others[rows]), axis=1)
        view._world.poses = np.ascontiguousarray(bodies.reshape(-1, 3))
        view.tick = np.full((len(rows), 1), t, dtype=np.int64)
        view.body_pose = self.poses[t][rows]
        view.twist = self.twists[t][rows]
        view.joints = self.joints[t][rows]
        view.joint_rates = self.rates[t][rows]
        mount = (self.mounts.x, self.mounts.y, self.mounts.heading)
        view.use(np.concatenate([np.asarray(value)[rows] for value in mount], axis=1), view.sensor)


class Session:
    """Some rows of a rig, going through its steps."""

    def __init__(self, rig: Rig, rows: Ints) -> None:
        self.rig = rig
        self.rows = rows
        self.index = rows % ROWS
        self.draws = rig.draws(rows)
        self._counter: Any = self.draws._counter
        self.robot = rig.robot(rows)
        self.view = rig.view(rows)
        self.t = 0

    def context(self, size: int = 0) -> Context:
        """The context that `start` is given."""
        return Context(rows=len(self.rows), dt=DT, robot=self.robot, pose=self.rig.starts[self.index], size=size)

    def go_to(self, t: int) -> None:
        """Put time to step `t`."""
        self.t = t
        self._counter[:, 2] = t
        self.draws.rewind()
        self.rig.set_view(self.view, self.rows, t)

    def measurements(self) -> dict[str, Measurement]:
        """The readings of this step; now and then a row has no new one, and keeps the one before."""
        stale = ((self.index + self.t) % 4 == 0) & (self.t > 0)
        stamp = (self.t - stale.astype(np.int64))[:, None]
        age = (self.t - stamp) * DT
        found = {}
        for name, values in self.rig.readings.items():
            measured = np.where(stale[:, None], values[self.t - 1][self.index], values[self.t][self.index])
            found[name] = Measurement(measured=measured, stamp=stamp.copy(), age=age.copy(), fresh=~stale[:, None])
        return found

    def estimate(self) -> Estimate:
        """The estimate that the controller is given."""
        covariance = np.zeros((len(self.rows), 3, 3))
        covariance[:] = np.diag((4e-4, 4e-4, 1e-4))
        return Estimate(pose=self.rig.estimates[self.t][self.index], covariance=covariance)

    def clock(self) -> Clock:
        """The time of this step."""
        tick = np.full((len(self.rows), 1), self.t, dtype=np.int64)
        return Clock(tick=tick, time=np.multiply(tick, DT, dtype=np.float64), dt=DT)

    def elapsed(self) -> Array:
        """Seconds since the step before `(N, 1)`, 0 at the first."""
        return np.full((len(self.rows), 1), DT if self.t else 0.0)


def bent(session: Session, size: int) -> Aim:
    """Beams that are bent a little at every step, and at every other odd one look at different times."""
    bend = 0.01 * np.sin(session.index[:, None] + np.arange(size) + session.t)
    return Aim(bearing=bend, time=-np.abs(bend) if session.t % 4 == 3 else None)
