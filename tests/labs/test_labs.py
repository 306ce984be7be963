"""Labs: what is handed out runs, and each solution earns what the lecturer's page says."""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.grading.grade import grade
from amorsim.grading.results import Grade
from amorsim.grading.seeds import Seed, write_seeds
from tests.first_hour.conftest import ROOT
from tests.grading.courses import fence_problem

LABS = ROOT / "docs" / "labs"
# Of lab 7, one in which the mistake is one; of lab 10 two, since single runs of its starter differ much; of others 11.
SEEDS = {"07-monte-carlo-localization": [2], "10-graph-slam": [11, 12]}
# Points by file: the least, and the most.
EARNED = {
    "01-odometry": {
        "odometry": (0.0, 0.5),
        "good": (9.0, 10.0),
        "nominal": (0.0, 1.5),
        "one_way": (2.0, 5.0),
        "cheating": (0.0, 0.0),
    },
    "02-the-banana": {
        "banana": (0.0, 0.0),
        "good": (9.0, 10.0),
        "not_carried": (4.5, 5.0),
        "one_draw": (4.5, 5.0),
        "cheating": (0.0, 0.0),
    },
    "03-sensors": {"heading": (0.0, 0.5), "good": (9.0, 10.0), "bias_alone": (0.5, 4.0), "cheating": (0.0, 0.0)},
    "04-wall-following": {"follow": (0.0, 0.0), "good": (9.0, 10.0), "swinging": (6.5, 7.5), "cheating": (0.0, 0.0)},
    "05-gyro-and-compass": {
        "heading": (0.0, 6.0),
        "good": (9.0, 10.0),
        "unwrapped": (0.0, 0.5),
        "compass_alone": (0.0, 0.5),
        "cheating": (0.0, 0.0),
    },
    "06-ekf-with-landmarks": {
        "filter": (0.0, 6.0),
        "good": (9.0, 10.0),
        "overconfident": (6.0, 7.5),
        "unwrapped": (0.0, 1.0),
        "cheating": (0.0, 0.0),
    },
    "07-monte-carlo-localization": {
        "cloud": (0.0, 0.5),
        "good": (9.0, 10.0),
        "sharp": (0.0, 6.0),
        "cheating": (0.0, 0.0),
    },
    "08-occupancy-grids": {
        "grid": (0.0, 0.0),
        "good": (9.0, 10.0),
        "ends_alone": (1.0, 7.0),
        "by_wheels": (0.0, 3.0),
        "cheating": (0.0, 0.0),
    },
    "09-scan-matching": {
        "matcher": (0.0, 1.5),
        "good": (9.0, 10.0),
        "far_partners": (0.0, 3.0),
        "cheating": (0.0, 0.0),
    },
    "10-graph-slam": {
        "graph": (0.0, 2.0),
        "good": (9.0, 10.0),
        "unwrapped": (0.0, 3.0),
        "cheating": (0.0, 0.0),
    },
    "11-planning": {
        "plan": (0.0, 0.0),
        "good": (9.0, 10.0),
        "greedy": (5.0, 6.5),
        "four_neighbours": (7.0, 9.0),
        "point": (0.0, 1.0),
        "cheating": (0.0, 0.0),
    },
    "12-avoidance": {"avoid": (0.0, 6.0), "good": (9.0, 10.0), "point": (0.0, 6.0), "cheating": (0.0, 0.0)},
    "13-learning": {"learned": (0.0, 6.0), "good": (9.0, 10.0), "unscaled": (0.0, 6.0), "cheating": (0.0, 0.0)},
}
# The criterion that a mistake costs whole, and it alone, in labs where there is one.
LOST = {
    "02-the-banana": ("not_carried", "ellipse"),
    "04-wall-following": ("swinging", "smooth"),
    "06-ekf-with-landmarks": ("overconfident", "consistent"),
    "11-planning": ("greedy", "way"),
}


def test_every_lab_has_its_parts() -> None:
    assert {path.parent.name for path in LABS.glob("*/rubric.toml")} == set(EARNED)
    for name, earned in EARNED.items():
        folder = LABS / name
        assert (folder / "handout.md").exists()
        assert {path.stem for path in folder.rglob("*.py")} == set(earned)
        assert f"({name}/handout.md)" in (LABS / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", EARNED)
def test_what_is_handed_out_moves(name: str) -> None:
    simulation = am.Simulation(am.load(LABS / name / "lab.toml"))
    before = simulation.true_pose.copy()
    simulation.run(5.0)
    assert np.hypot(*(simulation.true_pose - before)[0, :2]) > 0.5


@pytest.mark.long
@pytest.mark.parametrize("name", EARNED)
def test_submissions_earn_what_they_should(name: str, tmp_path: Path) -> None:
    seeds = SEEDS.get(name, [11])
    rubric = practice(name, tmp_path / "lab", seeds)
    files = [path for path in sorted(rubric.parent.rglob("*.py")) if "__pycache__" not in path.parts]
    graded = grade(rubric, files, tmp_path / "grades", fence=not fence_problem(), seeds=seeds_of(rubric))
    found = {one.label: one for one in graded}
    for label, (least, most) in EARNED[name].items():
        assert [case.problem for case in found[label].cases] == [""] * len(seeds), label
        program, answers = points_of(found[label])
        assert least <= program <= most, (label, program)
        assert answers == (found[label].of - 10.0 if label == "good" else 0.0), label
    if name not in LOST:
        return
    label, lost = LOST[name]
    for criterion in found["good"].cases[0].points:
        if not criterion.startswith("question"):
            expected = 0.0 if criterion == lost else found["good"].points_for(criterion)
            assert found[label].points_for(criterion) == pytest.approx(expected, abs=0.5), criterion


@pytest.mark.parametrize("runs", [pytest.param(3, marks=pytest.mark.long), pytest.param(10, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("name", EARNED)
def test_a_good_solution_earns_nine_tenths_over_many_seeds(name: str, runs: int, tmp_path: Path) -> None:
    rubric = practice(name, tmp_path / "lab", list(range(101, 101 + runs)))
    good = rubric.parent / "solutions" / "good.py"
    (found,) = grade(rubric, [good], tmp_path / "grades", fence=not fence_problem(), seeds=seeds_of(rubric))
    assert found.total >= 0.9 * found.of
    assert sum(case.total < 0.9 * found.of for case in found.cases) <= 1


def practice(name: str, lab: Path, seeds: list[int]) -> Path:
    """The rubric of a copy of a lab, with seeds that are known; worlds that are drawn are drawn by the replica."""
    shutil.copytree(LABS / name, lab)
    rubric = lab / "rubric.toml"
    text, count = re.subn(
        r"^runs = \d+$", f"runs = {len(seeds)}", rubric.read_text(encoding="utf-8"), flags=re.MULTILINE
    )
    assert count == 1
    rubric.write_text(text, encoding="utf-8")
    is_drawn = 'per = "replica"' in (lab / "lab.toml").read_text(encoding="utf-8")
    write_seeds(seeds_of(rubric), [Seed(seed, seed if is_drawn else 0) for seed in seeds])
    return rubric


def seeds_of(rubric: Path) -> Path:
    return rubric.with_name("seeds.toml")


def points_of(found: Grade) -> tuple[float, float]:
    """The points of a submission's program, and those of its answers."""
    answers = math.fsum(found.points_for(each) for each in found.cases[0].points if each.startswith("question"))
    return found.total - answers, answers
