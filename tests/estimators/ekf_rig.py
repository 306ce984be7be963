"""An extended Kalman filter over rows, given readings by hand."""

from __future__ import annotations

import math

import numpy as np

import amorsim as am
from amorsim.contracts import Context, Draws, Measurement, Mount, RobotModel, SensorModel
from amorsim.core.rows import stack
from amorsim.core.shapes import Shape
from amorsim.drives import Differential
from amorsim.sensors import Compass, Encoder, Fiducial, Gps, Gyro

TRACK = 0.4
RADIUS = 0.1
COUNTS = 1000.0
DT = 0.1
SENSORS = {
    "encoder": Encoder(counts_per_revolution=COUNTS),
    "fiducial": Fiducial(slots=4, fov=2.0 * math.pi),
    "gps": Gps(),
    "compass": Compass(),
    "gyro": Gyro(),
}
_NOTHING = {"fiducial": [np.inf, np.inf, -1.0] * 4, "gps": [np.nan] * 2, "compass": [np.nan], "gyro": [np.nan]}


class Filter:
    """An estimator over rows, stepped with joints [rad] and what some sensors measure."""

    def __init__(
        self, estimator, rows=1, start=(0.0, 0.0, 0.0), mounts=None, marks=((1, 5.0, 0.0),), dt=DT, drive=None
    ):
        drive = drive or Differential(wheel_radius_left=RADIUS, wheel_radius_right=RADIUS, track=TRACK, rate_max=1000.0)
        estimators = list(estimator) if isinstance(estimator, (list, tuple)) else [estimator] * rows
        self.rows, self.dt = len(estimators), dt
        mounts = mounts or {}
        self.robot = RobotModel(
            rows=self.rows,
            dt=dt,
            drive=stack([drive] * self.rows),
            channels=drive.channels,
            shape=Shape.circle(0.2),
            sensors={
                name: SensorModel(
                    name=name,
                    sensor=stack([sensor] * self.rows),
                    mount=stack([mounts.get(name, Mount())] * self.rows),
                    size=sensor.size(drive),
                    rate=None,
                )
                for name, sensor in SENSORS.items()
            },
            landmarks=np.array([[x, y] for _, x, y in marks]).reshape(-1, 2) if marks else None,
            landmark_ids=np.array([number for number, _, _ in marks], dtype=np.int64) if marks else None,
        )
        self.estimator = stack(estimators)
        pose = np.array(np.broadcast_to(np.array(start, dtype=float), (self.rows, 3)))
        self.state = dict(self.estimator.start(Context(rows=self.rows, dt=dt, robot=self.robot, pose=pose)))
        self.draws = Draws(np.zeros(self.rows, dtype=np.uint64), np.zeros((self.rows, 3), dtype=np.uint32))
        self.joints = np.zeros((self.rows, 2))
        self.has_started = False

    def step(self, turned=(0.0, 0.0), command=(0.0, 0.0), age=0.0, **values):
        """One update after the wheels have turned [rad]; sensors that are not named have nothing new."""
        if self.has_started:
            self.joints = self.joints + np.array(turned)
        readings = {}
        for name in SENSORS:
            given = values.get(name)
            if name == "encoder":
                given = self.joints / (2.0 * math.pi) * COUNTS
            fresh = given is not None
            filled = np.array(
                np.broadcast_to(
                    _NOTHING[name] if given is None else np.asarray(given, float),
                    (self.rows, self.robot.sensors[name].size),
                )
            )
            readings[name] = Measurement(
                measured=filled,
                stamp=np.zeros((self.rows, 1), dtype=np.int64),
                age=np.full((self.rows, 1), age if name != "encoder" else 0.0),
                fresh=np.full((self.rows, 1), fresh),
            )
        elapsed = np.full((self.rows, 1), self.dt if self.has_started else 0.0)
        self.has_started = True
        commands = np.array(np.broadcast_to(np.asarray(command, float), (self.rows, 2)))
        return self.estimator.update(self.robot, readings, commands, elapsed, self.state, self.draws)

    def beliefs(self):
        return self.estimator.beliefs(self.state)


def seen(pose, marks, mount=(0.0, 0.0, 0.0)):
    """What an ideal fiducial of four slots reads of marks (id, x, y) from a pose."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x, y = pose[0] + c * mount[0] - s * mount[1], pose[1] + s * mount[0] + c * mount[1]
    found = []
    for number, mark_x, mark_y in marks:
        bearing = math.remainder(math.atan2(mark_y - y, mark_x - x) - pose[2] - mount[2], 2.0 * math.pi)
        found += [math.hypot(mark_x - x, mark_y - y), bearing, float(number)]
    return found + [np.inf, np.inf, -1.0] * (4 - len(marks))


ASIDE = np.array([[0.0, -1.0], [1.0, 0.0]])


def corrected_by_arc(mean, step, covariance):
    """The mean after a correction by (x, y, turn) along an arc, and the covariance of x, y and heading about it.

    In complex numbers an arc is the integral of its direction; a shift u with a turn t leads about t / 2 times u aside.
    """
    x, y, turn = step[:3]
    way = (x + 1j * y) * (np.exp(1j * turn) - 1.0) / (1j * turn) if turn else x + 1j * y
    carried = np.eye(3)
    carried[:2, 2] = ASIDE @ [way.real, way.imag]
    covariance = carried @ covariance[:3, :3] @ carried.T
    both = covariance[:2, 2]
    covariance[:2, :2] += ASIDE @ (covariance[2, 2] * covariance[:2, :2] + 2.0 * np.outer(both, both)) @ ASIDE.T / 4.0
    return np.array([mean[0] + way.real, mean[1] + way.imag, am.wrap_angle(mean[2] + turn)]), covariance
