"""After installing, a mistyped word is reported before the kernels are compiled."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from amorsim.cli.studies.study import check_out
from amorsim.core.errors import RunError
from amorsim.plugins.manager import default_registry
from tests.cli.conftest import Command


@pytest.fixture
def just_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where nothing has been compiled yet; to begin compiling fails."""

    def compile_kernels(*_: object, more: bool = False) -> None:
        raise AssertionError("compiled for nothing")

    monkeypatch.setattr("amorsim.kernels.cache_folder.is_cold", lambda: True)
    monkeypatch.setattr("amorsim.runs.warm.compile_kernels", compile_kernels)


@pytest.mark.usefixtures("just_installed")
@pytest.mark.parametrize("command", ["run", "view", "umbmark", "explain-errors"])
def test_a_mistyped_name_is_reported_before_anything_is_compiled(amorsim: Command, command: str) -> None:
    for name, problem in (("dmo", "Did you mean 'demo'?"), ("nowhere.wld", "there is no such file")):
        result = amorsim(command, name)
        assert result.status == 2
        assert problem in result.err


@pytest.mark.usefixtures("just_installed")
@pytest.mark.parametrize("command", ["run", "view", "umbmark", "explain-errors"])
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("robots.rover.wheels=3", "wheels: unknown key"),
        ("robots.rover.controller.use=wandr", "Did you mean 'wander'?"),
        ("robots.rover.drive.track=-1", "track: expected"),
        ("simulation.dt=fast", "dt: expected"),
        ("world.map=none.wld", "there is no such file"),
    ],
)
def test_a_fault_of_the_words_is_reported_before_anything_is_compiled(
    amorsim: Command, study: Path, command: str, change: str, message: str
) -> None:
    result = amorsim(command, study, "--set", change)
    assert (result.status, result.out) == (2, "")
    assert message in result.err


@pytest.mark.usefixtures("just_installed")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--seed", "-1"), "--seed: expected"),
        (("--duration", "0"), "--duration: expected"),
        (("--resolution", "0.1"), "--resolution is for a map alone"),
        (("--out", "."), "the folder holds files already"),
        (("--gif", "run.mp4"), "--gif: expected the name of a file that ends in .gif"),
        (("--gif", "run.gif", "--gif-size", "5"), "--gif-size: expected at least 120 pixels"),
    ],
)
def test_a_wrong_option_is_reported_before_anything_is_compiled(
    amorsim: Command, study: Path, arguments: tuple[str, ...], message: str
) -> None:
    result = amorsim("run", study, *arguments)
    assert result.status == 2
    assert message in result.err


@pytest.mark.usefixtures("just_installed")
@pytest.mark.parametrize("command", [("umbmark",), ("calibrate", "--what", "gyro"), ("explain-errors",)])
def test_a_folder_that_cannot_be_made_is_reported_before_any_experiment(
    amorsim: Command, study: Path, command: tuple[str, ...], tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    name, *options = command
    result = amorsim(name, study, "--out", "file/of/mine", *options)
    assert (result.status, result.out) == (2, "")
    assert "file/of/mine: cannot make this folder" in result.err
    with pytest.raises(AssertionError, match="compiled for nothing"):
        amorsim(name, study, "--out", "new/of/mine", *options)
    assert not (tmp_path / "new").exists()
    with pytest.raises(AssertionError, match="compiled for nothing"):
        amorsim(name, study, *options)
    assert not (tmp_path / "amorsim-runs").exists()
    (tmp_path / "amorsim-runs").touch()
    result = amorsim(name, study, *options)
    assert (result.status, result.out) == (2, "")
    assert "amorsim-runs: is in the way of the folder for runs" in result.err


def test_to_look_whether_a_folder_can_be_made_makes_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another process may be looking at the same time."""

    def mkdir(*_: object, **__: object) -> None:
        raise AssertionError("made a folder")

    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("os.mkdir", mkdir)
    for out in (None, Path("new/of/mine"), tmp_path / "empty"):
        check_out(out)
    monkeypatch.setattr("os.access", lambda *_: False)
    for out, says in ((None, "amorsim-runs"), (Path("new/of/mine"), "new/of/mine"), (tmp_path / "empty", "empty")):
        with pytest.raises(RunError, match=rf"{says}: cannot make this folder or write into it .*no permission"):
            check_out(out)


@pytest.mark.usefixtures("just_installed")
def test_a_fault_of_a_map_alone_is_reported_before_anything_is_compiled(amorsim: Command, study: Path) -> None:
    world = next(study.parent.glob("*.wld"))
    result = amorsim("run", world, "--set", "robots.rover.controller.sped=1")
    assert result.status == 2
    assert "Did you mean 'speed'?" in result.err


@pytest.mark.usefixtures("just_installed")
@pytest.mark.parametrize("name", list(default_registry().names("scenario")))
def test_the_words_of_what_comes_with_amorsim_have_no_faults(amorsim: Command, name: str) -> None:
    with pytest.raises(AssertionError, match="compiled for nothing"):
        amorsim("run", name)


@pytest.mark.long
def test_to_look_at_the_words_compiles_nothing_in_truth(study: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    ended = subprocess.run(
        [sys.executable, "-m", "amorsim", "run", str(study), "--set", "robots.rover.sensors.laser.rang=1"],
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
    )
    assert (ended.returncode, ended.stdout) == (2, "")
    assert "rang: unknown key" in ended.stderr
    assert not list(cache.rglob("*.nb?"))
