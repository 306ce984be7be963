"""Attempts to learn the truth, to read what is not one's own, and to harm the grades of others: a submission for each.

An attempt drives well, and earns points, only if it gets what it tried. So each must have none, for the reason that is
expected. The first and the last submission of each grading are honest, and must earn the same as each other.
"""

from __future__ import annotations

import contextlib
import csv
import os
import re
import resource
import socket
import string
import threading
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs
import pytest

from amorsim.grading.grade import grade
from amorsim.grading.results import Grade
from tests.grading.courses import GOOD, RUBRIC, make_course, needs_fence

pytestmark = needs_fence

SUBMISSION = string.Template("""\
import ctypes
import os
import pathlib
import resource
import signal
import socket
import subprocess
import sys
import time

import amorsim as am

libc = ctypes.CDLL(None, use_errno=True)
course, grader = pathlib.Path("$course"), $grader


def call(name, *arguments):
    if getattr(libc, name)(*arguments) < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def answer(data):
    for each in range(3, 20):
        try:
            os.write(each, data)
        except OSError:
            continue
    time.sleep(60.0)


def reach():
$body


def drive(readings, estimate, clock):
    if clock.tick == 0:
        reach()
    return am.Twist(0.4 if estimate.x < 2.2 else 0.0, 0.0)
""")
NO_FILE = "FileNotFoundError"
READ_ONLY = "Read-only file system|PermissionError"
NO_PROCESS = "ProcessLookupError|No such process"


@attrs.frozen
class Attempt:
    """What is tried, why it fails, and whether it is known to succeed without a fence, where it harms nobody."""

    body: str
    reason: str
    succeeds: bool = False


def reads(what: str, reason: str = NO_FILE) -> Attempt:
    return Attempt(f"assert {what}", reason, True)


READING = {
    "the rubric": reads("(course / 'rubric.toml').read_text()"),
    "the seeds": reads("(course / 'grades' / 'seeds.toml').read_text()"),
    "a held-out world": reads("(course / 'secret' / 'held-out.yaml').read_text()"),
    "the picture beside it": reads("(course / 'secret' / 'held-out.pgm').read_bytes()"),
    "another submission": reads("(course / 'ann.py').read_text()"),
    "the code of another submission": Attempt("sys.path.insert(0, str(course))\nimport ann", "No module", True),
    "a letter of the lecturer": reads("(course.parent / 'letter.txt').read_text()"),
    "names in the lecturer's folder": reads("os.listdir(course.parent)"),
    "the users of the system": reads("pathlib.Path('/etc/passwd').read_text()"),
    "the environment": reads("os.environ['AMORSIM_SECRET']", "KeyError"),
    "the grader's environment": reads("pathlib.Path(f'/proc/{grader}/environ').read_bytes()"),
    "the parent's environment": Attempt(
        "assert b'SECRET' in pathlib.Path('/proc/1/environ').read_bytes()", "AssertionError"
    ),
    "the grader's command line": reads("pathlib.Path(f'/proc/{grader}/cmdline').read_bytes()"),
    "the grader's folder": reads("os.listdir(f'/proc/{grader}/cwd')"),
    "the grader's open files": reads("os.listdir(f'/proc/{grader}/fd')"),
    "the grader's memory": reads("open(f'/proc/{grader}/mem', 'rb')"),
    "the parent's root": Attempt("assert pathlib.Path(f'/proc/1/root/{course}/rubric.toml').read_text()", NO_FILE),
    "any rubric anywhere": Attempt(
        "for folder, inner, names in os.walk('/'):\n"
        "    inner[:] = [] if folder in ('/proc', '/usr', sys.prefix, sys.base_prefix) else inner\n"
        "    if {'rubric.toml', 'seeds.toml', 'grades.csv'} & set(names):\n"
        "        return\n"
        "raise LookupError",
        "LookupError",
    ),
    "a disk": Attempt("os.mknod('disk', 0o60666, os.makedev(254, 0))", "PermissionError"),
}
CHANGING = {
    "another submission": Attempt("(course / 'ann.py').write_text('')", NO_FILE, True),
    "the table": Attempt("(course / 'grades' / 'grades.csv').open('a')", NO_FILE, True),
    "who may read a file": Attempt("(course / 'rubric.toml').chmod(0o644)", NO_FILE, True),
    "the lecturer's folder": Attempt("(course / 'new').mkdir()", NO_FILE, True),
    "amorsim": Attempt("open(am.__file__, 'a')", READ_ONLY),
    "Python": Attempt("open(os.__file__, 'a')", READ_ONLY),
    "compiled kernels": Attempt(
        "kernels = pathlib.Path(os.environ['NUMBA_CACHE_DIR'])\n"
        "link = next(each for each in kernels.rglob('*') if each.is_symlink())\n"
        "link.open('r+b')",
        READ_ONLY,
    ),
    "the system's settings": Attempt("open('/proc/sys/kernel/core_pattern', 'r+')", READ_ONLY),
    "which memory is freed first": Attempt("open('/proc/self/oom_score_adj', 'w').write('-1000')", READ_ONLY),
    "the root": Attempt("pathlib.Path('/new').mkdir()", READ_ONLY),
    "what is mounted": Attempt("call('mount', None, am.__file__.encode(), None, 32 | 4096, None)", "not permitted"),
    "what covers the root": Attempt("call('umount2', b'/', 2)", "not permitted"),
    "its user": Attempt(
        "if os.fork() == 0:\n    os._exit(libc.unshare(0x10000000) and ctypes.get_errno())\nassert os.wait()[1] == 0",
        "AssertionError",
    ),
    "its root": Attempt("os.chroot('/proc/1/root')", "PermissionError"),
    "leaving a note": Attempt(
        "for each in ('/tmp/note', '/dev/shm/note', 'note'):\n"
        "    pathlib.Path(each).write_text('')\n"
        "raise RuntimeError",
        "Runt",
    ),
    "what was left": Attempt(
        "assert any(pathlib.Path(each).exists() for each in ('/tmp/note', '/dev/shm/note', 'note'))", "AssertionError"
    ),
}
STRAY = "[sys.executable, '-c', 'import time; time.sleep(600.0)  # amorsim-stray']"
PROCESSES = {
    "a signal": Attempt("os.kill(grader, signal.SIGURG)", NO_PROCESS, True),
    "a signal to all": Attempt("os.kill(-1, signal.SIGURG)", NO_PROCESS),
    **{
        f"the grader's limit {kind}": Attempt(
            f"kind = resource.RLIMIT_{kind}\nresource.prlimit(grader, kind, resource.prlimit(grader, kind))",
            NO_PROCESS,
            True,
        )
        for kind in ("CPU", "NOFILE", "AS", "FSIZE")
    },
    "anybody's limit": Attempt(
        "own = set(map(int, os.listdir('/proc/self/task')))\n"
        "for each in range(2, 1 << 16):\n"
        "    if each not in own:\n"
        "        try:\n"
        "            return resource.prlimit(each, resource.RLIMIT_CPU)\n"
        "        except ProcessLookupError:\n"
        "            continue\n"
        "raise LookupError",
        "LookupError",
    ),
    "the grader's priority": Attempt("os.setpriority(os.PRIO_PROCESS, grader, 0)", NO_PROCESS, True),
    "the user's priority": Attempt("os.setpriority(os.PRIO_USER, 0, 19)\nraise RuntimeError", "RuntimeError"),
    "the grader's cores": Attempt("os.sched_setaffinity(grader, os.sched_getaffinity(grader))", NO_PROCESS, True),
    "a handle": Attempt("os.pidfd_open(grader)", NO_PROCESS, True),
    "tracing": Attempt("call('ptrace', 0x4206, grader, None, None)", NO_PROCESS),
    "its own limits": Attempt("resource.setrlimit(resource.RLIMIT_AS, (-1, -1))", "ValueError|PermissionError"),
    "a stray": Attempt(f"subprocess.Popen({STRAY}, start_new_session=True)\nraise RuntimeError", "RuntimeError"),
    "a stray that none is told of": Attempt(
        f"call('prctl', 1, 0, 0, 0, 0)\n[signal.signal(each, signal.SIG_IGN) for each in (1, 2, 15)]\n"
        f"subprocess.Popen({STRAY}, start_new_session=True)\n"
        "os.fork() or os.setsid() or time.sleep(600.0)\nraise RuntimeError",
        "RuntimeError",
    ),
    "an end of its first process": Attempt(
        "os.kill(1, signal.SIGKILL)\nos.kill(1, signal.SIGSTOP)\nraise RuntimeError", "Runt"
    ),
    "leaving": Attempt("os._exit(0)", r"its process ended \("),
    "a crash": Attempt("ctypes.string_at(0)", "its process ended by signal 11"),
}
TAKING = {
    "memory": Attempt("bytearray(10**11)", "MemoryError"),
    "open files": Attempt("kept = [open('/dev/null') for _ in range(10_000)]", "Too many open files"),
    "time": Attempt("while True:\n    pass", "took longer than 2 s in all"),
    "time at last": Attempt("time.sleep(60.0)", "took longer than 2 s in all"),
    "room for answers": Attempt("answer(b'x' * 10_000_000)", "answered with more than a command"),
    "more answers than questions": Attempt(
        "answer(b'[\"twist\", [0.4, 0, 0]]\\n' * 50)", "answered before it was asked"
    ),
    "no end": Attempt("os.closerange(0, 20)\ntime.sleep(60.0)", "took longer than 2 s in all"),
}
MUCH = {
    "memory for all": Attempt(
        "for number in range(40):\n    pathlib.Path(f'/dev/shm/{number}').write_bytes(bytes(50_000_000))",
        "No space left",
    ),
    "the disk": Attempt(
        "for number in range(40):\n    pathlib.Path(f'{number}').write_bytes(bytes(50_000_000))", "No space left"
    ),
    "a large file": Attempt("pathlib.Path('large').write_bytes(bytes(200_000_000))", "File too large"),
    "forks": Attempt("while True:\n    os.fork()", "more than 512 processes|more memory than"),
    "threads": Attempt(
        "import threading\n"
        "threading.stack_size(65536)\n"
        "while True:\n"
        "    threading.Thread(target=time.sleep, args=(60,)).start()",
        "more than 512 processes|RuntimeError",
    ),
    "memory by many": Attempt(
        "for _ in range(4):\n    os.fork() or (bytearray(b'x') * 700_000_000, time.sleep(60.0))\ntime.sleep(60.0)",
        "more memory than",
    ),
    "memory in files": Attempt(
        "kept = [os.memfd_create('x') for _ in range(40)]\n"
        "for each in kept:\n    os.write(each, bytes(90_000_000))\ntime.sleep(60.0)",
        "more memory than",
    ),
    "hidden memory": Attempt(
        "call('prctl', 4, 0, 0, 0, 0)\n"
        "kept = [os.memfd_create('x') for _ in range(40)]\n"
        "for each in kept:\n    os.write(each, bytes(90_000_000))\ntime.sleep(60.0)",
        "more memory than|hides which files",
    ),
}
ANSWERS = {
    "no json": Attempt("answer(b'forward!\\n')", "which is not a command"),
    "no text": Attempt('answer(b\'["twist", "\\xff\\xfe"]\\n\')', "which is not a command"),
    "depth": Attempt("answer(b'[' * 100_000 + b'\\n')", "which is not a command"),
    "a table": Attempt('answer(b\'{"twist": 1, "wheels": 2}\\n\')', "which is not a command"),
    "digits": Attempt("answer(b'[\"twist\", [1' + b'0' * 5000 + b', 0, 0]]\\n')", "which is not a command"),
    "a large number": Attempt(
        "answer(b'[\"twist\", [1' + b'0' * 400 + b', 0, 0]]\\n')", r"returned Twist\(forward=1000"
    ),
    "no number": Attempt("answer(b'[\"twist\", [NaN, Infinity, 1e999]]\\n')", "is not finite"),
    "too many numbers": Attempt("answer(b'[\"twist\", [1, 2, 3, 4, 5]]\\n')", "which is not a command"),
    "nothing": Attempt("answer(b'[\"wheels\", null]\\n')", "which is not a command"),
    "half a character": Attempt("raise ValueError('\\ud800 \\udfff')", r"\\ud800 \\udfff"),
    "colours": Attempt("raise ValueError('\\x1b[2J\\x1b[31m \\u202e \\x00')", r"\\x1b\[2J\\x1b\[31m \\u202e \\x00"),
    "a formula": Attempt('answer(b\'["error", "=HYPERLINK(1)"]\\n\')', "=HYPERLINK"),
    "a script": Attempt("raise ValueError('<script>alert(1)</script>')", "<script>"),
    "many lines": Attempt("raise ValueError('line\\n' * 50_000)", r"ValueError: line / line \.\.\."),
    "a long text": Attempt("raise ValueError('x' * 3_000_000)", "answered with more than a command"),
    "a text that fails": Attempt("raise type('Odd', (Exception,), {'__str__': lambda self: 1 / 0})", "Odd"),
    "an exit": Attempt("raise SystemExit(0)", "its process ended"),
    "an interrupt": Attempt("raise KeyboardInterrupt", "its process ended"),
    "an error of another kind": Attempt('answer(b\'["error", {"a": [1, null]}]\\n\')', "'a'"),
}


@pytest.fixture
def course(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A rubric with a held-out world, and private files beside it."""
    monkeypatch.setenv("AMORSIM_SECRET", "of the lecturer")
    rubric = make_course(tmp_path / "course", RUBRIC.replace("4e9", "1.5e9"))
    secret = rubric.parent / "secret"
    secret.mkdir()
    (secret / "held-out.pgm").write_bytes(b"P5\n160 100\n255\n" + bytes([255]) * 16000)
    (secret / "held-out.yaml").write_text(
        "image: held-out.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    rubric.write_text(rubric.read_text().replace("runs = 1", 'worlds = ["secret/held-out.yaml"]'))
    (tmp_path / "letter.txt").write_text("of the lecturer")
    return rubric


def write(course: Path, attempts: Mapping[str, Attempt]) -> dict[str, Path]:
    """The files of attempts, by what they try."""
    paths = {}
    for number, (what, attempt) in enumerate(attempts.items()):
        body = "\n".join(f"    {line}" for line in attempt.body.splitlines())
        paths[what] = course.parent / f"attempt{number}.py"
        paths[what].write_text(SUBMISSION.substitute(course=course.parent, grader=os.getpid(), body=body))
    return paths


def try_all(course: Path, attempts: Mapping[str, Attempt]) -> dict[str, Grade]:
    """Grade attempts among honest submissions; the grades by what was tried."""
    paths = write(course, attempts)
    honest = [course.parent / "ann.py", course.parent / "zoe.py"]
    for path in honest:
        path.write_text(GOOD)
    before = state_of(course.parent)
    found = grade(course, [honest[0], *paths.values(), honest[1]], course.parent / "grades")
    assert state_of(course.parent) == before
    ann, *tried, zoe = found
    assert ann.total == zoe.total > 8.0
    assert [case.values for case in ann.cases] == [case.values for case in zoe.cases]
    assert not strays()
    return dict(zip(paths, tried, strict=True))


def check(attempts: Mapping[str, Attempt], found: Mapping[str, Grade]) -> None:
    """Each has no points, for the reason that is expected."""
    wrong = {}
    for what, attempt in attempts.items():
        (case,) = found[what].cases
        if found[what].total != 0.0 or not re.search(attempt.reason, case.problem):
            wrong[what] = (found[what].total, case.problem)
    assert not wrong


def state_of(folder: Path) -> list[Any]:
    """What must not change: the files of a folder, and limits and priority of this process."""
    files = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.parent.name != "grades"}
    modes = {path: path.stat().st_mode for path in files}
    kinds = [getattr(resource, name) for name in dir(resource) if name.startswith("RLIMIT_")]
    return [files, modes, [resource.getrlimit(kind) for kind in kinds], os.getpriority(os.PRIO_PROCESS, 0)]


def strays() -> list[str]:
    """Processes that attempts left behind; they have a moment to end."""
    until = time.monotonic() + 10.0
    while left := [
        entry.parent.name for entry in Path("/proc").glob("[0-9]*/cmdline") if b"amorsim-stray" in said(entry)
    ]:
        if time.monotonic() > until:
            break
        time.sleep(0.1)
    return left


def said(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""


GROUPS = {
    "reading": READING,
    "changing": CHANGING,
    "processes": PROCESSES,
    "taking": TAKING,
    "much": MUCH,
    "answers": ANSWERS,
}
HALVES = [(name, half) for name in GROUPS for half in (0, 1)]


@pytest.mark.long
@pytest.mark.parametrize(("name", "half"), HALVES, ids=[f"{name}-{half}" for name, half in HALVES])
def test_no_attempt_earns_anything_or_costs_others(course: Path, name: str, half: int) -> None:
    every = list(GROUPS[name].items())
    attempts = dict(every[: len(every) // 2] if half == 0 else every[len(every) // 2 :])
    if name == "much":  # taking it takes time
        course.write_text(course.read_text().replace("time_limit = 2.0", "time_limit = 60.0"))
    found = try_all(course, attempts)
    check(attempts, found)
    with (course.parent / "grades" / "grades.csv").open(newline="", encoding="utf-8") as file:
        for row in csv.reader(file):
            assert not any(cell.startswith(("=", "+", "-", "@")) for cell in row)
            assert "".join(row).isprintable()
    for page in (course.parent / "grades").glob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert text.replace("\n", "").isprintable()
        assert "<script>" not in text
        assert "of the lecturer" not in text


@pytest.mark.long
@pytest.mark.parametrize("name", ["reading", "processes"])
def test_these_attempts_succeed_without_a_fence(course: Path, name: str) -> None:
    (course.parent / "ann.py").write_text(GOOD)
    attempts = {what: attempt for what, attempt in GROUPS[name].items() if attempt.succeeds}
    paths = write(course, attempts)
    found = grade(course, list(paths.values()), course.parent / "grades", fence=False)
    assert len(found) > 5
    assert {what: each.cases[0].problem for what, each in zip(paths, found, strict=True) if each.total < 8.0} == {}


class Server:
    """A socket that answers whatever reaches it, until it is closed."""

    def __init__(self, family: int, kind: int, address: Any) -> None:
        self._socket = socket.socket(family, kind)
        self._socket.bind(address)
        self._socket.settimeout(0.1)
        self._is_stream = kind == socket.SOCK_STREAM
        if self._is_stream:
            self._socket.listen()
        self.address = self._socket.getsockname()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._answer)
        self._thread.start()

    def _answer(self) -> None:
        while not self._ended.is_set():
            with contextlib.suppress(TimeoutError):
                if self._is_stream:
                    with self._socket.accept()[0] as other:
                        other.sendall(other.recv(1))
                else:
                    _, sender = self._socket.recvfrom(1)
                    self._socket.sendto(b"x", sender)

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._socket.close()


@pytest.fixture
def network(course: Path) -> Iterator[dict[str, Attempt]]:
    """Attempts to reach sockets of this process."""
    unix, internet, local = socket.AF_UNIX, socket.AF_INET, ("127.0.0.1", 0)
    sockets = {
        "TCP": (Server(internet, socket.SOCK_STREAM, local), "2, 1", "ConnectionRefused"),
        "UDP": (Server(internet, socket.SOCK_DGRAM, local), "2, 2", "ConnectionRefused"),
        "a socket with a path": (Server(unix, socket.SOCK_STREAM, str(course.parent / "socket")), "1, 1", NO_FILE),
        "a socket with a name": (
            Server(unix, socket.SOCK_STREAM, f"\0amorsim-{os.getpid()}"),
            "1, 1",
            "ConnectionRefused",
        ),
    }
    body = "with socket.socket({}) as ours:\n    ours.connect({!r})\n    ours.send(b'x')\n    assert ours.recv(1)"
    attempts = {
        name: Attempt(body.format(kind, server.address), reason, True)
        for name, (server, kind, reason) in sockets.items()
    }
    tcp = sockets["TCP"][0].address
    attempts["MPTCP"] = Attempt(body.format("2, 1, 262", tcp), "ConnectionRefused|not supported|not available")
    attempts["another machine"] = Attempt(body.format("2, 2", ("192.0.2.1", 9)), "Network is unreachable")
    yield attempts
    for server, *_ in sockets.values():
        server.close()


@pytest.mark.long
def test_no_attempt_reaches_the_network(course: Path, network: dict[str, Attempt]) -> None:
    check(network, try_all(course, network))


@pytest.mark.long
def test_the_network_is_reached_without_a_fence(course: Path, network: dict[str, Attempt]) -> None:
    attempts = {what: attempt for what, attempt in network.items() if attempt.succeeds}
    paths = write(course, attempts)
    found = grade(course, list(paths.values()), course.parent / "grades", fence=False)
    assert {what: each.cases[0].problem for what, each in zip(paths, found, strict=True) if each.total < 8.0} == {}


MIRROR = """\
import attrs
import numpy as np

import amorsim as am
from amorsim.controllers.user import UserController


class Estimator:
    def __init__(self, start):
        self.mirror = None

    def update(self, readings, command, elapsed):
        seen = readings["gyro"].measured
        if self.mirror is None:
            self.mirror = self.found(command, seen)
        else:
            self.command = list(command)
            self.mirror.step()
        assert np.array_equal(self.mirror.frames()[0].readings["gyro"][1].measured[0], seen)
        return self.mirror.true_pose[0]

    def found(self, command, seen):
        scenario = am.load("small.toml")
        robot = attrs.evolve(scenario.robots[0], controller=UserController(source='', function=lambda *_: self.command))
        scenario = attrs.evolve(scenario, robots=[robot], resolved=None)
        for seed in range(6, 9):
            mirror = am.Simulation(scenario, seed=seed)
            if np.array_equal(mirror.frames()[0].readings["gyro"][1].measured[0], seen):
                return mirror
        raise LookupError("no seed fits")
"""


@pytest.mark.long
def test_a_submission_finds_a_seed_that_is_known_and_none_that_is_drawn(tmp_path: Path) -> None:
    text = RUBRIC[: RUBRIC.index("[criteria]")].replace('function = "drive"', 'role = "estimator"')
    text += '[criteria]\nnear = { use = "position_error", at = "max", points = 10.0, none = 1e-6, full = 0.0 }\n'
    text = text.replace("time_limit = 2.0", "time_limit = 600.0")  # it simulates several runs, beside other work
    course = make_course(tmp_path / "course", text.replace("runs = 1", "practice = true\nseeds = [7]"))
    own = tmp_path / "handed-in" / "mirror.py"
    own.parent.mkdir()
    own.write_text(MIRROR)
    for name in ("small.toml", "rooms.wld"):  # which the students have
        (own.parent / name).write_bytes((course.parent / name).read_bytes())
    (known,) = grade(course, [own], tmp_path / "practice")
    assert known.cases[0].problem == ""
    assert known.total == 10.0  # the truth, to the last bit
    course.write_text(text)
    (drawn,) = grade(course, [own], tmp_path / "grades")
    assert drawn.total == 0.0
    assert "no seed fits" in drawn.cases[0].problem
