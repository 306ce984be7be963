"""Saving a run at any time: another process repeats the simulation with the same inputs, and writes it.

So nothing is written while nobody asks for it, and the simulation in the window goes on meanwhile.
"""

from __future__ import annotations

import _thread
import json
import os
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.runs.session import RunSession
from amorsim.ui.simulator.process.orphan import stay
from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.sources.inputs import Input, Inputs

__all__ = ["main", "save_again"]

LONGEST_END = 1.5  # [s] that it takes to end with whole files


def save_again(recipe: Recipe, inputs: Inputs, tick: int, folder: Path) -> str:
    """Simulate up to `tick` and write it into a folder, new or empty; returns the digest.

    Raises
    ------
    AmorsimError
        If the folder cannot be written, or the scenario no longer be read.
    """
    simulation, _ = recipe.simulation()
    with RunSession(simulation, folder) as recording:
        for _ in inputs.replay(simulation, tick):
            recording.keep()
        last = simulation.steps_of(simulation.scenario.duration)
        recording.close("finished" if tick >= last else "interrupted")
    return simulation.digest()


def main() -> None:
    """Read the order as a line of standard input, and answer with a line."""
    order: Mapping[str, Any] = json.loads(sys.stdin.readline())
    threading.Thread(target=_end_with_the_session, name="amorsim-end", daemon=True).start()
    stay()
    answers = sys.stdout
    sys.stdout = sys.stderr  # what a user's controller prints
    try:
        inputs = Inputs(Input.from_json(one) for one in order["inputs"])
        digest = save_again(Recipe.from_json(order["recipe"]), inputs, order["tick"], Path(order["folder"]))
        answer: dict[str, Any] = {"ok": True, "digest": digest}
    except AmorsimError as error:
        answer = {"ok": False, "error": str(error)}
    except KeyboardInterrupt as error:
        answer = {"ok": False, "error": "\n".join(["it was broken off", *getattr(error, "__notes__", ())])}
    answers.write(json.dumps(answer) + "\n")
    answers.flush()
    os._exit(0)


def _end_with_the_session() -> None:
    """Break off when nobody waits any more, at the end of standard input."""
    sys.stdin.read()
    _thread.interrupt_main()
    time.sleep(LONGEST_END)
    os._exit(1)
