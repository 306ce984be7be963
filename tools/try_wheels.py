"""Tries the wheels of a release as a new user would, in an environment and a folder with nothing else in them.

    python tools/try_wheels.py dist

All bundled scenarios run and compile nothing; the examples of the docs, the report, the page of a run, the window, and
what the messages advise work. It ends with an error where that is not so.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
import urllib.request
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
_COMPILED = """
import sys, pathlib
from amorsim.kernels.cache_folder import cache_folder
print(sum(1 for file in cache_folder().rglob("*.nbc")))
"""


class Trial:
    """A fresh environment with the wheels of a folder, and an empty folder to work in."""

    def __init__(self, folder: Path, wheels: list[Path]) -> None:
        self._bin = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        self._work = folder / "work"
        self._work.mkdir()
        venv.create(folder / "venv", with_pip=True)
        self._environment = {
            **{key: value for key, value in os.environ.items() if not key.startswith(("NUMBA", "PYTHON", "VIRTUAL"))},
            "XDG_CACHE_HOME": str(folder / "cache"),
        }
        names = [f"{wheel}[learn,ui,plot]" if wheel.name.startswith("amorsim-") else str(wheel) for wheel in wheels]
        self.run("python", "-m", "pip", "install", "--quiet", "-c", str(ROOT / "constraints.txt"), *names)

    def run(self, *command: str, folder: str = ".") -> str:
        """What a command prints, in a folder of the empty one; an error if it fails."""
        where = self._work / folder
        where.mkdir(parents=True, exist_ok=True)
        found = subprocess.run(
            [self._bin / command[0], *command[1:]],
            cwd=where,
            env=self._environment,
            capture_output=True,
            text=True,
            check=False,
        )
        if found.returncode:
            raise SystemExit(f"{' '.join(command)} ended with {found.returncode}:\n{found.stdout}{found.stderr}")
        return found.stdout

    def compiled(self) -> int:
        """How many compiled functions there are; asking takes installed ones first."""
        return int(self.run("python", "-c", _COMPILED))

    def answers(self, *command: str) -> str:
        """The page of a window that a command opens, which is ended then."""
        process = subprocess.Popen(
            [self._bin / command[0], *command[1:]],
            cwd=self._work,
            env=self._environment,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            assert process.stdout is not None
            address = next(word for line in process.stdout for word in line.split() if word.startswith("http://"))
            with urllib.request.urlopen(address, timeout=30) as page:
                return str(page.read().decode())
        finally:
            process.terminate()
            process.wait(30)


def main(dist: Path) -> None:
    """Try them all."""
    wheels = sorted(dist.absolute().glob("*.whl"))
    _expect(len(wheels) == 2, f"expected two wheels in {dist}, got {[wheel.name for wheel in wheels]}")
    with tempfile.TemporaryDirectory() as folder:
        trial = Trial(Path(folder), wheels)
        began, used = time.monotonic(), _processor_time()
        trial.run("amorsim", "run", "demo", "--duration", "10")
        used, took = _processor_time() - used, time.monotonic() - began
        _say(f"first run of the demo: {used:.1f} s of the processor, {took:.1f} s on the clock")
        before = trial.compiled()
        _expect(before > 200, f"expected compiled kernels from the wheel, got {before}")
        names = trial.run(
            "python", "-c", "from amorsim.plugins.manager import default_registry as r; print(*r().names('scenario'))"
        ).split()
        for name in names:
            trial.run("amorsim", "run", name, "--duration", "3", "--out", f"runs/{name}", "--quiet")
            _say(f"{name}: {trial.compiled() - before} functions compiled so far")
        new = trial.compiled() - before
        _expect(new == 0, f"expected that nothing is compiled, got {new} functions")
        for example in sorted((ROOT / "docs" / "examples").glob("*.py")):
            printed = trial.run("python", str(example), folder=example.stem)
            expected = example.with_suffix(".out").read_text(encoding="utf-8")  # last digits are a machine's own
            _expect(len(printed.split()) == len(expected.split()), f"{example.name}: expected\n{expected}\n{printed}")
        _say("the examples of the docs print what they are to print")
        trial.run("amorsim", "report", "runs/demo")
        trial.run("amorsim", "export", "runs/demo", "--to", "html")
        trial.run("amorsim", "plot", "runs/demo")
        trial.run("amorsim", "new", "mine")
        trial.run("amorsim", "run", "mine/scenario.toml", "--duration", "5")
        for command in (("view", "demo"), ("edit", "mine/scenario.toml"), ("replay", "runs/demo")):
            page = trial.answers("amorsim", *command, "--no-open")
            _expect("<html" in page, f"amorsim {command[0]}: expected a page, got {page[:200]}")
        _say("the report, the page, the plots, a scenario of one's own and the windows work")


def _processor_time() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _expect(holds: bool, message: str) -> None:
    if not holds:
        raise SystemExit(message)


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "dist"))
