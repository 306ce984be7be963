"""The process in which users' programs are loaded to be checked; see `amorsim.scenario.programs.code_check`."""

from __future__ import annotations

import faulthandler
import json
import os
import pickle
import signal
import sys
from typing import IO, Any

import attrs

from amorsim.core.error_text import error_in_words
from amorsim.core.errors import AmorsimError, ScenarioError
from amorsim.core.user_code import UserCode
from amorsim.scenario.programs.program_text import Program
from amorsim.scenario.programs.programs import made_of

__all__ = ["main"]


def main() -> None:
    """Read from standard input what to check, and write lines about what has begun and how it ended."""
    time_limit, components = pickle.load(sys.stdin.buffer)
    answers = _Answers(os.fdopen(os.dup(1), "w", encoding="utf-8", buffering=1))
    # What a program prints must not be taken for an answer, and it must not wait for the keyboard.
    os.dup2(2, 1)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    faulthandler.enable(file=answers.pipe)
    if hasattr(faulthandler, "register"):  # not on Windows
        faulthandler.register(signal.SIGUSR1, file=answers.pipe)
    for number, component in components:
        answers.say(begun=number)
        faulthandler.dump_traceback_later(time_limit, exit=True, file=answers.pipe)
        problem = _check(answers, component)
        faulthandler.cancel_dump_traceback_later()
        answers.say(ended=number, problem=problem)
    answers.say(done=True)
    if hasattr(signal, "pause"):
        signal.pause()  # the caller ends this process, and what programs have left running
    os._exit(0)


class _Answers:
    """Writes lines for the parent process. In a copy of this process, forked by a program, it ends the copy."""

    def __init__(self, pipe: IO[str]) -> None:
        self.pipe = pipe
        self._process = os.getpid()

    def say(self, **message: Any) -> None:
        if os.getpid() != self._process:
            os._exit(0)
        self.pipe.write(json.dumps(message) + "\n")


def _check(answers: _Answers, component: UserCode) -> str:
    """The fault of a component; empty if there is none."""
    program: Program = component.function
    try:
        program.load(dict(component.options))
        answers.say(loaded=True)
        made = made_of(component)
        if isinstance(made, UserCode):
            made.try_out()
    except ScenarioError as error:
        return "; ".join(
            str(attrs.evolve(fault, file="", named=fault.path.rpartition(".")[2])) for fault in error.faults
        )
    except AmorsimError as error:
        return str(error)
    except BaseException as error:  # Ctrl-C is not for this process
        return f"{program.path}: {error_in_words(error)}"
    return ""
