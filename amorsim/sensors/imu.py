"""An inertial measurement unit: two accelerometers and a gyro."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Context, Draws, Drive, Sensor, State, View
from amorsim.kernels.sensing import readings

__all__ = ["Imu"]

_NOTHING: Mapping[str, Array] = types.MappingProxyType({})
_COLUMNS: Mapping[str, str] = types.MappingProxyType({"ahead": "m/s^2", "left": "m/s^2", "turn": "rad/s"})


@attrs.frozen(kw_only=True)
class Imu(Sensor):
    """Specific force ahead and to the left [m/s^2], in the mount's frame, and the rate of turn [rad/s].

    On level ground the specific force is the acceleration of the mount: v' + w x v, where v is the mount's velocity
    in the body's frame and w the rate of turn. On a circle, a unit ahead of the axle thus measures the centripetal
    acceleration of its own, larger circle. v is the mean velocity over the last step. v' is its change since the
    previous sample, divided by the time between; when a wall stops the robot, it appears within one step. Before the
    second sample v' is 0.
    """

    unit: ClassVar[str] = "mixed"

    def size(self, drive: Drive) -> int:
        """Three values."""
        return 3

    def columns(self) -> Mapping[str, str]:
        """Two accelerations and a rate."""
        return _COLUMNS

    def start(self, context: Context) -> State:
        """Velocity `(N, 2)` of the mount in the body's frame at the previous sample, and its tick `(N, 1)`."""
        rows = context.rows
        return {"velocity": np.zeros((rows, 2)), "tick": np.full((rows, 1), -1, dtype=np.int64)}

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Accelerations and rate `(N, 3)`."""
        values, velocity = np.empty((view.rows, 3)), np.empty((view.rows, 2))
        readings.specific_force(
            view.twist, view.mount, state["velocity"], state["tick"], view.tick, view.dt, velocity, values
        )
        state["velocity"], state["tick"] = velocity, view.tick.copy()
        return values, _NOTHING
