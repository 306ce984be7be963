"""Users' programs tried out: loaded in another process, which is ended after a time limit."""

from __future__ import annotations

import contextlib
import json
import pickle
import queue
import re
import signal
import subprocess
import threading
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import IO, Any

from amorsim.core.arguments import check_kind
from amorsim.core.errors import AmorsimError, Fault
from amorsim.core.execution.processes import end_with_children, python_command
from amorsim.core.parameters import ParameterError
from amorsim.core.user_code import UserCode
from amorsim.scenario.programs.program_text import Program
from amorsim.scenario.programs.programs import programs_of
from amorsim.scenario.reading.lines import with_lines
from amorsim.scenario.spec import Scenario

__all__ = ["check_code", "check_time_limit"]

MOST_OUTPUT = 1_000_000  # bytes
_START = 120.0  # [s] that the process has to start: it loads numpy and numba, on a machine that may be busy
_GRACE = 2.0  # [s] until it reports its place
_REST = 1.0  # [s] for the last lines of a process that has ended
_FRAME = re.compile(r'File "(.*)", line (\d+) in ')


def check_code(scenario: Scenario, *, time_limit: float = 10.0) -> tuple[Fault, ...]:
    """The faults of the components that a scenario's file names as ``"FILE.py:NAME"``: controllers, estimators ...

    Another process loads them: it runs their files, and makes an object of each class with its options. Nothing of them
    runs in this process. The other one is ended, with all processes that it has started.

    Parameters
    ----------
    scenario
        As `load` or `Document.scenario` gives it. What a script has given as an object is not checked.
    time_limit
        How long each may take [s].

    Returns
    -------
    tuple[Fault, ...]
        Of a file that raises, does not finish in time, ends its process, or prints without end; of a name that is not
        there, or that does not take its options.

    Raises
    ------
    ParameterError
        If the time limit is not a number > 0.
    AmorsimError
        If the process does not start.
    """
    check_kind(scenario, Scenario, "scenario", "a Scenario, as am.load('demo')")
    check_time_limit(time_limit)
    programs = list(programs_of(scenario))
    faults: list[Fault] = []
    hopeless: dict[Path, str] = {}  # files that cannot be loaded again, and why
    waiting = list(range(len(programs)))
    while waiting:
        trial = _Trial([(number, *programs[number]) for number in waiting], time_limit)
        for number, problem in trial.run():
            waiting.remove(number)
            if problem:
                faults.append(programs[number][1].fault(problem))
        if trial.broken is None:
            break
        number, problem, is_loaded = trial.broken
        program = programs[number][1]
        waiting.remove(number)
        faults.append(program.fault(problem))
        if not is_loaded:
            hopeless[program.path] = problem
        for number in [each for each in waiting if programs[each][1].path in hopeless]:
            waiting.remove(number)
            faults.append(programs[number][1].fault(hopeless[programs[number][1].path]))
    return tuple(with_lines(dict.fromkeys(faults)))


def check_time_limit(value: float) -> None:
    """Raise `ParameterError` unless this is a time limit [s]."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value <= 1e6:
        raise ParameterError("time_limit", f"expected a number of seconds > 0 and <= 1e+06, got {value!r}")


class _Trial:
    """A process that loads one program after another, and its answers.

    `broken` is the number of the program with which it broke off, what happened, and whether the file had been loaded.
    """

    def __init__(self, programs: Sequence[tuple[int, UserCode, Program]], time_limit: float) -> None:
        self._programs = {number: (component, program) for number, component, program in programs}
        self._time_limit = time_limit
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()  # None at the end of the process's answers
        self._output = 0  # bytes that programs have printed
        self._is_flood = threading.Event()
        self._stacks: list[str] = []  # lines of stacks
        self._ended: float | None = None  # [s] when the process was found to have ended
        self.broken: tuple[int, str, bool] | None = None

    def run(self) -> list[tuple[int, str]]:
        """The numbers of the programs that were tried, with what is wrong with each, or nothing."""
        process = subprocess.Popen(
            python_command("from amorsim.scenario.programs.code_child import main; main()"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        readers = [
            threading.Thread(target=self._read_answers, args=(process.stdout,), daemon=True),
            threading.Thread(target=self._read_output, args=(process.stderr,), daemon=True),
        ]
        try:
            for reader in readers:
                reader.start()
            components = [(number, component) for number, (component, _) in self._programs.items()]
            with contextlib.suppress(OSError):
                process.stdin.write(pickle.dumps((self._time_limit, components)))
                process.stdin.close()
            return self._follow(process)
        finally:
            end_with_children(process)
            for reader, pipe in zip(readers, (process.stdout, process.stderr), strict=True):
                reader.join(1.0)
                if not reader.is_alive():  # else a process in a session of its own holds the other end
                    pipe.close()

    def _read_answers(self, pipe: IO[bytes]) -> None:
        with contextlib.suppress(OSError, ValueError):
            for line in pipe:
                self._lines.put(line.decode(errors="replace"))
        self._lines.put(None)

    def _read_output(self, pipe: IO[bytes]) -> None:
        with contextlib.suppress(OSError, ValueError):
            while data := pipe.read1(65536):  # type: ignore[attr-defined]
                self._output += len(data)
                if self._output > MOST_OUTPUT:
                    self._is_flood.set()
                    return  # what prints waits from now on

    def _follow(self, process: subprocess.Popen[bytes]) -> list[tuple[int, str]]:
        found: list[tuple[int, str]] = []
        number: int | None = None
        is_loaded = False
        deadline = time.monotonic() + _START
        while True:
            answer = self._answer(process, deadline)
            if isinstance(answer, str):
                if number is None:
                    raise AmorsimError(f"the process that loads components in files did not start: {answer}")
                self.broken = number, self._in_words(number, is_loaded, answer), is_loaded
                return found
            if "begun" in answer:
                number, is_loaded = answer["begun"], False
                deadline = time.monotonic() + self._time_limit + _GRACE
            elif "loaded" in answer:
                is_loaded = True
            elif "ended" in answer:
                found.append((answer["ended"], answer["problem"]))
            else:
                return found

    def _answer(self, process: subprocess.Popen[bytes], deadline: float) -> dict[str, Any] | str:
        """The next answer, or how the process has broken off."""
        late = f"did not finish within {self._time_limit:g} s"
        while True:
            if self._is_flood.is_set():
                self._ask_where(process)
                return f"printed more than {MOST_OUTPUT // 1_000_000} MB"
            try:
                line = self._lines.get(timeout=0.05)
            except queue.Empty:
                if time.monotonic() > deadline:
                    return late
                if process.poll() is None:
                    continue
                self._ended = self._ended or time.monotonic()
                if time.monotonic() < self._ended + _REST:
                    continue
                line = None  # one of its own children holds the pipe
            if line is None:
                self._take_rest()
                if any(line.startswith("Timeout (") for line in self._stacks):
                    return late
                return _ending(process.wait())
            if line.startswith("{"):
                with contextlib.suppress(ValueError):
                    answer: dict[str, Any] = json.loads(line)
                    return answer
            self._stacks.append(line)

    def _ask_where(self, process: subprocess.Popen[bytes]) -> None:
        """Let the process report where it is."""
        if not hasattr(signal, "SIGUSR1"):
            return
        with contextlib.suppress(OSError):
            process.send_signal(signal.SIGUSR1)
        time.sleep(0.2)
        self._take_rest()

    def _take_rest(self) -> None:
        with contextlib.suppress(queue.Empty):
            while (line := self._lines.get(timeout=0.1)) is not None:
                self._stacks.append(line)

    def _in_words(self, number: int, is_loaded: bool, happened: str) -> str:
        component, program = self._programs[number]
        line = _line(self._stacks, program.path)
        doing = f"making an object of {program.name} with the options {dict(component.options)}"
        remedy = ""
        if not is_loaded:
            doing = "loading the file"
            remedy = "; what stands at its top runs then, so put it into a function"
        return f"{program.path}{f', line {line}' if line else ''}: {doing} {happened}{remedy}"


def _line(printed: Iterable[str], path: Path) -> int | None:
    """The line of a file that stacks of several threads show, innermost first; of the present or the main one."""
    name = str(path).encode("ascii", "backslashreplace").decode()
    stacks: list[list[int]] = [[]]
    at = 0
    for line in printed:
        if line.startswith(("Current thread", "Thread")):
            stacks.append([])
            at = len(stacks) - 1 if line.startswith("Current") else at
        elif (frame := _FRAME.search(line)) and frame[1] == name:
            stacks[-1].append(int(frame[2]))
    for lines in (stacks[at], *reversed(stacks)):
        if lines:
            return lines[0]
    return None


def _ending(status: int) -> str:
    """How a process has ended, in words."""
    if status >= 0:
        return f"ended its process with the exit status {status}, as os._exit does"
    try:
        name = signal.Signals(-status).name
    except ValueError:
        name = str(-status)
    return f"broke its process down, with the signal {name}"
