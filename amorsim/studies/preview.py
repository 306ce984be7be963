"""Previews of a robot's errors: its estimates on a square, and the scatter of its sensors' readings."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.controllers.square import Square
from amorsim.core.errors import AmorsimError
from amorsim.core.poses import wrap_angle
from amorsim.scenario.spec import Deviation, Robot, Scenario
from amorsim.simulation.simulation import Simulation
from amorsim.studies.robot_under_test import alone, empty_world, only_odometry, with_known_place

__all__ = ["SquarePreview", "preview_noise", "preview_square"]


_SPEED = 0.5  # [m/s] of the square's driver


@attrs.frozen(kw_only=True)
class SquarePreview:
    """Paths of a square that a robot believes to drive, in replicas with errors of their own.

    Attributes
    ----------
    true, estimated
        Positions `(R, T, 2)` [m] from the start.
    """

    true: Array
    estimated: Array

    @property
    def ends(self) -> Array:
        """Where each really ends, seen from where it believes to be `(R, 2)` [m]."""
        return np.asarray(self.true[:, -1] - self.estimated[:, -1])


def preview_square(scenario: Scenario, robot: Robot, *, side: float = 10.0, replicas: int = 20) -> SquarePreview:
    """The paths of a robot that drives one square by dead reckoning in an empty world, with its errors drawn.

    Raises
    ------
    AmorsimError
        If it has no odometry, cannot drive a square, or does not come round.
    """
    driver, _ = only_odometry(robot)
    square = Square(side=side, speed=_SPEED)
    driver = attrs.evolve(driver, controller=square, on_collision="end")
    simulation = Simulation(alone(scenario, driver, empty_world(1.5 * side + 10.0)), replicas=replicas)
    group = simulation._fleet.groups[0]
    start = simulation.true_pose, simulation.estimated_pose
    every = max(1, simulation.steps_of(0.2))
    most = simulation.steps_of(8.0 * (side / _SPEED + 2.0 * np.pi / square.turn_rate) + 60.0)
    paths: list[tuple[Array, Array]] = []
    while not (group.driver.state["reached"] >= 4).all():
        if simulation.tick % every == 0:
            paths.append((simulation.true_pose, simulation.estimated_pose))
        if simulation.tick > most:
            raise AmorsimError(f"robot {robot.name!r} does not come round a square of {side:g} m")
        simulation.step()
    paths.append((simulation.true_pose, simulation.estimated_pose))
    true, estimated = (np.array([pair[n] for pair in paths])[..., :2].swapaxes(0, 1) for n in (0, 1))
    return SquarePreview(true=true - start[0][:, None, :2], estimated=estimated - start[1][:, None, :2])


def preview_noise(scenario: Scenario, name: str, sensor: str, *, samples: int = 2000, replicas: int = 20) -> Array:
    """Errors `(n,)` of a sensor's readings, in its unit, while its robot stands at its start.

    Values without a return are left out. For a robot whose start is drawn, each replica has its own.

    Raises
    ------
    AmorsimError
        If there is no such robot or sensor.
    """
    robot = next((one for one in scenario.robots if one.name == name), None)
    if robot is None or sensor not in robot.sensors:
        raise AmorsimError(f"there is no sensor {sensor!r} of a robot {name!r}")
    standing = attrs.evolve(
        with_known_place(robot),
        controller=None,
        sensors={sensor: robot.sensors[sensor]},
        estimators={},
        errors=_errors_of(robot, sensor),
    )
    simulation = Simulation(attrs.evolve(alone(scenario, standing), obstacles=[]), replicas=replicas)
    is_angle = robot.sensors[sensor].sensor.unit == "rad"
    found: list[Array] = []
    count = 0
    for _ in range(simulation.steps_of(60.0)):
        simulation.step()
        reading = simulation.readings[sensor]
        rows = reading.fresh.ravel()
        if not rows.any():
            continue
        with np.errstate(invalid="ignore"):
            difference = reading.measured[rows] - reading.true[rows]
        fine = difference[np.isfinite(difference)]
        found.append(wrap_angle(fine) if is_angle else fine)
        count += fine.size
        if count >= samples:
            break
    return np.concatenate(found)[:samples] if found else np.empty(0)


def _errors_of(robot: Robot, sensor: str) -> dict[str, Deviation]:
    """The errors of the sensor alone."""
    return {path: error for path, error in robot.errors.items() if path.split(".")[:2] == ["sensors", sensor]}
