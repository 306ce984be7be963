"""What only a process of its own shows: signals, kills, pipes, start-up."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.analysis.run_files import RunFiles
from amorsim.kernels.cache_folder import cache_folder
from tests.studies import make_study

SLOW = "import time\n\n\ndef drive(r, e, c, speed):\n    time.sleep(0.005)\n    return 1.0, -1.0\n"
BARE = """format = 1
[world]
map = "room.wld"
[simulation]
duration = 0.5
[[robots]]
name = "rover"
shape = { circle = 0.2 }
pose = { x = 2.0, y = 2.0 }
[robots.drive]
use = "differential"
wheel_radius_left = 0.05
wheel_radius_right = 0.05
track = 0.3
rate_max_deg = 600.0
[robots.controller]
use = "square"
[robots.sensors.encoder]
use = "encoder"
counts_per_revolution = 1000.0
[robots.estimators.dead_reckoning]
use = "dead_reckoning"
"""
HANGS = """import pathlib


def drive(r, e, c, speed):
    if c.time > 0.25:
        pathlib.Path(__file__).with_name("hangs").touch()
        while True: pass
    return 0.1, 0.0
"""


def begin(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "amorsim", *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def begin_run(folder: Path, wait: float) -> subprocess.Popen[str]:
    """A run that goes on for long, and has done so for `wait` seconds."""
    make_study(folder / "study", SLOW)
    process = begin(folder, "run", "study/scenario.toml", "--duration", "3000", "--out", "run")
    wait_for(process, folder / "run" / "sensors" / "sonar.csv")
    time.sleep(wait)
    return process


def wait_for(process: subprocess.Popen[str], file: Path) -> None:
    """Until a process has made a file."""
    deadline = time.monotonic() + 60.0
    while not file.exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_leaves_whole_files_and_says_so(tmp_path: Path) -> None:
    process = begin_run(tmp_path, 0.5)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (130, "")
    about = json.loads((tmp_path / "run" / "run.json").read_text())
    assert about["status"] == "interrupted"
    steps = about["steps_done"]
    assert f"interrupted after {steps * 0.1:g} s of simulated time; the files are whole up to there" in out
    files = RunFiles(tmp_path / "run")
    for table in ("poses", "velocities", "commands", "sensors/laser", "estimates/dead_reckoning"):
        assert len(files.table(table)["time"]) == steps + 1, table
    assert (tmp_path / "run" / "picture.png").exists()


LONG_PLAN = """import pathlib

import attrs

import amorsim as am
from amorsim.cli import main

plan = am.planners.RrtStar.plan


def begun(self, world, start, goal, *, footprint=None):
    if self.budget == 1_000_000:  # not the short one that compiles the kernels
        plan(attrs.evolve(self, budget=10), world, start, goal, footprint=footprint)  # loads those of this map
        pathlib.Path("begun").touch()
    return plan(self, world, start, goal, footprint=footprint)


am.planners.RrtStar.plan = begun
main()
"""


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_in_a_long_plan_ends_it_at_once(tmp_path: Path) -> None:
    am.save_map(am.Map.from_array(np.zeros((100, 100)), resolution=0.5), tmp_path / "field.yaml")
    (tmp_path / "long.py").write_text(LONG_PLAN)
    asked = ["plan", "field.yaml", "--from", "1,1", "--to", "49,49", "--planner", "rrt_star", "--set", "budget=1000000"]
    command = [sys.executable, "long.py", *asked]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, cwd=tmp_path, text=True, **pipes) as process:
        wait_for(process, tmp_path / "begun")
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        out, err = process.communicate(timeout=60)
    assert time.monotonic() - began < 10.0
    assert (process.returncode, err) == (130, "interrupted\n")
    assert "found" not in out
    assert not (tmp_path / "plan.png").exists()


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_in_a_controller_that_does_not_return_says_where_it_was(tmp_path: Path) -> None:
    make_study(tmp_path / "study", HANGS)
    process = begin(tmp_path, "run", "study/scenario.toml", "--out", "run")
    wait_for(process, tmp_path / "study" / "hangs")
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted\nthis did not return:\n" in err
    assert "while True: pass" in err
    assert "the files up to 0.3 s are in run" in err
    assert json.loads((tmp_path / "run" / "run.json").read_text())["status"] == "interrupted"


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_killed_run_keeps_all_but_its_last_second(tmp_path: Path) -> None:
    process = begin_run(tmp_path, 1.5)
    began = time.monotonic()
    before = {path: path.stat().st_size for path in (tmp_path / "run").rglob("*.csv")}
    while any(path.stat().st_size == size for path, size in before.items() if path.name != "events.csv"):
        assert time.monotonic() - began < 1.0  # every file moves on within a second
        time.sleep(0.01)
    process.kill()
    process.communicate(timeout=60)
    about = json.loads((tmp_path / "run" / "run.json").read_text())
    assert about["status"] == "running"
    files = RunFiles(tmp_path / "run")
    rows = [len(files.table(name)["time"]) for name in ("poses", "commands", "sensors/laser", "sensors/sonar")]
    assert min(rows) > 20
    for path in (tmp_path / "run").rglob("*.csv"):
        assert path.read_bytes().endswith(b"\n"), path


@pytest.mark.long
def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    with begin(tmp_path, "check", "demo", "--resolved") as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        assert process.stderr.read() == ""


@pytest.mark.skipif(sys.platform != "linux", reason="a device of Linux")
@pytest.mark.parametrize("arguments", [("plugins",), ("--help",)])
def test_a_full_disk_is_reported_by_what_prints(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "amorsim", *arguments]
        done = subprocess.run(command, cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (2, "what is printed cannot be written (No space left on device)\n")


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="a shell of POSIX")
def test_a_closed_output_is_no_error(tmp_path: Path) -> None:
    command = f"{sys.executable} -m amorsim check line >&-"
    done = subprocess.run(["sh", "-c", command], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(os.name == "nt", reason="Windows does not remove a folder that is in use")
def test_a_present_folder_that_is_gone_is_reported(tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    code = "import os; os.rmdir(os.getcwd()); from amorsim.cli import main; main()"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(os.path.abspath, filter(None, sys.path)))}
    command = [sys.executable, "-c", code, "run", "demo"]
    done = subprocess.run(command, cwd=tmp_path / "gone", env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("the present folder cannot be used (No such file or directory); go to another one")


INTERRUPT = "import os, signal; os.kill(os.getpid(), signal.SIGINT)"
INTERRUPT_AT_THE_END = f"import atexit; atexit.register(exec, {INTERRUPT!r}, {{}})"


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_while_a_command_is_imported_ends_it_without_a_word(tmp_path: Path) -> None:
    (tmp_path / "typer.py").write_text(INTERRUPT)  # imported in place of the library
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-m", "amorsim", "check", "demo"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_while_the_interpreter_ends_is_silent() -> None:
    code = f"{INTERRUPT_AT_THE_END}; from amorsim.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code, "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "")


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_that_is_ignored_stays_ignored() -> None:
    ignore = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
    code = f"{ignore}; {INTERRUPT_AT_THE_END}; from amorsim.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code, "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_importing_amorsim_brings_in_nothing_that_is_large() -> None:
    code = "import sys, amorsim; print(sorted({name.split('.')[0] for name in sys.modules} & set(sys.argv[1:])))"
    large = ["numpy", "numba", "matplotlib", "rich", "typer", "shapely", "PIL", "scipy", "pluggy", "tomlkit"]
    done = subprocess.run([sys.executable, "-c", code, *large], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.skipif(sys.platform != "linux", reason="drops a capability of Linux")
@pytest.mark.long
def test_it_runs_where_nothing_can_be_written_but_the_run(tmp_path: Path) -> None:
    """Installed read-only, with no home; root is forbidden to write what is marked read-only too."""
    installed = tmp_path / "lib" / "amorsim"
    assert am.__file__ is not None
    shutil.copytree(Path(am.__file__).parent, installed, ignore=shutil.ignore_patterns("__pycache__"))
    for path in (*installed.rglob("*"), installed):
        path.chmod(0o555 if path.is_dir() else 0o444)
    (tmp_path / "work").mkdir()
    (tmp_path / "work" / "room.wld").write_text("width 4000\nheight 4000\n")
    (tmp_path / "work" / "bare.toml").write_text(BARE)
    # Compiled already, in the temporary folder, but for a few, as that would take a minute.
    compiled = cache_folder()
    assert compiled is not None
    kept = tmp_path / "work" / f"amorsim-{os.getuid()}" / compiled.name
    kept.parent.mkdir(mode=0o700)
    shutil.copytree(compiled, kept)
    lacking = list(kept.rglob("number_checks.all_finite*"))
    for path in (kept / "warm", *lacking):
        path.unlink(missing_ok=True)
    forbid = "import ctypes; ctypes.CDLL(None).prctl(24, 1, 0, 0, 0)"  # PR_CAPBSET_DROP, CAP_DAC_OVERRIDE
    command = [sys.executable, "-m", "amorsim", "run", "bare.toml", "--out", "run"]
    code = f"{forbid}\nimport os; os.execv({command[0]!r}, {command!r})"
    unwanted = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")
    environment = {key: value for key, value in os.environ.items() if key not in unwanted}
    environment |= {"HOME": "/proc/nowhere", "PYTHONPATH": str(tmp_path / "lib"), "TMPDIR": str(tmp_path / "work")}
    try:
        for _ in range(2):
            done = subprocess.run(
                [sys.executable, "-c", code], cwd=tmp_path / "work", env=environment, capture_output=True, text=True
            )
            assert done.returncode == 0, done.stderr
            assert "rover: drove" in done.stdout
            (tmp_path / "work" / "run").rename(tmp_path / "work" / "before")
            shutil.rmtree(tmp_path / "work" / "before")
        assert "compiling" not in done.stdout  # the temporary folder kept the kernels
        assert lacking
        assert list(kept.rglob("number_checks.all_finite*"))
        assert not list(installed.rglob("__pycache__"))
    finally:
        for path in (installed, *installed.rglob("*")):
            path.chmod(0o755 if path.is_dir() else 0o644)
