"""Handles to one robot or obstacle of a running simulation, for scripts and analysis: truth included."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import Estimate, Measurement, RobotModel
from amorsim.contracts.joints import joints_of
from amorsim.controllers.abilities import command_along
from amorsim.controllers.manual import limited
from amorsim.core.error_text import in_words
from amorsim.core.errors import AmorsimError
from amorsim.core.parameters import LARGEST
from amorsim.core.unknown_names import no_such

if TYPE_CHECKING:
    from amorsim.scenario.spec import Robot
    from amorsim.simulation.fleet.fleet import Fleet
    from amorsim.simulation.fleet.group import Group
    from amorsim.simulation.fleet.obstacles import ObstacleGroup

__all__ = ["Known", "ObstacleHandle", "Reading", "Readings", "RobotHandle", "finite_numbers"]


_NUMBER = (int, float, np.integer, np.floating)


class Reading(NamedTuple):
    """A sensor's reading with its truth, for rows `(N, k)` or for one robot `(k,)`."""

    true: Array
    measured: Array
    stamp: Ints  # the tick of both
    age: Array  # [s]
    fresh: Bools


class Known(NamedTuple):
    """What the robots of some rows know: a model of themselves, readings as measured, an estimate of their poses."""

    robot: RobotModel
    readings: Mapping[str, Measurement]
    estimate: Estimate


class Readings(Mapping[str, Reading]):
    """The readings of a group's rows, or of one of them, by the sensor's name."""

    def __init__(self, group: Group, row: int | None = None) -> None:
        self._group = group
        self._row = row

    def __getitem__(self, name: str) -> Reading:
        sensors = self._group.sensors
        if name not in sensors:
            raise KeyError(no_such("sensor", name, sensors))
        held = sensors[name]
        whole = (held.true, held.measured, held.stamp, held.age, held.fresh)
        parts = whole if self._row is None else tuple(part[self._row] for part in whole)
        return Reading(*(_read_only(part) for part in parts))

    def __iter__(self) -> Iterator[str]:
        return iter(self._group.sensors)

    def __len__(self) -> int:
        return len(self._group.sensors)


class _Handle:
    """A body of a simulation; resets and changes may give that another fleet, so it is looked up in the present one.

    Parameters
    ----------
    fleet
        Returns the fleet that the simulation has now.
    body
        The body's index, the same in all of them.
    """

    def __init__(self, fleet: Callable[[], Fleet], body: int) -> None:
        self._present = fleet
        self._body = body
        self._fleet: Fleet | None = None  # in which it was looked up
        self._place: tuple[Any, int] = None, 0

    def _find(self) -> tuple[Any, int]:
        fleet = self._present()
        if fleet is not self._fleet:
            self._fleet, self._place = fleet, fleet.row_of(self._body)
        return self._place

    @property
    def _row(self) -> int:
        return self._find()[1]


class RobotHandle(_Handle):
    """One robot in one replica. Its values are those of the present step; read them again after the next."""

    @property
    def _group(self) -> Group:
        group: Group = self._find()[0]
        return group

    def __repr__(self) -> str:
        x, y, heading = self.true_pose
        return f"<robot {self.name!r} at ({x:.3f}, {y:.3f}) m, heading {heading:.3f} rad>"

    @property
    def name(self) -> str:
        """Its name."""
        return self._group.names[self._row]

    @property
    def replica(self) -> int:
        """The number of the replica it is in."""
        return int(self._group.row_clock.replica[self._row])

    @property
    def true_pose(self) -> Array:
        """The true pose: (x [m], y [m], heading [rad]) in the world."""
        return _read_only(self._group.true_pose[self._row])

    @property
    def estimated_pose(self) -> Array:
        """The estimated pose: (x [m], y [m], heading [rad]) in the world."""
        return _read_only(self._group.estimate.pose[self._row])

    @property
    def covariance(self) -> Array:
        """The covariance `(3, 3)` of its estimate, by its own estimator."""
        return _read_only(self._group.estimate.covariance[self._row])

    @property
    def true_twist(self) -> Array:
        """Its mean velocity over the last step: (forward [m/s], left [m/s], turn [rad/s])."""
        return _read_only(self._group.true_twist[self._row])

    @property
    def joints(self) -> Array:
        """Positions [rad] of its drive's joints."""
        return _read_only(self._group.joints[self._row])

    @property
    def parts(self) -> Mapping[str, Array]:
        """True poses of its parts, by name: (x [m], y [m], heading [rad]) in the world."""
        parts = self._group.parts
        if parts is None:
            return {}
        poses = _read_only(parts.of(self._row))
        return {part.name: pose for part, pose in zip(self._group.drive.parts, poses, strict=True)}

    @property
    def readings(self) -> Readings:
        """Its readings by sensor, true and measured."""
        return Readings(self._group, self._row)

    @property
    def is_active(self) -> bool:
        """Whether its controller has not ended."""
        return bool(self._group.driver.active[self._row, 0])

    @property
    def is_by_hand(self) -> bool:
        """Whether it was handed over and is driven from outside (`Simulation.hand_over`)."""
        return bool(self._group.driver.by_hand[self._row, 0])

    @property
    def takes_commands(self) -> bool:
        """Whether it accepts `drive` and `command`: it was handed over, or its controller is `manual`."""
        return self.is_by_hand or "command" in self._group.driver.state

    @property
    def nominal(self) -> Robot:
        """Its present specification: the nominal parameters, and in `errors` how the true ones differ."""
        robot: Robot = self._group.specified[self._row]
        return robot

    @property
    def true(self) -> Robot:
        """The same robot with its true parameters."""
        return self._group.true[self._row]

    @property
    def channels(self) -> tuple[str, ...]:
        """The names of its command's channels: the drive's, then those of devices that take commands."""
        return self._group.channels

    def command_for(self, forward: float = 0.0, turn: float = 0.0, left: float = 0.0) -> list[float]:
        """The command that makes it go forward [m/s], turn [rad/s] and go left [m/s], or as close as possible.

        The robot's own software computes it, with nominal parameters and within the limits of a `manual` controller;
        devices keep their commands. Forward is the direction in which the drive travels: for a synchro drive, the
        direction of its wheels.

        Raises
        ------
        AmorsimError
            If these are not finite numbers, or one is above 1e12.
        """
        group, row = self._group, self._row
        wanted = finite_numbers((forward, left, turn))
        if wanted is None or max(map(abs, wanted)) > LARGEST:
            raise AmorsimError(
                f"robot {self.name!r}: expected finite numbers for forward, turn and left, of {LARGEST:g} at most, "
                f"got {in_words((forward, turn, left))}"
            )
        twists = np.zeros((group.rows, 3))
        twists[row] = wanted
        joints = joints_of(group.robot, group.readings)
        along = command_along(group.robot, limited(group.driver.controller, twists), joints)
        wheels: list[float] = along[row].tolist()
        devices: list[float] = group.command[row, len(wheels) :].tolist()
        return [*wheels, *devices]

    def drive(self, forward: float = 0.0, turn: float = 0.0, left: float = 0.0) -> None:
        """Set the velocity of a robot driven by hand: forward [m/s], turn [rad/s], left [m/s], held until the next.

        The command is that of `command_for`.
        """
        self.command(*self.command_for(forward, turn, left))

    def command(self, *channels: float) -> None:
        """Set the command of a robot driven by hand, channel by channel [rad/s], held until the next.

        Raises
        ------
        AmorsimError
            If its controller is not `manual` and it was not handed over, or if these are not finite numbers, one for
            each channel.
        """
        group = self._group
        names = group.channels
        if not self.takes_commands:
            raise AmorsimError(
                f"robot {self.name!r}: only the 'manual' controller takes commands from outside, and this is "
                f"{type(group.driver.controller).__name__}; take the robot over with hand_over({self.name!r}) first"
            )
        rates = finite_numbers(channels)
        if rates is None or len(rates) != len(names):
            raise AmorsimError(
                f"robot {self.name!r}: expected a finite number for each of {', '.join(names)}, got "
                f"{in_words(channels)}"
            )
        if self.is_by_hand:
            group.driver.hand[self._row] = rates
        else:
            group.driver.state["command"][self._row] = rates


class ObstacleHandle(_Handle):
    """One obstacle in one replica. Its values are those of the present step; read them again after the next."""

    @property
    def _group(self) -> ObstacleGroup:
        group: ObstacleGroup = self._find()[0]
        return group

    @property
    def true_pose(self) -> Array:
        """The true pose: (x [m], y [m], heading [rad]) in the world."""
        return _read_only(self._group.true_pose[self._row])

    @property
    def true_twist(self) -> Array:
        """Its mean velocity over the last step: (forward [m/s], left [m/s], turn [rad/s])."""
        return _read_only(self._group.true_twist[self._row])


def finite_numbers(values: Any) -> list[float] | None:
    """Numbers as floats; None if they are not a sequence, or one is not a finite number."""
    try:
        numbers = [float(value) for value in values if isinstance(value, _NUMBER) and not isinstance(value, bool)]
        is_whole = len(numbers) == len(values)
    except (TypeError, OverflowError):  # not a sequence; an integer of hundreds of digits
        return None
    return numbers if is_whole and all(map(math.isfinite, numbers)) else None


def _read_only(array: npt.NDArray[np.generic]) -> npt.NDArray:  # type: ignore[type-arg]
    copy = array.copy()  # the engine writes into its own in the next step
    copy.flags.writeable = False
    return copy
