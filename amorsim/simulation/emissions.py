"""The emitters that fire into a medium at this tick, collected from all sensors before any sensor senses."""

from __future__ import annotations

import numpy as np

from amorsim.contracts import Emission
from amorsim.core.error_text import RAISED
from amorsim.simulation.error_context import array_problem
from amorsim.simulation.group import Group
from amorsim.simulation.world.world import Emitted, World

__all__ = ["collect", "emission_problem"]


def collect(groups: list[Group], world: World) -> None:
    """Put into ``world.emissions`` what every sensor with a medium emits."""
    by_medium: dict[str, list[Emitted]] = {}
    for group in groups:
        for name, unit in group.sensors.items():
            medium = unit.sensor.medium
            if not medium:
                continue
            try:
                emitted = unit.sensor.emit(unit.look(), unit.state)
                if emitted is None:
                    raise group.whose.wrong(
                        f"sensor {name!r}",
                        unit.sensor,
                        f"it has the medium {medium!r}, but emit() gave nothing; expected poses, half angles and "
                        "whether each emitter fires",
                    )
                said_here = Emission(*emitted)
            except RAISED as error:
                unit.blame(error)
            if problem := emission_problem(said_here, group.rows):
                raise group.whose.wrong(f"sensor {name!r}", unit.sensor, problem)
            poses, half_angle, fired, time = said_here
            due, _ = unit.due()
            fired = fired & due
            replicas, each = len(world.first) - 1, poses.shape[1]
            body = np.repeat(group.bodies[:, None], each, axis=1)
            by_medium.setdefault(medium, []).append(
                # A group has the same robots in every replica, in order of replica.
                Emitted(
                    poses=poses.reshape(replicas, -1, 3),
                    half_angle=half_angle.reshape(replicas, -1),
                    fired=fired.reshape(replicas, -1),
                    time=(np.zeros(fired.shape) if time is None else time).reshape(replicas, -1),
                    body=body.reshape(replicas, -1),
                    sensor=np.full(body.size // replicas, name),
                )
            )
    world.emissions = {medium: _joined(parts) for medium, parts in by_medium.items()}


def emission_problem(emission: Emission, rows: int) -> str:
    """The fault of what `emit` returned for a number of rows; empty if there is none."""
    poses, half_angle, fired, time = emission
    each = np.shape(half_angle)[-1] if np.ndim(half_angle) == 2 else 1
    if problem := array_problem(half_angle, "half angles", (rows, each), "emit()"):
        return problem
    if problem := array_problem(poses, "poses", (rows, each, 3), "emit()"):
        return problem
    if not isinstance(fired, np.ndarray) or fired.shape != (rows, each) or fired.dtype != bool:
        found = f"{fired.dtype} {fired.shape}" if isinstance(fired, np.ndarray) else f"a {type(fired).__name__}"
        return f"fired from emit(): expected bool {(rows, each)}, got {found}"
    return "" if time is None else array_problem(time, "times", (rows, each), "emit()")


def _joined(parts: list[Emitted]) -> Emitted:
    """All emitters in order of body, then of the sensor's name, for any grouping of the robots."""
    if len(parts) == 1:
        return parts[0]  # one sensor of one group, whose robots are in order
    body = np.concatenate([part.body for part in parts], axis=1)
    sensor = np.concatenate([part.sensor for part in parts])
    order = np.lexsort((sensor, body[0]))
    return Emitted(
        poses=np.concatenate([part.poses for part in parts], axis=1)[:, order],
        half_angle=np.concatenate([part.half_angle for part in parts], axis=1)[:, order],
        fired=np.concatenate([part.fired for part in parts], axis=1)[:, order],
        time=np.concatenate([part.time for part in parts], axis=1)[:, order],
        body=body[:, order],
        sensor=sensor[order],
    )
