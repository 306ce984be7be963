"""The pictures of where a robot was: over the map, in one replica or in all of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D

from amorsim.analysis.plots.figures import TRUE, draw_ellipse, legend, tidy
from amorsim.analysis.plots.pose_traces import Trace
from amorsim.analysis.run_files import RunFiles, Table
from amorsim.array_types import AnyArray
from amorsim.core.errors import RunError
from amorsim.core.files.json_files import parse_json
from amorsim.core.shapes import Shape
from amorsim.render.marks import COLOURS
from amorsim.scenario.colours import robot_colours
from amorsim.worlds.drawn import map_of, origin_of

__all__ = ["draw_all_paths", "draw_path"]


PIXELS = 900  # of the map's longer side
MOST_PATHS = 300  # of replicas that are drawn
ELLIPSES = 12  # along a path, at most


def draw_path(files: RunFiles, robot: str, replica: int | None, trace: Trace) -> Figure:
    """A robot's true and estimated paths over the map, with the uncertainty that the estimators believe."""
    figure, axis = _new_map()
    seen = [_draw_map(axis, files, files.replicas[0] if replica is None else replica), trace.true[:, 0, :2]]
    _draw_obstacles(axis, files, _table(files, "obstacles", replica))
    _draw_body(axis, files, robot, trace, _table(files, "parts", replica))
    axis.plot(*trace.true[:, 0, :2].T, **TRUE)
    dots = {"linestyle": "", "markersize": 8, "zorder": 3}
    for estimate in trace.estimates:
        path = estimate.pose[:, 0, :2]
        axis.plot(*path.T, **estimate.style)
        seen.append(path)
        if estimate.has_sigma:
            _draw_uncertainty(axis, path, estimate.covariance[:, 0, :2, :2], estimate.style, f"1σ of {estimate.name}")
    if len(trace.time):
        axis.plot(*trace.true[0, 0, :2], "o", mfc="none", mec="#111827", label="start", **dots)
        axis.plot(*trace.true[-1, 0, :2], "o", color=TRUE["color"], label="end", **dots)
        for estimate in trace.estimates:
            label = "estimated end" if estimate is trace.estimates[0] else None
            axis.plot(*estimate.pose[-1, 0, :2], "D", color=estimate.style["color"], label=label, **dots)
    _draw_events(axis, files.table("events", robot=robot, replica=replica))
    _frame(figure, axis, np.concatenate(seen))
    return figure


def draw_all_paths(files: RunFiles, robot: str, trace: Trace) -> Figure:
    """A robot's true paths in all replicas over the map, and where it ended and believed to end in each."""
    figure, axis = _new_map()
    is_same = origin_of(files.scenario.map) is None
    walls = [_draw_map(axis, files, files.replicas[0])] if is_same else []  # else no map belongs to all paths
    seen = [*walls, trace.true[..., :2].reshape(-1, 2)]
    _draw_obstacles(axis, files, _standing(_table(files, "obstacles", "all")))
    drawn = min(trace.true.shape[1], MOST_PATHS)
    label = "true" if drawn == trace.true.shape[1] else f"true, of the first {drawn} replicas"
    paths = LineCollection(
        [trace.true[:, i, :2] for i in range(drawn)],
        colors=TRUE["color"],
        linewidths=0.8,
        alpha=max(0.05, min(0.6, 8.0 / drawn)),
        zorder=2,
    )
    axis.add_collection(paths)
    axis.plot([], [], color=TRUE["color"], linewidth=1.2, label=label)
    if len(trace.time):
        dots: dict[str, Any] = {"linestyle": "", "markersize": 4, "zorder": 3, "alpha": 0.7}
        axis.plot(*np.unique(trace.true[0, :, :2], axis=0).T, "o", mfc="none", mec="#111827", label="start", **dots)
        axis.plot(*trace.true[-1, :, :2].T, "o", color=TRUE["color"], label="ends", **dots)
        for estimate in trace.estimates:
            name = "estimated ends" if len(trace.estimates) == 1 else f"ends, {estimate.style['label']}"
            ends = estimate.pose[-1, :, :2]
            axis.plot(*ends.T, "D", color=estimate.style["color"], label=name, **(dots | {"markersize": 3}))
            seen.append(ends)
    _draw_events(axis, files.table("events", robot=robot, replica="all"))
    _frame(figure, axis, np.concatenate(seen))
    return figure


def _new_map() -> tuple[Figure, Any]:
    figure = Figure(figsize=(9.0, 7.8), layout="constrained")
    axis: Any = figure.subplots()
    tidy(axis)
    axis.grid(visible=False)  # too like walls
    return figure, axis


def _frame(figure: Figure, axis: Any, seen: AnyArray) -> None:
    """Show all that was seen (n, 2), with its label."""
    seen = seen[np.isfinite(seen).all(axis=1)]
    margin = 0.02 * np.ptp(seen, axis=0).max()
    axis.set_xlim(seen[:, 0].min() - margin, seen[:, 0].max() + margin)
    axis.set_ylim(seen[:, 1].min() - margin, seen[:, 1].max() + margin)
    axis.set_aspect("equal")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    legend(figure, axis)


def _draw_events(axis: Any, events: Table) -> None:
    """Where it collided, and where it was put or carried to."""
    hits = events["kind"] == "collision"
    if hits.any():
        axis.plot(events["x"][hits], events["y"][hits], "x", color="#b91c1c", label="collision", mew=2, zorder=4)
    moved = np.isin(events["kind"], ("pose_set", "kidnapped"))
    places = np.array([place for text in events["value"][moved] if (place := _place_in(str(text))) is not None])
    if len(places):
        axis.plot(*places.T, "*", color="#7c3aed", label="put elsewhere", markersize=11, linestyle="", zorder=4)


def _place_in(text: str) -> tuple[float, float] | None:
    """The place in a pose of JSON; None if it is not a pose."""
    try:
        x, y, _ = parse_json(text)
        return float(x), float(y)
    except (ValueError, TypeError):
        return None


def _draw_uncertainty(axis: Any, path: AnyArray, covariance: AnyArray, style: dict[str, Any], label: str) -> None:
    """Ellipses of one standard deviation along a path, and at its end."""
    places = np.unique(np.linspace(0, max(len(path) - 1, 0), ELLIPSES).round().astype(int))[: len(path)].tolist()
    for place in places:
        last = place == len(path) - 1
        draw_ellipse(
            axis, path[place], covariance[place], style, alpha=0.9 if last else 0.5, label=label if last else None
        )


def _draw_map(axis: Any, files: RunFiles, replica: int) -> AnyArray:
    """Draw the map of a replica, and return its corners in the world (4, 2)."""
    found = map_of(files.scenario.map, replica)
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
    placed: AnyArray = np.sum(corners[:, :, None] * turn, axis=1) + np.array([x, y])
    return placed


def _table(files: RunFiles, name: str, replica: Any) -> Table | None:
    """A table that not every run has: of obstacles or parts."""
    return files.table(name, replica=replica) if (files.folder / f"{name}.csv").exists() else None


def _standing(recorded: Table | None) -> Table | None:
    """The lines of obstacles that never move, once each: they are the same in all replicas."""
    if recorded is None:
        return None
    names, kept = recorded["obstacle"], []
    for name in dict.fromkeys(names.tolist()):
        rows = np.flatnonzero(names == name)
        if all(np.ptp(recorded[key][rows]) == 0.0 for key in ("x", "y", "heading")):
            kept.append(rows[0])
    return {key: values[kept] if kept else values[:0] for key, values in recorded.items()}


def _fill(axis: Any, shape: Shape, pose: tuple[float, float, float], **how: Any) -> None:
    """A body's outline at a pose (x [m], y [m], heading [rad])."""
    x, y, heading = pose
    c, s = np.cos(heading), np.sin(heading)
    outline = shape.outline
    corners = (x + c * outline[:, 0] - s * outline[:, 1], y + s * outline[:, 0] + c * outline[:, 1])
    axis.fill(*corners, linewidth=0.8, zorder=2, **how)


def _draw_body(axis: Any, files: RunFiles, name: str, trace: Trace, recorded: Table | None) -> None:
    """A robot where it was at the end, with its parts such as a trailer, and the ways of these."""
    robot = next(robot for robot in files.scenario.robots if robot.name == name)
    colour = robot_colours(files.scenario.robots)[name] or COLOURS["body"]
    look = {"facecolor": colour, "edgecolor": TRUE["color"], "alpha": 0.8}
    label: str | None = "trail of " + ", ".join(part.name for part in robot.drive.parts)
    for part in robot.drive.parts if recorded is not None else ():
        assert recorded is not None
        rows = recorded["part"] == f"{name}.{part.name}"
        x, y, heading = (recorded[key][rows] for key in ("x", "y", "heading"))
        if len(x):
            axis.plot(x, y, color=TRUE["color"], linewidth=0.8, alpha=0.6, zorder=1, label=label)
            _fill(axis, part.shape, (x[-1], y[-1], heading[-1]), **look)
            label = None
    if len(trace.time):
        x, y, heading = trace.true[-1, 0]
        _fill(axis, robot.shape, (x, y, heading), **look)


def _draw_obstacles(axis: Any, files: RunFiles, recorded: Table | None) -> None:
    """The ways of the obstacles that moved, and all of them where they were at the end."""
    if recorded is None or not len(recorded["time"]):
        return
    obstacles = {obstacle.name: obstacle for obstacle in files.scenario.obstacles}
    names = recorded["obstacle"]
    label: str | None = "obstacles, at the end"
    for name in dict.fromkeys(names.tolist()):
        rows = names == name
        if name not in obstacles:
            line = int(np.argmax(rows)) + 2
            raise RunError(f"{files.folder / 'obstacles.csv'}, line {line}, obstacle: there is no obstacle {name!r}")
        x, y, heading = (recorded[key][rows] for key in ("x", "y", "heading"))
        if len(x) > 1:
            axis.plot(x, y, color=COLOURS["obstacle"], linewidth=0.6, alpha=0.5, zorder=1)
        look = {"facecolor": obstacles[name].colour or COLOURS["obstacle"], "edgecolor": COLOURS["edge"], "alpha": 0.7}
        _fill(axis, obstacles[name].shape, (x[-1], y[-1], heading[-1]), label=label, **look)
        label = None
