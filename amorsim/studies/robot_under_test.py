"""One robot taken out of its scenario for an experiment: its true parameters settled, its odometry, a place to be."""

from __future__ import annotations

from collections.abc import Iterable

import attrs
import numpy as np

from amorsim.core.errors import AmorsimError
from amorsim.core.maps.map import Map
from amorsim.core.unknown_names import no_such
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.scenario.initial_belief import InitialBelief
from amorsim.scenario.parameter_paths import value_in
from amorsim.scenario.spec import Deviation, Pose, Robot, Scenario
from amorsim.simulation.truth import true_robot

__all__ = [
    "alone",
    "chosen_robot",
    "empty_world",
    "error_paths",
    "only_odometry",
    "true_value",
    "with_known_place",
    "with_settled_errors",
]

_NOBODY = 0.5  # [m] cells of a world without obstacles


def chosen_robot(scenario: Scenario, name: str | None) -> Robot:
    """The robot of that name, or without one the first.

    Raises
    ------
    AmorsimError
        If there is none of that name.
    """
    names = [robot.name for robot in scenario.robots]
    if name is None:
        return scenario.robots[0]
    if name not in names:
        raise AmorsimError(no_such("robot", name, names))
    return scenario.robots[names.index(name)]


def true_value(robot: Robot, path: str, seed: int) -> float:
    """True value of the number at a path, for the robot of replica 0."""
    return float(value_in(true_robot(robot, seed, 0), path.split(".")))


def with_settled_errors(robot: Robot, seed: int) -> Robot:
    """The robot of replica 0 for every replica: the random values of its errors are drawn once.

    All runs of one experiment thus use the same robot, also in a study with many replicas.
    """
    settled = {path: Deviation(value=true_value(robot, path, seed)) for path in robot.errors}
    return attrs.evolve(robot, errors=settled)


def with_known_place(robot: Robot) -> Robot:
    """The robot that knows its start exactly and is never carried away.

    Neither is an error of its drive or of a sensor, and an experiment would take them for such errors.
    """
    return attrs.evolve(robot, initial_belief=InitialBelief(), kidnappings=())


def error_paths(robot: Robot, sensor: str) -> list[str]:
    """The paths of the errors of the drive, of the start, or of one sensor."""
    return [path for path in robot.errors if path.split(".")[0] in ("drive", "pose") or _is_of(path, sensor)]


def _is_of(path: str, sensor: str) -> bool:
    return path.split(".")[:2] == ["sensors", sensor]


def only_odometry(robot: Robot) -> tuple[Robot, str]:
    """The robot with dead reckoning alone and the encoder that it reads, and the encoder's name.

    It knows its start, and is not carried away. All other sensors are removed: they do not affect odometry, and draws
    depend only on names, so none changes.

    Raises
    ------
    AmorsimError
        If the robot has no sensor that counts its joints.
    """
    reckoning = next(((n, e) for n, e in robot.estimators.items() if isinstance(e, DeadReckoning)), None)
    if reckoning is None:
        counters = [name for name, unit in robot.sensors.items() if callable(getattr(unit.sensor, "angles", None))]
        if not counters:
            raise AmorsimError(
                f"robot {robot.name!r} has no odometry: it has no sensor that counts its joints, such as an encoder"
            )
        reckoning = ("dead_reckoning", DeadReckoning(encoder=counters[0]))
    name, estimator = reckoning
    encoder = estimator.encoder
    if encoder not in robot.sensors:
        raise AmorsimError(f"robot {robot.name!r}: its dead reckoning reads {encoder!r}, which the robot does not have")
    kept = attrs.evolve(
        with_known_place(robot),
        sensors={encoder: robot.sensors[encoder]},
        estimators={name: estimator},
        errors={path: robot.errors[path] for path in error_paths(robot, encoder)},
    )
    return kept, encoder


def empty_world(reach: float, walls: Iterable[tuple[float, float, float, float]] = ()) -> Map:
    """Free space to `reach` [m] on all sides of the origin, but for walls (x0, y0, x1, y1) [m]."""
    segments = np.array(list(walls), dtype=np.float64).reshape(-1, 4)
    return Map.from_segments(
        segments, resolution=0.001 if len(segments) else _NOBODY, extent=(-reach, -reach, reach, reach)
    )


def alone(scenario: Scenario, robot: Robot, world: Map | None = None) -> Scenario:
    """The scenario with only this robot; in another world it stands at the origin, without obstacles."""
    if world is None:
        return attrs.evolve(scenario, robots=[robot], source=None, resolved=None)
    placed = attrs.evolve(robot, pose=Pose(), start=None)
    return attrs.evolve(scenario, map=world, robots=[placed], obstacles=[], zones=[], source=None, resolved=None)
