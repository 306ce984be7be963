"""The dynamic window approach."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Beliefs, Context, State, parameter
from amorsim.controllers.avoider import Avoider, SteeringInput, body_of, sight_of
from amorsim.kernels.avoidance.dynamic_window import Abilities, Scene, Weights, choose_twists, keep_behind

__all__ = ["Dwa"]


_WORK = 600  # cost of one decision for a robot, in rays
_LOOK = 40  # the same for a look round
_BEHIND = 96  # places next to its way that it remembers


@attrs.frozen(kw_only=True)
class Dwa(Avoider):
    """Drives to a goal past what it sees, by the dynamic window approach.

    In each step it looks at the pairs of speed and turning rate that its drive can have one step later. It leaves out
    those from which it could not brake, along the same arc, before its footprint meets something seen. Of the others
    it takes the one after which the way to the goal is shortest. If none is left, it brakes. After D. Fox, W. Burgard
    and S. Thrun, "The dynamic window approach to collision avoidance", IEEE Robotics & Automation Magazine 4 (1),
    1997. Arcs are exact. The footprint is taken as a disc if it is one, or else as the rectangle that holds it, cut off
    by the circle that it sweeps as it turns.

    It uses what its sensor sees now, and remembers for some seconds what it passed, so that its rear does not swing
    into what it no longer sees. It knows no way round: a dead end stops it, which it reports. `Navigate` leads
    it along a planned path. It drives backwards only if `reverse_speed` allows it, and only as far as its sensor shows
    that the way is free.

    Parameters
    ----------
    goals, loop, tolerance
        Where it drives [m], whether it goes round for ever, and how near to a goal it must come [m].
    speed, reverse_speed, turn_rate
        Fastest that it drives ahead and backwards [m/s], and turns [rad/s]; slower if the drive is slower.
    sensor
        Name of the range sensor that it uses, a scanner or a ring.
    clearance
        What it keeps free around its footprint [m].
    patience
        Time without progress after which it reports that it is blocked [s].
    horizon
        How long a twist is thought to go on [s].
    speed_samples, turn_rate_samples
        How many of each it compares; their product is the number of arcs.
    forward_distance
        How far ahead of the base point the place is whose way to the goal counts [m].
    path_weight
        How many metres along the path one metre off the path counts.
    obstacle_weight
        What a twist may cost [m] that would meet something at once; less, the later it would.
    turn_weight
        What the largest change of the turning rate costs [m].
    """

    reverse_speed: float = parameter(0.0, unit="m/s", ge=0, help="fastest that it drives backwards")
    horizon: float = parameter(1.5, unit="s", gt=0, le=60, help="for which a twist is thought to go on")
    speed_samples: int = parameter(7, ge=2, le=1000, static=True, help="how many speeds it compares")
    turn_rate_samples: int = parameter(
        21, ge=3, le=1000, static=True, help="how many turning rates it compares for each speed"
    )
    forward_distance: float = parameter(
        0.3, unit="m", ge=0, help="place ahead of the base point whose way to the goal counts"
    )
    path_weight: float = parameter(2.0, ge=1, help="metres along the path that a metre off it counts")
    obstacle_weight: float = parameter(0.3, unit="m", ge=0, help="cost of a twist that would meet something at once")
    turn_weight: float = parameter(0.05, unit="m", ge=0, help="cost of the largest change of turning")

    def start_steering(self, context: Context) -> State:
        """State: the sensor's beams, the drive's limits, what it passed, and room for the arcs."""
        behind = np.full((context.rows, _BEHIND, 3), -1e30)
        return {
            **super().start_steering(context),
            "behind": behind,
            "arcs": np.full((context.rows, self.speed_samples, self.turn_rate_samples, 3), np.nan),
        }

    def steer(self, given: SteeringInput) -> Array:
        """The twists `(N, 3)` along the paths of the guide; robots that are not active brake."""
        robot, course, state = given.course.robot, given.course, given.state
        box, margin = body_of(robot, self.clearance)
        own: Any = self
        able = Abilities(own.speed, own.reverse_speed, own.turn_rate, state["limits"], state["curvature"], state["lag"])
        weights = Weights(
            margin, own.horizon, own.forward_distance, own.path_weight, own.obstacle_weight, own.turn_weight
        )
        reading = given.readings[self.sensor]
        sight = sight_of(robot, reading, self.sensor, course.joints, state)
        twist = np.empty((robot.rows, 3))
        scene = Scene(sight, reading.age, state["behind"], given.clock.time)
        given.draws.share(_LOOK, lambda first, end: keep_behind(scene, course.poses, state["moving"], first, end))
        mine = scene, course.poses, box, given.guide, able, weights, given.active, given.clock.dt, state["moving"]
        given.draws.share(_WORK, lambda first, end: choose_twists(*mine, first, end, state["arcs"], twist))
        return twist

    def beliefs(self, state: State) -> Beliefs:
        """The twist that it has by its own account, and all that it compared: v, w and cost of each."""
        return {"twist": state["moving"].copy(), "arcs": state["arcs"].copy()}
