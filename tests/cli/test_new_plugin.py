"""``amorsim new DIR --plugin KIND``: a package that passes its own tests, and ``amorsim plugins check``."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from amorsim.cli.plugin_package import KINDS
from tests.cli.conftest import Command
from tests.installed import write_info


def install(folder: Path, site: Path) -> dict[str, str]:
    """Install a package as far as Python can see it; the environment in which it is."""
    import os

    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    write_info(site, project["name"], project["version"], project["entry-points"]["amorsim"])
    paths = [str(site), str(folder / "src"), str(Path(__file__).parents[2])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def passed(folder: Path, environment: dict[str, str]) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error", "tests"],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.long
@pytest.mark.parametrize(
    "kinds", [*((kind,) for kind in KINDS), KINDS], ids=lambda kinds: "all" if len(kinds) > 1 else kinds[0]
)
def test_a_package_passes_its_own_tests(amorsim: Command, tmp_path: Path, kinds: tuple[str, ...]) -> None:
    options = [word for kind in kinds for word in ("--plugin", kind)]
    result = amorsim("new", "my-parts", *options)
    assert result.status == 0, result.err
    environment = install(tmp_path / "my-parts", tmp_path / "site")
    assert f"{2 * len(kinds) + 1} passed" in passed(tmp_path / "my-parts", environment)


def test_several_kinds_are_one_package_with_types(amorsim: Command, tmp_path: Path) -> None:
    assert amorsim("new", "my.parts", "--plugin", "sensor", "--plugin", "noise").status == 0
    there = sorted(str(path.relative_to(tmp_path / "my.parts")) for path in (tmp_path / "my.parts").rglob("*.*"))
    assert there == [
        *("README.md", "pyproject.toml", "room.wld", "src/my_parts/__init__.py", "src/my_parts/noise.py"),
        *(
            "src/my_parts/plugin.py",
            "src/my_parts/py.typed",
            "src/my_parts/sensor.py",
            "tests/test_plugin.py",
            "try.toml",
        ),
    ]


@pytest.mark.long
def test_all_templates_are_typed_as_strictly_as_amorsim(amorsim: Command, tmp_path: Path) -> None:
    assert amorsim("new", "parts", *(word for kind in KINDS for word in ("--plugin", kind))).status == 0
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--config-file", "", "--cache-dir", str(tmp_path), "src/parts"],
        cwd=tmp_path / "parts",
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("parts", "--plugin", "sensr"), "there is no template of this kind. Did you mean 'sensor'?"),
        (
            ("1st", "--plugin", "sensor"),
            "expected a folder whose name can be a package's, such as my-sensors, got '1st'",
        ),
        (("amorsim", "--plugin", "sensor"), "there is a package 'amorsim' already"),
        (("my parts", "--plugin", "sensor"), "expected a folder whose name can be a package's"),
        (("-", "--plugin", "sensor"), "expected a folder whose name can be a package's"),
        (("parts-", "--plugin", "sensor"), "expected a folder whose name can be a package's"),
        (("random", "--plugin", "sensor"), "there is a package 'random' already"),
        (("numpy", "--plugin", "sensor"), "there is a package 'numpy' already"),
        (("class", "--plugin", "sensor"), "expected a folder whose name can be a package's"),
        (("parts", "--plugin", "sensor", "--from", "demo"), "--plugin and --from do not go together"),
    ],
)
def test_mistakes_are_named_and_nothing_is_made(
    amorsim: Command, tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    result = amorsim("new", *arguments)
    assert (result.status, result.out) == (2, "")
    assert says in result.err
    assert not list(tmp_path.iterdir())


def test_what_it_is_for_is_written_in_words(amorsim: Command, tmp_path: Path) -> None:
    assert amorsim("new", "parts", "--plugin", "estimator", "--plugin", "map_loader").status == 0
    project = tomllib.loads((tmp_path / "parts" / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["description"] == "A plugin for amorsim: estimator, map loader."


def test_nothing_is_replaced(amorsim: Command, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "README.md").write_text("mine")
    result = amorsim("new", "parts", "--plugin", "sensor")
    assert result.status == 2
    assert "README.md would be replaced" in result.err
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["README.md"]


def test_a_component_is_checked_by_its_name(amorsim: Command, tmp_path: Path) -> None:
    assert amorsim("plugins", "check", "noise/scale").out == "noise scale keeps its contract\n"
    (tmp_path / "a.maz").write_text("._._.\n|   |\n._._.\n")
    assert amorsim("plugins", "check", "maz", "--path", "a.maz").out == "map loader maz keeps its contract\n"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("scal",), "nothing is registered as 'scal'. Did you mean 'scale'?"),
        (("maz",), "a loader is checked with a file that it reads: --path FILE"),
        (("demo",), "a scenario is a file; amorsim check looks for its faults"),
    ],
)
def test_what_cannot_be_checked_is_named(amorsim: Command, arguments: tuple[str, ...], says: str) -> None:
    result = amorsim("plugins", "check", *arguments)
    assert (result.status, result.out) == (2, "")
    assert says in result.err


def test_a_contract_that_is_broken_is_reported_in_words(amorsim: Command, monkeypatch: Any) -> None:
    from amorsim import noise

    monkeypatch.setattr(noise.Scale, "corrupt", lambda self, values, *_: values[:, :1])
    monkeypatch.setattr(noise.Scale, "steps", lambda self: None)
    result = amorsim("plugins", "check", "noise/scale")
    assert result.status == 2
    assert "Traceback" not in result.err
    assert "Scale fails the check" in result.err
