"""A scanning laser range finder."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Directions, Draws, Drive, Sensor, SensorBinding, Side, State, View, parameter
from amorsim.core.execution.workers import at_first_call, in_turn
from amorsim.core.parameters import ParameterError
from amorsim.kernels.kinematics import poses
from amorsim.kernels.sensing import readings
from amorsim.sensors.beam_poses import poses_at
from amorsim.sensors.incidence import bind_incidence

__all__ = ["Laser"]

_FULL_CIRCLE = 2.0 * math.pi - 1e-9  # [rad] from this field of view on, the last beam would fall on the first


@functools.lru_cache(maxsize=64)
def _bearings(beams: int, fields_of_view: bytes) -> Array:
    """The result of `Laser.bearings`, from the bytes of the fields of view of all rows."""
    fov = np.frombuffer(fields_of_view).reshape(-1, 1)
    if (fov == fov[0]).all():
        fov = fov[:1]  # one table of directions for all rows
    steps = np.arange(beams, dtype=np.float64).reshape(1, -1)
    part = steps / (beams - 1) - 0.5 if beams > 1 else steps
    bearings: Array = np.where(fov < _FULL_CIRCLE, part, steps / beams - 0.5) * fov
    bearings.flags.writeable = False
    return bearings


@attrs.frozen(kw_only=True)
class Laser(Sensor):
    """Ranges [m] along beams spread evenly over a field of view, from its right end; inf for no return, -inf too near.

    The first beam looks at -fov / 2 from the mount's heading, the last at fov / 2. In a full circle no direction
    occurs twice. A single beam of a smaller field looks straight ahead.

    Parameters
    ----------
    beams
        Number of beams of a scan.
    fov
        Angle from the first beam to the last [rad].
    range_max
        Longest range that is seen [m].
    range_min
        Shortest range that is measured [m]. Nearer things read -inf, "too close to measure" in ROS (REP 117), and still
        hide what is behind them.
    """

    unit: ClassVar[str] = "m"

    beams: int = parameter(181, ge=1, le=100_000, static=True, help="beams in a scan")
    fov: float = parameter(math.pi, unit="rad", gt=0, le=2.0 * math.pi, help="angle from the first beam to the last")
    range_max: float = parameter(8.0, unit="m", gt=0, help="longest range that is seen")
    range_min: float = parameter(0.0, unit="m", ge=0, help="shortest range that is measured; nearer things read -inf")
    traversal: str = parameter(
        "exact",
        choices=("exact", "bresenham"),
        static=True,
        help="how walls are looked for: exactly, or along the cells of Bresenham's line as the original AMORsim did",
    )

    def __attrs_post_init__(self) -> None:
        if self.range_min >= self.range_max:
            raise ParameterError(
                "range_min", f"expected less than range_max {self.range_max!r}, got {self.range_min!r}"
            )

    def size(self, drive: Drive) -> int:
        """One value for each beam."""
        return self.beams

    def bearings(self) -> Array:
        """Bearings of the beams [rad] from the mount's heading, `(1, beams)`; `(N, beams)` if rows differ."""
        return _bearings(self.beams, np.asarray(self.fov).tobytes())

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Cast beams from the engine's own arrays."""
        ranges = np.empty((at.rows, self.beams))
        blank = functools.partial(readings.blank_near, ranges, self.range_min, at.out)
        if at.aim is not None:
            return in_turn([self._bind_bent(at, at.aim, ranges), blank])
        bearings = self.bearings()
        range_max: Any = self.range_max
        cast = at.view.bind_cast(at.pose, bearings, range_max, ranges, self.traversal)
        view, origins = at.view, at.pose
        at.sides["incidence"] = at_first_call(lambda: bind_incidence(view, origins, bearings, ranges, range_max))
        return in_turn([cast, blank])

    def _bind_bent(self, at: SensorBinding, aim_now: Callable[[], Aim], ranges: Array) -> Callable[[], None]:
        """A function that casts beams as each sample's aim bends them, from where the laser was when they looked."""
        straight, bearings = self.bearings(), np.empty(ranges.shape)
        towards = Directions(np.empty(ranges.shape), np.empty(ranges.shape))
        range_max: Any = self.range_max
        view, body_pose, twist, pose = at.view, at.body_pose, at.twist, at.pose
        moved = np.empty((ranges.size, 3))  # the origin of each beam, where they look at different times

        def bind_beams(origins: Array, each: int) -> tuple[Callable[[], None], Callable[[], Array]]:
            """What casts the beams, `each` of every origin, and what computes their angles of incidence."""
            angles, cos, sin, found = (array.reshape(-1, each) for array in (bearings, *towards, ranges))
            cast = view.bind_cast(origins, Directions(cos, sin), range_max, found, self.traversal)
            return cast, at_first_call(lambda: bind_incidence(view, origins, angles, found, range_max))

        at_once = bind_beams(pose, self.beams)
        one_by_one = functools.cache(lambda: bind_beams(moved, 1))
        cast, incidence = at_once

        def look() -> None:
            nonlocal cast, incidence
            aim = aim_now()
            bearings[:] = straight if aim.bearing is None else straight + aim.bearing
            poses.directions(bearings, *towards)
            cast, incidence = at_once if aim.time is None else one_by_one()
            if aim.time is not None:
                moved[:] = poses_at(body_pose, twist, np.repeat(pose, self.beams, axis=0), aim.time)
            cast()

        at.sides["incidence"] = lambda: incidence().reshape(ranges.shape)
        return look

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Ranges `(N, beams)` [m], inf for no return, -inf for what is nearer than `range_min`.

        For the noise chain also each beam's angle of ``incidence`` [rad].
        """
        bearings = self.bearings()
        if aim.bearing is not None:
            bearings = bearings + aim.bearing
        range_max: Any = self.range_max
        origins = view.pose
        shape = (view.rows, self.beams)
        if aim.time is not None:  # each beam from where the laser was when it looked
            origins = poses_at(view.body_pose, view.twist, np.repeat(origins, self.beams, axis=0), aim.time)
            bearings = np.array(np.broadcast_to(bearings, shape)).reshape(-1, 1)
        ranges = view.cast(origins, bearings, range_max, self.traversal)
        side = Side(incidence=lambda: bind_incidence(view, origins, bearings, ranges, range_max)().reshape(shape))
        shown = np.empty(shape)
        readings.blank_near(ranges.reshape(shape), self.range_min, shown)
        return shown, side
