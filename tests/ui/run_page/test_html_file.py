"""The file of a run's page: one document that asks for nothing, made by the command."""

from __future__ import annotations

import base64
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

import amorsim as am
from amorsim.core.errors import RunError
from tests import building


@pytest.fixture
def run(tmp_path: Path) -> Path:
    scenario = building.scenario(building.robot(name="rover", sensors=building.all_sensors()))
    am.run(scenario, tmp_path / "run", duration=0.5, progress=False)
    return tmp_path / "run"


def test_all_scripts_that_are_imported_are_in_it(run: Path) -> None:
    text = am.run_page(run).read_text()
    scripts = dict(re.findall(r'"(amorsim/[^"]+)":"data:text/javascript;base64,([^"]+)"', text))
    assert "amorsim/simulator/stage.js" in scripts
    for script in scripts.values():
        imported = re.findall(r'^import[^"]*"([^"]+)"', base64.b64decode(script).decode(), re.MULTILINE)
        assert set(imported) <= set(scripts)
    assert not re.search(r'(src|href)="(?!data:)', text)


def test_the_command_writes_it_and_refuses_in_words(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from amorsim.cli.app import app

    monkeypatch.chdir(run.parent)
    made = CliRunner().invoke(app, ["export", "run", "--to", "html", "--out", "pages"])
    assert (made.exit_code, made.output) == (0, "pages/run.html\n")
    assert (run.parent / "pages" / "run.html").stat().st_size > 100_000


def test_what_cannot_be_shown_is_refused(run: Path, tmp_path: Path) -> None:
    with pytest.raises(RunError, match="no replica 3"):
        am.run_page(run, tmp_path / "page.html", replica=3)
    with pytest.raises(RunError, match=r"run\.json"):
        am.run_page(tmp_path)
    assert not (tmp_path / "page.html").exists()
