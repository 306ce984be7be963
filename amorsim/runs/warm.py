"""Compiling ahead: short simulations of what nearly every run needs, half of them in a second process.

numba compiles a kernel at its first call, and keeps it in its cache. To compile ahead, the kernels are called by small
robots from a list, and by the bundled scenarios. Each has something that the ones before it lack. `amorsim compile`
goes through all of them.
"""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amorsim.contracts import Planner
from amorsim.core.files.temporary_folders import temporary_folder
from amorsim.core.maps.map import Map
from amorsim.core.parameters import describe
from amorsim.core.shapes import Shape
from amorsim.kernels.cache_folder import cache_folder, mark_warm
from amorsim.kernels.sensing.readings import range_and_bearing, shares_of_range
from amorsim.planners.d_star_lite import DStarLite
from amorsim.planners.hybrid_a_star import HybridAStar
from amorsim.planners.wavefront import Wavefront
from amorsim.plugins.manager import default_registry, make_registry
from amorsim.runs.run import run
from amorsim.scenario.reading.read import load, loads
from amorsim.scenario.spec import Scenario
from amorsim.worlds.made import MadeWorld, make_world

__all__ = ["cold_planners", "compile_kernels", "compile_planner"]

Progress = Callable[[int, int], None]
Table = dict[str, Any]
_OURS = "amorsim.planners."
_NEEDS_EXTRA = "learned"  # ONNX Runtime; it has no kernels of its own
LONGEST_SECOND = 600.0  # [s] that the second process gets from its start; what it leaves is compiled when first called


def compile_kernels(progress: Progress | None = None, *, more: bool = False) -> None:
    """Compile the kernels of usual runs; `progress` is called with how many trials are done, and how many there are.

    Two processes share the work. This one returns when both have ended; the second is ended `LONGEST_SECOND` after its
    start.

    Parameters
    ----------
    progress
        Called at the beginning too.
    more
        Whether to compile also the kernels of robots that collide, of the bundled scenarios (so of the estimators), of
        controllers that avoid obstacles, of generated worlds and of planners.
    """
    first, second = _FIRST, _SECOND
    if more:
        named = {*_FIRST, *_MORE, *_BESIDE, _NEEDS_EXTRA}
        others = [name for name in make_registry(entry_points=()).names("scenario") if name not in named]
        first, second = _FIRST + _MORE, (*_SECOND, *_BESIDE, *others)
    total, done, lock = len(first) + len(second), 0, threading.Lock()

    def one_more() -> None:
        nonlocal done
        with lock:
            done += 1
            if progress is not None:
                progress(done, total)

    if progress is not None:
        progress(0, total)
    if not sys.executable:  # a program with an embedded Python may have none
        _try_all((*first, *second), one_more)
    else:
        _try_in_two(first, second, one_more)
    mark_warm()


def cold_planners(planners: Iterable[Planner]) -> list[type[Planner]]:
    """The built-in kinds among these planners whose kernels are not compiled yet, each once."""
    kinds = dict.fromkeys(type(planner) for planner in planners)
    return [kind for kind in kinds if kind.__module__.startswith(_OURS) and not _is_compiled(kind)]


def compile_planner(kind: type[Planner]) -> None:
    """Compile the kernels of a built-in planner, by plans around a wall."""
    start, goal, footprint = (1.1, 3.1), (5.1, 3.1), Shape.circle(0.1)
    room, changed = _rooms()
    kind().plan(room, start, goal, footprint=footprint)
    if issubclass(kind, HybridAStar):
        trailer = kind(trailer_length=0.4, trailer_width=0.1, trailer_front=0.05, trailer_rear=0.05)
        trailer.plan(room, (1.1, 2.1, 0.0), (2.1, 2.1, 0.0), footprint=footprint)
    if issubclass(kind, Wavefront):
        kind().field(room, goal, footprint=footprint)
    if issubclass(kind, DStarLite):
        replanner = kind().replanner(goal, footprint=footprint)
        for world in (room, changed):
            replanner.plan(world, start)
    folder = cache_folder()
    if folder is not None:
        _mark_of(folder, kind).touch()


def _is_compiled(kind: type[Planner]) -> bool:
    folder = cache_folder()
    return folder is not None and _mark_of(folder, kind).exists()


def _mark_of(folder: Path, kind: type[Planner]) -> Path:
    return folder / f"warm-{kind.__name__}"


def _rooms() -> tuple[Map, Map]:
    """A room with a wall in it, and the same with a longer one."""
    cells = np.zeros((20, 30))
    cells[5:, 15] = 1
    room = Map.from_array(cells, resolution=0.2)
    cells[3:5, 15] = 1
    return room, Map.from_array(cells, resolution=0.2)


def _try_in_two(first: Sequence[str], second: Sequence[str], one_more: Callable[[], None]) -> None:
    deadline = time.monotonic() + LONGEST_SECOND
    with subprocess.Popen(_command(second), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        try:
            listener = threading.Thread(target=_listen, args=(process, one_more), daemon=True)
            listener.start()
            _try_all(first, one_more)
            listener.join(max(0.0, deadline - time.monotonic()))
            if listener.is_alive():
                process.kill()
                listener.join()
        except BaseException:
            process.kill()
            raise


def _command(names: Sequence[str]) -> list[str]:
    # -P: otherwise Python would search the present folder first, where a user's struct.py may lie.
    return [sys.executable, "-P", "-m", __spec__.name, *names]


def _listen(process: subprocess.Popen[str], one_more: Callable[[], None]) -> None:
    assert process.stdout is not None
    for _ in process.stdout:
        one_more()


def _try_all(names: Sequence[str], one_more: Callable[[], None]) -> None:
    for name in names:
        if name in _OTHERS:
            _OTHERS[name]()
        else:
            scenario, steps = _TRIALS[name]() if name in _TRIALS else (load(name), _STEPS.get(name, 2))
            with temporary_folder("compile") as folder:
                run(scenario, folder / "run", duration=steps * scenario.dt, progress=False)
        one_more()


def _pioneers(*poses: tuple[float, float], controller: str = "manual", **sensors: Any) -> Scenario:
    """Pioneers in a hall; `sensors` are tables of their laser and sonar, which they lack otherwise."""
    return _in_hall(
        [_pioneer(f"robot{number}", *pose, {"use": controller}, sensors) for number, pose in enumerate(poses)]
    )


def _avoiders() -> Scenario:
    """A Pioneer with each built-in controller that avoids obstacles on its way to goals."""
    registry = make_registry(entry_points=())
    robots: list[Table] = []
    for name in registry.names("controller"):
        fields = describe(registry.get("controller", name))
        if "goals" in fields and {field for field in fields if fields[field].is_required} <= {"goals"}:
            x, y = 1.5 * (1 + len(robots) % 4), 1.5 + len(robots) // 4
            sensors = {"laser": {}, "neighbours": {"use": "neighbours"}}
            robots.append(_pioneer(name, x, y, {"use": name, "goals": [[x + 3.0, y]]}, sensors))
    return _in_hall(robots)


def _pioneer(name: str, x: float, y: float, controller: Table, sensors: Table) -> Table:
    return {
        "name": name,
        "model": "pioneer2dx",
        "pose": {"x": x, "y": y, "heading_deg": -90.0},
        "sensors": {"laser": False, "sonar": False, **sensors},
        "controller": controller,
    }


def _typical(name: str, x: float) -> Table:
    """A Pioneer with its usual errors, whose sonars hear one another."""
    return {"name": name, "model": "pioneer2dx-typical", "pose": {"x": x, "y": 3.0}}


def _in_hall(robots: Sequence[Table]) -> Scenario:
    registry = default_registry()
    place = registry.file("scenario", "convoy").parent
    document = {"format": 1, "world": {"map": "hall.wld"}, "simulation": {"dt": 0.1}, "robots": robots}
    return loads(document, place, registry=registry)


# By name: what is simulated, and for how many steps. Devices that are read together share one large kernel, which only
# one of the processes should compile: so the robot that wanders looks along Bresenham's lines.
_TRIALS: Mapping[str, Callable[[], tuple[Scenario, int]]] = {
    "look": lambda: (_pioneers((5.0, 3.0), laser={}, sonar={}), 1),
    "wander": lambda: (_pioneers((5.0, 3.0), controller="wander", laser={"traversal": "bresenham"}), 2),
    "collide": lambda: (_pioneers((5.0, 0.6), (5.0, 1.3), controller="square"), 40),
    "meet": lambda: (_pioneers((5.0, 3.0), (5.0, 4.0), laser={}, sonar={}), 1),
    "avoid": lambda: (_avoiders(), 2),
    "typical": lambda: (_in_hall([_typical("one", 4.0), _typical("other", 6.0)]), 2),
}
# Steps of bundled scenarios that need more than two until all their kernels were called.
_STEPS: Mapping[str, int] = {"loop": 40, "map-the-office": 40}


def _make_worlds() -> None:
    """Make a world of each built-in kind."""
    registry = make_registry(entry_points=())
    for name in registry.names("world_generator"):
        make_world(MadeWorld(generator=registry.get("world_generator", name)(), seed=0))


def _plan() -> None:
    """Plan with each built-in planner."""
    registry = make_registry(entry_points=())
    for name in registry.names("planner"):
        compile_planner(registry.get("planner", name))


def _observe() -> None:
    """Make what a task for learners observes, as the policy of `learned` does: ranges, and the way to a goal."""
    shares_of_range(np.ones((1, 1)), np.ones((1, 1)), 0, np.empty((1, 1)))
    range_and_bearing(np.zeros((1, 3)), np.ones((1, 2)), 1.0, np.empty((1, 3)))


_OTHERS: Mapping[str, Callable[[], None]] = {"worlds": _make_worlds, "plan": _plan, "observe": _observe}
# Names of trials and of bundled scenarios; the scenarios that are not listed go to the second process. With `_MORE` and
# `_BESIDE`, both processes take about the same time.
_FIRST: tuple[str, ...] = ("look", "demo")
_SECOND: tuple[str, ...] = ("wander",)
_MORE: tuple[str, ...] = ("collide", "meet", "typical", "landmarks", "find-yourself", "loop")
_BESIDE: tuple[str, ...] = ("worlds", "plan", "observe", "avoid", "map-the-office", "find-the-way")


if __name__ == "__main__":
    _try_all(sys.argv[1:], lambda: print("done", flush=True))  # noqa: T201 - the first process listens
