"""Frames: a simulation at a moment, as numbers to be drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import AnyArray, Array
from amorsim.contracts import Frame, Measurement
from amorsim.core.poses import compose, logarithm, relative
from amorsim.simulation.simulation import Simulation
from amorsim.ui.simulator.frames.packing import Dynamic, RobotFlag, Selected

__all__ = [
    "_MOST_PARTICLES",
    "Before",
    "flags_of",
    "look_back",
    "moments_of",
    "obstacle_poses",
    "selected_of",
    "upper_triangle",
    "with_beliefs",
]


_MOST_PARTICLES = 3000  # that a frame has; of more, every second or third

_UPPER = np.array([0, 1, 2, 4, 5, 8])  # of a 3 x 3 matrix, row by row


class Before(NamedTuple):
    """Values of the step before a frame, for the selected robots: velocities are found from two positions."""

    tick: int
    estimated: Array  # (R, 3)
    angles: Mapping[int, tuple[Array, int]]  # measured (1, j), and their tick, where there are any


def _places(simulation: Simulation) -> Callable[[int], tuple[Frame, int]]:
    """Finds the frame and the row of a robot."""
    frames = simulation.frames()

    def find(robot: int) -> tuple[Frame, int]:
        name = simulation.names[robot]
        frame = next(frame for frame in frames if name in frame.names)
        return frame, list(frame.names).index(name)

    return find


def _joints_measured(frame: Frame) -> tuple[Array, Measurement] | None:
    """The joints `(N, j)` as measured by the first sensor that measures their angles, and its reading."""
    for name, model in frame.robot.sensors.items():
        if hasattr(model.sensor, "angles"):
            reading = frame.readings[name][1]
            angles = np.asarray(model.sensor.angles(reading.measured))
            if angles.shape[1] == len(frame.joint_names):
                return angles, reading
    return None


def _measured_angles(frame: Frame, row: int) -> tuple[Array, int] | None:
    """The joints' angles of a robot as measured `(1, j)`, and when."""
    found = _joints_measured(frame)
    return None if found is None else (found[0][row : row + 1], int(found[1].stamp[row, 0]))


def look_back(simulation: Simulation, robots: Iterable[int]) -> Before:
    """The values of this step that the frames of the next one need, for those who look at these robots."""
    find = _places(simulation)
    measured = {robot: _measured_angles(*find(robot)) for robot in robots}
    known = {robot: angles for robot, angles in measured.items() if angles is not None}
    return Before(simulation.tick, simulation.estimated_pose, known)


def selected_of(simulation: Simulation, robots: Iterable[int], before: Before | None) -> dict[int, Selected]:
    """All values of each robot; those that need the step before are 0 at the start, and nan where unknown."""
    find, pose = _places(simulation), simulation.estimated_pose
    return {robot: _selected(simulation, robot, *find(robot), pose[robot : robot + 1], before) for robot in robots}


def _selected(
    simulation: Simulation, robot: int, frame: Frame, row: int, estimated: Array, before: Before | None
) -> Selected:
    joints = len(frame.joint_names)
    rates, twist = np.full(joints, np.nan), np.full(3, np.nan)
    if simulation.tick == 0:
        rates, twist = np.zeros(joints), np.zeros(3)
    elif before is not None and before.tick == simulation.tick - 1:
        twist = logarithm(relative(before.estimated[robot : robot + 1], estimated))[0] / simulation.dt
        measured, was = _measured_angles(frame, row), before.angles.get(robot)
        if measured is not None and was is not None and measured[1] > was[1]:
            rates = (measured[0] - was[0])[0] / ((measured[1] - was[1]) * simulation.dt)
    readings = list(frame.readings.values())
    nothing = np.empty(0)
    return Selected(
        true=np.concatenate([nothing, *(true[row] for true, _ in readings)]),
        measured=np.concatenate([nothing, *(reading.measured[row] for _, reading in readings)]),
        age=np.concatenate([nothing, *(reading.age[row] for _, reading in readings)]),
        true_rates=frame.joint_rates[row],
        measured_rates=rates,
        true_twist=frame.true_twist[row],
        estimated_twist=twist,
        command=frame.command[row],
        parts=_believed_parts(frame, row, estimated),
    )


def _believed_parts(frame: Frame, row: int, estimated: Array) -> Array:
    """Where a robot's parts are `(3 P,)` by the pose it believes in `(1, 3)`, what is measured, and its model."""
    drive, count = frame.robot.drive, len(frame.parts)
    measured = _joints_measured(frame) if count else None
    if measured is None:
        return np.full(3 * count, np.nan)
    inside = np.asarray(drive.part_poses(measured[0]))[row]
    return compose(np.repeat(estimated, count, axis=0), inside).reshape(-1)


def _with_beliefs(simulation: Simulation, robot: int, selected: Selected) -> Selected:
    """With the particles and hypotheses that the robot's estimators hold."""
    frame, row = _places(simulation)(robot)
    return with_beliefs(selected, frame.beliefs, row)


def with_beliefs(selected: Selected, found_beliefs: Mapping[str, Mapping[str, AnyArray]], row: int) -> Selected:
    """Adds the particles and hypotheses in a row of the first estimator whose beliefs have any."""
    for beliefs in found_beliefs.values():
        if "particles" in beliefs and "weights" in beliefs:
            table = np.column_stack((beliefs["particles"][row], beliefs["weights"][row]))
            table = table[np.isfinite(table).all(axis=1)]
            selected = selected._replace(particles=table[:: 1 + len(table) // _MOST_PARTICLES].reshape(-1))
        if "hypotheses" in beliefs and "hypotheses_covariance" in beliefs:
            upper = upper_triangle(beliefs["hypotheses_covariance"][row])
            table = np.column_stack((beliefs["hypotheses"][row], beliefs["hypotheses_weight"][row], upper))
            selected = selected._replace(hypotheses=table[np.isfinite(table).all(axis=1)].reshape(-1))
        if len(selected.particles) or len(selected.hypotheses):
            break
    return selected


def moments_of(
    simulation: Simulation,
    robots: Sequence[int],
    before: Before | None,
    obstacles: list[str],
    poses: Array | None,
) -> list[Dynamic]:
    """The present moment, for each selected robot; what the player adds is still missing.

    Parameters
    ----------
    before
        The step before.
    obstacles
        Their names, in order.
    poses
        True and estimated poses `(R, 6)`, where of this moment nothing else is known.
    """
    true, estimated = simulation.true_pose, simulation.estimated_pose
    covariance, marks = upper_triangle(simulation.covariance), flags_of(simulation)
    selected = selected_of(simulation, robots, before)
    if poses is not None:
        true, estimated = poses[:, :3], poses[:, 3:]
        covariance, marks = np.full_like(covariance, np.nan), np.zeros_like(marks)
        selected = {robot: Selected(*(np.full_like(part, np.nan) for part in one)) for robot, one in selected.items()}
    else:
        selected = {robot: _with_beliefs(simulation, robot, one) for robot, one in selected.items()}
    first = Dynamic(
        version=0,
        number=0,
        epoch=0,
        time=0.0,
        speed=1.0,
        achieved=0.0,
        tick=0,
        newest=0,
        oldest=0,
        flags=0,
        events=0,
        selected_robot=robots[0],
        true_pose=true,
        estimated_pose=estimated,
        covariance=covariance,
        obstacle_pose=obstacle_poses(simulation, obstacles),
        robot_flags=marks,
        selected=selected[robots[0]],
    )
    return [first._replace(selected_robot=robot, selected=one) for robot, one in selected.items()]


def flags_of(simulation: Simulation) -> npt.NDArray[np.uint8]:
    """A `RobotFlag` for each robot."""
    flags = np.where(simulation.touching, RobotFlag.TOUCHING, 0)
    flags |= np.where(simulation.active, 0, RobotFlag.ENDED)
    flags |= np.where(simulation.by_hand, RobotFlag.BY_HAND, 0)
    return flags.astype(np.uint8)


def upper_triangle(covariance: Array) -> Array:
    """xx, xy, xh, yy, yh, hh of covariances `(N, 3, 3)`."""
    return covariance.reshape(len(covariance), 9)[:, _UPPER]


def obstacle_poses(simulation: Simulation, names: list[str]) -> Array:
    """True poses `(O, 3)` of obstacles, and after them of the robots' parts."""
    obstacles = np.array([simulation.obstacle(name).true_pose for name in names]).reshape(-1, 3)
    return np.concatenate((obstacles, simulation.part_pose))
