"""Submissions earn what the rubric says; one that misbehaves costs only itself."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.controllers.user import PoseVector, RobotClock, RobotEstimate, RobotReading
from amorsim.grading.grade import grade
from amorsim.grading.handed_in import HandedIn
from amorsim.grading.remote import Remote
from tests.grading.courses import ESTIMATOR, GOOD, LAZY, RUBRIC, fence_problem, graded, make_course, needs_fence

ESTIMATE = RobotEstimate(np.zeros(3).view(PoseVector), np.zeros((3, 3)))


@pytest.fixture
def course(tmp_path: Path) -> Path:
    return make_course(tmp_path / "course")


def practice(*seeds: int) -> str:
    return RUBRIC.replace("runs = 1", f"practice = true\nseeds = {list(seeds)}")


def test_points_are_those_of_the_rubric(course: Path) -> None:
    course.write_text(practice(11))
    found = graded(course, good=GOOD, lazy=LAZY)
    assert [case.problem for case in found["good"].cases] == [""]
    assert found["good"].points_for("arrived") == 6.0
    assert 3.0 < found["good"].points_for("straight") <= 4.0
    assert found["lazy"].total == 0.0  # it did not turn, and did not move
    with (course.parent / "grades" / "grades.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["submission"] for row in rows] == ["good", "lazy"]
    assert float(rows[0]["total"]) == pytest.approx(found["good"].total, rel=1e-3)
    page = (course.parent / "grades" / "good.html").read_text(encoding="utf-8")
    assert "First homework: good" in page


def test_a_drawn_seed_stays_with_the_lecturer(course: Path) -> None:
    found = graded(course, good=GOOD)
    page = (course.parent / "grades" / "good.html").read_text(encoding="utf-8")
    assert str(found["good"].cases[0].case.seed.seed) not in page


def test_a_graded_controller_drives_as_it_does_in_a_run(course: Path) -> None:
    course.write_text(practice(12))
    found = graded(course, good=GOOD)
    scenario = am.load(
        course.parent / "small.toml", [f'robots.rover.controller={{use="{course.parent}/good.py:drive"}}']
    )
    simulation = am.Simulation(scenario, seed=12)
    kept = simulation.run(3.0, keep=("true_pose",))
    turned = abs(am.wrap_angle(kept["true_pose"][1:, 0, 2] - kept["true_pose"][:-1, 0, 2])).sum()
    assert found["good"].cases[0].values["straight"] * 0.9 < turned < found["good"].cases[0].values["straight"] * 1.3


@needs_fence
@pytest.mark.long
def test_a_fence_changes_no_result(course: Path) -> None:
    course.write_text(practice(11, 12))
    (course.parent / "good.py").write_text(GOOD)
    fenced, free = (
        grade(course, [course.parent / "good.py"], course.parent / f"grades-{fence}", fence=fence)[0]
        for fence in (True, False)
    )
    assert [case.values for case in fenced.cases] == [case.values for case in free.cases]
    assert fenced.total == free.total > 8.0


BAD = {
    "raises": ("def drive(readings, estimate, clock):\n    return 1 / 0\n", "ZeroDivisionError"),
    "hangs": ("def drive(readings, estimate, clock):\n    while True:\n        pass\n", "took longer than 2 s in all"),
    "leaves": ("import os\n\ndef drive(readings, estimate, clock):\n    os._exit(0)\n", "its process ended ("),
    "killed": (
        "import os\n\ndef drive(readings, estimate, clock):\n    os.kill(os.getpid(), 9)\n",
        "its process ended by signal 9",
    ),
    "words": ("def drive(readings, estimate, clock):\n    return 'forward'\n", "returned 'forward'"),
    "syntax": ("def drive(readings:\n", "SyntaxError"),
    "other": ("def steer(readings, estimate, clock):\n    return None\n", "no definition 'drive'"),
    "hungry": ("def drive(readings, estimate, clock):\n    return bytearray(10**11)\n", "memory"),
    "hasty": (
        "import os\n\ndef drive(readings, estimate, clock):\n"
        "    for answers in range(3, 20):\n"
        "        try:\n"
        "            os.write(answers, b'[\"twist\", [0.4, 0.0, 0.0]]\\n' * 3)\n"
        "        except OSError:\n"
        "            pass\n",
        "it answered before it was asked",
    ),
    "truth": (
        "import gc\nimport sys\n\nimport amorsim as am\n\n\ndef drive(readings, estimate, clock):\n"
        "    found = [each for each in gc.get_objects() if type(each).__name__ in ('Simulation', 'Fleet', 'Group')]\n"
        "    frame = sys._getframe()\n"
        "    while frame is not None:\n"
        "        found += [each for each in frame.f_locals.values() if hasattr(each, 'true_pose')]\n"
        "        frame = frame.f_back\n"
        "    return am.Twist(found[0].true_pose[0, 0], 0.0)\n",
        "IndexError",
    ),
}


@pytest.mark.parametrize("fence", [pytest.param(True, marks=needs_fence), False], ids=["fenced", "free"])
@pytest.mark.long
def test_a_submission_that_misbehaves_has_no_points_and_a_reason(course: Path, fence: bool) -> None:
    found = graded(course, fence, **{name: text for name, (text, _) in BAD.items()}, good=GOOD)
    table = (course.parent / "grades" / "grades.csv").read_text().replace('""', '"')
    for name, (_, reason) in BAD.items():
        (case,) = found[name].cases
        assert case.total == 0.0
        assert reason in case.problem
        assert reason in table
    assert found["good"].total > 8.0


@pytest.mark.long
def test_a_submission_has_its_own_files_and_those_of_the_rubric(course: Path, tmp_path: Path) -> None:
    course.write_text(RUBRIC.replace("runs = 1", 'runs = 1\nfiles = ["gains.txt"]'))
    (course.parent / "gains.txt").write_text("0.4")
    own = tmp_path / "handed-in"
    (own / "data").mkdir(parents=True)
    (own / "helper.py").write_text("def gain(text):\n    return float(text)\n")
    (own / "data" / "goal.txt").write_text("2.2")
    (own / "honest.py").write_text(
        """\
import pathlib
import tempfile

import amorsim as am
import helper

room = am.Map.from_segments([[0.0, 0.0, 1.0, 0.0]])


def drive(readings, estimate, clock):
    with open("log.txt", "a") as log, tempfile.TemporaryFile() as more:
        log.write("x")
        more.write(b"x")
    gain = helper.gain(open("gains.txt").read())
    goal = float((pathlib.Path(__file__).parent / "data" / "goal.txt").read_text())
    return am.Twist(gain if estimate.x < goal else 0.0, 0.0)
"""
    )
    before = sorted(own.rglob("*"))
    (honest,) = grade(course, [own / "honest.py"], tmp_path / "grades", fence=not fence_problem())
    assert [case.problem for case in honest.cases] == [""]
    assert honest.total > 8.0
    assert sorted(own.rglob("*")) == before


DEAF = """\
import os


def drive(readings, estimate, clock):
    for answers in range(3, 20):
        try:
            os.write(answers, b'["twist", [0.0, 0.0, 0.0]]\\n')
        except OSError:
            continue
    while True:
        pass
"""


@pytest.mark.long
def test_a_submission_that_does_not_read_holds_nothing_up() -> None:
    more_than_a_pipe_holds = {"laser": RobotReading(np.ones(100_000), 0, 0.0, True)}
    deaf = HandedIn("deaf.py", {"deaf.py": DEAF.encode()})
    with Remote(deaf, "drive", "controller", time_limit=0.5, memory_limit=4 * 10**9, fence=None) as remote:
        remote({}, ESTIMATE, RobotClock(0, 0.0, 0.1))
        with pytest.raises(am.ControllerError, match=r"took longer than 0.5 s in all \(at 0.1 s\)"):
            remote(more_than_a_pipe_holds, ESTIMATE, RobotClock(1, 0.1, 0.1))


@pytest.mark.long
def test_what_it_prints_is_no_command(course: Path) -> None:
    course.write_text(practice(11))
    loud = GOOD.replace("    return", "    print('[\"twist\", [9.0, 0.0, 0.0]]')\n    return")
    found = graded(course, loud=loud, good=GOOD)
    assert found["loud"].total == found["good"].total


@pytest.mark.long
def test_estimators_are_graded_too(course: Path) -> None:
    text = RUBRIC.replace('function = "drive"', 'role = "estimator"')
    text = text[: text.index("[criteria]")] + (
        "[criteria]\nnear = { use = 'position_error', at = 'max', points = 10.0, none = 1.0, full = 0.0 }\n"
    )
    course.write_text(text)
    bad = {
        "nan": ("self.pose * np.nan", "expected a pose (x, y, heading) of finite numbers"),
        "vague": ("self.pose, np.full((3, 3), np.inf)", "expected a pose (x, y, heading) of finite numbers"),
    }
    texts = {name: ESTIMATOR.replace("return self.pose", f"return {what}") for name, (what, _) in bad.items()}
    still = ESTIMATOR.replace("return self.pose", "return [1.0, 1.0, 0.0], np.eye(3)")
    wrong = "class Estimator:\n    def __init__(self, start):\n        pass\n"
    found = graded(course, good=ESTIMATOR, still=still, wrong=wrong, **texts)
    assert [case.problem for case in found["good"].cases] == [""]
    assert found["good"].total > found["still"].total > 0.0
    assert "expected a class with update(self, readings, command, elapsed)" in found["wrong"].cases[0].problem
    for name, (_, reason) in bad.items():
        assert reason in found[name].cases[0].problem
