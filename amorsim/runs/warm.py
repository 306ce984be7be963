"""Compiling ahead: short simulations that use what nearly every run needs, half of them in a second process.

numba compiles a kernel when it is first called, and keeps it in its cache. So to compile ahead is to call. A list of
small robots does it, each with something that the ones before it lack; `amorsim compile` goes through it.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from amorsim.kernels.cache_folder import mark_warm
from amorsim.plugins.manager import default_registry
from amorsim.runs.run import run
from amorsim.scenario.read import load, loads
from amorsim.scenario.spec import Scenario

__all__ = ["compile_kernels"]

Progress = Callable[[int, int], None]
LONGEST_SECOND = 600.0  # [s] that the second process gets from its start; what it leaves is compiled when first called


def compile_kernels(progress: Progress | None = None) -> None:
    """Compile the kernels of usual runs; `progress` is called with how many trials are done, and how many there are.

    Two processes share the work. This one returns when both have ended; the second is ended `LONGEST_SECOND` after its
    start.
    """
    total, done, lock = len(_TRIALS), 0, threading.Lock()

    def one_more() -> None:
        nonlocal done
        with lock:
            done += 1
            if progress is not None:
                progress(done, total)

    if progress is not None:
        progress(0, total)
    if not sys.executable:  # a program that Python is part of may name none
        _try_all(tuple(_TRIALS), one_more)
    else:
        deadline = time.monotonic() + LONGEST_SECOND
        with subprocess.Popen(_command(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as second:
            try:
                listener = threading.Thread(target=_listen, args=(second, one_more), daemon=True)
                listener.start()
                _try_all([name for name in _TRIALS if name not in _SECOND], one_more)
                listener.join(max(0.0, deadline - time.monotonic()))
                if listener.is_alive():
                    second.kill()
                    listener.join()
            except BaseException:
                second.kill()
                raise
    mark_warm()


def _command() -> list[str]:
    # -P: otherwise Python would look into the present folder first, where a user's struct.py may lie.
    return [sys.executable, "-P", "-m", __spec__.name, *_SECOND]


def _listen(process: subprocess.Popen[str], one_more: Callable[[], None]) -> None:
    assert process.stdout is not None
    for _ in process.stdout:
        one_more()


def _try_all(names: Sequence[str], one_more: Callable[[], None]) -> None:
    for name in names:
        scenario, steps = _TRIALS[name]()
        with tempfile.TemporaryDirectory() as folder:
            run(scenario, Path(folder) / "run", duration=steps * scenario.dt)
        one_more()


def _pioneers(*poses: tuple[float, float], controller: str = "manual", **sensors: bool) -> Scenario:
    """Pioneers in a hall, with those of their sensors that are named."""
    registry = default_registry()
    place = registry.file("scenario", "convoy").parent
    robots: list[Mapping[str, Any]] = [
        {
            "name": f"robot{number}",
            "model": "pioneer2dx",
            "pose": {"x": x, "y": y, "heading_deg": -90.0},
            "sensors": {name: False for name in ("laser", "sonar") if not sensors.get(name)},
            "controller": {"use": controller},
        }
        for number, (x, y) in enumerate(poses)
    ]
    document = {"format": 1, "world": {"map": "hall.wld"}, "simulation": {"dt": 0.1}, "robots": robots}
    return loads(document, place, registry=registry)


# By name: what is simulated, and for how many steps.
_TRIALS: Mapping[str, Callable[[], tuple[Scenario, int]]] = {
    "roll": lambda: (_pioneers((5.0, 3.0)), 1),
    "scan": lambda: (_pioneers((5.0, 3.0), laser=True), 1),
    "wander": lambda: (_pioneers((5.0, 3.0), controller="wander", laser=True), 2),
    "collide": lambda: (_pioneers((5.0, 0.6), (5.0, 1.3), controller="square"), 15),
    "hear": lambda: (_pioneers((5.0, 3.0), sonar=True), 1),
    "meet": lambda: (_pioneers((5.0, 3.0), (5.0, 4.0), laser=True, sonar=True), 1),
    "demo": lambda: (load("demo"), 2),
}
_SECOND = ("collide", "hear")


if __name__ == "__main__":
    _try_all(sys.argv[1:], lambda: print("done", flush=True))  # noqa: T201 - the first process listens
