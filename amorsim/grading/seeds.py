"""The seeds of a grading: drawn so that no submission can find them, written down so that it can be repeated."""

from __future__ import annotations

import os
import secrets
from collections.abc import Sequence
from pathlib import Path

import attrs

from amorsim.core.files.atomic_files import write_text
from amorsim.grading.toml_tables import read_tables
from amorsim.scenario.files.models import FORMAT
from amorsim.scenario.reading.faults import Node, shown
from amorsim.simulation.checked_arguments import MAX_REPLICA

__all__ = ["MOST_SEED", "Seed", "draw_seeds", "read_seeds", "write_seeds"]

MOST_SEED = 2**63 - 1


@attrs.frozen
class Seed:
    """Seed and replica of a simulation, on which all random draws of a run depend: 95 bits together."""

    seed: int
    replica: int = 0


def draw_seeds(count: int) -> list[Seed]:
    """Seeds from the system's entropy."""
    return [Seed(secrets.randbelow(MOST_SEED + 1), secrets.randbelow(MAX_REPLICA + 1)) for _ in range(count)]


def write_seeds(path: Path, seeds: Sequence[Seed]) -> None:
    """Write seeds into a file that `read_seeds` reads."""
    runs = "\n".join(f"  {{ seed = {each.seed}, replica = {each.replica} }}," for each in seeds)
    write_text(
        path,
        "# The seeds of this grading: `amorsim grade --seeds` repeats it with them.\n"
        "# With them the truth can be computed. Do not publish them, nor grade with them what was written afterwards.\n"
        f"format = {FORMAT}\nruns = [\n{runs}\n]\n",
    )


def read_seeds(path: str | os.PathLike[str]) -> list[Seed]:
    """The seeds in a file.

    Raises
    ------
    StudyError
        With all that is wrong with it.
    """
    return read_tables(path, ("format", "runs"), _read)


def _read(top: Node, _: Path) -> list[Seed]:
    runs = top.child("runs")
    if not runs.expect_list("a list of runs, as in [{ seed = 1, replica = 0 }]"):
        return []
    if not runs.value:
        runs.fault("expected one run at least, got none")
    return [Seed(_number(each, "seed", MOST_SEED), _number(each, "replica", MAX_REPLICA)) for each in runs.items()]


def _number(run: Node, key: str, most: int) -> int:
    if not run.expect_table("a table, as in { seed = 1, replica = 0 }"):
        return 0
    value = run.value.get(key)
    if type(value) is not int or not 0 <= value <= most:
        run.child(key).fault(f"expected a whole number from 0 to {most}, got {shown(value)}")
        return 0
    return value
