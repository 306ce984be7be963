"""amorsim replay: what it says of a folder that it cannot show."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Command

pytest.importorskip("starlette", reason="the extra 'ui' is not installed")


@pytest.mark.parametrize(
    ("files", "problem"),
    [
        ({}, "expected the folder of a run, with a run.json in it"),
        ({"run.json": "{"}, "run.json: cannot be read"),
        (
            {"run.json": json.dumps({"format": 9, "amorsim": "7.1"})},
            "is in format 9, of another version of amorsim (7.1)",
        ),
    ],
)
def test_a_folder_of_no_run_is_refused(amorsim: Command, tmp_path: Path, files: dict[str, str], problem: str) -> None:
    (tmp_path / "it").mkdir()
    for name, text in files.items():
        (tmp_path / "it" / name).write_text(text)
    result = amorsim("replay", "it", "--no-open")
    assert result.status == 2
    assert problem in result.err
    assert result.out == ""


def test_a_port_that_cannot_be_is_refused(amorsim: Command) -> None:
    result = amorsim("replay", "it", "--port", "70000")
    assert result.status == 2
    assert "--port: expected a whole number from 0 to 65535" in result.err
