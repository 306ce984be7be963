"""Compiling in two processes at once: what a first step needs last is compiled beside what it needs first.

On a machine of two cores this shortens the wait after installing. The kernels' cache is where the two meet: each loads
what the other has compiled already, and waits for what it is just compiling (`amorsim.kernels.claims`).
"""

from __future__ import annotations

import contextlib
import copy
import os
import subprocess
import sys
import threading
import tomllib
from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Draws, Drive, MapLoader, Sensor, State, View
from amorsim.core.map import Map
from amorsim.kernels import cache as compiling
from amorsim.kernels.cache import take_turns
from amorsim.kernels.draft import FREE
from amorsim.kernels.grid import Grid
from amorsim.plugins.hooks import hookimpl
from amorsim.plugins.manager import default_registry, make_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.read import loads
from amorsim.scenario.spec import Scenario
from amorsim.simulation.simulation import Simulation

__all__ = ["compile_beside", "compile_contact_beside", "compile_first", "main", "meet"]

LONGEST = 120.0  # [s]
_beside: list[subprocess.Popen[bytes]] = []

# What a free entry says of each quadrant: a free square of one entry's side, and no more (see `amorsim.kernels.grid`).
ROOM_FOR_ONE = 1 | 1 << 7 | 1 << 14 | 1 << 21


def compile_beside() -> None:
    """Start a process that compiles what a wandering robot needs besides its map and its laser, and share the work."""
    if (os.cpu_count() or 1) < 2:
        return
    with contextlib.suppress(OSError):  # it only saves time
        # Held, for nobody waits for it, and one that is let go while it runs is warned about.
        _beside.append(
            subprocess.Popen(
                [sys.executable, "-c", f"from {__name__} import main; main()"],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        )
        take_turns()


def compile_contact_beside() -> None:
    """Start a process that compiles what robots that meet something need, unless one has done so already.

    They do so in the middle of a run, where whoever watches would wait some seconds. The process ends with this one.
    """
    stamp = _contact_stamp()
    if stamp is None or stamp.exists() or (os.cpu_count() or 1) < 2:
        return
    with contextlib.suppress(OSError):  # it only saves time
        _beside.append(
            subprocess.Popen(
                [sys.executable, "-c", f"from {__name__} import meet; meet()"],
                stdin=subprocess.PIPE,  # nothing is written: that it closes is what tells of our end
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
        )
        take_turns()


def _contact_stamp() -> Path | None:
    """The file that says that it is done, for the present sources."""
    stamp = compiling.stamp_file()
    return None if stamp is None else stamp.with_name(f"contact-{stamp.name}")


def compile_first(scenario: Scenario) -> None:
    """Compile what scans a map, while a process beside compiles what a simulation asks for before it scans."""
    if _beside:
        scenario.map.cast_rays(np.zeros((1, 3)), np.zeros(1), 1.0)


@attrs.frozen(kw_only=True)
class _OpenSpace(MapLoader):
    """A square of free cells, put together without a kernel."""

    extensions: ClassVar[tuple[str, ...]] = (".toml",)

    def load(self, path: Path) -> Map:
        side = 4096
        grid = Grid(
            resolution=0.01,
            rows=side,
            cols=side,
            super_cols=1,
            supers=np.full(1, FREE | ROOM_FOR_ONE, dtype=np.int32),
            tables=np.zeros((1, side), dtype=np.int32),
            pages=np.full((1, 64), 2**64 - 1, dtype=np.uint64),
            room=np.zeros((1, 64), dtype=np.uint16),
        )
        return Map(grid=grid, origin=(0.0, 0.0, 0.0))


@attrs.frozen(kw_only=True)
class _Nothing(Sensor):
    """Ranges about the robot, none of which meets anything, told without a kernel."""

    unit: ClassVar[str] = "m"

    def size(self, drive: Drive) -> int:
        return 8

    def bearings(self) -> npt.NDArray[np.float64]:
        return np.linspace(-3.0, 3.0, 8)[None]

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[npt.NDArray[np.float64], dict[str, Any]]:
        return np.full((view.rows, 8), np.inf), {}


class _Plugin:
    @hookimpl
    def amorsim_register(self, registry: Registry) -> None:
        registry.sensor("nothing", _Nothing)
        registry.map_loader("open_space", _OpenSpace)


def _deadline() -> threading.Timer:
    deadline = threading.Timer(LONGEST, os._exit, (1,))  # nobody waits for this process, so it must end by itself
    deadline.daemon = True
    deadline.start()
    return deadline


def main() -> None:
    """Make two steps of the demo's robot in an open space: with ranges from nowhere, and then with its sonars alone.

    What needs no rays comes first, for it is what the other process, which begins with rays, comes to last.
    """
    deadline = _deadline()
    take_turns()
    path = default_registry().file("scenario", "demo")
    document = tomllib.loads(path.read_text(encoding="utf-8"))
    document["world"] = {"map": str(path), "use": "open_space"}
    robot = document["robots"][0]
    robot["pose"] = {"x": 20.0, "y": 20.0, "heading_deg": 0.0}
    robot.pop("knowledge", None)  # its map would be drawn here, with the kernels that the other process begins with
    far = {"laser": False, "sonar": False, "far": {"use": "nothing"}}
    registry = make_registry({"warm": _Plugin()}, disabled="")
    for sensors, looks in ((far, "far"), ({"laser": False}, "sonar")):
        robot["sensors"], robot["controller"]["sensor"] = sensors, looks
        # Which start is free is not asked: nothing is in the way, and asking takes kernels.
        simulation = Simulation(loads(copy.deepcopy(document), path.parent, registry=registry, starts=False))
        simulation.step()
        simulation.step()
    deadline.cancel()


def meet() -> None:
    """Let a robot run into a wall and another one into it, and leave word that this is compiled."""
    deadline = _deadline()
    threading.Thread(target=_end_with_the_other, name="amorsim-end", daemon=True).start()
    take_turns()
    simulation = collide()
    stamp = _contact_stamp()
    if stamp is not None and _have_met(simulation):
        with contextlib.suppress(OSError):
            for stale in stamp.parent.glob("contact-*"):
                stale.unlink(missing_ok=True)
            stamp.touch()
    deadline.cancel()


def _end_with_the_other() -> None:
    sys.stdin.read()
    os._exit(1)


def collide() -> Simulation:
    """Two robots without sensors, one behind the other before a wall, after they met it and each other."""
    path = default_registry().file("scenario", "convoy")
    document = {
        "format": 1,
        "world": {"map": "hall.wld"},
        "simulation": {"dt": 0.1, "duration": 10.0, "seed": 1},
        "robots": [
            {
                "name": name,
                "model": "pioneer2dx",
                "pose": {"x": 5.0, "y": y, "heading_deg": -90.0},
                "sensors": {"laser": False, "sonar": False},
                "controller": {"use": "manual"},
            }
            for name, y in (("first", 0.6), ("second", 1.3))
        ],
    }
    simulation = Simulation(loads(document, path.parent, registry=default_registry()))
    for name in simulation.names:
        simulation.robot(name).drive(0.5)
    while simulation.tick < 30 and not _have_met(simulation):
        simulation.step()
    return simulation


def _have_met(simulation: Simulation) -> bool:
    return {"wall", simulation.names[0]} <= {event.other for event in simulation.events}
