"""What a user's controller may do to the process of a run, and still its files are whole."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import amorsim as am
from amorsim.analysis.run_files import RunFiles
from tests.studies import make_study

posix = pytest.mark.skipif(os.name == "nt", reason="signals and forks of POSIX")


def study(folder: Path, body: str, *, top: str = "") -> am.Scenario:
    """A scenario whose controller does what `body` says, at 0.5 s."""
    lines = "\n".join(f"        {line}" for line in body.splitlines())
    code = f"import os, time\n{top}\n\ndef drive(r, e, c, speed):\n    if c.tick == 5:\n{lines}\n    return 1.0, 1.0\n"
    return am.load(make_study(folder / "study", code))


def about(folder: Path) -> dict[str, object]:
    found: dict[str, object] = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    return found


def check_whole(folder: Path, status: str, steps: int) -> None:
    assert (about(folder)["status"], about(folder)["steps_done"]) == (status, steps)
    files = RunFiles(folder)
    for table in ("poses", "commands", "sensors/laser"):
        assert len(files.table(table)["time"]) == steps + 1, table


@pytest.mark.parametrize(
    ("body", "problem"),
    [
        ("return [1.0, [2.0, 3.0]]", "returned [1.0, [2.0, 3.0]]: [2.0, 3.0] is not a number"),
        ("return [[1.0], [2.0, 3.0]]", "[1.0] is not a number"),
        ("return [10 ** 400, 0.0]", "is too large"),
        ("return [10 ** 5000, 0.0]", "a int (which cannot be shown: ValueError) is too large"),
        ("return Odd()", "returned a Odd (which cannot be shown: RuntimeError): a Odd is not a command"),
        ("return {Odd(): 1.0}", "there is no channel a Odd (which cannot be shown: RuntimeError)"),
        ("return list(range(10000))", "15, 16"),
        ("raise Odder()", "raised Odder (its text cannot be shown: RuntimeError)"),
        ("os.remove('no such file')", "raised FileNotFoundError"),
    ],
)
def test_what_a_controller_returns_or_raises_ends_the_run_with_a_message(
    tmp_path: Path, body: str, problem: str
) -> None:
    top = "class Odd:\n    def __repr__(self):\n        raise RuntimeError\n"
    top += "class Odder(Exception):\n    def __str__(self):\n        raise RuntimeError\n"
    with pytest.raises(am.ControllerError) as caught:
        am.run(study(tmp_path, body, top=top), tmp_path / "run")
    assert problem in str(caught.value)
    assert "of robot 'rover'" in str(caught.value)
    assert len(str(caught.value)) < 800
    check_whole(tmp_path / "run", "broken off", 5)


def test_a_controller_may_change_the_working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever was named by a relative path stays where it was."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    scenario = study(tmp_path, "os.chdir('elsewhere')")
    with pytest.warns(UserWarning, match=r"a controller or plugin changed the working folder to .*elsewhere; it is"):
        summary = am.run(scenario, "run", duration=1.0)
    assert Path.cwd() == tmp_path
    check_whole(tmp_path / "run", "finished", 10)
    assert (tmp_path / summary.folder / "picture.png").exists()
    assert not any((tmp_path / "elsewhere").iterdir())


def test_a_controllers_file_may_change_it_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    with pytest.warns(UserWarning, match=r"controller.py changed the working folder to .*elsewhere"):
        am.Simulation(study(tmp_path, "pass", top="os.chdir('elsewhere')"))
    assert Path.cwd() == tmp_path


@pytest.mark.long
@posix
@pytest.mark.parametrize("ending", ["pass", pytest.param("raise SystemExit", marks=pytest.mark.long)])
def test_a_copy_that_a_controller_forks_writes_nothing(tmp_path: Path, ending: str) -> None:
    """The run goes on in the first process, and has each step once."""
    make_study(
        tmp_path / "study",
        "import os\n\n\ndef drive(r, e, c, speed):\n"
        f"    if c.tick == 5 and os.fork() == 0:\n        {ending}\n    return 1.0, 1.0\n",
    )
    command = [sys.executable, "-m", "amorsim", "run", "study/scenario.toml", "--duration", "2", "--out", "run"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("forked the process of this run; the copy ends here") == 1
    assert done.stdout.count("results: run") == 1
    check_whole(tmp_path / "run", "finished", 20)
    times = RunFiles(tmp_path / "run").table("poses")["time"]
    assert list(times) == sorted(set(times))


@posix
@pytest.mark.parametrize("hang", ["while True: pass", "time.sleep(600)"])
def test_the_first_ctrl_c_is_answered_where_a_controller_does_not_return(tmp_path: Path, hang: str) -> None:
    scenario = study(tmp_path, f"open({str(tmp_path / 'hangs')!r}, 'w').close()\n{hang}")

    def press() -> None:
        while not (tmp_path / "hangs").exists():
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=press, daemon=True).start()
    with pytest.raises(KeyboardInterrupt) as caught:
        am.run(scenario, tmp_path / "run", progress=lambda _: None)
    said = "\n".join(caught.value.__notes__)
    assert "this did not return:" in said
    assert hang in said
    assert "controller.py" in said
    assert "the files up to 0.5 s are in" in said
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    check_whole(tmp_path / "run", "interrupted", 5)


@posix
def test_a_slow_controller_that_returns_is_not_broken_off(tmp_path: Path) -> None:
    """Nor is code of amorsim, however long a step lasts: the run ends with the step."""
    scenario = study(tmp_path, "time.sleep(0.3)")
    began: list[float] = []

    def press(share: float) -> None:
        if not began and share > 0.24:
            began.append(time.monotonic())
            signal.raise_signal(signal.SIGINT)

    summary = am.run(scenario, tmp_path / "run", duration=2.0, progress=press)
    assert not summary.is_complete
    check_whole(tmp_path / "run", "interrupted", 5)
