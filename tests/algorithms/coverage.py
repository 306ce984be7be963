"""How often 95 % intervals of means cover the true one: the table on the page about comparisons.

``python -m tests.algorithms.coverage`` prints it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from amorsim.algorithms.intervals import mean_interval

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "compare-and-report.md"
SIZES = (5, 10, 20, 30, 50, 100)
TRIES = 4_000


class Distribution(NamedTuple):
    """Draws samples of a shape; and the mean that they have."""

    draw: Callable[[np.random.Generator, Any], Any]
    mean: float


DISTRIBUTIONS = {
    "normal": Distribution(lambda random, shape: random.normal(0.0, 1.0, shape), 0.0),
    "Rayleigh, difference of two": Distribution(
        lambda random, shape: random.rayleigh(1.0, shape) - random.rayleigh(1.0, shape), 0.0
    ),
    "heavy tails (Student's t of 3)": Distribution(lambda random, shape: random.standard_t(3.0, shape), 0.0),
    "Rayleigh": Distribution(lambda random, shape: random.rayleigh(1.0, shape), math.sqrt(0.5 * math.pi)),
    "exponential": Distribution(lambda random, shape: random.exponential(1.0, shape), 1.0),
    "log-normal (σ = 1)": Distribution(lambda random, shape: random.lognormal(0.0, 1.0, shape), math.exp(0.5)),
    "one in ten is 20 times as large": Distribution(
        lambda random, shape: random.rayleigh(1.0, shape) * np.where(random.random(shape) < 0.1, 20.0, 1.0),
        2.9 * math.sqrt(0.5 * math.pi),
    ),
    "1 in 90 %, else 0": Distribution(lambda random, shape: (random.random(shape) < 0.9).astype(float), 0.9),
}


def covered(name: str, size: int, tries: int) -> int:
    """How many intervals of samples of a size cover the mean of their distribution."""
    draw, mean = DISTRIBUTIONS[name]
    return sum(mean_interval(samples).covers(mean) for samples in draw(np.random.default_rng(size), (tries, size)))


def page_rows() -> dict[str, list[float]]:
    """The shares [%] on the page, by distribution."""
    lines = [line.strip("| ").split(" | ") for line in PAGE.read_text(encoding="utf-8").splitlines() if "|" in line]
    return {cells[0]: [float(cell) for cell in cells[1:]] for cells in lines if cells[0] in DISTRIBUTIONS}


if __name__ == "__main__":
    print("| samples | " + " | ".join(map(str, SIZES)) + " |\n|---" + "|---:" * len(SIZES) + "|")
    for name in DISTRIBUTIONS:
        shares = [f"{100.0 * covered(name, size, TRIES) / TRIES:.1f}" for size in SIZES]
        print(f"| {name} | " + " | ".join(shares) + " |")
