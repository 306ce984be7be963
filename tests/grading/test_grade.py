"""Submissions earn what the rubric says; one that misbehaves costs only itself."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.controllers.user import PoseVector, RobotClock, RobotEstimate, RobotReading
from amorsim.grading.fence import is_offered
from amorsim.grading.grade import Grade, grade
from amorsim.grading.remote import Remote
from tests.processes import is_running
from tests.studies import make_study
from tests.sweeps.studies import SCENARIO

RUBRIC = """\
format = 1
title = "First homework"
scenario = "small.toml"
function = "drive"
seeds = [11, 12]
duration = 3.0
time_limit = 2.0
memory_limit = 6e9

[criteria]
arrived = { use = "success", goal = [2.2, 1.0], within = 0.3, points = 6.0 }
straight = { use = "turning", points = 4.0, none = 1.0, full = 0.0 }
"""
GOOD = """\
import amorsim as am

def drive(readings, estimate, clock):
    return am.Twist(0.4 if estimate.x < 2.2 else 0.0, 0.0)
"""
LAZY = "def drive(readings, estimate, clock):\n    return None\n"


@pytest.fixture
def course(tmp_path: Path) -> Path:
    make_study(tmp_path / "course")
    (tmp_path / "course" / "small.toml").write_text(SCENARIO)
    rubric = tmp_path / "course" / "rubric.toml"
    rubric.write_text(RUBRIC)
    return rubric


def graded(course: Path, **submissions: str) -> dict[str, Grade]:
    paths = []
    for name, text in submissions.items():
        paths.append(course.parent / f"{name}.py")
        paths[-1].write_text(text)
    return {each.label: each for each in grade(course, paths, course.parent / "grades")}


def test_points_are_those_of_the_rubric(course: Path) -> None:
    found = graded(course, good=GOOD, lazy=LAZY)
    assert [case.problem for case in found["good"].cases] == ["", ""]
    assert found["good"].points_for("arrived") == 6.0
    assert 3.0 < found["good"].points_for("straight") <= 4.0
    assert found["lazy"].total == 0.0  # it did not turn, and did not move
    assert [case.case.seed for case in found["lazy"].cases] == [11, 12]
    with (course.parent / "grades" / "grades.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["submission"] for row in rows] == ["good", "lazy"]
    assert float(rows[0]["total"]) == pytest.approx(found["good"].total, rel=1e-3)
    page = (course.parent / "grades" / "good.html").read_text(encoding="utf-8")
    assert "First homework: good" in page
    assert "seed 11" not in page  # held-out seeds stay with the lecturer


def test_a_graded_controller_drives_as_it_does_in_a_run(course: Path) -> None:
    found = graded(course, good=GOOD)
    scenario = am.load(
        course.parent / "small.toml", [f'robots.rover.controller={{use="{course.parent}/good.py:drive"}}']
    )
    simulation = am.Simulation(scenario, seed=12)
    kept = simulation.run(3.0, keep=("true_pose",))
    turned = abs(am.wrap_angle(kept["true_pose"][1:, 0, 2] - kept["true_pose"][:-1, 0, 2])).sum()
    assert found["good"].cases[1].values["straight"] * 0.9 < turned < found["good"].cases[1].values["straight"] * 1.3


BAD = {
    "raises": ("def drive(readings, estimate, clock):\n    return 1 / 0\n", "ZeroDivisionError"),
    "hangs": ("def drive(readings, estimate, clock):\n    while True:\n        pass\n", "took longer than 2 s in all"),
    "leaves": ("import os\n\ndef drive(readings, estimate, clock):\n    os._exit(0)\n", "its process ended"),
    "killed": (
        "import os\n\ndef drive(readings, estimate, clock):\n    os.kill(os.getpid(), 9)\n",
        "its process ended by signal 9",
    ),
    "words": ("def drive(readings, estimate, clock):\n    return 'forward'\n", "returned 'forward'"),
    "syntax": ("def drive(readings:\n", "SyntaxError"),
    "other": ("def steer(readings, estimate, clock):\n    return None\n", "there is no 'drive'"),
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


@pytest.mark.parametrize(
    "name", [name if name == "truth" else pytest.param(name, marks=pytest.mark.long) for name in BAD]
)
def test_a_submission_that_misbehaves_has_no_points_and_a_reason(course: Path, name: str) -> None:
    text, reason = BAD[name]
    course.write_text(RUBRIC.replace("seeds = [11, 12]", "seeds = [11]"))
    begun = time.monotonic()
    found = graded(course, **{name: text, "good": GOOD})
    assert time.monotonic() - begun < 40.0
    (case,) = found[name].cases
    assert case.total == 0.0
    assert reason in case.problem
    assert found["good"].total > 8.0
    assert reason in (course.parent / "grades" / "grades.csv").read_text().replace('""', '"')


BACK_DOOR = """\
import os


def drive(readings, estimate, clock):
    with open(f"/proc/{os.getppid()}/mem", "rb") as memory:
        return memory.fileno()
"""
STRAY = """\
import os
import time


def drive(readings, estimate, clock):
    if clock.tick == 0 and os.fork() == 0:
        os.setsid()
        with open("stray", "w") as file:
            file.write(str(os.getpid()))
        time.sleep(100.0)
        os._exit(0)
    while not os.path.exists("stray"):
        time.sleep(0.01)
    with open("stray") as file:
        raise RuntimeError("stray " + file.read())
"""
on_linux = pytest.mark.skipif(sys.platform != "linux", reason="only Linux has /proc")


@on_linux
@pytest.mark.long
def test_the_memory_of_the_grader_cannot_be_read(course: Path) -> None:
    course.write_text(RUBRIC.replace("seeds = [11, 12]", "seeds = [11]"))
    shell = BACK_DOOR.replace(
        "    with", "    if not os.system(f'head -c 0 /proc/{os.getppid()}/mem'):\n        return None\n    with"
    )
    found = graded(course, memory=BACK_DOOR, shell=shell)  # nor by a program, which root would have all rights of
    for each in found.values():
        assert each.total == 0.0
        assert "PermissionError" in each.cases[0].problem


@on_linux
@pytest.mark.long
def test_what_a_submission_leaves_running_is_ended(course: Path) -> None:
    course.write_text(RUBRIC.replace("seeds = [11, 12]", "seeds = [11]"))
    problem = graded(course, stray=STRAY)["stray"].cases[0].problem
    stray = int(problem.partition("stray ")[2].split()[0])
    until = time.monotonic() + 60.0
    while is_running(stray) and time.monotonic() < until:
        time.sleep(0.05)
    assert not is_running(stray)


with_landlock = pytest.mark.skipif(not is_offered(), reason="needs Linux with Landlock")
REACHING = """\
import os
import pathlib


def drive(readings, estimate, clock):
    beside = pathlib.Path(__file__).parent
    {}
    return None
"""
REACHES = {
    "the held-out seeds": "(beside / 'rubric.toml').read_text()",
    "them by the grader's own folder": "pathlib.Path(f'/proc/{os.getppid()}/cwd/rubric.toml').read_text()",
    "a held-out world": "(beside / 'secret' / 'held-out.wld').read_text()",
    "what another submission says": "(beside / 'good.py').read_text()",
    "another submission's file, to change it": "(beside / 'good.py').write_text('')",
    "it to remove it": "(beside / 'good.py').unlink()",
    "the table": "(beside / 'grades' / 'grades.csv').write_text('')",
    "a folder to leave a file in": "(beside / 'new').touch()",
    "the grader, to end it": "os.kill(os.getppid(), 9)",
}


@with_landlock
@pytest.mark.long
def test_a_submission_reaches_nothing_of_others(course: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (course.parent / "secret").mkdir()
    world = course.parent / "secret" / "held-out.wld"
    world.write_text((course.parent / "rooms.wld").read_text())
    course.write_text(RUBRIC.replace("seeds = [11, 12]", 'seeds = [11]\nworlds = ["secret/held-out.wld"]'))
    monkeypatch.chdir(course.parent)
    before = {path: path.read_bytes() for path in course.parent.rglob("*") if path.is_file()}
    bad = {f"bad{number}": REACHING.format(reach) for number, reach in enumerate(REACHES.values())}
    found = graded(course, **bad, good=GOOD)
    for name, what in zip(bad, REACHES, strict=True):
        assert found[name].total == 0.0, what
        assert "PermissionError" in found[name].cases[0].problem, what
    assert found["good"].total > 8.0
    assert (course.parent / "good.py").read_text() == GOOD
    assert all(path.read_bytes() == content for path, content in before.items())
    assert not (course.parent / "new").exists()


@with_landlock
def test_what_is_hidden_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("11, 12")
    (tmp_path / "nosy.py").write_text(REACHING.format("return (beside / 'secret.txt').read_text()"))
    with Remote(
        tmp_path / "nosy.py",
        "drive",
        "controller",
        time_limit=5.0,
        memory_limit=6 * 10**9,
        hidden=[tmp_path / "secret.txt"],
    ) as remote:
        estimate = RobotEstimate(np.zeros(3).view(PoseVector), np.zeros((3, 3)))
        with pytest.raises(am.ControllerError, match="PermissionError"):
            remote({}, estimate, RobotClock(0, 0.0, 0.1))


@with_landlock
@pytest.mark.long
def test_a_submission_has_its_own_files_and_a_folder(course: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = course.parent / "temporary"
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    (course.parent / "gains.txt").write_text("0.4")
    (course.parent / "helper.py").write_text("def gain(text):\n    return float(text)\n")
    honest = """\
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
    assert gain == helper.gain((pathlib.Path(__file__).parent / "gains.txt").read_text())
    return am.Twist(gain if estimate.x < 2.2 else 0.0, 0.0)
"""
    found = graded(course, honest=honest, good=GOOD)
    assert [case.problem for case in found["honest"].cases] == ["", ""]
    assert found["honest"].total == found["good"].total
    assert not (course.parent / "log.txt").exists()
    assert not list(place.iterdir())


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
def test_a_submission_that_does_not_read_holds_nothing_up(tmp_path: Path) -> None:
    (tmp_path / "deaf.py").write_text(DEAF)
    more_than_a_pipe_holds = {"laser": RobotReading(np.ones(100_000), 0, 0.0, True)}
    estimate = RobotEstimate(np.zeros(3).view(PoseVector), np.zeros((3, 3)))
    remote = Remote(tmp_path / "deaf.py", "drive", "controller", time_limit=0.5, memory_limit=6 * 10**9)
    with remote:
        remote({}, estimate, RobotClock(0, 0.0, 0.1))
        with pytest.raises(am.ControllerError, match=r"took longer than 0.5 s in all \(at 0.1 s\)"):
            remote(more_than_a_pipe_holds, estimate, RobotClock(1, 0.1, 0.1))


GRADER = """\
import sys
from pathlib import Path
from amorsim.controllers.user import RobotClock
from amorsim.grading.remote import Remote

with Remote(Path(sys.argv[1]), "drive", "controller", time_limit=60.0, memory_limit=6 * 10**9) as remote:
    remote._say({"readings": {}, "estimate": [[0.0] * 3, [[0.0] * 3] * 3], "clock": [0, 0.0, 0.1]})
    print(remote._process.pid, flush=True)
    sys.stdin.read()
"""


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="looks for a process in /proc")
def test_a_submission_ends_with_a_grader_that_is_killed(tmp_path: Path) -> None:
    (tmp_path / "slow.py").write_text("def drive(readings, estimate, clock):\n    while True:\n        pass\n")
    command = [sys.executable, "-c", GRADER, str(tmp_path / "slow.py")]
    place = os.environ | {"TMPDIR": str(tmp_path)}  # for what a killed grader leaves
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=place) as grader:
        assert grader.stdout is not None
        submission = int(grader.stdout.readline())
        assert is_running(submission)
        grader.kill()
    deadline = time.monotonic() + 60.0
    while is_running(submission) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not is_running(submission)


@pytest.mark.long
def test_what_it_prints_is_no_command(course: Path) -> None:
    loud = GOOD.replace("    return", "    print('[\"twist\", [9.0, 0.0, 0.0]]')\n    return")
    found = graded(course, loud=loud, good=GOOD)
    assert found["loud"].total == found["good"].total


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"small.toml"', '"none.toml"', "none.toml"),
        ("points = 6.0", "points = 'six'", "expected a number, got 'six'"),
        ("points = 6.0", "points = inf", "expected a number, got inf"),
        ("points = 6.0", "points = -6.0", "expected 0 or more, got -6"),
        ("full = 0.0", "full = nan", "expected a number, got nan"),
        ("full = 0.0", "full = 1.0", "expected another value than for none"),
        ("time_limit = 2.0", "time_limit = 0", "time_limit: expected a number > 0"),
        ("time_limit = 2.0", "memory_limit = inf", "memory_limit: expected a number > 0, got inf"),
        ("seeds = [11, 12]", "seeds = 11", "seeds: expected a list of seeds"),
        ('use = "turning"', 'use = "turnin"', "Did you mean 'turning'"),
        ("duration = 3.0", "length = 3.0", "there is no such key"),
    ],
)
def test_a_wrong_rubric_is_reported_before_anybody_is_graded(course: Path, old: str, new: str, words: str) -> None:
    course.write_text(RUBRIC.replace(old, new))
    with pytest.raises(am.StudyError, match=words):
        graded(course, good=GOOD)
    assert not (course.parent / "grades" / "good.html").exists()


def test_a_submission_that_is_not_there_is_reported(course: Path) -> None:
    with pytest.raises(am.StudyError, match=r"none.py: there is no such file"):
        grade(course, [course.parent / "none.py"], course.parent / "grades")
    with pytest.raises(am.StudyError, match=r"it is a folder; a submission is a file of Python"):
        grade(course, [course.parent], course.parent / "grades")


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


@pytest.mark.long
def test_estimators_are_graded_too(course: Path) -> None:
    text = RUBRIC.replace('function = "drive"', 'role = "estimator"').replace("[11, 12]", "[11]")
    text = text[: text.index("[criteria]")] + (
        "[criteria]\nnear = { use = 'position_error', at = 'max', points = 10.0, none = 1.0, full = 0.0 }\n"
    )
    course.write_text(text)
    nan = ESTIMATOR.replace("return self.pose", "return self.pose * np.nan")
    still = ESTIMATOR.replace("return self.pose", "return [1.0, 1.0, 0.0], np.eye(3)")
    wrong = "class Estimator:\n    def __init__(self, start):\n        pass\n"
    found = graded(course, good=ESTIMATOR, nan=nan, still=still, wrong=wrong)
    assert [case.problem for case in found["good"].cases] == [""]
    assert found["good"].total > found["still"].total > 0.0
    assert "expected a pose (x, y, heading) of finite numbers" in found["nan"].cases[0].problem
    assert "expected a class with update(self, readings, command, elapsed)" in found["wrong"].cases[0].problem
