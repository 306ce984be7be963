"""The command line within this process, in a folder of its own."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import attrs
import pytest

from amorsim.cli import main
from tests.studies import make_study


@attrs.frozen
class Result:
    """How a command ended, and what it said."""

    status: int
    out: str
    err: str


Command = Callable[..., Result]


@pytest.fixture
def amorsim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """Runs ``amorsim ARGUMENTS`` in `tmp_path`."""
    monkeypatch.chdir(tmp_path)

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
