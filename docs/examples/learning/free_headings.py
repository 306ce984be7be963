"""What a classical rule reaches in the environments for learners: of the free headings it takes the cheapest.

    python docs/examples/learning/free_headings.py --envs 200

It is the rule of lab 12: a heading is free as far as no range lies in the robot's strip, and it costs to turn away from
the goal, to turn at all, and to have little room ahead.
"""

from __future__ import annotations

import argparse

import numpy as np
import numpy.typing as npt

from amorsim.learning import Evaluation, evaluate, make_parallel_vec, make_vec

Array = npt.NDArray[np.float32]

LONGEST, HALF_WIDTH = 8.0, 0.3  # [m] range of the laser; half of the strip that the robot needs
BEAMS = np.radians(np.arange(-90, 91))  # to the left above 0
HEADINGS = np.radians(np.arange(-90, 91, 5))
ALONG, ASIDE = np.cos(BEAMS - HEADINGS[:, None]), np.abs(np.sin(BEAMS - HEADINGS[:, None]))


def act(seen: Array) -> Array:
    """The actions `(N, 2)` for observations `(N, 186)`."""
    away, goal = seen[:, :1], np.arctan2(seen[:, 2], seen[:, 1])
    ranges = LONGEST * seen[:, None, 5:]
    is_in_way = (ALONG > 0.0) & (ranges * ASIDE < HALF_WIDTH)
    free = np.where(is_in_way, ranges * ALONG, LONGEST).min(axis=2)  # (N, headings) [m]
    looked = np.minimum(away, 2.0)  # what lies behind the goal does not matter
    off = np.abs(np.angle(np.exp(1j * (HEADINGS - goal[:, None]))))
    cost = 0.6 * off + 0.4 * np.abs(HEADINGS) + 3.0 * (1.0 - np.minimum(free, looked) / looked)
    chosen = HEADINGS[cost.argmin(axis=1)]
    chosen = np.where(np.abs(goal) > np.pi / 2, np.sign(goal) * np.pi / 2, chosen)  # it turns before it looks
    ahead = free[:, len(HEADINGS) // 2]
    goes = (np.abs(chosen) < 0.5) & (ahead > 0.55)
    forward = np.where(goes, np.clip((ahead - 0.4) / 1.2, 0.2, 0.8), 0.0)
    return np.stack((forward, np.clip(1.5 * chosen, -1.0, 1.0)), axis=1).astype(np.float32)


# Where the observation is a goal and a laser, as this rule needs it.
TASKS = [f"amorsim/{name}-v0" for name in ("PointGoal", "Maze", "Barn", "Crowd", "Doors", "Corridor", "FindYourself")]


def of_rule(name: str, count: int) -> Evaluation:
    """The evaluation of the rule over the first episodes of so many environments."""
    return evaluate(make_vec(name, count, threads=2), act)


def of_rule_among_others(worlds: int) -> tuple[float, float]:
    """The shares of the agents of Crossing that arrive, and that touch something, in the first episodes of worlds."""
    many = make_parallel_vec("amorsim/Crossing-v0", worlds, threads=2)
    seen, _ = many.reset(seed=0)
    done, failed = (np.zeros((worlds, len(many.possible_agents)), dtype=bool) for _ in range(2))
    over = np.zeros(worlds, dtype=bool)
    while not over.all():
        seen, _, terminated, _, infos = many.step({agent: act(seen[agent]) for agent in seen})
        for column, agent in enumerate(many.possible_agents):
            success = infos[agent]["is_success"]
            done[:, column] |= success & ~over
            failed[:, column] |= terminated[agent] & ~success & ~over
        over |= ~many.active.any(axis=1)
    return float(done.mean()), float(failed.mean())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="What a classical rule reaches in the environments for learners.")
    parser.add_argument("--envs", type=int, default=200)
    for each in TASKS:
        print(f"{each}: {of_rule(each, parser.parse_args().envs)}")
    arrived, touched = of_rule_among_others(25)
    print(f"amorsim/Crossing-v0: 200 agents: {arrived:.1%} done, {touched:.1%} failed")
