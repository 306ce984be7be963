"""Navigation: driving to goals along paths that a planner finds, past what is in the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import (
    Beliefs,
    Clock,
    Context,
    Controller,
    Draws,
    Estimate,
    Measurement,
    Planner,
    RobotModel,
    State,
    parameter,
)
from amorsim.controllers.abilities import Course
from amorsim.controllers.avoider import Avoider, SteeringInput, body_of, sight_of, start_sight
from amorsim.controllers.dwa import Dwa
from amorsim.controllers.planning import STATUSES, Ways, keep_searched, lay_path, no_path, turns_back_later
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import ParameterError
from amorsim.kernels.avoidance.guide import Guide
from amorsim.kernels.avoidance.seen_window import Window, guard, look_along, remember

__all__ = ["Navigate"]


DRIVING, RECOVERING, ARRIVED, GAVE_UP = range(4)
_MODES = ("driving", "recovering", "arrived", "gave_up")
_RECOVERIES = ("stop", "turn", "back")
_TIMES = (2.0, 4.0, 2.0)  # [s] that they take
_BACK = 0.15  # [m/s]
_STAYS = 0.25  # [m] within which a robot counts as standing
_LEAVES = 1.0  # [m] from the place of its trouble where the trouble is over
_WORK = 100  # cost of one look round for a robot, in rays


@attrs.frozen(kw_only=True)
class Navigate(Controller):
    """Drives to one goal after another: a planner finds the way, an avoider drives along it.

    The planner plans on the map that the robot was given (`knowledge.map`), or else on open ground, and adds what the
    robot has seen. The path keeps the reach of the footprint and the avoider's `clearance` from walls, so that the
    robot can turn anywhere on it; where no such way leads to the goal, or it is much longer, the reach alone, or else
    `least_clearance`. Planners with headings turn the footprint with the robot instead. The robot remembers what it
    sees around itself, and plans again if that blocks its path.

    If it stays in one place too long, it tries the `recovery` in turn, plans again after each, and gives up the goal
    after all were tried `rounds` times. Then it goes for the next goal. It reports ``goal_reached``, ``recovery`` and
    ``gave_up`` as events, with their time.

    Parameters
    ----------
    goals
        Places in the world [m], in order.
    headings
        The heading at each goal [rad], for planners with headings, such as ``hybrid_a_star``; or none.
    planner
        The planner, as ``{ use = "theta_star" }``.
    avoider
        The controller that drives along the path, as ``{ use = "dwa", speed = 0.4 }``. Its own goals are not used.
    mapper
        Name of an estimator that maps, such as ``grid_mapping``: it plans on the map that this has made so far, and
        again every `replan_after`. Empty: on the map that it was given.
    sensor
        Name of the range sensor whose readings it remembers.
    tolerance
        Distance from a goal at which it counts as reached [m].
    least_clearance
        Least distance [m] that paths keep from walls; by default half the width of the footprint.
    recovery
        What it tries where it cannot go on: ``"stop"`` and wait, ``"turn"`` in place, ``"back"`` up (or turn, if
        something is behind it).
    rounds
        How often it tries all of them before it gives up the goal.
    stuck_after
        Time at a place after which it cannot go on [s].
    replan_after
        Least time between two plans [s].
    look_ahead
        How far ahead on its path it looks for what blocks it [m].
    memory
        How long it remembers what it saw [s].
    window
        Side [m] of the square around the robot in which it remembers what it saw.
    cell
        Side of the cells of this memory [m].
    """

    goals: tuple[tuple[float, float], ...] = parameter(unit="m", frame="world", help="places in the world, in order")
    headings: tuple[float, ...] = parameter(
        (), unit="rad", help="heading at each goal, for planners with headings; or none"
    )
    planner: Planner = parameter(static=True, component="planner", help="what finds the way")
    avoider: Avoider = parameter(Dwa(), component="controller", help="what drives along it")
    mapper: str = parameter(
        "", refers="estimators", help="name of the estimator on whose map it plans; empty for the map that it was given"
    )
    sensor: str = parameter("laser", refers="sensors", help="name of the range sensor whose readings it remembers")
    tolerance: float = parameter(0.2, unit="m", gt=0, help="distance from a goal at which it counts as reached")
    least_clearance: float | None = parameter(
        None, unit="m", ge=0, static=True, help="least distance from walls; half the footprint's width if not given"
    )
    recovery: tuple[str, ...] = parameter(
        ("stop", "turn", "back"), choices=_RECOVERIES, static=True, help="what it tries where it cannot go on, in turn"
    )
    rounds: int = parameter(3, ge=0, le=1000, help="how often it tries all of them before it gives up a goal")
    stuck_after: float = parameter(4.0, unit="s", gt=0, help="time at a place after which it cannot go on")
    replan_after: float = parameter(1.0, unit="s", gt=0, help="least time between two plans")
    look_ahead: float = parameter(3.0, unit="m", ge=0, help="how far ahead on its path it looks for what blocks it")
    memory: float = parameter(20.0, unit="s", ge=0, help="how long it remembers what it saw")
    window: float = parameter(10.0, unit="m", gt=0, le=200, static=True, help="side of the square that it remembers")
    cell: float = parameter(0.05, unit="m", gt=0, static=True, help="side of the cells of its memory")

    def __attrs_post_init__(self) -> None:
        if not self.goals:
            raise ParameterError("goals", "expected one goal at least, got none")
        if self.headings and len(self.headings) != len(self.goals):
            raise ParameterError(
                "headings", f"expected one for each of {len(self.goals)} goals, got {len(self.headings)}"
            )
        if self.headings and not self.planner.plans_headings:
            name = type(self.planner).__name__
            raise ParameterError("headings", f"expected none, as {name} plans without headings, or another planner")
        if self.window / self.cell > 2000:
            raise ParameterError("cell", f"expected at most 2000 cells across the window of {self.window:g} m")

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The goals."""
        return [(f"goals.{i}", x, y) for i, (x, y) in enumerate(self.goals)]

    def start(self, context: Context) -> State:
        """The state of the avoider, an empty memory, and no path yet.

        Raises
        ------
        ComponentError
            If the robot has no range sensor of that name, or no estimator that maps of the name `mapper`.
        """
        rows = context.rows
        if self.mapper and "occupancy" not in context.robot.beliefs.get(self.mapper, {}):
            raise ComponentError(
                f"navigate plans on the map of the estimator {self.mapper!r}, but {context.robot.who(0)} has no such "
                "estimator, or it makes no map, as grid_mapping does"
            )
        size = max(int(np.ceil(self.window / self.cell)), 2)
        return {
            **self.avoider.start_steering(context),
            **start_sight(context, self.sensor, "navigate", "look_"),
            **no_path(context.pose),
            "seen": np.full((rows, size, size), -1e30, dtype=np.float32),
            "seen_at": np.zeros((rows, size, size, 2), dtype=np.int8),
            "corner": np.full((rows, 2), -(2**40), dtype=np.int64),
            "mode": np.full((rows, 1), DRIVING, dtype=np.int64),
            "goal": np.zeros((rows, 1), dtype=np.int64),
            "status": np.full((rows, 1), -1, dtype=np.int64),
            "wanted": np.ones((rows, 1), dtype=bool),  # a plan
            "planned": np.full((rows, 1), -1e30),  # [s] when it planned last
            "plans": np.zeros((rows, 1), dtype=np.int64),
            "anchor": context.pose[:, :2].copy(),  # the place at which it has been
            "anchored": np.zeros((rows, 1)),  # [s] since when
            "trouble": np.full((rows, 2), np.inf),  # where it last had to recover
            "troubled": np.full((rows, 1), np.inf),  # [s] when that trouble began
            "tries": np.zeros((rows, 1), dtype=np.int64),
            "until": np.zeros((rows, 1)),  # [s] the end of a recovery
            "news": np.zeros((rows, 1), dtype=np.int64),
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
        """The command `(N, c)` of this step; that of standing still after the last goal."""
        course = Course.of(robot, readings, estimate)
        reading = readings[self.sensor]
        sight = sight_of(robot, reading, self.sensor, course.joints, state, "look_")
        window = Window(state["seen"], state["corner"], self.cell, state["seen_at"])
        fresh = reading.fresh[:, 0].astype(np.int64)
        asked = sight, course.poses, clock.time, fresh, window
        draws.share(_WORK, lambda first, end: remember(*asked, first, end))
        state["news"] = np.zeros((robot.rows, 1), dtype=np.int64)
        self._arrive(estimate.pose, clock.time, state)
        self._recover(estimate.pose, clock.time, state)
        guide = self._way(robot, estimate.pose, clock.time, window, state)
        driving = (state["mode"] == DRIVING) & (state["status"] == 0)
        before = state["moving"].copy()
        twist = self.avoider.steer(SteeringInput(readings, course, guide, driving, clock, state, draws))
        recovering = state["mode"] == RECOVERING
        if recovering.any():
            state["moving"] = np.where(recovering, before, state["moving"])
            # It has hardly moved since its trouble began, so what it knew of this place then is still right.
            since = np.minimum(clock.time, state["troubled"]) - self.memory
            seen = (sight, reading.age, course.poses, *body_of(robot, self.avoider.clearance), state["limits"], window)
            wanted = self._wanted(state)
            guard(*seen, since, wanted, recovering, clock.dt, state["moving"], twist)
            stands = (state["moving"][:, :1] == 0.0) & (state["moving"][:, 1:] == 0.0)
            held = recovering & stands & (wanted[:, :1] < 0.0) & np.isinf(state["curvature"])
            if held.any():  # something behind it keeps it from backing up, so it turns
                wanted[:, 1:] = 0.5 * self.avoider.turn_rate
                wanted[:, :1] = 0.0
                guard(*seen, since, wanted, held, clock.dt, state["moving"], twist)
        return course.command(twist)

    def _goal(self, state: State) -> Array:
        """The goal that each robot is after `(N, 2)`."""
        goals = np.asarray(self.goals)
        chosen: Array = goals[np.arange(len(goals)), np.minimum(state["goal"][:, 0], goals.shape[1] - 1)]
        return chosen

    def _heading(self, state: State) -> Array:
        """The wanted heading `(N, 1)` [rad] at each robot's present goal; `(N, 0)` if none is given."""
        headings = np.asarray(self.headings, dtype=np.float64)
        if not headings.size:
            return np.empty((len(state["goal"]), 0))
        number = np.minimum(state["goal"], headings.shape[1] - 1)
        return np.take_along_axis(headings, number, axis=1)

    def _arrive(self, pose: Array, time: Array, state: State) -> None:
        """Go on to the next goal where one is reached."""
        off = self._goal(state) - pose[:, :2]
        there = (state["mode"] < ARRIVED) & (np.sqrt(off[:, :1] ** 2 + off[:, 1:] ** 2) <= self.tolerance)
        if there.any() and self.planner.plans_headings:
            # A path that only passes the goal comes back to it with the right heading.
            there &= (state["status"] != 0) | ~turns_back_later(state)
        if there.any():
            state["news"] = np.where(there, 1 + state["goal"], state["news"])
            self._next(there, ARRIVED, pose, time, state)

    def _next(self, which: Bools, at_the_end: int, pose: Array, time: Array, state: State) -> None:
        count = np.asarray(self.goals).shape[1]
        state["goal"] = state["goal"] + which
        is_last = which & (state["goal"] >= count)
        state["mode"] = np.where(is_last, at_the_end, np.where(which, DRIVING, state["mode"]))
        state["wanted"] = state["wanted"] | which
        state["planned"] = np.where(which, -1e30, state["planned"])
        state["status"] = np.where(which, -1, state["status"])
        state["tries"] = np.where(which, 0, state["tries"])
        self._anchor(which, pose, time, state)

    def _anchor(self, which: Bools, pose: Array, time: Array, state: State) -> None:
        state["anchor"] = np.where(which, pose[:, :2], state["anchor"])
        state["anchored"] = np.where(which, time, state["anchored"])

    def _recover(self, pose: Array, time: Array, state: State) -> None:
        """Begin and end recoveries, and give up."""
        ended = (state["mode"] == RECOVERING) & (time >= state["until"])
        if ended.any():
            state["mode"] = np.where(ended, DRIVING, state["mode"])
            state["wanted"] = state["wanted"] | ended
            self._anchor(ended, pose, time, state)
        self._anchor(_apart(pose, state["anchor"]) > _STAYS, pose, time, state)
        gone = _apart(pose, state["trouble"]) > _LEAVES
        state["tries"] = np.where(gone & np.isfinite(state["trouble"][:, :1]), 0, state["tries"])
        stuck = (state["mode"] == DRIVING) & (time - state["anchored"] >= self.stuck_after)
        if not stuck.any():
            return
        kinds = len(self.recovery)
        hopeless = stuck & (state["tries"] >= self.rounds * kinds)
        tries = stuck & ~hopeless
        if tries.any():
            new = tries & ~(_apart(pose, state["trouble"]) <= _LEAVES)
            state["troubled"] = np.where(new, time, state["troubled"])
            taken = np.array([_RECOVERIES.index(name) for name in self.recovery])[state["tries"] % kinds]
            state["news"] = np.where(tries, -1 - taken, state["news"])
            state["mode"] = np.where(tries, RECOVERING, state["mode"])
            state["until"] = np.where(tries, time + np.array(_TIMES)[taken], state["until"])
            state["trouble"] = np.where(tries, pose[:, :2], state["trouble"])
            state["tries"] = state["tries"] + tries
        if hopeless.any():
            state["news"] = np.where(hopeless, -100 - state["status"], state["news"])
            self._next(hopeless, GAVE_UP, pose, time, state)

    def _wanted(self, state: State) -> Array:
        """The twists `(N, 2)` of recoveries."""
        wanted = np.zeros((len(state["mode"]), 2))
        if not self.recovery:
            return wanted
        count = np.maximum(state["tries"] - 1, 0)
        taken = np.array([_RECOVERIES.index(name) for name in self.recovery])[count % len(self.recovery)]
        side = np.where((count // len(self.recovery)) % 2 == 0, 1.0, -1.0)
        wanted[:, :1] = np.where(taken == 2, -_BACK, 0.0)
        wanted[:, 1:] = np.where(taken == 1, 0.5 * side * self.avoider.turn_rate, 0.0)
        return wanted

    def _way(self, robot: RobotModel, pose: Array, time: Array, window: Window, state: State) -> Guide:
        """The paths, planned again where that is due."""
        rows = robot.rows
        ways = Ways.of(robot, self.planner, self.mapper, self.avoider.clearance, self.least_clearance)
        since = time - self.memory
        look = np.empty((rows, 3))
        room = np.full((rows, 1), max(ways.narrow - self.cell, 0.5 * self.cell))
        far: Any = np.zeros((rows, 1)) + self.look_ahead
        look_along(pose, state["path"], state["along"], state["count"], state["leg"], window, since, room, far, look)
        blocked = np.isfinite(look[:, 2:]) & (state["status"] == 0)
        due = (state["mode"] == DRIVING) & (time - state["planned"] >= self.replan_after)
        if not self.mapper:
            ends = state["cut"] & (state["leg"] >= state["count"] // 2)[:, None]
            due &= state["wanted"] | blocked | ends | (state["status"] > 0)
        goals = np.concatenate((self._goal(state), self._heading(state)), axis=1)
        for row in np.flatnonzero(due).tolist():
            answer = ways.plan(pose[row], goals[row], window, row, float(since[row, 0]))
            state["status"][row] = STATUSES.index(answer.status)
            state["planned"][row] = time[row]
            state["plans"][row] += 1
            state["wanted"][row] = False
            keep_searched(answer.searched, row, state)
            if answer.status == "found":
                lay_path(answer.points, row, state)
                self.avoider.take_path(row, pose[row], answer.axle, state)
        return Guide(state["path"], state["along"], state["count"], state["leg"])

    def reports(self, state: State) -> Sequence[tuple[int, str, object]]:
        """Goals that were reached or given up, and recoveries."""
        news = state["news"][:, 0]
        if not news.any():
            return ()
        count = np.asarray(self.goals).shape[1]
        found: list[tuple[int, str, object]] = []
        for row in np.flatnonzero(news).tolist():
            code = int(news[row])
            if code > 0:
                found.append((row, "goal_reached", f"{code} of {count}"))
            elif code <= -99:
                status = -100 - code
                why = "it does not get on" if status <= 0 else f"no path: {STATUSES[status].replace('_', ' ')}"
                found.append((row, "gave_up", f"goal {int(state['goal'][row, 0])} of {count}: {why}"))
            else:
                found.append((row, "recovery", _RECOVERIES[-1 - code]))
        return found

    def beliefs(self, state: State) -> Beliefs:
        """The path and what was searched for it (nan beyond their ends), the goal's number, its activity, and more.

        That is what its avoider believes. Of more than 1024 places that were searched, it keeps every n-th.
        """
        beyond = np.arange(state["path"].shape[1])[None, :] >= state["count"][:, None]
        no = (state["status"] != 0) | (state["mode"] >= ARRIVED)
        path = np.where((beyond | no)[:, :, None], np.nan, state["path"])
        return {
            "path": path,
            "searched": state["searched"].copy(),
            "goal": state["goal"].copy(),
            "mode": state["mode"].copy(),
            "plans": state["plans"].copy(),
            **self.avoider.beliefs(state),
        }


def _apart(pose: Array, place: Array) -> Array:
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt((pose[:, :1] - place[:, :1]) ** 2 + (pose[:, 1:2] - place[:, 1:2]) ** 2))
