"""The intentions of a robot's controller, as a window draws them: its path, and the options of its last decision."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from amorsim.array_types import AnyArray, Array
from amorsim.contracts import Beliefs, Drive, Sensor
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.frames.protocol import Intended, IntendedArc, IntendedVelocities

__all__ = ["NO_INTENTION", "ahead", "intended_in", "intended_of"]


_ON_ARC = 9  # points that draw an arc
# The beliefs that are drawn: how many axes a row has, and how long the last is; None for any length.
_SHAPES: Mapping[str, tuple[int, int | None]] = {
    "path": (2, 2),
    "searched": (2, 2),
    "arcs": (3, 3),
    "runs": (3, 2),
    "plan": (2, 2),
    "twist": (1, 2),
    "histogram": (1, None),
    "bearing": (1, 1),
    "ways": (2, 2),
    "others": (2, 5),
    "borders": (2, 4),
    "cones": (2, 6),
}
_SECONDS = 1.0  # that arcs last whose controller sets no time
NO_INTENTION: Intended = {
    "pose": [],
    "path": None,
    "searched": None,
    "arcs": None,
    "blocked": None,
    "bearing": None,
    "ways": None,
    "velocities": None,
}


def intended_of(simulation: Simulation, robot: str, *, is_known: bool = True) -> Intended:
    """The intentions of a robot's controller in the last step; see `intended_in`.

    All is empty for a moment of the past that is not known.
    """
    frame = next(frame for frame in simulation.frames() if robot in frame.names)
    if "controller" not in frame.beliefs:
        return NO_INTENTION
    row = list(frame.names).index(robot)
    handle = simulation.robot(robot)
    model = frame.robot
    measured = ((sensor.sensor, frame.readings[name][1].measured) for name, sensor in model.sensors.items())
    pose = ahead(model.drive, measured, model.rows, row, handle.estimated_pose)
    is_empty = handle.is_by_hand or not is_known
    return intended_in(frame.beliefs["controller"], row, pose, handle.nominal.controller, is_empty=is_empty)


def intended_in(beliefs: Beliefs, row: int, pose: Array, controller: Any, *, is_empty: bool = False) -> Intended:
    """The intentions in the beliefs of a controller; none where it has no such belief.

    A plugin's controller is drawn as well if its beliefs have the names and shapes of the built-in ones.

    Parameters
    ----------
    row
        Of the beliefs.
    pose
        The estimated one `(3,)`, with the heading in which the drive goes ahead (`ahead`).
    controller
        The nominal one.
    is_empty
        Whether the robot intends nothing, as while it is driven by hand.
    """
    found: Intended = {**NO_INTENTION, "pose": [round(value, 4) for value in pose.tolist()]}
    has = {name: array[:0] if is_empty else array for name, array in beliefs.items() if _is_drawn(name, array)}
    chooser: Any = getattr(controller, "avoider", controller)
    if "path" in has:
        found["path"] = _known(_of_row(has, "path", row))
    if "searched" in has:
        found["searched"] = _known(_of_row(has, "searched", row))
    if "arcs" in has and "twist" in has:
        seconds = float(getattr(chooser, "horizon", _SECONDS))
        found["arcs"] = _arcs(_of_row(has, "arcs", row), _of_row(has, "twist", row), pose, seconds)
    if "runs" in has and "plan" in has:
        step = float(getattr(chooser, "step", _SECONDS / max(has["plan"].shape[1], 1)))
        found["arcs"] = _runs(_of_row(has, "runs", row), _of_row(has, "plan", row), pose, step)
    if "histogram" in has:
        found["blocked"] = [bool(one) for one in _of_row(has, "histogram", row).tolist()]
    if "bearing" in has:
        bearing = _of_row(has, "bearing", row).ravel()
        found["bearing"] = [round(float(bearing[0]), 4)] if np.isfinite(bearing).any() else []
    if "ways" in has:
        found["ways"] = _known(_of_row(has, "ways", row))
    if "others" in has and "twist" in has:
        found["velocities"] = _velocities(has, row, float(getattr(chooser, "speed", 1.0)))
    return found


def _is_drawn(name: str, array: AnyArray) -> bool:
    """Whether a belief is one that a window draws."""
    axes, last = _SHAPES.get(name, (0, None))
    return array.ndim == axes + 1 and axes > 0 and last in (None, array.shape[-1])


def _of_row(beliefs: Beliefs, name: str, row: int) -> AnyArray:
    """A row's belief; empty, and of the same dimensions, where there are no rows."""
    array = beliefs[name]
    return array[row] if len(array) else np.empty((0, *array.shape[2:]))


def ahead(drive: Drive, measured: Iterable[tuple[Sensor, Array]], rows: int, row: int, estimated: Array) -> Array:
    """The estimated pose `(3,)` of a row, with the heading in which its drive goes ahead by the measured joints.

    `measured` are sensors with their readings `(N, values)`, in order.
    """
    angles = np.zeros((rows, len(drive.joints)))
    for sensor, values in measured:
        if hasattr(sensor, "angles"):
            found = np.asarray(sensor.angles(values))
            if found.shape == angles.shape:
                angles = np.where(np.isfinite(found), found, 0.0)
                break
    course = drive.heading_offset(angles)
    return estimated if course is None else estimated + np.array([0.0, 0.0, float(course[row, 0])])


def _known(places: Array, decimals: int = 3) -> list[list[float]]:
    """The lines that have numbers, rounded to a millimetre."""
    places = places[np.isfinite(places).all(axis=-1)]
    return [[round(value, decimals) for value in line] for line in places.tolist()]


def _arcs(arcs: Array, twist: Array, pose: Array, seconds: float) -> list[IntendedArc]:
    """The arcs `(S, T, 3)` of a dynamic window that the drive can follow; the chosen one is last."""
    arcs = arcs.reshape(-1, 3)
    arcs = arcs[np.isfinite(arcs[:, :2]).all(axis=1)]
    worth = _worths(arcs[:, 2])
    places = _along(np.repeat(arcs[:, None, :2], _ON_ARC - 1, axis=1), seconds / (_ON_ARC - 1), pose)
    same = np.isfinite(arcs[:, 2]) & (arcs[:, :2] == twist[None]).all(axis=1) if len(twist) else np.zeros(0)
    taken = set(np.flatnonzero(same).tolist())
    order = sorted(range(len(arcs)), key=lambda one: one in taken)
    return [
        {"points": _known(places[one]), "worth": round(float(worth[one]), 3), "taken": one in taken} for one in order
    ]


def _worths(costs: Array) -> Array:
    """The worth of each cost: 1 for the least, 0 for the largest, -1 for what was refused."""
    known = np.isfinite(costs)
    worths = np.full(len(costs), -1.0)
    if known.any():
        least, most = costs[known].min(), costs[known].max()
        worths[known] = (most - costs[known]) / (most - least) if most > least else 1.0
    return worths


def _runs(runs: Array, plan: Array, pose: Array, step: float) -> list[IntendedArc]:
    """Some of the runs `(K, T, 2)` that a plan was made of, and the plan `(T, 2)`, last."""
    found: list[IntendedArc] = [
        {"points": _known(places), "worth": 0.5, "taken": False} for places in _along(runs, step, pose)
    ]
    if len(plan):
        found.append({"points": _known(_along(plan[None], step, pose)[0]), "worth": 1.0, "taken": True})
    return found


def _along(twists: Array, step: float, pose: Array) -> Array:
    """The places `(K, T + 1, 2)` to which twists `(K, T, 2)` of `step` [s] each lead from a pose."""
    count, steps = twists.shape[:2]
    places = np.zeros((count, steps + 1, 3))
    places[:, 0] = pose
    for t in range(steps):
        v, w = twists[:, t, 0], twists[:, t, 1]
        middle = places[:, t, 2] + 0.5 * w * step
        # The chord of an arc.
        half = 0.5 * w * step
        chord = v * step * np.sinc(half / np.pi)
        places[:, t + 1, 0] = places[:, t, 0] + chord * np.cos(middle)
        places[:, t + 1, 1] = places[:, t, 1] + chord * np.sin(middle)
        places[:, t + 1, 2] = places[:, t, 2] + w * step
    return places[:, :, :2]


def _velocities(beliefs: Mapping[str, Array], row: int, speed: float) -> IntendedVelocities:
    """The other bodies that a robot knows of, and the velocities that would lead into them."""
    twist = _of_row(beliefs, "twist", row)
    return {
        "speed": speed,
        "twist": [round(value, 4) for value in twist.tolist()],
        "others": _known(_of_row(beliefs, "others", row)),
        "borders": _known(_of_row(beliefs, "borders", row), 4) if "borders" in beliefs else [],
        "cones": _known(_of_row(beliefs, "cones", row), 4) if "cones" in beliefs else [],
    }
