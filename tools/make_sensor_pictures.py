"""Makes the picture of docs/explanation/sensors.md: what ideal devices read, in runs of the simulator itself.

It is looked at and not compared, so make it again only where it should look different::

    python tools/make_sensor_pictures.py
"""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle
from PIL import Image

import amorsim as am
from amorsim import sensors

__all__ = ["make"]

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
COLOURS = 96
TRUE, OTHER = "#1b7f5c", "#2f6fde"

Array = npt.NDArray[np.float64]


def _empty(size: float) -> am.Map:
    return am.Map.from_segments(np.empty((0, 4)), resolution=0.01, extent=(-size, -size, size, size))


def _simulation(
    sensor: am.Sensor,
    *,
    world: am.Map,
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
    radius: float = 0.2,
    **more: Any,
) -> am.Simulation:
    """A round robot with one sensor, driven by hand."""
    dt = more.pop("dt", 0.1)
    mount = more.pop("mount", am.Mount())
    robot = am.Robot(
        name="rover",
        shape=am.Shape.circle(radius),
        drive=am.drives.Differential(wheel_radius_left=0.0825, wheel_radius_right=0.0825, track=0.33, rate_max=1e3),
        sensors={"eye": am.MountedSensor(sensor=sensor, mount=mount)},
        controller=am.controllers.Manual(),
        pose=am.Pose(x=pose[0], y=pose[1], heading=pose[2]),
    )
    return am.Simulation(am.Scenario(map=world, robots=[robot], dt=dt, **more))


def _true(sim: am.Simulation) -> Array:
    return sim.robot("rover").readings["eye"].true


def _infrared(axis: Any) -> None:
    """A flat wall and a thin post ahead of a Khepera's sensor, farther and farther off."""
    distances = np.linspace(0.002, 0.065, 64)
    wall, post = [], []
    for d in distances:
        world = am.Map.from_segments(np.array([(d, -1.0, d, 1.0)]), resolution=1e-4, extent=(-1.0, -1.0, 1.0, 1.0))
        wall.append(_true(_simulation(sensors.Infrared(), world=world, radius=0.001))[0])
        thin = am.Obstacle(name="post", shape=am.Shape.circle(2e-4), pose=am.Pose(x=d + 2e-4))
        post.append(_true(_simulation(sensors.Infrared(), world=_empty(1.0), radius=0.001, obstacles=[thin]))[0])
    axis.plot(distances * 1000, wall, color=TRUE, label="a flat wall")
    axis.plot(distances * 1000, post, color=OTHER, ls="--", label="a thin post")
    axis.plot([12, 20, 32, 44, 58], [900, 750, 650, 160, 40], "o", color="#111827", ms=4, label="published, ahead")
    axis.set(xlabel="distance [mm]", ylabel="counts", title="infrared")
    axis.legend(frameon=False, fontsize=8)


def _light(axis: Any) -> None:
    """A lamp at three distances, all about a Khepera's sensor."""
    angles = np.linspace(-math.pi, math.pi, 181)
    for d, colour, style in ((0.05, "#111827", "-"), (0.1, TRUE, "--"), (0.2, OTHER, ":")):
        values = []
        for angle in angles:
            lamp = am.Light(x=d * math.cos(angle), y=d * math.sin(angle))
            values.append(_true(_simulation(sensors.Light(), world=_empty(1.0), radius=0.01, lights=[lamp]))[0])
        axis.plot(np.degrees(angles), values, color=colour, ls=style, label=f"{d * 1000:.0f} mm")
    axis.set(xlabel="lamp's bearing [°]", ylabel="counts", title="light", ylim=(0, 540), xticks=range(-180, 181, 60))
    axis.legend(frameon=False, fontsize=8)


def _imu(axis: Any) -> None:
    """Stop and go and a circle, felt ahead of the axle."""
    sim = _simulation(sensors.Imu(), world=_empty(50.0), dt=0.02, mount=am.Mount(x=0.3))
    felt, times = [], []
    for step in range(300):
        t = step * 0.02
        forward = min(t, 1.0) if t < 4.0 else max(0.0, 1.0 - (t - 4.0))
        turn = 1.2 if 2.0 <= t < 4.0 else 0.0
        sim.robot("rover").drive(forward=forward, turn=turn)
        sim.step()
        felt.append(_true(sim).copy())
        times.append(sim.time)
    felt = np.array(felt)
    axis.plot(times, np.clip(felt[:, 0], -1.6, 1.6), color=TRUE, label="ahead")
    axis.plot(times, np.clip(felt[:, 1], -1.6, 1.6), color=OTHER, ls="--", label="left")
    axis.set(xlabel="time [s]", ylabel="specific force [m/s²]", title="imu, 0.3 m ahead of the axle")
    axis.legend(frameon=False, fontsize=8)


def _scene() -> tuple[am.Simulation, am.Simulation]:
    """The same robot with a finder of marks and with a camera, in a room with posts, a crate and marks."""
    walls = np.array([(0, 0, 6, 0), (6, 0, 6, 4), (6, 4, 0, 4), (0, 4, 0, 0), (3.2, 2.6, 3.2, 4.0)], dtype=float)
    world = am.Map.from_segments(walls, resolution=0.01)
    things = {
        "obstacles": [
            am.Obstacle(name="red", shape=am.Shape.circle(0.3), pose=am.Pose(x=2.8, y=1.2), colour="red", fiducial=20),
            am.Obstacle(
                name="green", shape=am.Shape.circle(0.25), pose=am.Pose(x=4.4, y=1.2), colour="green", height=0.6
            ),
            am.Obstacle(
                name="crate", shape=am.Shape.rectangle(0.7, 0.5), pose=am.Pose(x=4.4, y=2.2, heading=0.5), colour="blue"
            ),
        ],
        "landmarks": [
            am.Landmark(id=1, x=5.95, y=0.6),
            am.Landmark(id=2, x=5.95, y=2.6),
            am.Landmark(id=3, x=3.2, y=2.55),
            am.Landmark(id=4, x=4.8, y=3.9),
            am.Landmark(id=5, x=1.6, y=3.9),
        ],
    }
    pose, mount = (0.7, 1.7, 0.0), am.Mount(x=0.1)
    finder = _simulation(sensors.Fiducial(fov=math.pi), world=world, pose=pose, mount=mount, **things)
    camera = _simulation(sensors.Camera(), world=world, pose=pose, mount=mount, **things)
    return finder, camera


def _view(axis: Any, sim: am.Simulation) -> None:
    """From above: what the finder reads as lines of sight, what it does not see in grey."""
    scenario = sim.scenario
    for x0, y0, x1, y1 in scenario.map.segments:
        axis.plot([x0, x1], [y0, y1], color="#2b2f36", lw=1.5)
    for obstacle in scenario.obstacles:
        c, s = math.cos(obstacle.pose.heading), math.sin(obstacle.pose.heading)
        outline = obstacle.shape.outline @ np.array([[c, s], [-s, c]]) + [obstacle.pose.x, obstacle.pose.y]
        axis.add_patch(Polygon(outline, color=obstacle.colour, alpha=0.7, lw=0))
    x, y, _ = sim.true_pose[0]
    axis.add_patch(Circle((x, y), 0.2, color="#bfe3d6", ec=TRUE))
    seen = set()
    for distance, bearing, number in _true(sim).reshape(-1, 3):
        if number >= 0:
            place = (x + 0.1 + distance * math.cos(bearing), y + distance * math.sin(bearing))
            axis.plot([x + 0.1, place[0]], [y, place[1]], color=TRUE, lw=1)
            axis.text(place[0] + 0.08, place[1] + 0.1, f"{number:.0f}", fontsize=8, color=TRUE)
            seen.add(round(place[0], 6))
    for mark in scenario.landmarks:
        colour = "#7b4fc9" if round(mark.x, 6) in seen else "#c0c5cb"
        axis.plot(mark.x, mark.y, "o", color=colour, ms=6)
    axis.set(aspect="equal", xlim=(-0.1, 6.3), ylim=(-0.1, 4.1), xlabel="x [m]", ylabel="y [m]", title="fiducial")


def _image(axis: Any, sim: am.Simulation) -> None:
    """The blobs as boxes in the camera's image."""
    camera = sim.scenario.robots[0].sensors["eye"].sensor
    assert isinstance(camera, sensors.Camera)
    axis.add_patch(Rectangle((0, 0), camera.width, camera.height, color="#eef0f2", lw=0))
    blobs = [line for line in _true(sim).reshape(-1, 7) if line[0] >= 0]
    for colour, left, right, top, bottom, distance, _ in reversed(blobs):
        box = (left, top), right + 1 - left, bottom + 1 - top
        axis.add_patch(Rectangle(*box, color=camera.colours[int(colour)], alpha=0.7, lw=0))
        axis.text(0.5 * (left + right), top - 3, f"{distance:.2f} m", fontsize=8, ha="center")
    axis.set(
        xlim=(0, camera.width), ylim=(camera.height, 0), aspect="equal", xlabel="column", ylabel="row", title="camera"
    )


def _dash(axis: Any) -> None:
    axis.spines[["top", "right"]].set_visible(False)
    axis.title.set_fontsize(10)


def make(folder: Path) -> None:
    """Write the picture into `folder`."""
    figure = Figure(figsize=(10.0, 9.0), layout="constrained")
    axes: Any = figure.subplot_mosaic([["infrared", "light"], ["fiducial", "camera"], ["imu", "imu"]])
    _infrared(axes["infrared"])
    _light(axes["light"])
    finder, camera = _scene()
    _view(axes["fiducial"], finder)
    _image(axes["camera"], camera)
    _imu(axes["imu"])
    for axis in axes.values():
        _dash(axis)
    with io.BytesIO() as held:
        figure.savefig(held, dpi=110, format="png")
        with Image.open(held) as image:
            small = image.convert("RGB").quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            small.save(folder / "sensors.png", optimize=True)


if __name__ == "__main__":
    make(PICTURES)
