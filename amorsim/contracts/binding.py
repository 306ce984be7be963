"""The arrays that components are bound to: those of their robots, which keep their place, and those for results.

`bind` of a component returns the function that each step calls. Arrays here are those of the engine itself: read all of
them, and write into `out` and `state` only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import attrs

from amorsim.array_types import Array, Ints
from amorsim.contracts.values import Aim, Estimate, Measurement, State
from amorsim.contracts.view import View
from amorsim.core.draws import Draws

if TYPE_CHECKING:
    from amorsim.contracts.robot import RobotModel

__all__ = ["ControllerBinding", "DriveBinding", "EstimatorBinding", "SensorBinding", "simple_form_first"]

C = TypeVar("C", bound=type)


@attrs.frozen(kw_only=True, eq=False)
class SensorBinding:
    """A sensor of N robots: what it may look at, and where its reading goes."""

    rows: int
    dt: float
    """The step [s]."""
    tick: Ints
    """(N, 1)"""
    pose: Array
    """True pose of the mount in the world (N, 3)."""
    body_pose: Array
    """True pose of the robot's base in the world (N, 3)."""
    twist: Array
    """Mean true velocity over the last step, in the body's frame (N, 3) [m/s, m/s, rad/s]."""
    joints: Array
    """True positions of the drive's joints (N, j)."""
    joint_rates: Array
    """(N, j)"""
    view: View
    """For queries, such as `bind_cast`. Its own arrays are those of the last `look`."""
    look: Callable[[], View]
    """Returns the view with copies of the present arrays."""
    state: State
    draws: Draws
    aim: Callable[[], Aim] | None
    """Returns the aim of this sample; None if nothing bends the sensor's beams."""
    sides: dict[str, Callable[[], Array]]
    """For further quantities that the noise chain may need: functions that compute them, by name."""
    out: Array
    """The reading (N, k)."""
    answer: Callable[[Any, Mapping[str, Array]], None]
    """Checks what `Sensor.sense` returned, and takes it."""


@attrs.frozen(kw_only=True, eq=False)
class DriveBinding:
    """The motors of N robots: where their joints are, and where these go in a step."""

    rows: int
    dt: float
    """The step [s]."""
    joints: Array
    """Positions of the joints at the beginning of the step (N, j) [rad]."""
    joint_rates: Array
    """Their rates then (N, j) [rad/s]."""
    command: Array
    """The drive's part of the command (N, c)."""
    state: State
    draws: Draws
    out: Array
    """Positions and rates of the joints a step later (2, N, j)."""
    answer: Callable[[Array, Array], None]
    """Takes what `Drive.advance` returned."""


@attrs.frozen(kw_only=True, eq=False)
class ControllerBinding:
    """A controller of N robots: what it knows, and where its command goes."""

    robot: RobotModel
    readings: Mapping[str, Measurement]
    """The arrays of the current readings."""
    copied_readings: Mapping[str, Measurement]
    """The same in copies, each made when it is looked up."""
    estimate: Estimate
    tick: Ints
    """(N, 1)"""
    time: Array
    """(N, 1) [s]"""
    dt: float
    """The step [s]."""
    state: State
    draws: Draws
    out: Array
    """The command (N, c), all of the robot's channels."""
    answer: Callable[[Any], None]
    """Checks what `Controller.command` returned, and takes it."""


@attrs.frozen(kw_only=True, eq=False)
class EstimatorBinding:
    """An estimator of N robots: what it knows, and where its estimate goes."""

    robot: RobotModel
    readings: Mapping[str, Measurement]
    """The arrays of the current readings."""
    copied_readings: Callable[[], Mapping[str, Measurement]]
    """The same in copies, with the estimates that feed the estimator."""
    command: Array
    """(N, c)"""
    elapsed: Callable[[], Array]
    """Returns the time since the previous update (N, 1) [s]; 0 at the first."""
    state: State
    draws: Draws
    out: Estimate
    answer: Callable[[Any], None]
    """Checks what `Estimator.update` returned, and takes it."""


def simple_form_first(cls: C, pairs: Mapping[str, str], base: type) -> C:
    """Where a class overrides the simple form but not what binds it, let `base` bind it.

    Otherwise a subclass of a bound component that overrides the simple form would be ignored. `pairs` gives the method
    that binds each simple form; the newer of the two stands first in the order in which Python looks methods up.
    """
    for simple, binds in pairs.items():
        newest = next(kind for kind in cls.__mro__ if {simple, binds} & vars(kind).keys())
        if binds not in vars(newest):
            setattr(cls, binds, getattr(base, binds))
    return cls
