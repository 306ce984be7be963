"""How tasks for learners are tried."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import attrs
import numpy as np

from amorsim.array_types import AnyArray
from amorsim.contracts import Draws, Observable, StepOutcome, Task, TrueState
from amorsim.controllers.wander import Wander
from amorsim.core.draws import stream_key
from amorsim.core.maps.map import Map
from amorsim.core.poses import Mount
from amorsim.core.shapes import Shape
from amorsim.motions.routes import Loop
from amorsim.scenario.floor import Floor, Marking
from amorsim.scenario.pose import Pose
from amorsim.scenario.reading.robots import load_robot
from amorsim.scenario.spec import MountedSensor, Obstacle, Scenario
from amorsim.sensors.fiducial import Fiducial
from amorsim.sensors.line import Line
from amorsim.simulation.simulation import Simulation
from amorsim.testing.failure import Who, array_in_words

__all__ = ["check_task"]


_REPLICAS = (3, 4, 5, 6, 7)
_STEPS, _PER_STEP = 12, 5  # judged, and simulated in each


def check_task(who: Who, task: Task, scene: Scenario | None) -> None:
    """Try a task on some replicas of a scene with one robot: shapes, rows that are independent, no truth seen."""
    scenario = _hall() if scene is None else scene
    together = _trial(who, task, scenario, _REPLICAS)
    for row, replica in enumerate(_REPLICAS):
        alone = _trial(who, task, scenario, (replica,))
        for name, arrays in together.items():
            for number, (of_all, of_one) in enumerate(zip(arrays, alone[name], strict=True)):
                same = of_all[row : row + 1].tobytes() == of_one.tobytes()
                who.require(same, "rows", f"{name} {number} of environment {replica} alone", "the same bits", "others")


def _trial(who: Who, task: Task, scenario: Scenario, replicas: Sequence[int]) -> dict[str, list[AnyArray]]:
    """The results of a task, step by step, on a robot that drives about."""
    simulation = Simulation(scenario, replicas=list(replicas))
    name = scenario.robots[0].name
    rows = len(replicas)
    actions = _actions(who, task, rows)
    with who.calling("bounds"):
        low, high = task.bounds(simulation.known(name).robot)
    fits = all(isinstance(one, np.ndarray) and one.ndim == 1 and np.isfinite(one).all() for one in (low, high))
    who.require(
        fits and low.shape == high.shape, "shapes", "bounds()", "two arrays (k,) of finite numbers", (low, high)
    )
    counter = np.zeros((rows, 3), dtype=np.uint32)
    counter[:, 0] = replicas
    draws = Draws(np.full(rows, stream_key(0, "task"), dtype=np.uint64), counter)
    with who.calling("begin"):
        episode = task.begin(simulation.truth(), draws)
    for key, array in episode.items():
        fits = isinstance(array, np.ndarray) and array.shape[:1] == (rows,)
        who.require(fits, "shapes", f"begin(): {key!r}", f"an array ({rows}, ...)", array_in_words(array))
    found: dict[str, list[AnyArray]] = {
        "observations": [],
        "rewards": [],
        "ends": [],
        "successes": [],
        "privileged": [],
    }
    for _ in range(_STEPS):
        simulation.run(_PER_STEP * scenario.dt)
        known, truth = Observable(*simulation.known(name), actions), simulation.truth()
        _check_blindness(who, task, known, truth, episode)
        outcome = _judged(who, task, truth, episode)
        seen = _observed(who, task, known, episode)
        inside = np.isfinite(seen).all() and (seen >= low).all() and (seen <= high).all()
        who.require(
            seen.shape == (rows, len(low)), "shapes", "observe()", f"({rows}, {len(low)})", array_in_words(seen)
        )
        who.require(inside, "bounds", "observe()", "numbers within bounds()", f"{seen.min()} to {seen.max()}")
        with who.calling("privileged"):
            privileged = task.privileged(truth, episode)
        for key, array in zip(found, (seen, *outcome, privileged), strict=True):
            found[key].append(array.copy())
    return found


def _actions(who: Who, task: Task, rows: int) -> AnyArray:
    """Actions between the bounds `(N, a)`."""
    with who.calling("action_bounds"):
        low, high = task.action_bounds
    fits = low.ndim == 1 and low.shape == high.shape and np.isfinite([low, high]).all() and (low < high).all()
    who.require(fits, "shapes", "action_bounds", "two arrays (a,) of finite numbers, the first less", (low, high))
    actions: AnyArray = np.tile(0.75 * low + 0.25 * high, (rows, 1))
    with who.calling("velocities"):
        velocities = task.velocities(actions)
    for velocity in velocities:
        fits = np.shape(velocity) == (rows,) and np.isfinite(velocity).all()
        who.require(fits, "shapes", "velocities()", f"three arrays ({rows},)", array_in_words(velocity))
    return actions


def _judged(who: Who, task: Task, truth: TrueState, episode: dict[str, AnyArray]) -> StepOutcome:
    with who.calling("judge"):
        outcome = task.judge(truth, episode)
    rows = len(truth.pose)
    for field, array, kind in zip(StepOutcome._fields, outcome, (np.floating, np.bool_, np.bool_), strict=True):
        fits = isinstance(array, np.ndarray) and array.shape == (rows,) and np.issubdtype(array.dtype, kind)
        who.require(fits, "shapes", f"judge(): {field}", f"({rows},) of {kind.__name__}", array_in_words(array))
    who.require(np.isfinite(outcome.reward).all(), "values", "judge(): reward", "finite numbers", outcome.reward)
    return outcome


def _observed(who: Who, task: Task, known: Observable, episode: dict[str, AnyArray]) -> AnyArray:
    before = {key: array.tobytes() for key, array in episode.items()}
    with who.calling("observe"):
        seen: AnyArray = task.observe(known, episode)
        again = task.observe(known, episode)
    who.require(isinstance(seen, np.ndarray), "shapes", "observe()", "an array", type(seen).__name__)
    who.require(seen.tobytes() == again.tobytes(), "determinism", "a second observe()", "the same bits", "others")
    kept = all(episode[key].tobytes() == data for key, data in before.items())
    who.require(kept, "inputs", "the episode after observe()", "the same bits", "others")
    return seen


def _check_blindness(who: Who, task: Task, known: Observable, truth: TrueState, episode: dict[str, AnyArray]) -> None:
    """Check that another truth, once judged, changes no observation: a robot cannot know it."""
    elsewhere = truth._replace(
        pose=truth.pose + 0.7,
        twist=truth.twist - 0.3,
        is_touching=~truth.is_touching,
        pose_of=lambda name: truth.pose_of(name) + 0.4,
        part_pose=truth.part_pose - 0.6,
        lines=tuple(line + 0.2 for line in truth.lines),
    )
    seen = []
    for each in (truth, elsewhere):
        own = copy.deepcopy(episode)
        _judged(who, task, each, own)
        seen.append(_observed(who, task, known, own))
    same = seen[0].tobytes() == seen[1].tobytes()
    who.require(same, "truth", "observe() after judge() of another truth", "the same bits", "others")


def _hall() -> Scenario:
    """A robot that sees marks and the floor, somebody who walks and carries a mark, and a line on the floor."""
    walls = [(0, 0, 12, 0), (12, 0, 12, 8), (12, 8, 0, 8), (0, 8, 0, 0), (3, 6.5, 5, 7), (9, 1, 9.5, 3)]
    robot = load_robot("pioneer2dx", name="rover", pose=Pose(x=2.0, y=2.0), controller=Wander())
    marks, line = Fiducial(range_max=20.0), Line(elements=(Mount(y=0.02), Mount(y=-0.02)))
    sensors = {"fiducial": MountedSensor(sensor=marks), "line": MountedSensor(sensor=line, mount=Mount(x=0.2))}
    walk = Loop(waypoints=((5.0, 3.0), (8.0, 5.0), (5.0, 6.0)))
    leader = Obstacle(name="leader", shape=Shape.circle(0.2), fiducial=1, motion=walk)
    marking = Marking(points=((2.0, 2.0), (5.0, 2.0), (5.0, 4.0)), width=0.05)
    return Scenario(
        map=Map.from_segments(np.array(walls, dtype=np.float64), resolution=0.05),
        robots=[attrs.evolve(robot, on_collision="continue", sensors=robot.sensors | sensors)],
        obstacles=[leader],
        floor=Floor(markings=[marking]),
    )
