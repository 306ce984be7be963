"""Users' programs are tried out in a process that is ended after a time limit, and each failure is reported."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

import amorsim as am
from tests.processes import is_running
from tests.studies import make_study

SOUND = "def drive(readings, estimate, clock, speed):\n    return None\n"
posix = pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")


def messages(folder: Path, code: str, time_limit: float = 20.0) -> list[str]:
    """What is wrong with a scenario whose controller is in a file of this code."""
    path = make_study(folder / "study", code)
    before = set(sys.modules)
    faults = am.check_code(am.load(path), time_limit=time_limit)
    assert not [name for name in set(sys.modules) - before if name.startswith("amorsim_controller")]
    assert all((fault.file, fault.line) == (str(path), 19) for fault in faults)
    return [fault.message for fault in faults]


@pytest.mark.parametrize(
    "code",
    [
        SOUND,
        "import amorsim as am\n\n\nclass drive:\n    def __init__(self, speed):\n        print('made', input)\n\n"
        "    def command(self, readings, estimate, clock):\n        pass\n",
    ],
)
def test_a_sound_program_has_no_faults(tmp_path: Path, code: str) -> None:
    assert messages(tmp_path, code) == []


@pytest.mark.parametrize(
    ("code", "says"),
    [
        ("x = 1\n1 / 0\n" + SOUND, "controller.py, line 2: ZeroDivisionError"),
        ("import sys\nsys.exit(3)\n" + SOUND, "controller.py, line 2: SystemExit: 3"),
        ("raise KeyboardInterrupt\n" + SOUND, "controller.py: KeyboardInterrupt"),
        ("import os\nos._exit(3)\n" + SOUND, "loading the file ended its process with the exit status 3"),
        ("while True:\n    print('x' * 1000)\n" + SOUND, "loading the file printed more than 1 MB"),
        ("input()\n" + SOUND, "controller.py, line 1: EOFError"),
        ("drive = [1]\n", "'drive' in "),
        ("drive = lambda r, e, c: None\n", "cannot be called as drive(readings, estimate, clock, **options)"),
        ("class drive:\n    def __init__(self, speed):\n        1 / 0\n", "raised ZeroDivisionError"),
        (
            "class drive:\n    def __init__(self, speed):\n        pass\n",
            "has no method command(self, readings, estimate, clock)",
        ),
        pytest.param(
            "import ctypes\n\nctypes.string_at(0)\n" + SOUND,
            "controller.py, line 3: loading the file broke its process down, with the signal SIGSEGV",
            marks=posix,
        ),
        pytest.param(
            "import os, signal\nos.kill(os.getpid(), signal.SIGKILL)\n" + SOUND, "with the signal SIGKILL", marks=posix
        ),
    ],
)
def test_what_a_program_does_wrong_is_reported(tmp_path: Path, code: str, says: str) -> None:
    (message,) = messages(tmp_path, code)
    assert says in message


@pytest.mark.parametrize(
    ("code", "line", "doing"),
    [
        ("import time\n\ntime.sleep(600)\n" + SOUND, 3, "loading the file did not finish within 0.5 s"),
        (
            "class drive:\n    def __init__(self, speed):\n        while True: pass\n",
            3,
            "making an object of drive with the options {'speed': 0.3} did not finish within 0.5 s",
        ),
        (  # where Python itself does nothing any more
            "import ctypes\nctypes.PyDLL(None).sleep(600)\n" + SOUND,
            2,
            "loading the file did not finish within 0.5 s",
        ),
    ],
)
@posix
def test_what_hangs_is_ended_and_says_where(tmp_path: Path, code: str, line: int, doing: str) -> None:
    began = time.monotonic()
    (message,) = messages(tmp_path, code, time_limit=0.5)
    assert f"controller.py, line {line}: {doing}" in message
    assert time.monotonic() - began < 100.0  # and not 600


@posix
@pytest.mark.parametrize("then", ["time.sleep(600)", "os._exit(0)", "pass"])
def test_the_processes_that_it_has_started_end_with_it(tmp_path: Path, then: str) -> None:
    pid = tmp_path / "pid"
    code = (
        f"import os, subprocess, time\nother = subprocess.Popen(['sleep', '600'])\nopen({str(pid)!r}, 'w').write(str("
        f"other.pid))\n{then}\n"
    )
    assert len(messages(tmp_path, code + SOUND, time_limit=1.0)) == (then != "pass")
    number = int(pid.read_text())
    for _ in range(100):  # until the system has taken it away
        if not is_running(number):
            return
        time.sleep(0.1)
    raise AssertionError("it runs still")


@pytest.mark.long
@posix
def test_a_copy_that_it_forks_says_nothing(tmp_path: Path) -> None:
    assert messages(tmp_path, "import os\nos.fork()\nos.fork()\n" + SOUND) == []


@pytest.mark.long
def test_others_are_tried_though_one_breaks_off(tmp_path: Path) -> None:
    """Each at its own place, a motion too; a file that cannot be loaded is not tried again."""
    path = make_study(tmp_path / "study", "import os\nos._exit(3)\n" + SOUND)
    (path.parent / "other.py").write_text("def go(obstacle):\n    pass\n\n\n1 / 0\n")
    text = path.read_text()
    robot = text[text.index("[[robots]]") :]
    for number, use in enumerate(("controller.py:drive", "sound.py:drive"), start=1):
        text += (
            robot.replace("rover", f"rover{number}").replace("controller.py:drive", use).replace("x = 1.0", "x = 6.0")
        )
    (path.parent / "sound.py").write_text(SOUND)
    path.write_text(
        text + "\n[[obstacles]]\nname = 'box'\nshape = { circle = 0.1 }\npose = { x = 6.0, y = 4.0 }\n"
        "motion = { use = 'other.py:go' }\n"
    )
    scenario = attempt(path)
    found = {fault.named: fault.message for fault in am.check_code(scenario)}
    assert set(found) == {
        "robots.rover.controller.use",
        "robots.rover1.controller.use",
        "obstacles.box.motion.use",
    }
    assert found["robots.rover.controller.use"] == found["robots.rover1.controller.use"]
    assert "other.py, line 5: ZeroDivisionError" in found["obstacles.box.motion.use"]


def attempt(path: Path) -> am.Scenario:
    """A scenario whose robots may stand in one another."""
    document = am.open_document(path)
    for number, (x, y) in enumerate(((1.0, 1.0), (6.0, 1.0), (6.0, 3.0))):
        document.set(f"robots.{number}.pose", {"x": x, "y": y})
    document.save()
    return am.load(path)


@pytest.mark.parametrize("limit", [0, -1.0, float("nan"), "10", True])
def test_a_time_limit_is_a_number_of_seconds(limit: object) -> None:
    with pytest.raises(am.ParameterError, match="time_limit: expected a number of seconds > 0"):
        am.check_code(am.load("demo"), time_limit=limit)  # type: ignore[arg-type]


def test_what_a_script_gives_and_what_is_registered_is_not_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("subprocess.Popen", lambda *_, **__: pytest.fail("a process for nothing"))
    assert am.check_code(am.load("demo")) == ()
