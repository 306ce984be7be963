"""The command line within this process, in a folder of its own."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from pathlib import Path

import attrs
import pytest
import typer.main

from amorsim.cli import main
from tests.studies import make_study


@attrs.frozen
class Result:
    """How a command ended, and what it said."""

    status: int
    out: str
    err: str


Command = Callable[..., Result]

# A process has one command line; made again for each command, it would take longer than many of them.
_get_command = functools.cache(typer.main.get_command)


@pytest.fixture
def amorsim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """Runs ``amorsim ARGUMENTS`` in `tmp_path`."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(typer.main, "get_command", _get_command)

    def command(*arguments: object) -> Result:
        monkeypatch.setattr(sys, "argv", ["amorsim", *map(str, arguments)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr()
        status = ended.value.code
        return Result(0 if status is None else int(status), said.out, said.err)

    return command


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """A scenario with map and controller, in ``study``."""
    return make_study(tmp_path / "study")
