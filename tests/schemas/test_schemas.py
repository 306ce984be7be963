"""The JSON Schemas: they accept what the readers accept, and underline what they can know to be wrong."""

from __future__ import annotations

import copy
import json
import random
import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import jsonschema
import pytest
import tomlkit

import amorsim as am
from amorsim.core.errors import AmorsimError, ScenarioError
from amorsim.plugins.manager import make_registry
from amorsim.schemas import KINDS, make_schema

ROOT = Path(__file__).parents[2]
BUNDLED = ROOT / "amorsim" / "scenarios"
# Faults that need a map, another file or several places of the file to be seen.
BEYOND = (
    "overlaps",
    "outside the map",
    "there is no such file",
    "the true value is wrong",
    "the robot has no",
    "names must differ",
    "a robot that knows nothing",
    "expected a pose for each",
    "cannot start at one place",
    "cover",
    "of several quantities",
    "noise.0.column",
    "one of the two",
    "times that increase",
    "at least, got",
    "expected either",
    "behind its front",
    "differ from the one before",
    "would stand at",
)
Path_ = tuple[str | int, ...]


def _validator(kind: str) -> Any:
    return jsonschema.Draft202012Validator(make_schema(kind))


@pytest.fixture(scope="module")
def scenarios() -> Any:
    return _validator("scenario")


@pytest.mark.parametrize("kind", KINDS)
def test_each_is_a_schema_in_json(kind: str) -> None:
    schema = make_schema(kind)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert json.loads(json.dumps(schema)) == schema


@pytest.mark.long
def test_files_that_the_readers_accept_are_accepted() -> None:
    kinds = {"criteria": "rubric", "metrics": "study", "robots": "scenario"}
    files: dict[str, list[Path]] = {kind: [] for kind in kinds.values()}
    for folder in (BUNDLED, ROOT / "docs", ROOT / "amorsim" / "cli" / "template"):
        for file in sorted(folder.rglob("*.toml")):
            keys = tomllib.loads(file.read_text(encoding="utf-8"))
            files[next((kinds[key] for key in kinds if key in keys), "scenario")].append(file)
    for kind, found in files.items():
        validator = _validator(kind)
        for file in found:
            content = tomllib.loads(file.read_text(encoding="utf-8"))
            if kind != "scenario" or "robots" in content:
                assert not list(validator.iter_errors(content)), file
    assert len(files["scenario"]) > 20
    assert len(files["rubric"]) >= 3


@pytest.mark.long
def test_a_resolved_scenario_is_accepted(scenarios: Any) -> None:
    """All tables of all components, with every field written out."""
    for name in ("demo", "find-yourself", "crowd", "parking-lot", "line"):
        resolved = am.load(name).resolved
        assert resolved is not None
        assert not list(scenarios.iter_errors(resolved)), name


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"simulation": {"dt": 0}}, "0 is less than the minimum of 1e-06"),
        ({"worlds": {}}, "'worlds' was unexpected"),
        ({"world": {}}, "'map' is a required property"),
        ({"format": 2}, "1 was expected"),
        ({"robots": []}, "[] should be non-empty"),
        ({"recording": {"sensors": "some"}}, "'some' is not one of ['auto', 'all', 'none']"),
    ],
)
def test_what_is_wrong_at_the_top_is_refused(scenarios: Any, change: dict[str, Any], message: str) -> None:
    document = tomllib.loads((BUNDLED / "demo.toml").read_text(encoding="utf-8"))
    errors = [error.message for error in scenarios.iter_errors(document | change)]
    assert any(message in error for error in errors), errors


@pytest.mark.parametrize(
    "change",
    [
        {"controller": {"use": "wander", "sped": 1.0}},
        {"controller": {"use": "wandr"}},
        {"controller": {"use": "navigate"}},  # without its goals
        {"controller": {"speed": 0.1}},  # the model has no controller
        {"sensors": {"laser": {"beems": 9}}},  # of the model's laser
        {"sensors": {"laser": {"noise": [{"use": "gaussian", "std_deg": 1.0}]}}},
        {"sensors": {"compass": {"noise": [{"use": "gaussian", "std": 1.0}]}}},
        {"sensors": {"nose": {"mount": {"x": 1.0}}}},
        {"sensors": {"compass": {"mount": {"heading": 1.0}}}},
        {"errors": {"drive": {"trak": 1.0}}},
        {"errors": {"drive": {"track": {"scal": 1.0}}}},
        {"errors": {"drive": {"track": {"normal": [1.0, -1.0]}}}},
        {"errors": {"sensors": {"laser": {"mount": "left"}}}},
        {"model": "pioneer2dy"},
        {"pose": {"heading": 1.0}},
        {"start": {"grid": [0.0, 0.0]}},
        {"shape": {"circle": 0.1, "rectangle": [1.0, 1.0]}},
    ],
)
def test_what_is_wrong_in_a_robot_is_refused_by_both(scenarios: Any, change: dict[str, Any], tmp_path: Path) -> None:
    document = tomllib.loads((BUNDLED / "demo.toml").read_text(encoding="utf-8"))
    document["world"]["map"] = str(BUNDLED / "office.wld")
    document["robots"][0] = {"name": "rover", "model": "pioneer2dx"} | change
    file = tmp_path / "changed.toml"
    file.write_text(tomlkit.dumps(document), encoding="utf-8")
    assert not scenarios.is_valid(document)
    with pytest.raises(ScenarioError):
        am.load(file)


def test_a_plugin_that_is_installed_is_in_it() -> None:
    registry = make_registry()

    @attrs.frozen(kw_only=True)
    class Dance(am.Controller):
        """Dances."""

        tempo: float = am.parameter(1.0, unit="Hz", gt=0, help="how fast")

        def command(self, robot: Any, readings: Any, estimate: Any, clock: Any, state: Any, draws: Any) -> Any:
            return None

    registry.controller("dance", Dance)
    table = make_schema("scenario", registry)["$defs"]["controller.dance"]
    assert table["properties"]["tempo"] == {
        "description": "how fast [Hz]",
        "type": "number",
        "maximum": 1e12,
        "exclusiveMinimum": 0,
        "default": 1.0,
    }


# ----------------------------------------------------------------------------------------------------------- mutations


def _places(value: Any, path: Path_ = ()) -> Iterator[tuple[Path_, Any]]:
    yield path, value
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from _places(item, (*path, key))


def _mutated(document: dict[str, Any], rng: random.Random) -> dict[str, Any]:
    """A document with one change: an unknown key, another type, a huge or negative number, or something left out."""
    document = copy.deepcopy(document)
    how = rng.choice(("key", "type", "left out", "huge", "negative"))
    if how == "key":
        rng.choice([value for _, value in _places(document) if isinstance(value, dict)])["unheard_of"] = 1
        return document
    path, value = rng.choice([(path, value) for path, value in _places(document) if path])
    table: Any = document
    for key in path[:-1]:
        table = table[key]
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if how == "left out":
        del table[path[-1]]
    elif how == "type":
        table[path[-1]] = rng.choice([True, "text", [1.0], {}, 3, 2.5, [], -1])
    else:
        table[path[-1]] = 1e300 if how == "huge" else -value if is_number else -5.0
    return document


@pytest.mark.long
def test_schema_and_reader_agree_on_mutated_scenarios(scenarios: Any, tmp_path: Path) -> None:
    for file in BUNDLED.iterdir():
        if file.is_file():
            shutil.copy(file, tmp_path)
    documents = [tomllib.loads(file.read_text(encoding="utf-8")) for file in sorted(BUNDLED.glob("*.toml"))]
    rng = random.Random(20)
    refused, wrong = 0, []
    for _ in range(500):
        document = _mutated(rng.choice(documents), rng)
        file = tmp_path / "mutated.toml"
        file.write_text(tomlkit.dumps(document), encoding="utf-8")
        errors = list(scenarios.iter_errors(document))
        try:
            am.load(file)
            problem = ""
        except AmorsimError as error:
            problem = str(error)
        refused += bool(errors)
        if errors and not problem:
            wrong.append(f"only the schema refuses: {errors[0].message}")
        elif problem and not errors and not any(words in problem for words in BEYOND):
            wrong.append(f"only the reader refuses: {problem}")
    assert not wrong, "\n".join(wrong)
    assert refused > 300
