"""A ring of ultrasonic range finders."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Emission, Mount, Sensor, SensorBinding, Side, State, View, parameter
from amorsim.core.execution.workers import at_first_call, in_turn
from amorsim.core.parameters import ParameterError
from amorsim.kernels.sensing import readings
from amorsim.sensors.hearing import bind_hearing
from amorsim.sensors.incidence import bind_nearest_incidence
from amorsim.sensors.response import ring_poses

__all__ = ["Sonar"]


@attrs.frozen(kw_only=True)
class Sonar(Sensor):
    """The nearest return [m] in the cone of each element of a ring; inf where nothing returns.

    Parameters
    ----------
    elements
        Where each element sits and looks, in the frame of the ring's mount. One element straight ahead by
        default.
    half_angle
        Angle from the axis of a cone to its edge [rad]. The default is half of the 30 degrees that MobileSim
        gives the Pioneer's sonars.
    range_min
        Nearer things read this range [m], because the transducer still rings when their echo arrives.
    range_max
        Longest range that is seen [m].
    medium
        Name of the medium, such as ``"ultrasound"``. Elements in the same medium hear each other, and a `cross_talk` in
        the chain takes that sound for an echo. Empty: they hear no others and no others hear them.
    firing
        The turn in which each element fires, from 0 on; elements of one turn fire together. Empty: all at once.
    interval
        Time from one turn to the next [s]. The default is the Pioneer's, whose arrays each fire one element at 25 Hz
        [remembered].
    phase
        Time of the first turn [s], from the tick of the reading on. Rings of different robots are not in step, so
        draw it: ``errors.sensors.sonar.phase = { add = { uniform = [0.0, 0.3] } }``.
    """

    unit: ClassVar[str] = "m"

    elements: tuple[Mount, ...] = parameter((Mount(),), help="where each element sits on the mount, and looks")
    half_angle: float = parameter(
        math.pi / 12.0, unit="rad", ge=0, le=math.pi / 2.0, help="between a cone's axis and its edge"
    )
    range_min: float = parameter(0.1, unit="m", ge=0, help="nearer things read as this far")
    range_max: float = parameter(5.0, unit="m", gt=0, help="longest range that is seen")
    traversal: str = parameter(
        "exact",
        choices=("exact", "bresenham"),
        static=True,
        help="how walls are looked for: exactly, or along the cells of Bresenham's line as the original AMORsim did",
    )
    medium: str = parameter(  # type: ignore[misc]  # of each sonar, where other sensors have it of their class
        "", static=True, help="what it fires into, where others hear it; empty: hears nobody, and is not heard"
    )
    firing: tuple[int, ...] = parameter((), ge=0, help="turn in which each element fires, from 0; empty: all at once")
    interval: float = parameter(0.04, unit="s", ge=0, help="from one turn to the next")
    phase: float = parameter(0.0, unit="s", help="when the first turn is, from the tick on")

    def __attrs_post_init__(self) -> None:
        if not self.elements:
            raise ParameterError("elements", "expected one element at least, got none")
        if self.range_min >= self.range_max:
            raise ParameterError(
                "range_min", f"expected less than range_max {self.range_max!r}, got {self.range_min!r}"
            )
        if self.firing and len(self.firing) != len(self.elements):
            raise ParameterError(
                "firing", f"expected a turn for each of {len(self.elements)} elements, got {len(self.firing)}"
            )

    def size(self, drive: Drive) -> int:
        """One value for each element."""
        return int(self.bearings().shape[1])

    def bearings(self) -> Array:
        """Directions [rad] `(N, k)` of the elements' axes, from the mount's heading."""
        elements: Any = self.elements
        if isinstance(elements, Mount):  # over rows: a table of arrays
            return np.asarray(elements.heading)
        return np.array([[element.heading for element in elements]])

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Search the cones on the engine's own arrays, unless something bends them."""
        if at.aim is not None:
            return super().bind(at)
        ring: Any = self.elements
        origins = np.empty((ring.x.size, 3))
        place = functools.partial(readings.place_ring, at.pose, ring.x, ring.y, ring.heading, origins)
        half_angle: Any = self.half_angle
        range_max: Any = self.range_max
        cones = _Cones(at.view, origins, half_angle, range_max, at.out, self.traversal)
        ring_down = functools.partial(np.maximum, at.out, self.range_min, out=at.out)
        sides = self._sides(at.view, origins) | {"incidence": cones.bind_incidence}
        at.sides.update({name: at_first_call(bind) for name, bind in sides.items()})
        return in_turn([place, cones.search, ring_down])

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Ranges `(N, k)` [m], inf for no return; for the chain also the nearest return's ``incidence`` [rad].

        With a `medium`, also ``heard`` [m]: the range that the sound of others would read, inf for silence.
        """
        origins = ring_poses(view, self.elements, aim)
        half_angle: Any = self.half_angle
        range_max: Any = self.range_max
        ranges = view.cone(origins, half_angle, range_max, self.traversal)
        sides = {name: at_first_call(bind) for name, bind in self._sides(view, origins).items()}
        return np.maximum(ranges, self.range_min), Side(**sides)

    def _sides(self, view: View, origins: Array) -> dict[str, Callable[[], Callable[[], Array]]]:
        """What a chain may need, by name: each a function that binds it, for elements at `origins`."""
        half_angle: Any = self.half_angle
        near: Any = self.range_min
        far: Any = self.range_max
        sides: dict[str, Callable[[], Callable[[], Array]]] = {
            "incidence": lambda: _bind_incidence(view, origins, half_angle, far)
        }
        if self.medium:
            turns = self._turns(view.rows)
            emissions = view.bind_emissions(self.medium)  # now, while the view is this sensor's
            sides["heard"] = lambda: bind_hearing(view, emissions, origins, half_angle, turns, near, far)
        return sides

    def emit(self, view: View, state: State) -> Emission | None:
        """All elements, each in its turn."""
        time = self._turns(view.rows)
        return Emission(
            poses=ring_poses(view, self.elements, Aim()).reshape(*time.shape, 3),
            half_angle=np.repeat(self.half_angle, time.shape[1], axis=1),
            fired=np.ones(time.shape, dtype=bool),
            time=time,
        )

    def bind_emit(self, at: SensorBinding) -> Callable[[], Emission]:
        """Place all elements in the world."""
        ring: Any = self.elements
        time = self._turns(at.rows)
        half_angle = np.repeat(self.half_angle, time.shape[1], axis=1)
        emission = Emission(np.empty((*time.shape, 3)), half_angle, np.ones(time.shape, dtype=bool), time)
        origins = emission.poses.reshape(-1, 3)

        def emit() -> Emission:
            readings.place_ring(at.pose, ring.x, ring.y, ring.heading, origins)
            return emission

        return emit

    def _turns(self, rows: int) -> Array:
        """Firing time `(N, k)` [s] of each element after the tick."""
        turns: Any = self.firing
        late = np.zeros((rows, self.bearings().shape[1])) if isinstance(turns, tuple) else turns * self.interval
        return np.asarray(late + self.phase)


class _Cones:
    """The search in all cones. Once angles of incidence are wanted, it also tells where the nearest walls are."""

    def __init__(
        self, view: View, origins: Array, half_angle: Array, range_max: Array, out: Array, traversal: str
    ) -> None:
        self._view, self._given, self._out, self._traversal = view, (origins, half_angle, range_max), out, traversal
        self._search = view.bind_cone(*self._given, out, traversal)

    def search(self) -> None:
        """Write the nearest returns into `out`."""
        self._search()

    def bind_incidence(self) -> Callable[[], Array]:
        """A function of the angles of incidence [rad] `(N, m)` after a search: that of this step, or a later one."""
        if self._traversal != "exact":  # its search is of cells, not of walls
            return _bind_incidence(self._view, *self._given)
        wall = np.empty(self._out.shape), np.empty(self._out.shape)
        self._view.bind_nearest_wall(*self._given, *wall)()
        self._search = self._view.bind_cone(*self._given, self._out, wall=wall)
        return bind_nearest_incidence(self._view, *self._given, wall)


def _bind_incidence(view: View, origins: Array, half_angle: Array, range_max: Array) -> Callable[[], Array]:
    """A function of the angles of incidence [rad] `(N, m)` in cones, which looks for the nearest walls itself."""
    shape = view.rows, len(origins) // view.rows
    wall = np.empty(shape), np.empty(shape)
    find = view.bind_nearest_wall(origins, half_angle, range_max, *wall)
    incidence = bind_nearest_incidence(view, origins, half_angle, range_max, wall)

    def find_and_tell() -> Array:
        find()
        return incidence()

    return find_and_tell
