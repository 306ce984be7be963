"""The pictures of a run, drawn from its files: what was true, what was measured, what was believed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from amorsim.analysis.files import RunFiles, Table
from amorsim.scenario.read import load

__all__ = ["plot_run"]

Array = npt.NDArray[Any]

# One colour for each channel everywhere, and a dash of its own, for those who do not see colours.
TRUE = {"color": "#1b7f5c", "linestyle": "-", "linewidth": 1.6, "label": "true"}
MEASURED = {"color": "#d97706", "linestyle": ":", "linewidth": 1.2, "label": "measured"}
ESTIMATED = {"color": "#2f6fde", "linestyle": "--", "linewidth": 1.4, "label": "estimated"}


def plot_run(
    folder: Path, *, out: Path | None = None, robot: str | None = None, replica: int | None = None
) -> list[Path]:
    """Draw a run's pictures and return where they lie.

    ``path``, ``speed``, ``wheels``, ``heading``, ``error``, and ``sensor-<name>`` for each sensor that was written.

    Raises
    ------
    RunError
        If the folder is none of a run, or there is no such robot.
    """
    files = RunFiles(folder)
    name = robot or files.robots[0]
    target = out or Path(folder) / "plots"
    target.mkdir(parents=True, exist_ok=True)
    poses = files.table("poses", robot=name, replica=replica)
    velocities = files.table("velocities", robot=name, replica=replica)
    figures = {
        "path": _path(files, poses),
        "speed": _speed(velocities),
        "wheels": _wheels(velocities),
        "heading": _heading(poses),
        "error": _error(poses),
    }
    for sensor in files.sensors:
        readings = files.table(f"sensors/{sensor}", robot=name, replica=replica)
        if len(readings["time"]):
            figures[f"sensor-{sensor}"] = _sensor(sensor, readings)
    made = []
    for kind, figure in figures.items():
        path = target / f"{kind}.png"
        figure.savefig(path, dpi=120)
        made.append(path)
    return made


def _figure(rows: int = 1, height: float = 4.5) -> tuple[Figure, list[Any]]:
    # Figures of their own, without pyplot: no window system is asked for, and nothing is kept open.
    with matplotlib.rc_context({"axes.spines.top": False, "axes.spines.right": False, "axes.grid": True}):
        figure = Figure(figsize=(9.0, height), layout="constrained")
        axes = figure.subplots(rows, 1, squeeze=False, sharex=True)
    for axis in axes[:, 0]:
        axis.grid(color="#e5e7eb", linewidth=0.8)
        axis.set_axisbelow(True)
    return figure, list(axes[:, 0])


def _path(files: RunFiles, poses: Table) -> Figure:
    figure, (axis,) = _figure(height=7.0)
    map_ = load(files.folder / "scenario.toml").map
    width, height = map_.size
    cell = max(map_.resolution, max(width, height) / 1200.0)
    x, y, yaw = map_.origin
    image = map_.to_array(resolution=cell)
    extent = (0.0, image.shape[1] * cell, 0.0, image.shape[0] * cell)
    from matplotlib.transforms import Affine2D

    placed = Affine2D().rotate(yaw).translate(x, y) + axis.transData
    axis.imshow(
        np.ma.masked_equal(image, 0), origin="lower", extent=extent, cmap="gray", vmin=0, vmax=4, transform=placed
    )
    axis.plot(poses["true_x"], poses["true_y"], **TRUE)
    axis.plot(poses["estimated_x"], poses["estimated_y"], **ESTIMATED)
    axis.plot(poses["true_x"][:1], poses["true_y"][:1], "o", color="#111827", label="start")
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]])
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    world = corners @ turn + (x, y)
    seen = np.vstack(
        (
            world,
            np.column_stack((poses["true_x"], poses["true_y"])),
            np.column_stack((poses["estimated_x"], poses["estimated_y"])),
        )
    )
    axis.set_xlim(seen[:, 0].min() - 0.2, seen[:, 0].max() + 0.2)
    axis.set_ylim(seen[:, 1].min() - 0.2, seen[:, 1].max() + 0.2)
    axis.set_aspect("equal")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    axis.set_title("path")
    axis.legend(loc="upper right")
    return figure


def _speed(velocities: Table) -> Figure:
    figure, (forward, turn) = _figure(2, 5.5)
    time = velocities["time"]
    forward.plot(time, velocities["true_forward"], **TRUE)
    forward.plot(time, velocities["estimated_forward"], **ESTIMATED)
    forward.set_ylabel("forward [m/s]")
    turn.plot(time, velocities["true_turn"], **TRUE)
    turn.plot(time, velocities["estimated_turn"], **ESTIMATED)
    turn.set_ylabel("turning [rad/s]")
    return _finish(figure, [forward, turn], "translational and rotational speed")


def _wheels(velocities: Table) -> Figure:
    body = ("true_forward", "true_left", "true_turn")
    joints = [key.removeprefix("true_") for key in velocities if key.startswith("true_") and key not in body]
    figure, axes = _figure(max(1, len(joints)), 1.0 + 2.3 * max(1, len(joints)))
    for axis, joint in zip(axes, joints, strict=False):
        axis.plot(velocities["time"], velocities[f"measured_{joint}"], **MEASURED)
        axis.plot(velocities["time"], velocities[f"true_{joint}"], **TRUE)
        axis.set_ylabel(f"{joint.replace('_', ' ')} [rad/s]")
    return _finish(figure, axes, "wheels: true rate, and as the encoders say")


def _heading(poses: Table) -> Figure:
    figure, axes = _figure()
    for channel, style in (("true", TRUE), ("estimated", ESTIMATED)):
        axes[0].plot(poses["time"], np.degrees(np.unwrap(poses[f"{channel}_heading"])), **style)
    axes[0].set_ylabel("heading [°], turns counted")
    return _finish(figure, axes, "heading")


def _error(poses: Table) -> Figure:
    figure, axes = _figure(2, 5.5)
    distance = np.hypot(poses["true_x"] - poses["estimated_x"], poses["true_y"] - poses["estimated_y"])
    turn = poses["estimated_heading"] - poses["true_heading"]
    axes[0].plot(poses["time"], distance, color=ESTIMATED["color"])
    axes[0].set_ylabel("position [m]")
    axes[1].plot(poses["time"], np.degrees((turn + np.pi) % (2 * np.pi) - np.pi), color=ESTIMATED["color"])
    axes[1].set_ylabel("heading [°]")
    return _finish(figure, axes, "estimated less true", legend=False)


def _sensor(name: str, readings: Table) -> Figure:
    size = sum(key.startswith("true_") for key in readings)
    if size > 24:
        return _scan(name, readings, size)
    columns = min(size, 4)
    rows = -(-size // columns)
    figure = Figure(figsize=(9.0, max(3.5, 1.9 * rows)), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True).ravel()
    for i, axis in enumerate(axes):
        if i >= size:
            axis.axis("off")
            continue
        axis.grid(color="#e5e7eb", linewidth=0.8)
        axis.plot(readings["time"], _finite(readings[f"measured_{i}"]), **MEASURED)
        axis.plot(readings["stamp"], _finite(readings[f"true_{i}"]), **TRUE)
        if size > 1:
            axis.set_title(f"{name} {i}", fontsize=9)
        axis.tick_params(labelsize=8)
    axes[0].legend(fontsize=8)
    figure.suptitle(name)
    figure.supxlabel("time [s]")
    return figure


def _scan(name: str, readings: Table, size: int) -> Figure:
    """A ring of many beams as an image, beam over time: true, measured, and their difference."""
    figure = Figure(figsize=(9.0, 8.0), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True, sharey=True)
    true = np.array([readings[f"true_{i}"] for i in range(size)])
    measured = np.array([readings[f"measured_{i}"] for i in range(size)])
    with np.errstate(invalid="ignore"):  # no return on either side
        difference = measured - true
    time = readings["time"]
    extent = (float(time[0]), float(time[-1]) if len(time) > 1 else float(time[0]) + 1.0, -0.5, size - 0.5)
    finite = np.abs(difference[np.isfinite(difference)])
    limit = max(float(finite.max(initial=0.0)), 1e-9)
    for axis, values, title, how in (
        (axes[0], true, "true [m]", {"cmap": "viridis"}),
        (axes[1], measured, "measured [m]", {"cmap": "viridis"}),
        (axes[2], difference, "measured less true [m]", {"cmap": "coolwarm", "vmin": -limit, "vmax": limit}),
    ):
        image = axis.imshow(
            np.ma.masked_invalid(values), aspect="auto", origin="lower", extent=extent, interpolation="nearest", **how
        )
        axis.set_ylabel("beam")
        axis.set_title(f"{name}: {title}", fontsize=10)
        figure.colorbar(image, ax=axis)
    axes[2].set_xlabel("time [s]")
    return figure


def _finite(values: Array) -> Array:
    return np.where(np.isfinite(values), values, np.nan)


def _finish(figure: Figure, axes: list[Any], title: str, *, legend: bool = True) -> Figure:
    axes[0].set_title(title)
    axes[-1].set_xlabel("time [s]")
    if legend:
        axes[0].legend()
    return figure
