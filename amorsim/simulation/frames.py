"""A group's step as recorders get it, made in little time, for a run asks for it after every step."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Bundle, Frame, Measurement

if TYPE_CHECKING:
    from amorsim.simulation.group import Group

__all__ = ["Showing"]

Array = npt.NDArray[np.float64]
Shown = tuple[Array, Measurement]
_NONE: dict[str, Shown] = {}


class Showing:
    """Makes a group's frames; made anew with its parameters."""

    def __init__(self, group: Group) -> None:
        self._group = group
        self._joint_names = [joint.name for joint in group.drive.joints]
        self._parts = tuple(part.name for part in group.drive.parts)
        self._no_parts = np.empty((group.rows, 0, 3))

    def frame(self) -> Frame:
        """The present step."""
        group, batch = self._group, self._group.sensing.batch
        row_clock = group.row_clock
        bundle: Bundle | None = None
        readings: Mapping[str, Shown]
        if batch.is_held:
            bundle = Bundle(batch.places, batch.values)
            others = group.sensing.others
            held = {unit.name: (unit.true, unit.reading) for unit in others} if others else _NONE
            readings = _Readings(group.sensors, held, bundle, (batch.tick, batch.now, batch.always))
        else:
            readings = {name: (unit.true, unit.reading) for name, unit in group.sensors.items()}
        return Frame(
            group.names,
            row_clock.replica,
            row_clock.tick.ravel(),
            row_clock.time.ravel(),
            group.true_pose,
            group.true_twist,
            self._joint_names,
            group.mean_rates,
            group.estimates,
            readings,
            group.channels,
            group.command,
            group.robot,
            self._parts,
            self._no_parts if group.parts is None else group.parts.per_robot,
            bundle,
        )


class _Readings(Mapping[str, Shown]):
    """Those of one step; what was read together is taken apart when somebody asks for it."""

    __slots__ = ("_bundle", "_held", "_names", "_when")

    def __init__(
        self,
        names: Collection[str],
        held: dict[str, Shown],
        bundle: Bundle,
        when: tuple[npt.NDArray[np.int64], Array, npt.NDArray[np.bool_]],
    ) -> None:
        self._names, self._held, self._bundle, self._when = names, held, bundle, when

    def __getitem__(self, name: str) -> Shown:
        if name in self._held:
            return self._held[name]
        place = self._bundle.places[name]
        rows = len(self._when[0])
        shape = rows, (place.stop - place.start) // rows
        true, measured = self._bundle.true[place].reshape(shape), self._bundle.measured[place].reshape(shape)
        return true, Measurement(measured, *self._when)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
