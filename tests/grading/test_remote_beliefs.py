"""What a submission sends as its beliefs is judged where it is arrays of numbers, and costs it the run elsewhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.grading.courses import ESTIMATOR, RUBRIC, graded, make_course
from tests.some_cases import one_in

CRITERION = 'cloud = { use = "nees", at = "median", estimator = "dead_reckoning", particles = true, points = 10.0 }\n'
RIGHT = '{"particles": np.tile(self.pose, (9, 1)) + 0.1 * np.eye(9, 3), "weights": np.ones(9)}'
ANSWERS = {
    "right": (RIGHT, ""),
    "texts": ("['particles']", "ValueError"),
    "objects": ("{'particles': [None], 'weights': [object()]}", "TypeError"),
    "infinite": ("{'particles': np.full((9, 3), np.inf), 'weights': np.ones(9)}", "expected finite numbers"),
    "other": ("{'cloud': np.ones(3)}", "no belief 'particles'"),
}


@pytest.mark.parametrize("name", one_in(4, ANSWERS))
def test_beliefs_are_numbers_or_the_run_is_lost(tmp_path: Path, name: str) -> None:
    returned, reason = ANSWERS[name]
    text = RUBRIC[: RUBRIC.index("[criteria]")].replace('function = "drive"', 'role = "estimator"')
    text = text.replace("duration = 3.0", "duration = 0.5").replace("time_limit = 2.0", "time_limit = 60.0")
    course = make_course(tmp_path / "course", f"{text}[criteria]\n{CRITERION}")
    scenario = course.parent / "small.toml"
    own = f"{ESTIMATOR}\n    def beliefs(self):\n        return {RIGHT}\n"
    (course.parent / "own.py").write_text(own)
    before = scenario.read_text()
    scenario.write_text(before + '\n[robots.estimators]\ndead_reckoning = { use = "own.py:Estimator" }\n')
    found = graded(course, fence=False, ann=f"{ESTIMATOR}\n    def beliefs(self):\n        return {returned}\n")["ann"]
    assert reason in found.cases[0].problem
    assert bool(found.cases[0].problem) == bool(reason)
    assert ("cloud" in found.cases[0].values) == (name == "right")
