"""Compiling what contact needs, in a process beside the one that runs.

The kernels' cache is where the two meet: each loads what the other has compiled already, and waits for what it is just
compiling (`amorsim.kernels.claims`). What nearly every run needs has a list (`amorsim.kernels.ahead`).
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
from pathlib import Path

from amorsim.kernels import folder as compiling
from amorsim.kernels.beside import command_for
from amorsim.kernels.cache import take_turns
from amorsim.plugins.manager import default_registry
from amorsim.scenario.read import loads
from amorsim.simulation.simulation import Simulation

__all__ = ["compile_contact_beside", "meet"]

_beside: list[subprocess.Popen[bytes]] = []


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
                command_for(__name__, "meet"),
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


def meet() -> None:
    """Let a robot run into a wall and another one into it, and leave word that this is compiled."""
    threading.Thread(target=_end_with_the_other, name="amorsim-end", daemon=True).start()
    take_turns()
    simulation = collide()
    stamp = _contact_stamp()
    if stamp is not None and _have_met(simulation):
        with contextlib.suppress(OSError):
            for stale in stamp.parent.glob("contact-*"):
                stale.unlink(missing_ok=True)
            stamp.touch()


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
