"""The plan of a group's sensing: devices of the common kinds read together, made once from their parameters.

A sensor unit reads by itself (`SensorUnit.sample`): its class senses, each element of its chain is called, and the
reading is delivered. At one row that is mostly calls. Where all of it is of classes that have a twin in
`amorsim.kernels.sensing`, and the reading is taken at every step and arrives at once, the unit is taken into the plan:
its parameters are laid into tables, and all such units of the group are placed, cast and read in a few calls. A
subclass has no twin, for it may do anything; it goes the other road, and so does everything with a rate or a latency.
Both give the same bits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Noise, Sensor
from amorsim.kernels import digest, sensing
from amorsim.noise.bias import Bias
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.quantize import Quantize
from amorsim.noise.scale import Scale
from amorsim.sensors.compass import Compass
from amorsim.sensors.encoder import Encoder
from amorsim.sensors.gyro import Gyro
from amorsim.sensors.laser import Laser
from amorsim.sensors.sonar import Sonar
from amorsim.simulation.moment import Moment
from amorsim.simulation.sensing import SensorUnit
from amorsim.simulation.view import GroupView, cone_bearings, directions_of

__all__ = ["SensePlan"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_KINDS: Mapping[type[Sensor], int] = {
    Encoder: sensing.ENCODER,
    Compass: sensing.COMPASS,
    Gyro: sensing.GYRO,
    Laser: sensing.LASER,
    Sonar: sensing.SONAR,
}
_VALUE_WORK = 0.15  # rays that a value and its noise cost as much as


class SensePlan:
    """Those units of a group that are read together, and the others.

    Parameters
    ----------
    units
        All of the group, their parameters set.
    rows
        How many rows there are.

    Attributes
    ----------
    others
        The units that read by themselves.
    """

    def __init__(self, units: Sequence[SensorUnit], rows: int) -> None:
        self._units = [unit for unit in units if _fits(unit)]
        self.others = [unit for unit in units if not _fits(unit)]
        held = self._units
        table = np.zeros((len(held), sensing.TABLE_COLUMNS), dtype=np.int64)
        sizes = [unit.size for unit in held]
        rings = [unit.size if type(unit.sensor) is Sonar else 0 for unit in held]
        places = [_places(unit) for unit in held]
        links = [len(unit.chain.elements) for unit in held]
        for d, unit in enumerate(held):
            before, after = sum(links[:d]), sum(links[: d + 1])
            table[d] = (
                _KINDS[type(unit.sensor)],
                sizes[d],
                sum(sizes[:d]),
                sum(rings[:d]),
                sum(places[:d]),
                before,
                after,
            )
        self._rows = rows
        self._sizes = np.array(sizes, dtype=np.int64)
        self._true = self._measured = np.empty(0)
        self._values = sum(sizes)
        self._mounts = np.array([unit.mount for unit in held]).reshape(-1, rows, 3)
        most = max([1, *(unit.size for unit in held if type(unit.sensor) is Encoder)])
        numbers = np.zeros((len(held), rows, most))
        for d, unit in enumerate(held):
            numbers[d, :, : unit.size if type(unit.sensor) is Encoder else 1] = _numbers(unit.sensor)
        ring = np.concatenate([np.zeros((0, 3)), *(_ring(unit.sensor) for unit in held if type(unit.sensor) is Sonar)])
        links_of = [
            (element, draws)
            for unit in held
            for element, draws in zip(unit.chain.elements, unit.chain.draws, strict=True)
        ]
        kinds = np.array([_link(element)[0] for element, _ in links_of], dtype=np.int64)
        parts = np.zeros((len(links_of), rows, 2))
        for c, (element, _) in enumerate(links_of):
            for column, value in enumerate(_link(element)[1:]):
                parts[c, :, column] = np.asarray(value)[:, 0]
        keys = np.array([draws.keys for _, draws in links_of], dtype=np.uint64).reshape(-1, rows)
        # Where range finders look from: written anew in each step, and shown to nobody.
        self._places = np.empty((rows * sum(places), 3))
        self._look = (table, self._mounts, ring)
        self._read = (table, kinds, parts, keys, self._mounts, numbers)
        self._finders = [_Finder(unit, table[d], rows, self._places) for d, unit in enumerate(held) if places[d]]
        ends = np.cumsum([0, *sizes]) * rows
        self._spans = [
            (unit, int(a), int(b), (rows, unit.size)) for unit, a, b in zip(held, ends[:-1], ends[1:], strict=True)
        ]
        self._work = int(1.0 + _VALUE_WORK * self._values)

    def sense(self, view: GroupView, moment: Moment) -> None:
        """Read all units."""
        if self._units:
            self._sense(view, moment)
        for unit in self.others:
            unit.sample(view, moment)

    def absorb(self, fingerprint: npt.NDArray[np.uint64]) -> None:
        """Mix what the units read last into the fingerprints of the rows `(N, 2)`."""
        if self._units:
            digest.absorb_together(self._sizes, self._true, self._measured, fingerprint)

    def _sense(self, view: GroupView, moment: Moment) -> None:
        true = np.empty(self._rows * self._values)
        measured = np.empty(self._rows * self._values)
        if self._finders:
            sensing.place(*self._look, view.body_pose, self._places)
            for finder in self._finders:
                finder.cast(view, true)

        def part(first: int, end: int) -> None:
            sensing.read(
                *self._read, moment.counter, view.body_pose, view.twist, view.joints, first, end, true, measured
            )

        view.workers.share(self._rows, self._work, part)
        self._true, self._measured = true, measured
        for unit, a, b, shape in self._spans:
            unit.deliver(true[a:b].reshape(shape), measured[a:b].reshape(shape), moment)


class _Finder:
    """A range finder of the plan: from where it looks, and how."""

    def __init__(self, unit: SensorUnit, table: Ints, rows: int, places: Array) -> None:
        sensor: Any = unit.sensor
        self._is_cone = type(sensor) is Sonar
        size = int(table[1])
        per_row = size if self._is_cone else 1
        self._span = int(table[2]) * rows, (int(table[2]) + size) * rows
        self._shape = (rows * size,) if self._is_cone else (rows, size)
        self._from = places[int(table[4]) * rows : (int(table[4]) + per_row) * rows]
        self._limits = np.repeat(sensor.range_max[:, 0], per_row)
        self._half_angle = float(sensor.half_angle[0, 0]) if self._is_cone else 0.0
        self._table = directions_of(cone_bearings(self._half_angle) if self._is_cone else sensor.bearings())

    def cast(self, view: GroupView, true: Array) -> None:
        """Put what it sees into its part of `true`."""
        out = true[self._span[0] : self._span[1]].reshape(self._shape)
        if self._is_cone:
            view.hear(self._from, self._half_angle, self._table, self._limits, out)
        else:
            view.scan(self._from, self._table, self._limits, out)


def _fits(unit: SensorUnit) -> bool:
    """Whether everything about a unit has a twin among the kernels."""
    sensor: Any = unit.sensor
    kind = _KINDS.get(type(unit.sensor))
    chain = unit.chain
    if kind is None or not unit.is_prompt or chain.aims or chain.columns or chain.watch is not None:
        return False
    if kind in (sensing.LASER, sensing.SONAR) and sensor.traversal != "exact":
        return False
    if kind == sensing.LASER and len(sensor.bearings()) > 1:  # rows of different fields of view
        return False
    if kind == sensing.SONAR and not (sensor.half_angle == sensor.half_angle[0]).all():
        return False
    return all(_link(element) is not None for element in unit.chain.elements)


def _link(element: Noise) -> Any:
    """The twin of an element of a chain, and its parameters; None where there is none."""
    kind, it = type(element), element
    if isinstance(it, Gaussian) and kind is Gaussian and it.per == "sample":
        return sensing.GAUSSIAN, it.std, it.proportional
    if isinstance(it, Bias) and kind is Bias:
        return sensing.BIAS, it.value
    if isinstance(it, Scale) and kind is Scale:
        return sensing.SCALE, it.factor
    if isinstance(it, Quantize) and kind is Quantize:
        return (sensing.NEAREST if it.rounding == "nearest" else sensing.FLOOR), it.step
    return None


def _places(unit: SensorUnit) -> int:
    """From how many places a device looks for ranges."""
    return unit.size if type(unit.sensor) is Sonar else int(type(unit.sensor) is Laser)


def _numbers(sensor: Any) -> Any:
    """What the kernel must know of a device beside its place: `(N, 1)`, or `(N, j)` for the joints of an encoder."""
    kind = type(sensor)
    if kind is Encoder:
        return sensor.counts_per_revolution
    return sensor.range_min if kind is Sonar else 0.0


def _ring(sensor: Any) -> Array:
    """Where the elements of a ring sit on their mounts, `(N * k, 3)`."""
    ring = sensor.elements
    return np.stack((ring.x, ring.y, ring.heading), axis=2).reshape(-1, 3)
