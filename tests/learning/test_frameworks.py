"""Frameworks for learning that take vector environments of Gymnasium; the nightly tests install TorchRL."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples" / "learning"
pytestmark = pytest.mark.nightly


@pytest.mark.parametrize(("framework", "package"), [("torchrl", "torchrl"), ("rllib", "ray.rllib")])
def test_the_example_trains_and_tells_what_the_policy_reaches(framework: str, package: str) -> None:
    pytest.importorskip(package, reason="installed by hand, or by the nightly tests")
    given = [sys.executable, EXAMPLES / f"{framework}_point_goal.py", "--rounds", "1"]
    ended = subprocess.run(given, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert "1000 episodes:" in ended.stdout
