"""Twenty small robots cross, as in navground's tutorial on deadlocks and collisions: which runs have neither?

``python -m benchmarks.cross --way human_like`` prints the shares of 250 runs without collision, without deadlock, and
without both. The scenario is Cross of https://github.com/idsia-robotics/navground with a side of 4 m: Thymios of a
radius of 0.08 m start at random places and drive to and fro between two opposite places out of four, for 120 s, and
know where the others within 5 m are. Its tutorial gives each run a safety margin drawn evenly from 0 to 0.25 m; here 25
margins spread evenly have ten runs each. With ``--margin`` all runs have the same.

A deadlock is a robot that in the last 10 s stays within 0.1 m.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import math
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np

import amorsim as am

__all__ = ["WAYS", "Outcome", "cross", "margins", "outcomes_of", "share"]

SIDE = 4.0  # m
RADIUS = 0.08  # m
AXIS = 0.094  # m
WHEEL = 0.021  # m
FASTEST = 0.166  # m/s
SPEED = 0.12  # m/s
DURATION = 120.0  # s
DT = 0.1
MOST_MARGIN = 0.25  # m
APART = 0.1  # m between two at the start
STILL = (10.0, 0.1)  # s, m

PUBLISHED = {"no collision": 0.856, "no deadlock": 0.796, "neither": 0.656}
"""Shares in navground's table, of 250 runs with `human_like`."""

Way = Callable[..., am.Controller]


def _human_like(**given: Any) -> am.Controller:
    """With the parameters of the tutorial: eta 0.25 s, tau 0.5 s, horizon 5 m."""
    return am.controllers.HumanLike(reaction_time=0.25, relaxation_time=0.5, horizon=5.0, **given)


WAYS: dict[str, Way] = {
    "human_like": _human_like,
    "orca": am.controllers.Orca,
    "hrvo": am.controllers.Hrvo,
    "social_force": am.controllers.SocialForce,
}


@attrs.frozen(kw_only=True)
class Outcome:
    """What became of a run."""

    margin: float
    """[m]"""
    run: int
    collisions: int
    deadlocks: int
    """Robots in a deadlock at the end."""
    goals: int
    """Goals reached by all robots."""

    @property
    def is_good(self) -> bool:
        """Whether there was neither a collision nor a deadlock."""
        return self.collisions == 0 and self.deadlocks == 0


def cross(way: str, margin: float, *, number: int = 20, seed: int = 0) -> am.Scenario:
    """The scenario with one margin [m] for all robots."""
    half = 0.5 * SIDE
    ends = ((half, 0.0), (-half, 0.0), (0.0, half), (0.0, -half))
    robots = []
    for place in range(number):
        first = ends[place % 4]
        controller = WAYS[way](
            goals=(first, (-first[0], -first[1])),
            loop=True,
            tolerance=0.5,
            speed=SPEED,
            turn_rate=math.pi,
            clearance=margin,
        )
        robots.append(
            am.Robot(
                name=f"r{place:02d}",
                shape=am.Shape.circle(RADIUS),
                on_collision="continue",
                start=am.RandomStart(random=(-half, -half, half, half), clearance=APART),
                controller=controller,
                drive=am.drives.Differential(
                    wheel_radius_left=WHEEL, wheel_radius_right=WHEEL, track=AXIS, rate_max=FASTEST / WHEEL
                ),
                sensors={
                    "encoder": am.MountedSensor(sensor=am.sensors.Encoder(counts_per_revolution=4000.0)),
                    "neighbours": am.MountedSensor(sensor=am.sensors.Neighbours(slots=number - 1, range_max=5.0)),
                },
                estimators={"dead_reckoning": am.estimators.DeadReckoning()},
            )
        )
    around = half + 1.0
    walls = am.Map.from_segments([], resolution=0.05, extent=(-around, -around, around, around))
    return am.Scenario(map=walls, robots=robots, dt=DT, seed=seed)


def outcomes_of(way: str, margin: float, runs: int, *, seed: int = 0) -> list[Outcome]:
    """What becomes of `runs` runs with one margin [m]."""
    simulation = am.Simulation(cross(way, margin, seed=seed), replicas=runs)
    simulation.run(DURATION - STILL[0])
    shape = (runs, -1, 2)
    before = simulation.true_pose[:, :2].reshape(shape)
    farthest = np.zeros(before.shape[:2])
    for _ in range(round(STILL[0] / DT)):
        simulation.step()
        moved = simulation.true_pose[:, :2].reshape(shape) - before
        farthest = np.maximum(farthest, np.hypot(moved[:, :, 0], moved[:, :, 1]))
    still = (farthest < STILL[1]).sum(axis=1)
    kinds = [(event.replica, event.kind, event.path) for event in simulation.events]
    return [
        Outcome(
            margin=margin,
            run=run,
            collisions=sum(which == run and kind == "collision" for which, kind, _ in kinds),
            deadlocks=int(still[run]),
            goals=sum(which == run and path == "goal_reached" for which, _, path in kinds),
        )
        for run in range(runs)
    ]


def margins(count: int) -> list[float]:
    """Margins [m] spread evenly over those of the tutorial: the middles of `count` parts."""
    return [(place + 0.5) / count * MOST_MARGIN for place in range(count)]


def share(outcomes: Sequence[Outcome]) -> dict[str, float]:
    """The shares of runs without collision, without deadlock, and with neither."""
    return {
        "no collision": sum(one.collisions == 0 for one in outcomes) / len(outcomes),
        "no deadlock": sum(one.deadlocks == 0 for one in outcomes) / len(outcomes),
        "neither": sum(one.is_good for one in outcomes) / len(outcomes),
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.cross", description=__doc__.splitlines()[0])
    parser.add_argument("--way", choices=sorted(WAYS), default="human_like")
    parser.add_argument("--margin", type=float, help="of all runs [m]; without it, 25 from 0 to 0.25")
    parser.add_argument("--runs", type=int, default=250)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--each", action="store_true", help="print each margin")
    chosen = parser.parse_args(arguments)
    began = time.perf_counter()
    wanted = margins(25) if chosen.margin is None else [chosen.margin] * 5
    runs = max(1, round(chosen.runs / len(wanted)))
    asked = [(chosen.way, margin, runs) for margin in wanted]
    outcomes: list[Outcome] = []
    with concurrent.futures.ProcessPoolExecutor(chosen.jobs) as pool:
        parts = [pool.submit(outcomes_of, *one, seed=chosen.seed + place) for place, one in enumerate(asked)]
        for part in parts:
            found = part.result()
            outcomes += found
            if chosen.each:
                kinds = ", ".join(f"{name} {value:.0%}" for name, value in share(found).items())
                goals = sum(one.goals for one in found) / len(found)
                print(f"margin {found[0].margin:.3f} m: {kinds}; {goals:.0f} goals", flush=True)
    kinds = ", ".join(f"{name} {value:.1%}" for name, value in share(outcomes).items())
    goals = sum(one.goals for one in outcomes) / len(outcomes)
    print(f"{chosen.way}, {len(outcomes)} runs: {kinds}; {goals:.0f} goals a run", end="")
    print(f"; computed in {time.perf_counter() - began:.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
