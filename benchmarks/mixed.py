"""A mixed fleet: the ten models that ship, `pioneer2dx-typical` among them, as many robots of each."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

import amorsim as am
from benchmarks import worlds
from benchmarks.contest import Clock, drive
from benchmarks.ours import UnderWay, given
from benchmarks.results import Conduct, Row
from benchmarks.task import DT

__all__ = ["measure"]

SECTION = "mixed"
MODELS = (
    "b21r",
    "car",
    "khepera",
    "nomad200",
    "pioneer2dx",
    "pioneer2dx-typical",
    "pioneer3dx",
    "segway_rmp",
    "turtlebot3_burger",
    "youbot",
)
NOTE = (
    "all sensors of each model with all their noise, true and measured, dead reckoning, contact with walls and one "
    "another; wandering where a model has a laser or sonars, commands given where not"
)
_GIVEN = {"khepera": (1.5, 1.8), "segway_rmp": (0.5, 0.6)}
"""Commands of those that cannot see [rad/s]."""
_CLEARANCE = 0.2  # m at the starts
_STEPS = 10
_AT_LEAST = 1.0  # s timed in a round


def measure(rounds: int, quick: bool, clock: Clock, say: Callable[[str], None]) -> list[Row]:
    """One row: robot-steps a second of twenty robots of each model, in the office with a hall."""
    each = 2 if quick else 20
    setting = f"ten models by {each} robots, office with a hall"
    say(f"mixed: {setting}")
    robots = [_robot(model, number) for model in MODELS for number in range(each)]
    scenario = am.Scenario(map=worlds.office_with_hall().map, robots=robots, dt=DT, seed=11)
    side = UnderWay(am.Simulation(scenario), _STEPS)
    before = side.simulation.true_pose.copy()
    rates = []
    for _ in range(rounds):
        made = drive(side, _STEPS, 0.1 if quick else _AT_LEAST, clock)
        rates.append(len(robots) * made.steps / made.seconds)
    way = np.hypot(*(side.simulation.true_pose - before)[:, :2].T)
    conduct = Conduct(
        first_range=None,
        mean_range=None,
        distance=float(way.mean()),
        stopped=float((way < 1e-6).mean()),
        steps=_STEPS,
    )
    return [
        Row(
            section=SECTION,
            setting=setting,
            side="amorsim",
            unit="robot-steps/s",
            rounds=tuple(rates),
            conduct=conduct,
            note=NOTE,
        )
    ]


def _robot(model: str, number: int) -> am.Robot:
    made = am.load_robot(model)
    eyes = "laser" if "laser" in made.sensors else "sonar"
    controller = given(*_GIVEN[model]) if model in _GIVEN else am.controllers.Wander(sensor=eyes, speed=0.3)
    return attrs.evolve(
        made,
        name=f"{model}{number:02d}".replace("-", "_"),
        controller=controller,
        start=am.RandomStart(random=worlds.HALL if model == "car" else "anywhere", clearance=_CLEARANCE, per="study"),
        on_collision="continue",
    )
