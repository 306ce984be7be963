"""Studies of a small scenario, for tests."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

from amorsim.scenario.toml.literals import as_toml
from tests.studies import make_study

SCENARIO = """\
format = 1

[world]
map = "rooms.wld"

[simulation]
dt = 0.1
duration = 1.0
seed = 5

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 1.0, y = 1.0 }
controller = { use = "square", side = 2.0 }
sensors = { laser = false, sonar = false }
ground = [{ use = "diffusion", variance_per_length = 1e-4 }]

[robots.errors.drive]
track = { scale = 1.0 }
"""
TRACK = "robots.rover.errors.drive.track.scale"
METRICS = {"final_error": {"use": "position_error"}, "length": {"use": "path_length"}}

needs_extra = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("joblib", "distributed")),
    reason="the extra 'sweep' is not installed",
)


def tables(folder: Path, **changes: Any) -> dict[str, Any]:
    """A study of the small scenario in this folder, which is made."""
    if not folder.exists():
        make_study(folder)
    (folder / "small.toml").write_text(SCENARIO)
    given: dict[str, Any] = {
        "format": 1,
        "scenario": str(folder / "small.toml"),
        "replicas": 3,
        "axes": {TRACK: [1.0, 1.05]},
        "metrics": METRICS,
    }
    return {key: value for key, value in (given | changes).items() if value is not None}


def study_file(path: Path, given: dict[str, Any]) -> Path:
    """The file of a study with these tables."""
    path.write_text("".join(f"{key} = {as_toml(value)}\n" for key, value in given.items()))
    return path
