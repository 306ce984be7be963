"""How sure estimators with lasers are, by what they are off: docs/explanation/consistency.md."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import amorsim as am

Array = npt.NDArray[np.float64]

MAZE = '{ generate = "maze", seed = 5, size = [10.0, 8.0], corridor = 1.3, loops = 0.1 }'
SCENARIO = f"""
format = 1

[world]
map = {MAZE}

[simulation]
dt = 0.1
duration = 60.0
seed = 1

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = {{ x = 0.75, y = 0.75, heading_deg = 90.0 }}
controller = {{ use = "wander", speed = 0.4 }}
knowledge = {{ map = {MAZE} }}
sensors = {{ sonar = false }}
ground = [{{ use = "diffusion", variance_per_length = 1e-5 }}]

[robots.errors.drive]
wheel_radius_left = {{ scale = 1.003 }}
track = {{ scale = 1.02 }}

[robots.estimators]
dead_reckoning = false
scan_matching = {{ use = "scan_matching", wheel_variance = 1e-4, range_std = 0.005 }}
monte_carlo = {{ use = "monte_carlo", wheel_variance = 1e-4 }}

[robots.estimators.grid_slam]
use = "grid_slam"
wheel_variance = 1e-4
range_std = 0.005
width = 14.0
height = 12.0
center_x = 5.0
center_y = 4.0

[robots.estimators.graph_slam]
use = "graph_slam"
wheel_variance = 1e-4
range_std = 0.005
width = 14.0
height = 12.0
center_x = 5.0
center_y = 4.0
"""


def nees_of(frame: am.Frame, name: str) -> Array:
    """The NEES of an estimator in each of a frame's rows."""
    pose, covariance = frame.estimates[name]
    error = pose - frame.true_pose
    error[:, 2] = am.wrap_angle(error[:, 2])
    return am.analysis.nees(error, covariance)


@pytest.mark.long
def test_errors_are_about_as_large_as_covariances_say(tmp_path: Path) -> None:
    """Right is a mean NEES of 3. With the particles' spread alone grid SLAM had 41 after a minute in this maze."""
    path = tmp_path / "maze.toml"
    path.write_text(SCENARIO)
    sim = am.Simulation(am.load(path), replicas=30)
    sim.run(40.0)
    frame = sim.frames()[0]
    for name in frame.estimates:
        assert nees_of(frame, name).mean() < 6.0, name
    # The field's cells are 0.05 m; it is 16 mm, if all of a wall is at the distance 0.
    off = frame.estimates["monte_carlo"].pose - frame.true_pose
    assert np.hypot(off[:, 0], off[:, 1]).mean() < 0.014
    # With the whole of what may be added to its edges, graph SLAM had 0.4 where loops have closed.
    sim.run(20.0)
    (frame,) = sim.frames()
    has_loops = frame.beliefs["graph_slam"]["graph_loops"] > 0
    assert 2.0 < nees_of(frame, "graph_slam")[has_loops].mean() < 6.0
