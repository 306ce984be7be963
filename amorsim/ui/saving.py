"""Saving a run at any time: another process simulates it again with what was given to it, and writes it down.

So nothing is written while nobody asks for it, and the simulation in the window goes on meanwhile.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from amorsim.core.errors import AmorsimError
from amorsim.runs.session import RunSession
from amorsim.ui.inputs import Input, Inputs
from amorsim.ui.recipe import Recipe

__all__ = ["main", "save_again"]


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
    answers = sys.stdout
    sys.stdout = sys.stderr  # what a user's controller prints
    try:
        inputs = Inputs(Input(**one) for one in order["inputs"])
        digest = save_again(Recipe.from_json(order["recipe"]), inputs, order["tick"], Path(order["folder"]))
        answer: dict[str, Any] = {"ok": True, "digest": digest}
    except AmorsimError as error:
        answer = {"ok": False, "error": str(error)}
    answers.write(json.dumps(answer) + "\n")
    answers.flush()


if __name__ == "__main__":
    main()
