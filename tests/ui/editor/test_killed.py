"""The Editor's steps in a process that is killed again and again, at any moment: what was reported as done is kept."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from amorsim.core.execution.processes import python_command
from amorsim.ui.editor.changes import apply
from amorsim.ui.editor.work import Work

BACK = 5  # steps that are taken back each time
KILLS = 50  # in each of four parts: 200 in all


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
@pytest.mark.parametrize("part", range(4))
def test_a_server_killed_at_any_moment_keeps_every_step_that_it_reported(part: int, tmp_path: Path) -> None:
    chance = random.Random(part)
    command = python_command("from tests.ui.editor.test_killed import bring_up; bring_up()")
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as nursery:
        assert nursery.stdin is not None
        assert nursery.stdout is not None
        said = 1
        for _ in range(KILLS):
            nursery.stdin.write(f"{tmp_path} {said + 1}\n")
            nursery.stdin.flush()
            pid = int(nursery.stdout.readline())
            time.sleep(chance.uniform(0.02, 0.3))
            os.kill(pid, signal.SIGKILL)
            assert nursery.stdout.readline() == f"{pid} has ended\n"
            said = check(tmp_path, said)
        nursery.stdin.close()
    assert said > 2 * KILLS  # it had something to lose


def check(folder: Path, before: int) -> int:
    """Open it again, and look whether all is there; the number of the step that was made last."""
    reported = folder / "reported"
    lines = reported.read_text().split("\n")[:-1] if reported.exists() else []
    last = int(lines[-1]) if lines else before
    work = Work("demo", folder, state=folder / ".state")
    found = work.document.get("simulation.seed")
    # A step is reported once it is made; one more may have been made, or, in the middle of an undo, one less.
    assert found in (last, last + 1) or (last + 1) % 7 == 0, f"{last} was reported, {found} is there"
    texts = work.texts
    back = min(BACK, len(work.steps.history.done))
    if found >= 5:  # each fifth step writes a program, too
        assert work.program("drive.py").text == program(int(found) // 5 * 5)
    for _ in range(back):
        work.undo()
    assert work.document.get("simulation.seed") == max(1, found - back)
    for _ in range(back):
        work.redo()
    assert work.texts == texts
    work.close()
    return int(found)


def bring_up() -> None:
    """Fork a process for each line of standard input: a folder, and the number of the first step."""
    for line in sys.stdin:
        folder, first = line.rsplit(" ", 1)
        pid = os.fork()
        if pid == 0:
            make_steps(Path(folder), int(first))
        print(pid, flush=True)
        os.waitpid(pid, 0)
        print(pid, "has ended", flush=True)


def make_steps(folder: Path, first: int) -> None:
    """Make steps until somebody kills this process."""
    work = Work("demo", folder, state=folder / ".state")
    with (folder / "reported").open("a", buffering=1) as out:
        for number in range(first, first + 1_000_000):
            make_step(work, number)
            if number % 7 == 0:
                work.undo()
                work.redo()
            out.write(f"{number}\n")
    os._exit(1)


def make_step(work: Work, number: int) -> None:
    """The seed is the step's number; each third step draws a wall, too, and each fifth one writes a program."""
    changes = [{"op": "set", "path": "simulation.seed", "value": number}]
    if number % 3 == 0:
        changes.append({"op": "walls", "add": [[0.001 * (number % 900), 0.5, 1.0, 0.5]]})

    def change(work: Work) -> None:
        apply(work, changes)
        if number % 5 == 0:
            work.set_program("drive.py", program(number))

    work.edit("step", change)


def program(number: int) -> str:
    return f"SPEED = {number}\n"
