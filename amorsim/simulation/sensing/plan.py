"""The plan of a group's sensing: devices of the common kinds read together, made once from their parameters.

A sensor unit reads by itself (`SensorUnit.sample`): its class senses, each element of its chain is called, and the
reading is delivered. At one row that is mostly calls. Where all of it is of classes that have a twin in
`amorsim.kernels.sensing.together`, and the reading is taken at every step and arrives at once, the unit is taken
into the plan: its parameters are laid into tables, and all such units of the group are placed, cast and read in one
call. A subclass has no twin, for it may do anything; it reads by itself, and so does everything with a rate or a
latency. Both give the same bits.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Noise, Sensor
from amorsim.kernels.raycast import scans
from amorsim.kernels.sensing import together as sensing
from amorsim.kernels.sensing.among import sense_among
from amorsim.kernels.sensing.together import Layout, sense
from amorsim.kernels.text import digest
from amorsim.noise.bias import Bias
from amorsim.noise.gaussian import Gaussian
from amorsim.noise.quantize import Quantize
from amorsim.noise.scale import Scale
from amorsim.sensors.compass import Compass
from amorsim.sensors.encoder import Encoder
from amorsim.sensors.gyro import Gyro
from amorsim.sensors.laser import Laser
from amorsim.sensors.sonar import Sonar
from amorsim.simulation.row_clock import RowClock
from amorsim.simulation.sensing.sensor_unit import Batch, SensorUnit
from amorsim.simulation.world.sensor_view import CONE_WORK, GroupView, cone_bearings, directions_of
from amorsim.simulation.world.world import World

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
_TOGETHER = 5  # results of the commonest robots, besides their readings
_NO_ANGLE = np.zeros((1, 1))
_NONE: Ints = np.zeros(0, dtype=np.int64)


class SensePlan:
    """Those units of a group that are read together, and the others.

    Parameters
    ----------
    units
        All of the group, their parameters set.
    rows
        How many rows there are.
    world
        Where they are.

    Attributes
    ----------
    others
        The units that read by themselves.
    batch
        What the units that are read together read last.
    reads, looks
        Whether there are units that are read together, and range finders among them.
    places
        Where range finders look from: written anew in each step, and shown to nobody.
    """

    def __init__(self, units: Sequence[SensorUnit], rows: int, world: World) -> None:
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
            table[d, :-3] = (
                _KINDS[type(unit.sensor)],
                sizes[d],
                sum(sizes[:d]),
                sum(rings[:d]),
                sum(places[:d]),
                before,
                after,
            )
        self._world = world
        self._rows = rows
        self._sizes = np.array(sizes, dtype=np.int64)
        values = sum(sizes)
        mounts = np.array([unit.mount for unit in held]).reshape(-1, rows, 3)
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
        limits = np.concatenate([np.zeros(0), *(_limits(unit, n) for unit, n in zip(held, places, strict=True) if n)])
        finders = [_Finder(unit, table[d]) for d, unit in enumerate(held) if places[d]]
        beams = _Beams(finders)
        for finder, columns in zip(finders, beams.columns, strict=True):
            finder.line[-3:] = columns
        half_angles = np.array([float(getattr(unit.sensor, "half_angle", _NO_ANGLE)[0, 0]) for unit in held])
        edges = np.array([[math.cos(angle), math.sin(angle)] for angle in half_angles]).reshape(-1, 2)
        self._finders = finders
        self._among: tuple[Any, ...] | None = None  # what the finders need to meet bodies
        plan = sensing.Plan(
            table=table,
            order=beams.order,
            starts=beams.starts,
            chains=kinds,
            keys=keys,
            sizes=self._sizes,
            mounts=mounts,
            numbers=numbers,
            rings=ring,
            limits=limits,
            half_angles=half_angles,
            edges=edges,
            cosines=beams.cosines,
            sines=beams.sines,
            parameters=parts,
        )
        self.places = np.empty((rows * sum(places), 3))
        self._layout = Layout(
            world.map.grid, world.map.segment_index, *world.map.origin, *sensing.lay(plan), self.places
        )
        self.reads, self.looks = bool(held), bool(finders)
        self.batch = Batch(rows, values)
        ends = np.cumsum([0, *sizes]) * rows
        for unit, first, end in zip(held, ends[:-1].tolist(), ends[1:].tolist(), strict=True):
            unit.join(self.batch, first, end)
        for unit in self.others:
            unit.leave()
        rays = sum(finder.work for finder in finders)
        self._meet_work = sum(len(finder.table[0][0]) for finder in finders) // 2  # it is less work than to meet walls
        self._look_work, self._read_work = rays, int(1.0 + _VALUE_WORK * values)

    def read(self, view: GroupView, row_clock: RowClock) -> None:
        """Read all units of the plan at once."""
        if not self.reads:
            return
        self.batch.take(np.empty(self.batch.shape), row_clock)
        true, measured = self.batch.values
        where = view.body_pose, view.twist, view.joints, self._layout, row_clock.counter, true, measured
        if self.looks and self._world.has_company:
            work, company = self._look_work + self._meet_work, (*self._world.met(), *self._finders_among(view))
            self._share(work, lambda first, end: sense_among(first, end, *where, *company))
        else:
            self._share(self._look_work, lambda first, end: sense(first, end, True, True, *where))

    def absorb(self, results: Sequence[Array], fingerprint: npt.NDArray[np.uint64]) -> None:
        """Mix results, and then what the units read last, into the fingerprints of the rows `(N, 2)`."""
        if len(results) != _TOGETHER:
            digest.absorb(results, fingerprint)
            results = (digest.NOTHING,) * _TOGETHER
        a, b, c, d, e = results
        true, measured = self.batch.values
        mix = functools.partial(digest.absorb_together, a, b, c, d, e, self._sizes, true, measured)
        self._share(0, lambda first, end: mix(first, end, fingerprint))

    def _finders_among(self, view: GroupView) -> tuple[Any, ...]:
        if self._among is None:
            columns, begin = [], 0
            for finder in self._finders:
                rays = len(finder.table[0][0])
                columns.append([*finder.line[2:5:2].tolist(), finder.per_row, int(finder.line[1]), begin, rays])
                begin += rays
            carriers = [view.carriers(finder.per_row) for finder in self._finders]
            tables = [finder.table for finder in self._finders]
            self._among = (
                np.array(columns, dtype=np.int64),
                *(np.concatenate(each) for each in zip(*carriers, strict=True)),
                *(np.concatenate(each, axis=1)[0] for each in zip(*tables, strict=True)),
            )
        return self._among

    def _share(self, work: int, part: Callable[[int, int], None]) -> None:
        self._world.workers.share(self._rows, work + self._read_work, part)


class _Finder:
    """A range finder of the plan: what beams it has."""

    def __init__(self, unit: SensorUnit, line: Ints) -> None:
        sensor: Any = unit.sensor
        self.line = line  # of the table of devices
        self.is_cone = type(sensor) is Sonar
        size = int(line[1])
        self.per_row = size if self.is_cone else 1
        self.work = size * (CONE_WORK if self.is_cone else 1)
        bearings = cone_bearings(float(sensor.half_angle[0, 0])) if self.is_cone else sensor.bearings()
        self.table = directions_of(bearings)


class _Beams:
    """The beams of range finders, one after another, as `sensing.Plan` has them; `columns` are of its table."""

    def __init__(self, finders: Sequence[_Finder]) -> None:
        cosines, sines = [np.zeros(0)], [np.zeros(0)]
        orders, starts = [_NONE], [_NONE]
        self.columns = []
        for finder in finders:
            (cosine,), (sine,) = finder.table
            rays = len(cosine)
            begin, sector = sum(map(len, cosines)), sum(map(len, starts))
            if not finder.is_cone:
                cosine, sine, order, start = scans.sorted_beams(cosine, sine)
                rays = len(cosine)
                starts.append(start)
            else:
                order = np.zeros(rays, dtype=np.int64)
            cosines.append(cosine)
            sines.append(sine)
            orders.append(order)
            self.columns.append((begin, rays, sector))
        self.cosines, self.sines = np.concatenate(cosines), np.concatenate(sines)
        self.order, self.starts = np.concatenate(orders), np.concatenate(starts)


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
    if kind == sensing.LASER and (sensor.range_min > 0.0).any():
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


def _limits(unit: SensorUnit, places: int) -> Array:
    """The longest range [m] that is seen from each place, `(N * places,)`."""
    sensor: Any = unit.sensor
    return np.repeat(sensor.range_max[:, 0], places)


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
