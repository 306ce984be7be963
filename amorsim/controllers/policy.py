"""Driving by a policy that was learned: a network in an ONNX file."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import (
    Clock,
    Context,
    Controller,
    Draws,
    Estimate,
    Measurement,
    Observable,
    RobotModel,
    State,
    Task,
    parameter,
)
from amorsim.contracts.joints import joints_of
from amorsim.controllers.abilities import command_along
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import ComponentError

__all__ = ["Policy"]


@attrs.frozen(kw_only=True)
class Policy(Controller):
    """Drives by a network that maps a task's observations to its actions, from goal to goal.

    Observations are those of the task, made of what the robot measures and estimates, so the policy acts here as in the
    environments where it learned, to the bit. The network has one input `(1, k)`, the observation, and one output
    `(1, a)`, the action, whose values are clipped to the task's bounds. It is asked for each row by itself, for a
    product of matrices has other last bits for other numbers of rows.

    The file is data: a graph of ONNX's operators. Running it needs the extra ``learn``.

    Parameters
    ----------
    file
        The network, in ONNX's format.
    task
        The task that it learned, with the same parameters.
    goals
        Places in the world [m], driven to in order; the last one ends the drive. None for a task without goals.
    tolerance
        Distance from a goal, by the estimate, at which it counts as reached [m].
    """

    file: str = parameter(file=True, static=True, help="the ONNX file of the network")
    task: Task = parameter(static=True, component="task", help="the task that it learned")
    goals: tuple[tuple[float, float], ...] = parameter(
        (), unit="m", frame="world", static=True, help="places in the world, in order"
    )
    tolerance: float = parameter(0.4, unit="m", gt=0, help="distance from a goal at which it counts as reached")

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The goals."""
        return [(f"goals.{number}", x, y) for number, (x, y) in enumerate(self.goals)]

    def start(self, context: Context) -> State:
        """The number of the goal, and the last action.

        Raises
        ------
        ComponentError
            If the file cannot be run, or the network is of other sizes than the task; if the task's period is not a
            whole number of steps.
        """
        period = self.task.period / context.dt
        if round(period) < 1 or abs(period - round(period)) > 1e-6:
            raise ComponentError(
                f"policy: task.period: expected a whole number of steps of {context.dt:g} s, got {self.task.period:g} s"
            )
        low, _ = self.task.action_bounds
        seen, _ = self.task.bounds(context.robot)
        _network(self.file, len(seen), len(low))
        rows = context.rows
        return {
            "goal": np.zeros((rows, 1), dtype=np.int64),
            "arrived": np.zeros((rows, 1), dtype=np.int64),
            "action": np.zeros((rows, len(low))),
            "ticks": np.zeros((rows, 1), dtype=np.int64),
        }

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)`: of the last action; 0 after the last goal."""
        goals = self._goals(robot, estimate, state)
        steps = round(self.task.period / clock.dt)
        asked = state["ticks"][:, 0] % steps == 0
        state["ticks"] += 1
        if asked.any():
            known = Observable(robot, readings, estimate, state["action"])
            seen = self.task.observe(known, self.task.episode_for(goals))
            low, high = self.task.action_bounds
            run = _network(self.file, seen.shape[1], len(low))
            for row in np.flatnonzero(asked).tolist():
                state["action"][row] = np.clip(run(seen[row : row + 1]), low, high)
        forward, turn, left = self.task.velocities(state["action"])
        twists = np.stack((forward, left, turn), axis=1)
        if self.goals:
            twists[state["goal"][:, 0] == len(self.goals)] = 0.0
        return command_along(robot, twists, joints_of(robot, readings))

    def _goals(self, robot: RobotModel, estimate: Estimate, state: State) -> Array:
        """The present goals `(N, 2)`, after those that were reached."""
        if not self.goals:
            return np.zeros((robot.rows, 2))
        state["arrived"][:] = 0
        last = len(self.goals) - 1
        places = np.array(self.goals)
        present = places[np.minimum(state["goal"][:, 0], last)]
        away = np.hypot(present[:, 0] - estimate.pose[:, 0], present[:, 1] - estimate.pose[:, 1])
        reached = (away[:, None] <= self.tolerance) & (state["goal"] <= last)
        state["goal"] += reached
        state["arrived"][reached] = state["goal"][reached]
        return places[np.minimum(state["goal"][:, 0], last)]

    def reports(self, state: State) -> Sequence[tuple[int, str, object]]:
        """The goals that were reached in this step."""
        rows = np.flatnonzero(state["arrived"][:, 0])
        return [(row, "goal_reached", f"{state['arrived'][row, 0]} of {len(self.goals)}") for row in rows.tolist()]


@functools.lru_cache(maxsize=32)
def _network(file: str, observation: int, action: int) -> Any:
    """A function that maps an observation `(1, k)` to an action `(a,)`."""
    try:
        import onnxruntime
    except ImportError:
        raise ComponentError(
            'a policy needs the extra "learn": python -m pip install "amorsim[learn]", for ONNX Runtime'
        ) from None
    if not Path(file).is_file():
        raise ComponentError(f"policy: file: {file}: there is no such file")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    try:
        session = onnxruntime.InferenceSession(file, options, providers=["CPUExecutionProvider"])
    except RAISED as error:
        raise ComponentError(
            f"policy: file: {file}: expected a network in ONNX's format ({error_in_words(error)})"
        ) from None
    inputs, outputs = session.get_inputs(), session.get_outputs()
    found = [(each.type, each.shape[-1] if each.shape else 0) for each in (*inputs, *outputs)]
    expected = [("tensor(float)", observation), ("tensor(float)", action)]
    if found != expected:
        sizes = ", ".join(f"{kind} of {size}" for kind, size in found)
        raise ComponentError(
            f"policy: file: {file}: expected an input of {observation} values, the task's observation, and an output "
            f"of {action}, its action, both float32; got {sizes}"
        )
    name = inputs[0].name

    def run(seen: Array) -> Array:
        values: Array = session.run(None, {name: seen.astype(np.float32)})[0][0].astype(float)
        return values

    return run
