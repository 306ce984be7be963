"""Runs the scenarios beside this file and keeps what they write, for `tests/runs/test_golden.py`::

    python tests/golden/regenerate.py

Look at the difference, and commit it by itself: it says that results have changed.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import amorsim as am

__all__ = ["FOLDER", "SCENARIOS", "run_scenario", "tables"]

FOLDER = Path(__file__).resolve().parent
SCENARIOS = {"square": 2, "meeting": 1, "moving": 2, "trailer": 2}  # with how many replicas each


def run_scenario(name: str, folder: Path) -> None:
    """Run a scenario as it is kept."""
    am.run(am.load(FOLDER / name / "scenario.toml"), folder, replicas=SCENARIOS[name])


def tables(folder: Path) -> dict[str, Path]:
    """The text files of a run or of what was kept of one, by name."""
    return {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*.csv"))}


if __name__ == "__main__":
    for scenario in SCENARIOS:
        kept = FOLDER / scenario / "expected"
        shutil.rmtree(kept, ignore_errors=True)
        with tempfile.TemporaryDirectory() as beside:
            run_scenario(scenario, Path(beside) / "run")
            for table, written in tables(Path(beside) / "run").items():
                (kept / table).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(written, kept / table)
