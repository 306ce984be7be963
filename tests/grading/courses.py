"""A course to grade: scenario, rubric, and submissions in it."""

from __future__ import annotations

import functools
from pathlib import Path

import pytest

from amorsim.core.errors import StudyError
from amorsim.grading.fence import find_fence
from amorsim.grading.grade import grade
from amorsim.grading.results import Grade
from tests.studies import make_study
from tests.sweeps.studies import SCENARIO

__all__ = ["ESTIMATOR", "GOOD", "LAZY", "RUBRIC", "fence_problem", "graded", "make_course", "needs_fence"]

RUBRIC = """\
format = 1
title = "First homework"
scenario = "small.toml"
function = "drive"
runs = 1
duration = 3.0
time_limit = 2.0
memory_limit = 4e9

[criteria]
arrived = { use = "success", goal = [2.2, 1.0], tolerance = 0.3, points = 6.0 }
straight = { use = "turning", points = 4.0, none = 1.0, full = 0.0 }
"""
GOOD = """\
import amorsim as am

def drive(readings, estimate, clock):
    return am.Twist(0.4 if estimate.x < 2.2 else 0.0, 0.0)
"""
LAZY = "def drive(readings, estimate, clock):\n    return None\n"
ESTIMATOR = """\
import numpy as np


class Estimator:
    def __init__(self, start):
        self.pose = np.array(start)

    def update(self, readings, command, elapsed):
        forward, turn = 0.5 * 0.0825 * (command[0] + command[1]), 0.0825 * (command[1] - command[0]) / 0.33
        self.pose = self.pose + elapsed * np.array(
            [forward * np.cos(self.pose[2]), forward * np.sin(self.pose[2]), turn]
        )
        return self.pose
"""


@functools.cache
def fence_problem() -> str:
    """Why submissions cannot be fenced in here; empty where they can."""
    try:
        find_fence([])
    except StudyError as error:
        return str(error)
    return ""


needs_fence = pytest.mark.skipif(bool(fence_problem()), reason=fence_problem())


def make_course(folder: Path, rubric: str = RUBRIC) -> Path:
    """The path of a rubric in a new folder, beside its scenario."""
    make_study(folder)
    (folder / "small.toml").write_text(SCENARIO)
    path = folder / "rubric.toml"
    path.write_text(rubric)
    return path


def graded(rubric: Path, fence: bool | None = None, **submissions: str) -> dict[str, Grade]:
    """The grades of submissions, written beside the rubric; fenced in where that is possible."""
    paths = []
    for name, text in submissions.items():
        paths.append(rubric.parent / f"{name}.py")
        paths[-1].write_text(text)
    is_fenced = not fence_problem() if fence is None else fence
    return {each.label: each for each in grade(rubric, paths, rubric.parent / "grades", fence=is_fenced)}
