"""The README does what it says."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main

import amorsim as am
from amorsim.cli.app import app
from tests.first_hour.conftest import ROOT, Page, blocks_of, check_output

README = ROOT / "README.md"


def _command_after(text: str, before: str) -> str:
    """What stands after ``&&`` in the README's line that begins with `before`."""
    lines = [line for line in text.splitlines() if line.startswith(before)]
    assert len(lines) == 1, f"the README has {len(lines)} lines that begin with {before!r}"
    return lines[0].partition("&&")[2].strip()


@pytest.mark.long
def test_the_run_command_as_written(tmp_path: Path) -> None:
    command = _command_after(README.read_text(encoding="utf-8"), "python -m pip install -e . ")
    assert command == "amorsim run demo"
    done = subprocess.run(
        [sys.executable, "-m", *command.split(), "--duration", "5"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
        capture_output=True,
        encoding="utf-8",
    )
    lines = [line for line in done.stdout.splitlines() if "%" not in line and "compiling" not in line]
    assert len(lines) == 2  # what happened, and where it lies
    assert re.search(r"drove \d+\.\d+ m .* collision.*estimate is off by \d+\.\d+ m", lines[0])
    folder = re.fullmatch(r"results: (.+), picture: (.+)", lines[1])
    assert folder
    assert (tmp_path / folder[1] / "poses.csv").is_file()
    assert Path(folder[2]).is_file()


def test_the_test_command_as_written() -> None:
    command = _command_after(README.read_text(encoding="utf-8"), 'python -m pip install -e ".[dev]" ')
    assert command == "python -m pytest"
    # These tests themselves run by it; that it also works with what was installed is `.ci/run`'s.
    assert 'python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[dev]"' in (
        ROOT / ".ci" / "run"
    ).read_text(encoding="utf-8")


def test_the_script_as_written(page: Page) -> None:
    script = [block for block in blocks_of(README) if block.language == "python"]
    assert len(script) == 1
    assert len([line for line in script[0].text.splitlines() if line.strip()]) <= 15
    for block in blocks_of(README):
        page.run(block)
    assert page.ran == 2  # the script, and what it prints


def test_the_demo_has_the_errors_that_the_picture_is_explained_with() -> None:
    text = README.read_text(encoding="utf-8")
    errors = am.load("demo").robots[0].errors
    assert set(errors) == {"drive.wheel_radius_left", "drive.track"}
    for deviation in errors.values():
        assert isinstance(deviation.scale, float)
        assert deviation.scale > 1.0
        assert f"{100.0 * (deviation.scale - 1.0):.2g} %" in text


def test_each_command_in_the_table_is_one_and_the_reference_has_all() -> None:
    names = set(typer.main.get_command(app).commands)  # type: ignore[attr-defined]
    named = re.findall(r"^\| `amorsim (\S+?)[ `]", README.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(named) >= 10
    assert set(named) <= names
    reference = (ROOT / "docs" / "reference" / "command-line.md").read_text(encoding="utf-8")
    assert names <= {name for heading in re.findall(r"^## (.+)$", reference, re.MULTILINE) for name in heading.split()}


@pytest.mark.parametrize(
    ("written", "printed"),
    [
        ("believes 0.010 m", "believes 0.006 m"),
        ("0.00 m", "0.02 m"),
        ("1e-3", "1.1e-3"),
        ("1 robot", "2 robots"),
        ("0", "1"),
    ],
)
def test_small_figures_that_differ_are_noticed(written: str, printed: str) -> None:
    check_output(written, written)
    with pytest.raises(AssertionError):
        check_output(written, printed)


@pytest.mark.parametrize("change", ["1 robot", "off by 0.90 m", "off by ... metres"])
def test_outputs_that_differ_are_noticed(change: str) -> None:
    check_output("off by 0.50 m", "off by 0.501 m")
    check_output("off by ... m", "off by 0.501 m")
    with pytest.raises(AssertionError):
        check_output(change, "off by 0.50 m")
