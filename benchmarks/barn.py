"""The BARN challenge: a Jackal crosses 50 fields of cylinders, 10 times each, one batch a field.

``python -m benchmarks.barn --way best --runs 10`` prints what became of the runs, and the challenge's score. The fields
are D. Perille, A. Truong, X. Xiao and P. Stone, "Benchmarking metric ground navigation", 2020; those of
https://github.com/Daffan/the-barn-challenge are read from a file that is not part of the project.

Each run is a replica. A run ends when the robot is within 1 m of its goal, touches anything, or after 100 s. Fields lie
next to one another on one plain, far enough apart that no laser sees the next, with a robot in each. A batch goes on
until its last run has ended, so the command makes a batch of each field: in most of them all runs end within seconds.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["DATA", "Field", "Outcome", "fields_of", "robot_for", "run_fields", "score", "way_named"]

Array = npt.NDArray[np.float64]

DATA = Path(__file__).resolve().parents[2] / "shared" / "maps" / "barn" / "barn_50.npz"
START = (-2.25, 3.0, math.pi / 2.0)
GOAL = (-2.25, 13.0)
NEAR = 1.0  # m from the goal that counts as there
TIMEOUT = 100.0  # s
FASTEST = 2.0  # m/s
RADIUS = 0.075  # m of a cylinder
DT = 0.05
RANGE = 10.0  # m that the laser sees
_PITCH = (17.0, 27.0)  # m from one field to the next
_ACROSS = 10  # fields in a line
_CORNERS = 8  # of the polygon that stands for a cylinder
_RESOLUTION = 0.01


@attrs.frozen(kw_only=True, eq=False)
class Field:
    """One of the worlds."""

    number: int
    places: Array
    """(M, 2) [m] of the cylinders."""
    path: float
    """[m] the length of the reference path from start to goal."""


@attrs.frozen(kw_only=True)
class Outcome:
    """What became of a run."""

    world: int
    run: int
    status: str
    """``"success"``, ``"collision"`` or ``"timeout"``."""
    time: float
    """[s]"""
    score: float


def fields_of(data: Path = DATA) -> list[Field]:
    """The fields in the file."""
    found = []
    with np.load(data) as file:
        for number in np.unique(file["world"]).tolist():
            inner = file[f"path_{number}"]
            path = np.concatenate(([START[:2]], inner, [GOAL]))
            length = float(np.hypot(*np.diff(path, axis=0).T).sum())
            found.append(Field(number=number, places=file["xy"][file["world"] == number], path=length))
    return found


def score(success: bool, seconds: float, path: float) -> float:
    """The challenge's score of a run, 0.5 at the most."""
    best = path / FASTEST
    return best / min(max(seconds, 2.0 * best), 8.0 * best) if success else 0.0


def way_named(name: str, goal: tuple[float, float]) -> am.Controller:
    """A way of crossing a field, by its name."""
    return WAYS[name](goal)


def _dwa(goal: tuple[float, float]) -> am.Controller:
    """As the challenge's own: half a metre a second, along the path of a planner."""
    return am.controllers.Navigate(
        goals=(goal,),
        planner=am.planners.AStar(),
        avoider=am.controllers.Dwa(speed=0.5, turn_rate=1.57, clearance=0.012, horizon=2.0),
        tolerance=0.2,
        least_clearance=0.17,
        memory=100.0,
        window=8.0,
        recovery=("turn", "back"),
        rounds=20,
        stuck_after=3.0,
    )


def _alone(goal: tuple[float, float]) -> am.Controller:
    return am.controllers.Dwa(goals=(goal,), speed=0.5, turn_rate=1.57, clearance=0.02, horizon=2.0, tolerance=0.5)


def _best(goal: tuple[float, float]) -> am.Controller:
    return am.controllers.Navigate(
        goals=(goal,),
        planner=am.planners.ThetaStar(lazy=True),
        avoider=am.controllers.Dwa(speed=2.0, turn_rate=4.0, clearance=0.012, horizon=1.0),
        tolerance=0.2,
        least_clearance=0.17,
        memory=100.0,
        window=8.0,
        replan_after=0.5,
        recovery=("turn", "back"),
        rounds=20,
        stuck_after=2.0,
    )


WAYS = {"dwa": _dwa, "dwa_alone": _alone, "best": _best}


def _offset(place: int) -> Array:
    return np.array([place % _ACROSS * _PITCH[0], place // _ACROSS * _PITCH[1]])


def _plain(fields: Sequence[Field]) -> am.Map:
    """The map of all fields."""
    angles = (np.arange(_CORNERS) + 0.5) * 2.0 * math.pi / _CORNERS
    # A polygon of the same area; cells that its outline touches are occupied, so half a cell less.
    same = RADIUS * math.sqrt(2.0 * math.pi / (_CORNERS * math.sin(2.0 * math.pi / _CORNERS)))
    corners = (same - 0.5 * _RESOLUTION) * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    sides = np.concatenate((corners, np.roll(corners, -1, axis=0)), axis=1)
    lines = []
    for place, field in enumerate(fields):
        centres = field.places + _offset(place)
        lines.append((np.tile(centres, 2)[:, None, :] + sides).reshape(-1, 4))
    last = _offset(len(fields) - 1)
    wide = max(last[0], _offset(min(len(fields), _ACROSS) - 1)[0])
    extent = (-10.0, -6.0, wide + 6.0, float(last[1]) + 19.0)
    return am.Map.from_segments(np.concatenate(lines), resolution=_RESOLUTION, extent=extent)


def robot_for(name: str, offset: Array, way: str) -> am.Robot:
    """The Jackal at the start of a field."""
    x, y = offset.tolist()
    robot = am.load_robot("jackal", name=name, pose=am.Pose(x=START[0] + x, y=START[1] + y, heading=START[2]))
    laser = robot.sensors["laser"]
    sensor: Any = laser.sensor
    laser = attrs.evolve(laser, sensor=attrs.evolve(sensor, range_max=RANGE))
    scale = am.Distribution(kind="normal", values=(1.0, 0.002))
    return attrs.evolve(
        robot,
        sensors={**robot.sensors, "laser": laser},
        controller=way_named(way, (GOAL[0] + x, GOAL[1] + y)),
        errors={
            "drive.wheel_radius_left": am.Deviation(scale=scale),
            "drive.wheel_radius_right": am.Deviation(scale=scale),
        },
        on_collision="end",
    )


def run_fields(fields: Sequence[Field], way: str, runs: int, *, seed: int = 0, threads: int = 1) -> list[Outcome]:
    """What becomes of `runs` runs in each of the fields."""
    robots = [robot_for(f"w{field.number:03d}", _offset(place), way) for place, field in enumerate(fields)]
    scenario = am.Scenario(map=_plain(fields), robots=robots, dt=DT, seed=seed)
    simulation = am.Simulation(scenario, replicas=runs, threads=threads)
    order = {robot.name: place for place, robot in enumerate(robots)}
    places = np.array([order[name] for name in simulation.names] * runs)
    goals = np.array(GOAL) + np.array([_offset(place) for place in places])
    ended = np.full(len(places), math.inf)
    status = np.full(len(places), "timeout", dtype="<U9")
    for step in range(1, round(TIMEOUT / DT) + 1):
        simulation.step()
        open_ = np.isinf(ended)
        touched = open_ & ~simulation.active
        status[touched] = "collision"
        off = simulation.true_pose[:, :2] - goals
        there = open_ & ~touched & (np.hypot(off[:, 0], off[:, 1]) <= NEAR)
        status[there] = "success"
        ended[touched | there] = step * DT
        if np.isfinite(ended).all():
            break
    ended = np.minimum(ended, TIMEOUT)
    return [
        Outcome(
            world=fields[place].number,
            run=index // len(fields),
            status=str(status[index]),
            time=float(ended[index]),
            score=score(status[index] == "success", float(ended[index]), fields[place].path),
        )
        for index, place in enumerate(places.tolist())
    ]


def summary(outcomes: Sequence[Outcome]) -> str:
    """The shares of outcomes, the mean time of successes, and the score."""
    count = len(outcomes)
    share = {name: sum(one.status == name for one in outcomes) / count for name in ("success", "collision", "timeout")}
    times = [one.time for one in outcomes if one.status == "success"]
    mean = sum(times) / len(times) if times else math.nan
    total = sum(one.score for one in outcomes) / count
    parts = ", ".join(f"{name} {part:.1%}" for name, part in share.items())
    return f"{count} runs: {parts}; mean time {mean:.2f} s; score {total:.4f}"


def _one(number: int, way: str, runs: int, seed: int) -> list[Outcome]:
    return run_fields([field for field in fields_of() if field.number == number], way, runs, seed=seed)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.barn", description=__doc__.splitlines()[0])
    parser.add_argument("--way", choices=sorted(WAYS), default="best")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--worlds", type=int, nargs="*", help="numbers of the worlds; all without it")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2, help="processes that share the fields")
    parser.add_argument("--each", action="store_true", help="print each world")
    chosen = parser.parse_args(arguments)
    if not DATA.exists():
        print(f"there is no {DATA}; see its source in this file", file=sys.stderr)
        return 1
    numbers = [field.number for field in fields_of()]
    if chosen.worlds:
        numbers = [number for number in numbers if number in chosen.worlds]
    began = time.perf_counter()
    outcomes: list[Outcome] = []
    with concurrent.futures.ProcessPoolExecutor(min(chosen.jobs, len(numbers))) as pool:
        parts = [pool.submit(_one, number, chosen.way, chosen.runs, chosen.seed) for number in numbers]
        for number, part in zip(numbers, parts, strict=True):
            found = part.result()
            outcomes += found
            if chosen.each:
                print(f"world {number:3d}: {summary(found)}", flush=True)
    print(f"{chosen.way}: {summary(outcomes)}; computed in {time.perf_counter() - began:.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
