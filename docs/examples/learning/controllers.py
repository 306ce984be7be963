"""What controllers of amorsim reach in the environments that they fit: the least that a policy is to beat there.

python docs/examples/learning/controllers.py --envs 200
"""

from __future__ import annotations

import argparse
import math

import attrs

import amorsim as am
from amorsim.controllers import Braitenberg, Follow, Navigate, PathPursuit
from amorsim.learning import Evaluation, evaluate, load_environment, make_vec
from amorsim.planners import HybridAStar

UP = math.radians(90.0)
INTO_BAY = Navigate(
    goals=((29.7, 2.0),),
    headings=(UP,),
    planner=HybridAStar(radius=4.8, clearance=0.25, switch=3.0),
    avoider=PathPursuit(speed=1.2, lookahead=1.2, pause=2.0, clearance=0.12),
    tolerance=0.08,
    look_ahead=9.0,
    window=24.0,
    cell=0.1,
    stuck_after=8.0,
    recovery=("stop", "back"),
)
# The tractor stops 1.8 m ahead of where its trailer is to be.
WITH_TRAILER = Navigate(
    goals=((38.1, 33.0),),
    headings=(UP,),
    planner=HybridAStar(
        radius=2.5,
        clearance=0.25,
        backward=10.0,
        trailer_length=1.2,
        hitch_offset=0.6,
        hitch_max=math.radians(45.0),
        trailer_width=1.0,
        trailer_front=0.8,
        trailer_rear=0.9,
    ),
    avoider=PathPursuit(speed=0.8, lookahead=0.8, clearance=0.1),
    tolerance=0.08,
    stuck_after=8.0,
    recovery=("stop",),
)
# By environment: what drives there, and whether the robot is given the map.
DRIVERS = {
    "amorsim/Follow-v0": (Follow(gap=0.8, gain=2.0, speed=0.8), False),
    "amorsim/Line-v0": (Braitenberg(sensor="line", speed=0.03, left=(4.0, 0.0, -2.0), right=(-2.0, 0.0, 4.0)), False),
    "amorsim/Dock-v0": (INTO_BAY, True),
    "amorsim/Trailer-v0": (WITH_TRAILER, True),
}


def with_map(scenario: am.Scenario) -> am.Scenario:
    """A scenario whose robot is given the map of its world."""
    robot = attrs.evolve(scenario.robots[0], knowledge=am.Knowledge(map=scenario.map))
    return attrs.evolve(scenario, robots=[robot])


def of_controller(name: str, count: int) -> Evaluation:
    """The evaluation of an environment's controller over the first episodes of so many environments."""
    controller, knows_map = DRIVERS[name]
    scenario = with_map(load_environment(name)) if knows_map else name
    return evaluate(make_vec(scenario, count, controller=controller, threads=2))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="What controllers reach in the environments for learners.")
    parser.add_argument("--envs", type=int, default=200)
    for each, (driver, _) in DRIVERS.items():
        print(f"{each}: {type(driver).__name__}: {of_controller(each, parser.parse_args().envs)}")
