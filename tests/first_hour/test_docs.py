"""The documentation: its code runs, its commands work, its links lead somewhere, its generated page is up to date."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import typer.main
from PIL import Image

import amorsim as am
from amorsim.cli.app import app
from amorsim.scenario.files import models
from amorsim.scenario.reading import contents, robots
from tests.first_hour.conftest import ROOT, Page, blocks_of, check_output
from tests.grading.courses import needs_fence

DOCS = ROOT / "docs"
# The website's own pages are made from these.
MADE = (DOCS / "reference" / "components", DOCS / "reference" / "python")
DOC_PAGES = [path for path in DOCS.rglob("*.md") if path.parent not in MADE]
PAGES = sorted(
    [
        *DOC_PAGES,
        *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "RELEASING.md")),
    ]
)
# Written by others, with tests of their own.
ELSEWHERE = {DOCS / "how-to" / "write-a-plugin.md", DOCS / "how-to" / "write-a-controller.md", ROOT / "README.md"}
# Examples and pages that simulate for more than some seconds.
_LONG = {
    *("crowd_crossing", "ekf_or_dead_reckoning", "snapshot", "spread", "track_until_it_fails", "wheel_error"),
    *("calibrate", "first-run", "plan-a-path", "sweep-a-parameter", "train-a-policy", "environments", "a-filter"),
    *("from-here-to-there", "grade-submissions", "work-in-a-notebook", "from-a-log-to-a-map", "make-a-map"),
    *("two_robots", "from-a-question-to-a-figure", "write-an-estimator"),
}

_LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")


def _marked(paths: list[Path]) -> list[Any]:
    return [pytest.param(path, marks=_marks(path.stem)) for path in paths]


def _marks(name: str) -> list[pytest.MarkDecorator]:
    return [pytest.mark.long] * (name in _LONG) + [needs_fence] * (name == "grade-submissions")


def _is_run(path: Path) -> bool:
    return path not in ELSEWHERE and any(block.language in ("console", "python", "toml") for block in blocks_of(path))


def _name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def _tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("path", _marked([path for path in PAGES if _is_run(path)]), ids=_name)
def test_a_page_does_what_it_says(path: Path, page: Page) -> None:
    blocks = blocks_of(path)
    if not any(block.language == "console" for block in blocks):
        page.lend_maps()  # otherwise a reader who types the commands must have made all files before
    for block in blocks:
        page.run(block)
    assert page.ran


@pytest.mark.long
@pytest.mark.parametrize("path", _marked(sorted((DOCS / "examples").glob("*.py"))), ids=lambda path: path.stem)
def test_an_example_prints_what_stands_beside_it(path: Path) -> None:
    check_output(path.with_suffix(".out").read_text(encoding="utf-8"), _tool("make_example_outputs").output_of(path))


@pytest.mark.long
def test_the_page_of_components_is_up_to_date() -> None:
    tool = _tool("make_reference")
    written = tool.PAGE.read_text(encoding="utf-8")
    assert written == tool.page(), "run: python tools/make_reference.py"


@pytest.mark.long
def test_the_page_of_python_is_up_to_date() -> None:
    tool = _tool("make_python_reference")
    written = tool.PAGE.read_text(encoding="utf-8")
    assert written == tool.page(), "run: python tools/make_python_reference.py"


def test_every_public_name_is_on_the_page_of_python() -> None:
    text = (DOCS / "reference" / "python.md").read_text(encoding="utf-8")
    components = {"controllers", "drives", "estimators", "metrics", "motions", "noise", "planners", "sensors", "tasks"}
    packages = components | {"algorithms", "worlds"}
    for name in set(am.__all__) - packages - {"analysis", "testing"}:
        assert f"### `am.{name}`\n" in text, name
    for name in packages:
        for public in getattr(am, name).__all__:
            assert f"| `{public}` |" in text, f"{name}.{public}"
    for name in am.testing.__all__:
        assert f"### `amorsim.testing.{name}`\n" in text, name


def _anchors(page: Path) -> set[str]:
    found: dict[str, int] = {}
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for heading in re.findall(r"^#+ (.+)$", text, re.MULTILINE):
        # As GitHub makes them: lower case, blanks to hyphens, and nothing but letters, digits and these.
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        found[slug] = found.get(slug, -1) + 1
        if found[slug]:
            found[f"{slug}-{found[slug]}"] = 0
    return set(found)


@pytest.mark.parametrize("path", PAGES, ids=_name)
def test_links_lead_somewhere(path: Path) -> None:
    text = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for link in _LINK.findall(text):
        if link.startswith(("https://", "http://")):
            continue
        target, _, anchor = link.partition("#")
        found = (path.parent / target).resolve() if target else path
        assert found.exists(), f"{link} leads nowhere"
        if anchor:
            assert anchor in _anchors(found), f"{link}: {found.name} has no such heading"


def test_every_page_can_be_reached_from_the_index() -> None:
    seen: set[Path] = set()
    waiting = [DOCS / "index.md"]
    while waiting:
        path = waiting.pop()
        if path in seen or path.suffix != ".md" or not path.exists():
            continue
        seen.add(path)
        links = _LINK.findall(path.read_text(encoding="utf-8"))
        waiting += [(path.parent / link.partition("#")[0]).resolve() for link in links if not link.startswith("http")]
    assert set(DOC_PAGES) <= seen


def test_pictures_are_small() -> None:
    pictures = sorted((DOCS / "pictures").glob("*.png"))
    assert pictures
    for path in pictures:
        assert path.stat().st_size < 300_000, path.name
        with Image.open(path) as picture:
            assert max(picture.size) > 400


def test_moving_pictures_are_small() -> None:
    for path in (DOCS / "pictures").glob("*.gif"):
        assert path.stat().st_size < 1_500_000, path.name


def test_every_column_is_described(page: Page) -> None:
    summary = am.run(am.load("demo"), "run", duration=0.2)
    moving = am.run(am.load("doors"), "moving", duration=0.2)
    text = (DOCS / "reference" / "run-folder.md").read_text(encoding="utf-8")
    files = sorted([*summary.folder.rglob("*.csv"), moving.folder / "obstacles.csv"])
    assert {path.stem for path in files} >= {"poses", "velocities", "commands", "events", "laser"}
    for path in files:
        for column in path.read_text(encoding="utf-8").partition("\n")[0].split(","):
            plain = re.sub(r"_\d+$", "_0", column)
            plain = re.sub(r"^(true|measured)_(left|right)_wheel$", r"\1_JOINT", plain)
            assert f"`{plain}`" in text, f"{path.name}: nothing is said of {column}"
    for key in json.loads((summary.folder / "run.json").read_text(encoding="utf-8")):
        assert f"`{key}`" in text, f"run.json: nothing is said of {key}"


def test_every_key_of_a_scenario_is_described() -> None:
    text = (DOCS / "reference" / "scenario.md").read_text(encoding="utf-8")
    keys = {
        *contents._KEYS,
        *contents._TIMES,
        *robots._ROBOT_KEYS,
        *robots._OBSTACLE_KEYS,
        *robots._ZONE_KEYS,
        *models.MODEL_KEYS,
    }
    for key in keys:
        assert re.search(rf"`(\[+)?(robots\.)?{key}(\]+)?`", text), f"nothing is said of {key}"


def test_every_option_of_a_command_is_described() -> None:
    text = (DOCS / "reference" / "command-line.md").read_text(encoding="utf-8")
    group = typer.main.get_command(app)
    commands = group.commands  # type: ignore[attr-defined]
    assert "run" in commands
    for name, command in commands.items():
        assert f"## amorsim {name}" in text
        for parameter in command.params:
            for option in parameter.opts:
                if option.startswith("--") and option != "--help":
                    assert f"`{option}" in text, f"amorsim {name}: nothing is said of {option}"


@pytest.mark.parametrize(
    ("page", "kinds"),
    [
        ("write-an-estimator", (am.Estimator, am.Context, am.Measurement, am.RobotModel, am.Estimate)),
        ("write-a-sensor", (am.Sensor, am.View, am.Aim, am.Emission)),
        ("write-a-drive", (am.Drive,)),
        ("write-a-planner", (am.Planner, am.Plan)),
    ],
)
def test_every_method_and_field_of_a_contract_is_described(page: str, kinds: tuple[type, ...]) -> None:
    text = (DOCS / "how-to" / f"{page}.md").read_text(encoding="utf-8")
    described = {word for code in re.findall(r"`([^`\n]+)`", text) for word in re.findall(r"\w+", code)}
    for kind in kinds:
        names = {name for cls in kind.__mro__[:-1] for name in (*vars(cls), *vars(cls).get("__annotations__", {}))}
        # The size of a sample is for sensors and noise alone.
        names -= {"count", "index", "size"} if kind is am.Context else {"count", "index"}
        missing = {name for name in names if not name.startswith("_")} - described
        assert not missing, f"{page}.md says nothing of {sorted(missing)} of {kind.__name__}"
