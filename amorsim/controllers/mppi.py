"""Model predictive path integral control."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Beliefs, Context, State, parameter
from amorsim.controllers.avoider import Avoider, SteeringInput, body_of, guarded, sight_of
from amorsim.kernels.avoidance.arcs import Box
from amorsim.kernels.avoidance.dynamic_window import Abilities
from amorsim.kernels.avoidance.sampling import Costs, Field, roll_out

__all__ = ["Mppi"]


_DISCS = 3  # that hold a footprint
_SHOWN = 24  # runs among its beliefs


@attrs.frozen(kw_only=True)
class Mppi(Avoider):
    """Drives to goals past what it sees, by model predictive path integral control (MPPI).

    It keeps a plan of twists for the next ``time_steps * time_step`` seconds. In each step it makes `samples` copies of
    the plan with noise, drives each ahead by its own model of the drive, and replaces the plan by their mean, weighted
    by ``exp(-cost / temperature)``. The cost is the way to the goal from where a run ends, and what it passes too near.
    It drives the first twist of the plan if it could brake from it before its footprint meets something seen;
    otherwise it brakes. After G. Williams, A. Aldrich and E. Theodorou, "Model predictive path integral control", JGCD
    40 (2), 2017.

    Parameters
    ----------
    samples, time_steps, time_step
        How many runs ahead there are, of how many steps, and how long a step is [s].
    speed_noise, turn_rate_noise
        Standard deviations of the noise [m/s] and [rad/s]. Without noise it drives its plan as it is, for which it has
        no reason to change: it stands.
    temperature
        Cost by which a run may be worse than the best and still count [m].
    path_weight
        How many metres along the path one metre off the path counts.
    obstacle_weight, obstacle_distance, collision_weight
        What it costs [m] to be near something all the time, from which distance on [m], and to touch something [m].
    window, cell
        Side of the square in which it looks up distances [m], and of its cells [m].
    """

    samples: int = parameter(300, ge=1, le=100_000, static=True, help="how many runs ahead there are")
    time_steps: int = parameter(30, ge=1, le=10_000, static=True, help="how many steps a run has")
    time_step: float = parameter(0.05, unit="s", gt=0, static=True, help="how long a step of a run is")
    reverse_speed: float = parameter(0.0, unit="m/s", ge=0, help="fastest that it drives backwards")
    speed_noise: float = parameter(0.2, unit="m/s", ge=0, help="standard deviation of the noise of the speed")
    turn_rate_noise: float = parameter(
        0.6, unit="rad/s", ge=0, help="standard deviation of the noise of the turning rate"
    )
    temperature: float = parameter(0.05, unit="m", gt=0, help="by which a run may be worse and still count")
    path_weight: float = parameter(2.0, ge=1, help="metres along the path that a metre off it counts")
    obstacle_weight: float = parameter(1.0, unit="m", ge=0, help="cost of being against something all the time")
    obstacle_distance: float = parameter(0.2, unit="m", gt=0, help="distance from which on things cost")
    collision_weight: float = parameter(5.0, unit="m", ge=0, help="cost of touching something")
    window: float = parameter(6.0, unit="m", gt=0, le=100, static=True, help="side of the square of distances")
    cell: float = parameter(0.05, unit="m", gt=0, static=True, help="side of its cells")

    def start_steering(self, context: Context) -> State:
        """State: the sensor's beams, the drive's limits, a plan to stand still, and room for some of the samples."""
        runs = np.zeros((context.rows, min(self.samples, _SHOWN), self.time_steps, 2))
        return {**super().start_steering(context), "plan": np.zeros((context.rows, self.time_steps, 2)), "runs": runs}

    def steer(self, given: SteeringInput) -> Array:
        """The twists `(N, 3)` along the paths of the guide; robots that are not active brake."""
        robot, course, state = given.course.robot, given.course, given.state
        rows = robot.rows
        box, margin = body_of(robot, self.clearance)
        own: Any = self
        reading = given.readings[self.sensor]
        sight = sight_of(robot, reading, self.sensor, course.joints, state)
        able = Abilities(own.speed, own.reverse_speed, own.turn_rate, state["limits"], state["curvature"], state["lag"])
        costs = Costs(
            own.temperature, own.path_weight, own.obstacle_weight, own.obstacle_distance, own.collision_weight, margin
        )
        field = Field(max(math.ceil(self.window / self.cell), 2), self.cell)
        plan = _later(state["plan"], given.clock.dt / self.time_step)
        noise = given.draws.normal(self.samples * self.time_steps * 2).reshape(rows, self.samples, self.time_steps, 2)
        scale = np.empty((rows, 1, 1, 2))
        scale[:, 0, 0, :1], scale[:, 0, 0, 1:] = own.speed_noise, own.turn_rate_noise
        noise = noise * scale
        mine = sight, reading.age, course.poses, _discs(box), field, given.guide, able, costs
        moving = state["moving"]
        before = plan.copy()
        given.draws.share(
            self.samples * self.time_steps // 4,
            lambda first, end: roll_out(*mine, noise, self.time_step, moving, first, end, plan),
        )
        # The kernel leaves in `noise` what the drive could follow of it.
        state["runs"] = before[:, None] + noise[:, :_SHOWN]
        state["plan"] = np.where(given.active[:, :, None], plan, 0.0)
        first_step = np.ascontiguousarray(state["plan"][:, 0])
        return guarded(first_step, sight, reading.age, course, (box, margin), state, given.clock.dt)

    def beliefs(self, state: State) -> Beliefs:
        """The twist that it has by its own account, its plan, and some of the runs: v and w of each step."""
        return {"twist": state["moving"].copy(), "plan": state["plan"].copy(), "runs": state["runs"].copy()}


def _later(plan: Array, steps: float) -> Array:
    """A plan `(N, T, 2)` shifted by `steps` steps; its last twist is repeated."""
    count = plan.shape[1]
    at = np.minimum(np.arange(count) + steps, count - 1)
    low = np.floor(at).astype(np.int64)
    high = np.minimum(low + 1, count - 1)
    part = (at - low)[None, :, None]
    return np.ascontiguousarray(plan[:, low] + part * (plan[:, high] - plan[:, low]))


def _discs(box: Box) -> Array:
    """Discs (D, 3), x, y and radius [m], that hold a rectangle."""
    length, middle = box.front - box.rear, 0.5 * (box.left + box.right)
    count = 1 if length == 0.0 else _DISCS
    radius = math.hypot(0.5 * length / count, 0.5 * (box.left - box.right))
    return np.array([(box.rear + (n + 0.5) * length / count, middle, radius) for n in range(count)])
