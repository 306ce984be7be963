"""The emitters that fire into a medium at this tick, collected from all sensors before any sensor senses."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from amorsim.contracts import Emission
from amorsim.core.error_text import RAISED
from amorsim.simulation.error_context import array_problem
from amorsim.simulation.fleet.group import Group
from amorsim.simulation.sensing.device import Device
from amorsim.simulation.world.world import Emitted, World

__all__ = ["bind_emitters", "emission_problem"]


def bind_emitters(groups: Sequence[Group], world: World) -> Callable[[], None]:
    """A function that puts into ``world.emissions`` what every sensor with a medium emits at this tick."""
    by_medium: dict[str, list[_Source]] = {}
    for group in groups:
        for name, unit in group.sensors.items():
            if unit.sensor.medium:
                by_medium.setdefault(unit.sensor.medium, []).append(_Source(group, name, unit, len(world.first) - 1))

    def collect() -> None:
        world.emissions = {
            medium: _joined([source.emitted() for source in sources]) for medium, sources in by_medium.items()
        }

    return collect


class _Source:
    """A sensor of a group that emits."""

    def __init__(self, group: Group, name: str, unit: Device, replicas: int) -> None:
        self._group, self._name, self._unit, self._replicas = group, name, unit, replicas
        self._known: Emission | None = None  # whose arrays, if they are given again, are those of `_emitted`
        self._emitted: Emitted

    def emitted(self) -> Emitted:
        """What it emits now, by replica."""
        unit = self._unit
        try:
            emission = unit.emit()
            if emission is None or emission is not self._known:
                self._emitted = self._by_replica(emission)
                is_bound = all(array is None or array.flags.c_contiguous for array in emission or ())
                self._known = emission if is_bound else None
        except RAISED as error:
            unit.blame(error)
        due, _ = unit.due()
        known = self._emitted
        return known._replace(fired=(known.fired.reshape(self._group.rows, -1) & due).reshape(self._replicas, -1))

    def _by_replica(self, given: Emission | None) -> Emitted:
        """The arrays of an emission, by replica: a group has the same robots in each, in order of replica."""
        group, name, sensor, replicas = self._group, self._name, self._unit.sensor, self._replicas
        if given is None:
            raise group.whose.wrong(
                f"sensor {name!r}",
                sensor,
                f"it has the medium {sensor.medium!r}, but emit() gave nothing; expected poses, half angles "
                "and whether each emitter fires",
            )
        poses, half_angle, fired, time = emission = Emission(*given)
        if problem := emission_problem(emission, group.rows):
            raise group.whose.wrong(f"sensor {name!r}", sensor, problem)
        body = np.repeat(group.bodies, poses.shape[1]).reshape(replicas, -1)
        return Emitted(
            poses.reshape(replicas, -1, 3),
            half_angle.reshape(replicas, -1),
            fired.reshape(replicas, -1),
            (np.zeros(fired.shape) if time is None else time).reshape(replicas, -1),
            body,
            np.full(body.shape[1], name),
        )


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
