"""Feeds a program thousands of inputs in a child process that the system kills where one takes too long.

Each input is made from a seed of its own, so that one that fails is found again alone::

    python -m tests.fuzz.harness NAME FOLDER FIRST END SEED

The child tells which input it is at by writing its number to a file; what it finds goes to another. A time limit by
signals with their default action ends compiled code too; it counts the child's own processor time, so that a busy
machine changes nothing, and a second one by the clock ends what waits for ever.
"""

from __future__ import annotations

import random
import resource
import signal
import subprocess
import sys
import traceback
import warnings
from pathlib import Path

from amorsim.core.errors import AmorsimError
from tests.fuzz.inputs import FUZZERS

SECONDS = 10.0
BYTES = 10**9
_COMPILING = 300.0  # for an input that is the first to need a kernel
_WAITING = 20.0  # times as long as that, by the clock
_AT, _FOUND = "at.txt", "found.txt"


def fuzz(name: str, folder: Path, count: int, seed: int) -> list[str]:
    """What went wrong with inputs 0 to `count` - 1, one entry each."""
    print(f"fuzz {name}: seed {seed}, {count} inputs")
    (folder / _FOUND).write_text("")
    first, slow = 0, -1
    lost = []
    while first < count:
        code = _run(name, folder, first, count, seed, SECONDS)
        if code == 0:
            break
        at = int((folder / _AT).read_text())
        if at == slow or not _compiles(name, folder, at, seed):
            lost.append(f"input {at} (seed {seed}): {_ending(code)}")
            first = at + 1
        else:
            first = slow = at  # once more, with all kernels it needs
    return [*lost, *filter(None, (folder / _FOUND).read_text().split("\n\n"))]


def _run(name: str, folder: Path, first: int, end: int, seed: int, seconds: float) -> int:
    command = [sys.executable, "-m", "tests.fuzz.harness", name, folder, first, end, seed, seconds]
    root = Path(__file__).parents[2]
    return subprocess.run([str(part) for part in command], cwd=root, check=False).returncode


def _compiles(name: str, folder: Path, at: int, seed: int) -> bool:
    return _run(name, folder, at, at + 1, seed, _COMPILING) == 0


def _ending(code: int) -> str:
    if -code == signal.SIGPROF:
        return f"took more than {SECONDS:g} s of processor time"
    return f"ended the process with {code}" if code > 0 else f"was ended by {signal.Signals(-code).name}"


def main(name: str, folder: Path, first: int, end: int, seed: int, seconds: float) -> None:
    """Try inputs `first` to `end` - 1."""
    warnings.simplefilter("ignore")
    fuzzer = FUZZERS[name](folder)
    used = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmData"))
    most = int(used.split()[1]) * 1024 + BYTES
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with (folder / _AT).open("w") as at, (folder / _FOUND).open("a") as found:
        for number in range(first, end):
            at.seek(0)
            at.write(f"{number}\n")
            at.flush()
            signal.setitimer(signal.ITIMER_PROF, seconds)
            signal.setitimer(signal.ITIMER_REAL, seconds * _WAITING)
            try:
                fuzzer.attempt(random.Random(f"{seed} {name} {number}"))
            except AmorsimError:
                pass
            except (Exception, SystemExit):
                lines = traceback.format_exc().strip().splitlines()
                found.write(f"input {number} (seed {seed}): {fuzzer.said[:300]}\n")
                found.write("\n".join([*lines[-7:-1], lines[-1][:300]]).replace("\n\n", "\n") + "\n\n")
                found.flush()


if __name__ == "__main__":
    _, _name, _folder, *_numbers = sys.argv
    main(_name, Path(_folder), *map(int, _numbers[:3]), float(_numbers[3]) if len(_numbers) > 3 else SECONDS)
