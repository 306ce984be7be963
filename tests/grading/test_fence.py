"""The fence: where there is none, nobody is graded without the lecturer's word; with it, all processes end."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import attrs
import pytest

import amorsim as am
from amorsim.controllers.user import RobotClock
from amorsim.grading.fence import HOME, find_fence
from amorsim.grading.handed_in import HandedIn
from amorsim.grading.remote import Remote
from tests.grading.courses import GOOD, graded, make_course, needs_fence
from tests.grading.test_grade import ESTIMATE
from tests.processes import is_running

BWRAP = {
    "missing": (None, "there is no bubblewrap"),
    "refused": (
        "#!/bin/sh\necho 'bwrap: setting up uid map: Permission denied' >&2\nexit 1\n",
        "uid map: Permission denied",
    ),
    "old": (
        "#!/bin/sh\n[ $1 = --version ] && echo bubblewrap 0.4.1 && exit\necho 'bwrap: Unknown option' >&2\nexit 1\n",
        "it must be 0.8 or later",
    ),
}


@pytest.mark.parametrize("name", BWRAP)
def test_without_a_fence_nobody_is_graded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    script, words = BWRAP[name]
    programs = tmp_path / "programs"
    programs.mkdir()
    if script is not None:
        (programs / "bwrap").write_text(script)
        (programs / "bwrap").chmod(0o755)
    monkeypatch.setenv("PATH", str(programs))
    course = make_course(tmp_path / "course")
    with pytest.raises(am.StudyError, match=words) as raised:
        graded(course, fence=True, good=GOOD)
    assert "--no-fence" in str(raised.value)
    assert not (course.parent / "grades").exists()


@needs_fence
def test_nobody_is_graded_where_the_fence_would_show_what_is_private(tmp_path: Path) -> None:
    with pytest.raises(am.StudyError, match="which submissions can read; move it elsewhere"):
        find_fence([Path(am.__file__).parent / "scenarios" / "rubric.toml"])


@needs_fence
def test_within_the_fence_are_python_and_the_submission_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMORSIM_SECRET", "of the lecturer")
    look = """\
import os


def drive(readings, estimate, clock):
    folders = sorted(os.listdir("/"))
    raise RuntimeError(repr((os.getcwd(), folders, sorted(os.environ), os.getuid(), len(os.listdir("/proc/self/fd")))))
"""
    submission = HandedIn("look.py", {"look.py": look.encode()})
    fence = find_fence([tmp_path])
    with Remote(submission, "drive", "controller", time_limit=5.0, memory_limit=4 * 10**9, fence=fence) as remote:
        with pytest.raises(am.ControllerError) as raised:
            remote({}, ESTIMATE, RobotClock(0, 0.0, 0.1))
        found = eval(str(raised.value).partition(": ")[2].rpartition(" (")[0])
    home, folders, settings, user, opened = found
    tops = {path.parts[1] for path in fence.visible} | {"bin", "lib", "lib32", "lib64", "libx32", "sbin"}
    assert home == HOME
    assert set(folders) <= tops | {"dev", "etc", "proc", "submission", "tmp"}
    assert "AMORSIM_SECRET" not in settings
    assert len(settings) < 12
    assert user == 1000
    assert opened == 6  # input, output and errors lead nowhere; what is asked, what is answered, and this folder


@needs_fence
def test_python_may_lie_among_temporary_files() -> None:
    found = find_fence([])
    for folder in ("/tmp", "/dev/shm"):
        own = Path(tempfile.mkdtemp(dir=folder))
        (own / "python").touch()
        fence = attrs.evolve(found, visible=(*found.visible, own))
        look = ["/bin/sh", "-c", f"cat {own}/python && touch {folder}/new && ! touch {own}/new"]
        assert subprocess.run(fence.command(look), check=False, stderr=subprocess.DEVNULL).returncode == 0
        shutil.rmtree(own)


GRADER = """\
import sys
from amorsim.controllers.user import RobotClock
from amorsim.grading.fence import find_fence
from amorsim.grading.handed_in import HandedIn
from amorsim.grading.remote import Remote

slow = HandedIn("slow.py", {"slow.py": b"def drive(readings, estimate, clock):\\n    while True:\\n        pass\\n"})
fence = find_fence([]) if sys.argv[1] == "fenced" else None
with Remote(slow, "drive", "controller", time_limit=60.0, memory_limit=4 * 10**9, fence=fence) as remote:
    remote._say({"readings": {}, "estimate": [[0.0] * 3, [[0.0] * 3] * 3], "clock": [0, 0.0, 0.1]}, "now")
    print(remote._process._popen.pid, flush=True)
    sys.stdin.read()
"""


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="looks for a process in /proc")
@pytest.mark.parametrize(
    "kind", [pytest.param("fenced", marks=needs_fence), pytest.param("free", marks=pytest.mark.long)]
)
def test_a_submission_ends_with_a_grader_that_is_killed(tmp_path: Path, kind: str) -> None:
    place = os.environ | {"TMPDIR": str(tmp_path)}  # for what a killed grader leaves
    command = [sys.executable, "-c", GRADER, kind]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=place) as grader:
        assert grader.stdout is not None
        submission = int(grader.stdout.readline())
        family = [submission, *_started_by(submission)]
        assert len(family) == (3 if kind == "fenced" else 1)
        assert all(map(is_running, family))
        grader.kill()
    deadline = time.monotonic() + 60.0
    while any(map(is_running, family)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(is_running, family))
    assert kind == "free" or not list(tmp_path.iterdir())


def _started_by(pid: int) -> list[int]:
    own = [int(each) for each in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    return [*own, *(each for child in own for each in _started_by(child))]
