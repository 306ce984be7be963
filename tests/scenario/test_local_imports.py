"""What a user's file imports from beside it: found, run, and copied into a run's folder."""

from __future__ import annotations

import json
import pickle
import sys
from collections.abc import Iterator
from pathlib import Path

import attrs
import pytest

import amorsim as am
from amorsim.core.errors import ControllerError, RunError
from amorsim.scenario.programs.controller_files import load_controller
from amorsim.scenario.programs.local_imports import files_beside
from tests.studies import make_study

CONTROLLER = (
    "import math\nimport numpy\nfrom beside_speeds import fast\nimport beside_kit.turns\n\n"
    "def drive(readings, estimate, clock, speed):\n    import beside_late\n"
    "    return fast(speed), beside_kit.turns.slow(speed)\n"
)
FILES = {
    "beside_speeds.py": "from beside_more import FACTOR\n\ndef fast(speed):\n    return FACTOR * speed\n",
    "beside_more.py": "FACTOR = 3.0\n",
    "beside_kit/__init__.py": "",
    "beside_kit/turns.py": "from .data import HALF\n\ndef slow(speed):\n    return HALF * speed\n",
    "beside_kit/data.py": "HALF = 0.5\n",
    "beside_late.py": "",
    "math.py": "raise RuntimeError('the standard library comes first')\n",
    "unused.py": "raise RuntimeError('nobody asked')\n",
}


@pytest.fixture(autouse=True)
def forget() -> Iterator[None]:
    """Leave no module of these tests behind."""
    yield
    for name in [name for name in sys.modules if name.startswith("beside_")]:
        del sys.modules[name]


def write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def test_what_is_imported_is_found_and_nothing_else(tmp_path: Path) -> None:
    write(tmp_path, FILES | {"mine.py": CONTROLLER})
    found = files_beside(tmp_path / "mine.py")
    assert sorted(found) == sorted(set(FILES) - {"math.py", "unused.py"})
    assert all(file == tmp_path / name for name, file in found.items())
    assert files_beside(tmp_path / "none.py") == {}
    assert files_beside(tmp_path / "mine.py", b"def (") == {}


def test_a_run_with_imports_from_beside_reproduces(tmp_path: Path) -> None:
    path = make_study(tmp_path / "study", CONTROLLER)
    write(path.parent, {name: text for name, text in FILES.items() if name != "math.py"})
    summary = am.run(am.load(path), tmp_path / "run", duration=1.0)
    assert not list(path.parent.rglob("__pycache__"))
    copies = {name for name in FILES if (summary.folder / name).is_file()}
    assert copies == set(FILES) - {"math.py", "unused.py"}
    inputs = json.loads((summary.folder / "run.json").read_text())["inputs"]
    assert {"controller.py", "beside_speeds.py", "beside_kit/turns.py"} <= set(inputs)
    for file in path.parent.glob("beside_*.py"):
        file.unlink()
    assert am.reproduce(summary.folder).is_exact


def test_an_import_that_was_edited_is_run_again(tmp_path: Path) -> None:
    write(tmp_path, {"beside_more.py": "FACTOR = 3.0\n", "mine.py": "from beside_more import FACTOR\ndef f(r, e, c):\n  return FACTOR\n"})  # fmt: skip  # noqa: E501
    assert load_controller(tmp_path / "mine.py", "f", {})(0, 0, 0) == 3.0
    write(tmp_path, {"beside_more.py": "FACTOR = 4.0\n"})
    assert load_controller(tmp_path / "mine.py", "f", {})(0, 0, 0) == 4.0


def test_two_folders_each_have_their_own(tmp_path: Path) -> None:
    text = "import beside_more\ndef f(r, e, c, more=beside_more):\n    return more.FACTOR\n"
    for name in ("a", "b"):
        write(tmp_path / name, {"mine.py": text, "beside_more.py": f"FACTOR = {name!r}\n"})
    one, other = (load_controller(tmp_path / name / "mine.py", "f", {}) for name in ("a", "b"))
    assert (one(0, 0, 0), other(0, 0, 0)) == ("a", "b")


def test_what_was_made_of_an_import_can_be_copied(tmp_path: Path) -> None:
    write(
        tmp_path, {"beside_more.py": "class Filter:\n    last = 0.0\n", "mine.py": "from beside_more import Filter\n"}
    )
    made = load_controller(tmp_path / "mine.py", "Filter", {})()
    assert isinstance(pickle.loads(pickle.dumps(made)), type(made))


def test_an_import_that_fails_is_reported_with_its_line(tmp_path: Path) -> None:
    write(tmp_path, {"beside_more.py": "1 / 0\n", "mine.py": "x = 1\nimport beside_more\n"})
    with pytest.raises(ControllerError, match=r"mine\.py, line 2: ZeroDivisionError"):
        load_controller(tmp_path / "mine.py", "f", {})


def test_two_files_of_one_name_have_no_place_in_one_folder(tmp_path: Path) -> None:
    text = "import beside_more\ndef drive(readings, estimate, clock, speed=0.1):\n    return 1.0, 1.0\n"
    path = make_study(tmp_path / "study", text)
    write(path.parent, {"beside_more.py": ""})
    write(tmp_path / "other", {"mine.py": text, "beside_more.py": "x = 1\n"})
    robot = am.load(path).robots[0]
    scenario = am.load(path, [f"robots.0.controller.use='{tmp_path / 'other' / 'mine.py'}:drive'"])
    both = attrs.evolve(scenario, robots=[attrs.evolve(robot, name="second", pose=am.Pose(x=5, y=3)), *scenario.robots])
    with pytest.raises(RunError, match=r"beside_more\.py: cannot be copied into .* another file there"):
        am.run(both, tmp_path / "run", duration=0.5)
