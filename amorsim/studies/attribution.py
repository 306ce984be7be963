"""The effect of each error of a robot on its odometry: the same drive with each alone, and with all together."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.controllers.manual import Manual
from amorsim.core.errors import AmorsimError
from amorsim.core.poses import compose, relative
from amorsim.core.rows import stack
from amorsim.scenario.spec import Robot, Scenario
from amorsim.simulation.simulation import Simulation
from amorsim.studies.robot_under_test import (
    alone,
    chosen_robot,
    empty_world,
    error_paths,
    only_odometry,
    with_known_place,
)

__all__ = ["Attribution", "Case", "attribute_errors"]


@attrs.frozen(kw_only=True, eq=False)
class Case:
    """The drive with one error alone, or with all of them.

    Attributes
    ----------
    name
        Path of the error, such as ``"errors.drive.track"`` or ``"ground.diffusion"``.
    believed
        Estimated poses `(T, 3)` of the first replica's robot if it truly went along the reference.
    errors
        Estimated less true position at the end, in the robot's frame (ahead, to the left) [m], `(R, 2)`.
    error
        Their length, root mean square over replicas [m].
    share
        Share of the final error of all together, 1 for all of it. Negative if the error compensates others.
    """

    name: str
    believed: Array
    errors: Array
    error: float
    share: float


@attrs.frozen(kw_only=True, eq=False)
class Attribution:
    """All cases over one recorded drive.

    Attributes
    ----------
    reference
        The path without any error `(T, 3)`, in a frame that begins at the robot's start.
    together
        All errors at once; its share is 1.
    left_out
        Paths of errors that do not affect odometry; the zones of the floor, which an empty world does not have; and
        ``"initial_belief"`` and ``"kidnappings"`` if the robot has them: in the drive it knows its start exactly, and
        is not carried away.
    """

    robot: str
    reference: Array
    cases: tuple[Case, ...]
    together: Case
    left_out: tuple[str, ...]

    @property
    def interaction(self) -> float:
        """1 less the sum of the single shares: the part by which errors amplify or reduce each other."""
        return 1.0 - sum(case.share for case in self.cases)


def attribute_errors(scenario: Scenario, *, robot: str | None = None, replicas: int = 20) -> Attribution:
    """Drive once without errors, then repeat the commands with each error alone and with all together.

    An error is an entry of the robot's `errors`, an element of its `ground`, or one of its encoder's chain. Draws
    depend only on names, so each error draws the same alone and together with others. The estimate is dead reckoning.
    The commands are the controller's in the scenario's own world; they are repeated in an empty one. In both the robot
    knows its start exactly and is not kidnapped: neither is an error of its odometry.

    To first order, the final error of all together is the sum of the final errors of each alone. A share is the part
    of the sum that lies along the whole, averaged over replicas: mean of e_i . e over mean of e . e.

    Parameters
    ----------
    robot
        Its name; without it, the first.
    replicas
        Number of replicas, for random errors.

    Raises
    ------
    AmorsimError
        If the robot has no odometry, or no errors, or there are too few replicas.
    """
    chosen = chosen_robot(scenario, robot)
    if replicas < 1:
        raise AmorsimError(f"replicas: expected a whole number > 0, got {replicas!r}")
    odometer, encoder = only_odometry(chosen)
    everything = _names(odometer, encoder)
    if not everything:
        raise AmorsimError(
            f"robot {chosen.name!r} has nothing to explain: no errors of its drive, no ground noise, no encoder noise"
        )
    commands = _commands(scenario, chosen, encoder)
    player = attrs.evolve(odometer, controller=Manual(), on_collision="continue")
    world = empty_world(10.0 + _reach(scenario, commands, _with_only(player, encoder, set())))

    def play(kept: set[str], rows: int) -> tuple[Array, Array]:
        return _play(alone(scenario, _with_only(player, encoder, kept), world), commands, rows)

    reference, _ = play(set(), 1)
    offsets: dict[str, tuple[Array, Array]] = {}
    together = ""
    for name in (*everything, together):
        true, believed = play(set(everything) if name == together else {name}, replicas)
        steps, rows = true.shape[:2]
        off = relative(true.reshape(-1, 3), believed.reshape(-1, 3)).reshape(steps, rows, 3)
        offsets[name] = compose(reference[:, 0], off[:, 0]), off[-1, :, :2]
    whole = offsets[together][1]

    def case(name: str) -> Case:
        believed, errors = offsets[name]
        mean_square = float(np.mean(np.sum(whole * whole, axis=1)))
        along = float(np.mean(np.sum(errors * whole, axis=1)))
        return Case(
            name=name or "all together",
            believed=believed,
            errors=errors,
            error=math.sqrt(float(np.mean(np.sum(errors * errors, axis=1)))),
            share=along / mean_square if mean_square > 0.0 else 0.0,
        )

    kept = {f"errors.{path}" for path in odometer.errors}
    return Attribution(
        robot=chosen.name,
        reference=reference[:, 0],
        cases=tuple(case(name) for name in everything),
        together=case(together),
        left_out=(
            *(f"errors.{path}" for path in chosen.errors if f"errors.{path}" not in kept),
            *(f"zones.{zone.name}" for zone in scenario.zones),
            *(["initial_belief"] if chosen.initial_belief.kind != "exact" else []),
            *(["kidnappings"] if chosen.kidnappings else []),
        ),
    )


def _names(robot: Robot, encoder: str) -> list[str]:
    names = [f"errors.{path}" for path in error_paths(robot, encoder)]
    names += [f"ground.{element.name}" for element in robot.ground]
    return names + [f"sensors.{encoder}.noise.{element.name}" for element in robot.sensors[encoder].noise]


def _with_only(robot: Robot, encoder: str, kept: set[str]) -> Robot:
    unit = robot.sensors[encoder]
    chain = tuple(e for e in unit.noise if f"sensors.{encoder}.noise.{e.name}" in kept)
    return attrs.evolve(
        robot,
        errors={path: error for path, error in robot.errors.items() if f"errors.{path}" in kept},
        ground=tuple(element for element in robot.ground if f"ground.{element.name}" in kept),
        sensors={encoder: attrs.evolve(unit, noise=chain)},
    )


def _commands(scenario: Scenario, robot: Robot, encoder: str) -> Array:
    """The controller's commands, step by step `(T, c)`, in its own world, without odometry errors."""
    clean = attrs.evolve(
        with_known_place(robot),
        errors={},
        ground=(),
        sensors={**robot.sensors, encoder: attrs.evolve(robot.sensors[encoder], noise=())},
    )
    robots = [clean if other is robot else other for other in scenario.robots]
    simulation = Simulation(attrs.evolve(scenario, robots=robots, resolved=None))
    group, row = simulation._fleet.robot_row(robot.name, 0)
    channels = len(robot.drive.channels)
    commands = []
    for _ in range(simulation.steps_of(scenario.duration)):
        simulation.step()
        commands.append(group.command[row, :channels].copy())
    if not np.any(commands):
        raise AmorsimError(f"robot {robot.name!r} does not move in this scenario; give it a controller, or more time")
    return np.array(commands)


def _reach(scenario: Scenario, commands: Array, robot: Robot) -> float:
    """Largest distance [m] that the drive could reach, with every travel doubled."""
    radius = float(np.max(stack([robot.drive]).rolling_radius()))
    return 2.0 * radius * float(np.sum(np.max(np.abs(commands), axis=1))) * scenario.dt


def _play(scenario: Scenario, commands: Sequence[Array] | Array, replicas: int) -> tuple[Array, Array]:
    """True and believed poses `(T + 1, R, 3)` under these commands."""
    simulation = Simulation(scenario, replicas=replicas)
    group = simulation._fleet.groups[0]
    true, believed = [simulation.true_pose], [simulation.estimated_pose]
    for command in commands:
        group.driver.state["command"][:] = command
        simulation.step()
        true.append(simulation.true_pose)
        believed.append(simulation.estimated_pose)
    return np.array(true), np.array(believed)
