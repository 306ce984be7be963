"""The pictures of a run, drawn from its files: what was true, what was measured, what was believed."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Affine2D

from amorsim.analysis.figures import (
    ESTIMATED,
    MEASURED,
    TRUE,
    compare,
    legend,
    new_figure,
    save_figure,
    tidy,
    unwrapped_gaps,
)
from amorsim.analysis.files import RunFiles, Table
from amorsim.contracts import Sensor
from amorsim.core.errors import RunError
from amorsim.core.shapes import Shape
from amorsim.render.marks import COLOURS
from amorsim.scenario.colours import robot_colours

__all__ = ["plot_run"]

Array = npt.NDArray[Any]

MANY = 24  # values of a sensor from which it is drawn as an image
PIXELS = 900  # of the map's longer side


def plot_run(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    robot: str | None = None,
    replica: int | None = None,
) -> list[Path]:
    """Draw a run's pictures and return where they lie.

    ``path``, ``speed``, ``wheels``, ``heading``, ``error``, and ``sensor-<name>`` for each sensor that was written.

    Parameters
    ----------
    out
        The folder for the pictures; without it, ``plots`` in the run's.
    robot, replica
        Whose; without them, the first.

    Raises
    ------
    RunError
        If the folder is none of a run, there is no such robot or replica, or a picture cannot be written.
    """
    files = RunFiles(Path(folder))
    name = robot or files.robots[0]
    table = partial(files.table, robot=name, replica=replica)
    poses, velocities = table("poses"), table("velocities")
    drawn: dict[str, Callable[[], Figure | None]] = {
        "path": lambda: _path(files, name, poses, table("events"), replica),
        "speed": lambda: _speed(velocities),
        "wheels": lambda: _wheels(velocities),
        "heading": lambda: _heading(poses),
        "error": lambda: _error(poses),
    }
    sensors = {key: unit.sensor for r in files.scenario.robots if r.name == name for key, unit in r.sensors.items()}
    for sensor in files.sensors:
        if sensor in sensors:
            drawn[f"sensor-{sensor}"] = partial(_read_sensor, table, sensor, sensors[sensor])
    target = Path(out) if out is not None else Path(folder) / "plots"
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{target}: cannot be written ({error.strerror or error})") from None
    made = []
    for kind, draw in drawn.items():
        figure = draw()
        if figure is not None:
            save_figure(figure, target / f"{kind}.png", dpi=120)
            made.append(target / f"{kind}.png")
    return made


def _path(files: RunFiles, name: str, poses: Table, events: Table, replica: int | None) -> Figure:
    figure = Figure(figsize=(9.0, 7.5), layout="constrained")
    axis: Any = figure.subplots()
    tidy(axis)
    axis.grid(visible=False)  # too like walls
    corners = _draw_map(axis, files)
    _draw_obstacles(axis, files, _told(files, "obstacles", replica))
    _draw_body(axis, files, name, poses, _told(files, "parts", replica))
    axis.plot(poses["true_x"], poses["true_y"], **TRUE)
    axis.plot(poses["estimated_x"], poses["estimated_y"], **ESTIMATED)
    if len(poses["time"]):
        dots = {"linestyle": "", "markersize": 8, "zorder": 3}
        axis.plot(poses["true_x"][:1], poses["true_y"][:1], "o", mfc="none", mec="#111827", label="start", **dots)
        axis.plot(poses["true_x"][-1:], poses["true_y"][-1:], "o", color=TRUE["color"], label="end", **dots)
        axis.plot(
            poses["estimated_x"][-1:],
            poses["estimated_y"][-1:],
            "D",
            color=ESTIMATED["color"],
            label="believed end",
            **dots,
        )
    hits = events["kind"] == "collision"
    if hits.any():
        axis.plot(events["x"][hits], events["y"][hits], "x", color="#b91c1c", label="collision", mew=2, zorder=4)
    seen = np.vstack((corners, *(np.column_stack((poses[f"{c}_x"], poses[f"{c}_y"])) for c in ("true", "estimated"))))
    margin = 0.02 * np.ptp(seen, axis=0).max()
    axis.set_xlim(seen[:, 0].min() - margin, seen[:, 0].max() + margin)
    axis.set_ylim(seen[:, 1].min() - margin, seen[:, 1].max() + margin)
    axis.set_aspect("equal")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 6), frameon=False)
    return figure


def _draw_map(axis: Any, files: RunFiles) -> Array:
    """Draw the map, and return its corners in the world (4, 2)."""
    found = files.scenario.map
    width, height = found.size
    cell = max(found.resolution, max(width, height) / PIXELS)
    image = found.to_array(resolution=cell)
    x, y, yaw = found.origin
    axis.imshow(
        np.ma.masked_equal(image, 0),
        origin="lower",
        extent=(0.0, image.shape[1] * cell, 0.0, image.shape[0] * cell),
        cmap="gray",
        vmin=0,
        vmax=4,
        # Walls are thinner than what the picture can show: a pixel is as dark as its darkest cell.
        interpolation="nearest",
        transform=Affine2D().rotate(yaw).translate(x, y) + axis.transData,
    )
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    corners = np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])
    placed: Array = np.sum(corners[:, :, None] * turn, axis=1) + np.array([x, y])
    return placed


def _told(files: RunFiles, name: str, replica: int | None) -> Table | None:
    """A table of what not every run has: where obstacles were, or parts."""
    return files.table(name, replica=replica) if (files.folder / f"{name}.csv").exists() else None


def _fill(axis: Any, shape: Shape, pose: tuple[float, float, float], **how: Any) -> None:
    """A body's outline at a pose (x [m], y [m], heading [rad])."""
    x, y, heading = pose
    c, s = np.cos(heading), np.sin(heading)
    outline = shape.outline
    corners = (x + c * outline[:, 0] - s * outline[:, 1], y + s * outline[:, 0] + c * outline[:, 1])
    axis.fill(*corners, linewidth=0.8, zorder=2, **how)


def _draw_body(axis: Any, files: RunFiles, name: str, poses: Table, told: Table | None) -> None:
    """A robot where it was at the end, with its parts such as a trailer, and the ways of these."""
    robot = next(robot for robot in files.scenario.robots if robot.name == name)
    colour = robot_colours(files.scenario.robots)[name] or COLOURS["body"]
    look = {"facecolor": colour, "edgecolor": TRUE["color"], "alpha": 0.8}
    label: str | None = "trail of " + ", ".join(part.name for part in robot.drive.parts)
    for part in robot.drive.parts if told is not None else ():
        assert told is not None
        rows = told["part"] == f"{name}.{part.name}"
        x, y, heading = (told[key][rows] for key in ("x", "y", "heading"))
        if len(x):
            axis.plot(x, y, color=TRUE["color"], linewidth=0.8, alpha=0.6, zorder=1, label=label)
            _fill(axis, part.shape, (x[-1], y[-1], heading[-1]), **look)
            label = None
    if len(poses["time"]):
        _fill(axis, robot.shape, tuple(poses[f"true_{key}"][-1] for key in ("x", "y", "heading")), **look)


def _draw_obstacles(axis: Any, files: RunFiles, told: Table | None) -> None:
    """The ways of the obstacles that moved, and all of them where they were at the end."""
    if told is None or not len(told["time"]):
        return
    obstacles = {obstacle.name: obstacle for obstacle in files.scenario.obstacles}
    names = told["obstacle"]
    label: str | None = "obstacles, at the end"
    for name in dict.fromkeys(names.tolist()):
        rows = names == name
        x, y, heading = (told[key][rows] for key in ("x", "y", "heading"))
        if len(x) > 1:
            axis.plot(x, y, color=COLOURS["obstacle"], linewidth=0.6, alpha=0.5, zorder=1)
        look = {"facecolor": obstacles[name].colour or COLOURS["obstacle"], "edgecolor": COLOURS["edge"], "alpha": 0.7}
        _fill(axis, obstacles[name].shape, (x[-1], y[-1], heading[-1]), label=label, **look)
        label = None


def _speed(velocities: Table) -> Figure:
    figure, axes = new_figure(4, height=7.5, ratios=[3, 1, 3, 1])
    figure.suptitle("translational and rotational speed", x=0.02, ha="left")
    time = velocities["time"]
    for row, (key, label) in enumerate((("forward", "forward [m/s]"), ("turn", "turning [rad/s]"))):
        main, below = axes[2 * row : 2 * row + 2]
        compare(
            figure, main, below, (time, velocities[f"true_{key}"]), (time, velocities[f"estimated_{key}"]), ESTIMATED
        )
        main.set_ylabel(label)
    axes[-1].set_xlabel("time [s]")
    return figure


def _wheels(velocities: Table) -> Figure | None:
    body = ("true_forward", "true_left", "true_turn")
    joints = [key.removeprefix("true_") for key in velocities if key.startswith("true_") and key not in body]
    if not joints:
        return None
    figure, axes = new_figure(2 * len(joints), height=1.0 + 3.2 * len(joints), ratios=[3, 1] * len(joints))
    figure.suptitle("joints: mean rate over a step, true and by the encoders", x=0.02, ha="left")
    time = velocities["time"]
    for row, joint in enumerate(joints):
        main, below = axes[2 * row : 2 * row + 2]
        true, measured = velocities[f"true_{joint}"], velocities[f"measured_{joint}"]
        compare(figure, main, below, (time, true), (time, measured), MEASURED)
        main.set_ylabel(f"{joint.replace('_', ' ')} [rad/s]")
    axes[-1].set_xlabel("time [s]")
    return figure


def _heading(poses: Table) -> Figure:
    figure, (main, below) = new_figure(2, ratios=[3, 1])
    figure.suptitle("heading, turns counted", x=0.02, ha="left")
    true, estimated = (np.degrees(np.unwrap(poses[f"{channel}_heading"])) for channel in ("true", "estimated"))
    compare(figure, main, below, (poses["time"], true), (poses["time"], estimated), ESTIMATED)
    main.set_ylabel("heading [°]")
    below.set_xlabel("time [s]")
    return figure


def _error(poses: Table) -> Figure:
    figure, (position, heading) = new_figure(2, height=5.5)
    figure.suptitle("estimated less true", x=0.02, ha="left")
    distance = np.hypot(poses["true_x"] - poses["estimated_x"], poses["true_y"] - poses["estimated_y"])
    turn = np.degrees(poses["estimated_heading"] - poses["true_heading"])
    position.plot(poses["time"], distance, color=ESTIMATED["color"])
    position.set_ylabel("position [m]")
    heading.plot(poses["time"], unwrapped_gaps((turn + 180.0) % 360.0 - 180.0), color=ESTIMATED["color"])
    heading.set_ylabel("heading [°]")
    heading.set_xlabel("time [s]")
    return figure


def _read_sensor(table: Callable[[str], Table], name: str, sensor: Sensor) -> Figure | None:
    readings = table(f"sensors/{name}")
    if not len(readings["time"]):
        return None
    size = sum(key.startswith("true_") for key in readings)
    true, measured = (np.array([readings[f"{channel}_{i}"] for i in range(size)]) for channel in ("true", "measured"))
    true[~np.isfinite(true)] = np.nan  # no return
    measured[~np.isfinite(measured)] = np.nan
    unit, columns = sensor.unit, sensor.columns()
    if columns:
        return _columns(name, columns, readings["stamp"], true, measured)
    if unit.startswith("rad"):
        true, measured, unit = np.degrees(true), np.degrees(measured), unit.replace("rad", "°", 1)
    if size > MANY:
        return _scans(name, unit, readings["stamp"], true, measured)
    if size <= 2:
        return _values(name, unit, readings["stamp"], true, measured)
    return _elements(name, unit, readings["stamp"], true, measured)


def _values(name: str, unit: str, time: Array, true: Array, measured: Array) -> Figure:
    """A panel for each of one or two values, and their differences."""
    size = len(true)
    figure, axes = new_figure(2 * size, height=1.6 + 3.2 * size, ratios=[3, 1] * size)
    figure.suptitle(name, x=0.02, ha="left")
    for i in range(size):
        main, below = axes[2 * i : 2 * i + 2]
        one, other = true[i], measured[i]
        if unit == "°":
            with np.errstate(invalid="ignore"):
                nearest = one + (other - one + 180.0) % 360.0 - 180.0
            compare(figure, main, below, (time, unwrapped_gaps(one)), (time, unwrapped_gaps(nearest)), MEASURED)
        else:
            compare(figure, main, below, (time, one), (time, other), MEASURED)
        main.set_ylabel(f"{name} {i} [{unit}]" if size > 1 else f"{name} [{unit}]")
    axes[-1].set_xlabel("time [s]")
    return figure


def _columns(name: str, columns: Mapping[str, str], time: Array, true: Array, measured: Array) -> Figure:
    """A panel for each column of a table: what stands in all its lines, as dots; one line alone, as a curve."""
    lines = len(true) // len(columns)
    figure = Figure(figsize=(9.0, 1.2 + 1.7 * len(columns)), layout="constrained")
    axes: Any = figure.subplots(len(columns), 1, squeeze=False, sharex=True).ravel()
    for i, (column, unit) in enumerate(columns.items()):
        axis = axes[i]
        tidy(axis)
        of_true, of_measured = true[i :: len(columns)].T, measured[i :: len(columns)].T
        if unit == "id":  # an empty slot is none
            axis.yaxis.set_major_locator(MaxNLocator(integer=True))
            of_true, of_measured = (np.where(values < 0, np.nan, values) for values in (of_true, of_measured))
        if unit.startswith("rad"):
            of_true, of_measured, unit = np.degrees(of_true), np.degrees(of_measured), unit.replace("rad", "°", 1)
        for values, style, size in ((of_true, TRUE, 5.0), (of_measured, MEASURED, 2.5)):
            how = style if lines == 1 else {"color": style["color"], "linestyle": "", "marker": ".", "markersize": size}
            drawn = axis.plot(time, values, **{key: value for key, value in how.items() if key != "label"})
            drawn[0].set_label(style["label"])
        axis.set_ylabel(column if unit in ("", "id") else f"{column} [{unit}]", fontsize=9)
    axes[-1].set_xlabel("time [s]")
    figure.suptitle(name, x=0.02, ha="left")
    legend(figure, axes[0])
    return figure


def _elements(name: str, unit: str, time: Array, true: Array, measured: Array) -> Figure:
    """A ring of a few elements: a small panel for each."""
    columns = 4
    rows = -(-len(true) // columns)
    figure = Figure(figsize=(11.0, 1.2 + 1.9 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    for i, axis in enumerate(axes):
        if i >= len(true):
            axis.axis("off")
            continue
        tidy(axis)
        axis.plot(time, true[i], **(TRUE | {"linewidth": 1.6}))
        axis.plot(time, measured[i], **(MEASURED | {"linewidth": 1.0}))
        axis.set_title(str(i), fontsize=9, loc="left")
        axis.tick_params(labelsize=8)
    figure.suptitle(name, x=0.02, ha="left")
    figure.supxlabel("time [s]", fontsize=10)
    figure.supylabel(f"{name} [{unit}]", fontsize=10)
    legend(figure, axes[0])
    return figure


def _scans(name: str, unit: str, time: Array, true: Array, measured: Array) -> Figure:
    """A ring of many beams as images, beam over time: true, measured, and their difference."""
    figure = Figure(figsize=(9.0, 8.5), layout="constrained")
    axes: Any = figure.subplots(3, 1, sharex=True, sharey=True)
    difference = measured - true
    low, high = _range_of(np.concatenate((true, measured)))
    _, limit = _range_of(np.abs(difference))
    last = float(time[-1]) if time[-1] > time[0] else float(time[0]) + 1.0
    for axis, values, title, how in (
        (axes[0], true, "true", {"cmap": "viridis", "vmin": low, "vmax": high}),
        (axes[1], measured, "measured", {"cmap": "viridis", "vmin": low, "vmax": high}),
        (axes[2], difference, "measured less true", {"cmap": "coolwarm", "vmin": -limit, "vmax": limit}),
    ):
        axis.set_facecolor("white")
        image = axis.imshow(
            np.ma.masked_invalid(values),
            aspect="auto",
            origin="lower",
            extent=(float(time[0]), last, -0.5, len(true) - 0.5),
            interpolation="nearest",
            **how,
        )
        axis.set_ylabel("beam")
        axis.set_title(title, fontsize=10, loc="left")
        figure.colorbar(image, ax=axis, label=f"[{unit}]", pad=0.01)
    axes[2].set_xlabel("time [s]      white: no return")
    figure.suptitle(name, x=0.02, ha="left")
    return figure


def _range_of(values: Array) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    return low, high if high > low else low + 1e-9
