"""From a robot's nominal parameters to its true ones: deviations applied, random ones drawn."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from amorsim.core.distributions import STUDY, Distribution, drawn
from amorsim.core.errors import Fault, ScenarioError, did_you_mean
from amorsim.core.parameters import ParameterError
from amorsim.scenario.parameter_paths import changed
from amorsim.scenario.spec import Deviation, Number, Robot

__all__ = ["has_draws", "true_robot", "true_robots"]

_ROOTS = ("drive", "sensors", "pose")


def has_draws(robot: Robot) -> bool:
    """Whether replicas of this robot differ: some deviation is drawn for each replica."""
    return any(deviation.per == "replica" and deviation.is_drawn for deviation in robot.errors.values())


def true_robot(robot: Robot, seed: int, replica: int) -> Robot:
    """The robot with its true parameters in one replica: every parameter that `errors` names is changed.

    Raises
    ------
    ScenarioError
        With a fault for each path that leads nowhere, and each true value that its field does not accept.
    """
    faults = []
    true = robot
    for path, deviation in robot.errors.items():
        try:
            _check_root(path.split("."))
            deviate = functools.partial(_apply, robot, path, deviation, seed, replica)
            true = changed(true, path.split("."), deviate)
        except (ParameterError, LookupError) as error:
            problem = error.problem if isinstance(error, ParameterError) else error.args[0]
            if isinstance(error, ParameterError) and deviation.is_drawn:
                whom = "this seed" if deviation.per == "study" else f"replica {replica}"
                problem = f"{problem}, drawn for {whom}; take a narrower distribution"
            faults.append(Fault(file="", path=f"robots.{robot.name}.errors.{path}", message=problem))
    if faults:
        raise ScenarioError(faults)
    return true


def true_robots(robots: Sequence[Robot], replicas: npt.NDArray[np.integer], seed: int) -> list[Robot]:
    """Each robot with its true parameters in its replica; one object for all replicas if none draws any of them."""
    resolved: dict[tuple[int, int], Robot] = {}
    true = []
    for robot, replica in zip(robots, replicas.tolist(), strict=True):
        drawn = any(deviation.per == "replica" for deviation in robot.errors.values())
        key = (id(robot), replica if drawn else -1)
        if key not in resolved:
            resolved[key] = true_robot(robot, seed, replica)
        true.append(resolved[key])
    return true


def _check_root(path: list[str]) -> None:
    # One way for each: errors change geometry and constants, which the software knows too; noise chains do the rest.
    if path[0] not in _ROOTS:
        raise LookupError(f"expected drive, sensors or pose, got {path[0]!r}.{did_you_mean(path[0], _ROOTS)}")
    if path[0] == "sensors" and path[2:3] and path[2] in ("noise", "rate", "latency"):
        raise LookupError(f"{path[2]!r} has no error; change the noise chain of the sensor itself")


def _apply(robot: Robot, path: str, deviation: Deviation, seed: int, replica: int, nominal: float) -> float:
    who = STUDY if deviation.per == "study" else replica

    def number(part: Number, role: str) -> float:
        if not isinstance(part, Distribution):
            return part
        return drawn(part, seed, (robot.name, "errors", path, role), who)

    if deviation.value is not None:
        return number(deviation.value, "value")
    return nominal * number(deviation.scale, "scale") + number(deviation.add, "add")
