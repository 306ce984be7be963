"""What is measured in a process of its own: `python -m benchmarks.children WHAT ...`, a line of JSON as the answer.

``first-step SIDE FOLDER`` makes the room (``demo``: the bundled scenario) and one step, and says so at once; the
parent has the clock. ``memory FILE``
loads a `.wld` file and tells what that took, ``picture FILE`` a picture.
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["ROOM", "TASK", "main"]

TASK = "task.npz"
"""The file in the folder that holds walls, starts and twists for a peer."""
ROOM = "room.wld"
"""The file in the folder that holds the same walls for amorsim."""


def main(arguments: list[str]) -> None:
    """Do what the parent asks."""
    what, *rest = arguments
    does: dict[str, Callable[..., dict[str, Any]]] = {
        "first-step": _first_step,
        "memory": _memory,
        "picture": _picture,
    }
    print(json.dumps(does[what](*rest)), flush=True)


def _first_step(side: str, folder: str) -> dict[str, Any]:
    if side == "demo":
        import amorsim as am

        simulation = am.Simulation(am.load("demo"))
        simulation.step()
        return {"beams": simulation.readings["laser"].measured.size}
    if side == "amorsim":
        import numpy as np

        import amorsim as am
        from benchmarks.ours import pioneer

        starts = np.load(Path(folder) / TASK)["starts"]
        scenario = am.Scenario(map=am.load_map(Path(folder) / ROOM), robots=[pioneer("rover", starts[0])])
        simulation = am.Simulation(scenario)
        simulation.step()
        return {"beams": simulation.readings["laser"].measured.size}
    import numpy as np

    from benchmarks.peers import PEERS
    from benchmarks.task import Task

    # The peer gets arrays, so that nothing of amorsim runs in its process but the imports of its types.
    with np.load(Path(folder) / TASK) as file:
        world = _BareWorld(walls=file["walls"])
        task = Task(world=world, starts=file["starts"], twists=file["twists"])  # type: ignore[arg-type]
    module, _, cls = PEERS[side].partition(":")
    peer = getattr(importlib.import_module(module), cls)
    peer.prepare()
    made = peer(task)
    made.step(0)
    return {"beams": int(task.rows * made.ranges().shape[1])}


class _BareWorld:
    """As much of a world as a peer asks for in a room of lines: its walls."""

    def __init__(self, walls: Any) -> None:
        self.walls = walls
        self.size = (10.0, 10.0)
        self.map = self
        self.segments = walls


def _memory(file: str) -> dict[str, Any]:
    import amorsim as am

    # Compiles, or loads, the kernels that draw walls: they are not part of a map.
    am.Map.from_segments([(0.0, 0.0, 1.0, 1.0)]).occupied([(0.5, 0.5)])
    am.load_map(_smallest(Path(file).parent))
    # The high-water mark of what came before, compiling above all, is none of the map's.
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    before = _kept("VmRSS")
    started = time.perf_counter()
    loaded = am.load_map(file)
    seconds = time.perf_counter() - started
    grid = sum(array.nbytes for array in loaded.grid if hasattr(array, "nbytes"))
    return {
        "seconds": seconds,
        "resident": _kept("VmRSS") - before,
        "peak": _kept("VmHWM") - before,
        "grid": grid,
    }


def _picture(file: str) -> dict[str, Any]:
    import numpy as np

    import amorsim as am

    am.Map.from_array(np.eye(200, dtype=np.uint8), resolution=0.05)  # loads the kernels, which are not part of a map
    small = Path(file).with_name("small.png")
    am.save_map(am.Map.from_array(np.eye(20), resolution=0.05), small)
    am.load_map(small, resolution=0.05, threshold=0.5)
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    before, started = _kept("VmRSS"), time.process_time()
    am.load_map(file, resolution=0.05, threshold=0.5)
    return {"seconds": time.process_time() - started, "peak": _kept("VmHWM") - before}


def _smallest(folder: Path) -> Path:
    return min(folder.glob("*.wld"), key=lambda path: path.stat().st_size)


def _kept(which: str) -> int:
    """Bytes of memory that the process holds now (VmRSS), or held at most (VmHWM)."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith(f"{which}:"):
            return 1024 * int(line.split()[1])
    raise OSError(f"this system does not say how much memory a process holds (/proc/self/status, {which})")


if __name__ == "__main__":
    main(sys.argv[1:])
