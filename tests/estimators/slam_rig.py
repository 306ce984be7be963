"""Robots that follow a way through a small room with a niche and a column, and what estimators make of their scans."""

from __future__ import annotations

import numpy as np

import amorsim as am
from amorsim.controllers import Pursuit
from amorsim.sensors import Laser
from tests import building
from tests.kernels.matching.scenes import room

WAY = ((1.0, 1.0), (3.6, 1.1), (3.6, 2.6), (1.0, 2.6))
OFF = {"drive.wheel_radius_left": am.Deviation(scale=1.01), "drive.track": am.Deviation(scale=1.03)}


def scenario(world=None, pose=(1.0, 1.0, 0.0), way=WAY, beams=91, std=0.005, errors=OFF, speed=0.4, **estimators):
    """A robot whose wheels are off follows a way round; the first estimator leads it."""
    noise = building.chain(am.noise.Gaussian(std=std)) if std else ()
    laser = am.MountedSensor(sensor=Laser(beams=beams), mount=am.Mount(x=0.1, y=0.02, heading=0.1), noise=noise)
    robot = building.robot(
        pose=am.Pose(x=pose[0], y=pose[1], heading=pose[2]),
        controller=Pursuit(waypoints=way, loop=True, speed=speed, lookahead=0.4),
        sensors={"laser": laser, "encoder": building.encoder()},
        shape=am.Shape.circle(0.15),
        estimators=estimators,
        errors=dict(errors),
    )
    return am.Scenario(map=world or room(), robots=[robot], seed=4)


def errors_of(sim, duration):
    """Distances [m] of each estimator's pose from the true one at every step, by name; replicas in columns."""
    found = {}
    for _ in range(round(duration / sim.dt)):
        sim.step()
        frame = sim.frames()[0]
        for name, estimate in frame.estimates.items():
            off = estimate.pose[:, :2] - frame.true_pose[:, :2]
            found.setdefault(name, []).append(np.hypot(off[:, 0], off[:, 1]))
    return {name: np.array(rows) for name, rows in found.items()}
