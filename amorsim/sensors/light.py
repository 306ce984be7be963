"""A ring of sensors of ambient light."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Mount, Sensor, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import wrap_angle
from amorsim.kernels import elementary
from amorsim.sensors.response import ring_poses

__all__ = ["Light"]

_MOST_RAYS = 100_000  # towards lamps at once
_NOTHING: Mapping[str, Array] = types.MappingProxyType({})


@attrs.frozen(kw_only=True)
class Light(Sensor):
    """How bright it is before each element of a ring, in counts, from the lamps of the scenario.

    A lamp has intensity I, distance d and angle b from the element's axis. If no wall and no other body hides it, it
    adds a brightness of I g(d) cos(b * 90 deg / half_angle), and nothing beyond the half angle. With ``falloff =
    "linear"`` g is 1 - d / reach, and 0 beyond the reach. With ``"inverse_square"`` g is 1 / d^2; with a half angle of
    90 degrees the brightness is then an illuminance [lx]. The reading is ``dark + gain * brightness`` with the sum over
    all lamps, limited by ``bright``.

    The defaults are the Khepera's, from the Khepera Simulator 2.0 of O. Michel (1995): 500 in the dark, 50 in full
    light, lamps that reach 25 cm, 60 degrees to either side. Its noise, five per cent either way, belongs in the chain.

    Parameters
    ----------
    elements
        Where each element sits and looks, in the frame of the ring's mount. One straight ahead by default.
    half_angle
        Angle between an element's axis and the edge of its field of view [rad].
    falloff, reach
        How brightness falls with distance, and with ``"linear"`` where it ends [m].
    dark, gain, bright
        The reading in the dark, the change for a brightness of 1, and the limit of the reading; none for no limit.
    """

    unit: ClassVar[str] = "count"

    elements: tuple[Mount, ...] = parameter((Mount(),), help="where each element sits on the mount, and looks")
    half_angle: float = parameter(
        math.pi / 3.0, unit="rad", gt=0, le=math.pi / 2.0, help="between an element's axis and the edge of its sight"
    )
    falloff: str = parameter(
        "linear", choices=("linear", "inverse_square"), static=True, help="how brightness falls with distance"
    )
    reach: float = parameter(0.25, unit="m", gt=0, help="where light ends that falls linearly")
    dark: float = parameter(500.0, unit="count", help="reading in the dark")
    gain: float = parameter(-450.0, unit="count", help="what a brightness of 1 adds to it")
    bright: float | None = parameter(50.0, unit="count", help="what the reading never passes; none for no end")

    def __attrs_post_init__(self) -> None:
        if not self.elements:
            raise ParameterError("elements", "expected one element at least, got none")
        if self.bright is not None and (self.bright - self.dark) * self.gain < 0:
            raise ParameterError(
                "bright", f"expected a reading that a gain of {self.gain!r} leads to from {self.dark!r}"
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

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Counts `(N, k)`."""
        origins = ring_poses(view, self.elements, aim)
        lights = view.lights()
        brightness = np.zeros((view.rows, len(origins) // view.rows))
        together = max(1, _MOST_RAYS // len(origins))
        for first in range(0, len(lights.places), together):
            some = slice(first, first + together)
            reached = self._from(view, origins, lights.places[some]).reshape(*brightness.shape, -1)
            for lamp, intensity in enumerate(lights.intensity[some].tolist()):
                brightness = brightness + intensity * reached[:, :, lamp]
        counts = np.asarray(self.dark + self.gain * brightness)
        if self.bright is None:
            return counts, _NOTHING
        darkens = np.less(self.gain, 0.0)
        return np.where(darkens, np.maximum(counts, self.bright), np.minimum(counts, self.bright)), _NOTHING

    def _from(self, view: View, origins: Array, places: Array) -> Array:
        """Brightness `(N * k, M)` at each element from lamps of intensity 1 at `places` `(M, 2)`."""
        k = len(origins) // view.rows
        dx, dy = places[:, 0] - origins[:, :1], places[:, 1] - origins[:, 1:2]
        away = np.sqrt(dx * dx + dy * dy)
        bearing = wrap_angle(elementary.arctan2(dy, dx) - origins[:, 2:])
        half_angle = np.repeat(np.asarray(self.half_angle), k, axis=0)
        if self.falloff == "linear":
            falloff = np.maximum(0.0, 1.0 - away / np.repeat(np.asarray(self.reach), k, axis=0))
        else:
            falloff = 1.0 / np.maximum(away * away, 1e-12)
        reached = np.where(np.abs(bearing) < half_angle, falloff * np.cos(bearing * (0.5 * math.pi) / half_angle), 0.0)
        # Elements that a lamp does not reach cast no ray.
        farthest = np.where(reached > 0.0, away, 0.0)
        if not farthest.any():
            return reached
        # Lamps block no rays, so a ray that ends before its lamp has met something that hides it. Each row's needed
        # rays come first; rays beyond the largest number that any row needs are left out.
        per_row = (view.rows, k * len(places))
        wanted = (farthest > 0.0).reshape(per_row)
        most = int(wanted.sum(axis=1).max())
        which = np.argsort(~wanted, axis=1, kind="stable")[:, :most] + per_row[1] * np.arange(view.rows)[:, None]
        which = which.reshape(-1)
        free = np.full(away.size, np.inf)
        free[which] = view.cast(
            origins[which // len(places)], bearing.reshape(-1, 1)[which], farthest.reshape(-1, 1)[which]
        )[:, 0]
        return np.where(free.reshape(away.shape) < away, 0.0, reached)
