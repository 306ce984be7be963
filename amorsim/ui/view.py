"""The Simulator's window for a scenario that was made in Python."""

from __future__ import annotations

import contextlib
import json
import os
import re
import subprocess
import sys
from typing import Any

import attrs

from amorsim.core.errors import AmorsimError, Fault, ScenarioError
from amorsim.core.files.temporary_folders import temporary_folder
from amorsim.core.user_code import UserCode
from amorsim.runs.session import run_name
from amorsim.scenario.files.write import with_maps, write_table
from amorsim.scenario.programs.controller_files import reference_to
from amorsim.scenario.spec import Robot, Scenario
from amorsim.ui.simulator.process.orphan import is_child
from amorsim.ui.simulator.process.pipes import python_for
from amorsim.ui.simulator.recipe import Recipe
from amorsim.ui.simulator.show import check_extra

__all__ = ["view"]


def view(
    scenario: Scenario | str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    host: str = "127.0.0.1",
    port: int = 0,
    browser: bool = True,
) -> None:
    """Open the Simulator in the browser: what is true next to what the robot knows. Returns after Ctrl-C.

    The window's simulation runs in another process, which gets the scenario as a file would give it. So components
    have to be registered or in a file that the script imports. A function or plain class of one's own is at the top of
    a file: of one that is imported, or of the script itself, where what the script does stands below
    ``if __name__ == "__main__":``.

    Parameters
    ----------
    scenario
        A scenario, or what ``amorsim view`` takes: a file, the name of a bundled scenario, or a map alone. Of a file
        with faults the window shows the faults, until the file is mended.
    out
        Folder that the run is written into as it goes, new or empty.
    host, port
        Where the window is served; only this machine can reach the default, and 0 takes a port that is free. Traffic to
        other machines is not encrypted.
    browser
        Whether to open the window in the browser. Its address is printed in any case. It works once, for anyone who has
        it; then another one is printed.

    Raises
    ------
    ScenarioError
        If something in the scenario cannot be given to another process.
    AmorsimError
        If it cannot be simulated, the extra ``ui`` is not installed, the address is taken, or the folder cannot be
        written.
    """
    check_extra()
    if not isinstance(scenario, (Scenario, str, os.PathLike)):
        raise AmorsimError(
            f"scenario: expected a Scenario, a file, or the name of a bundled scenario, as 'demo', got {scenario!r}"
        )
    if is_child():
        raise AmorsimError(
            "the window's simulation looks for a component in this file, and must not open a window of its "
            "own; put what the script does below: if __name__ == '__main__':"
        )
    with temporary_folder("view") as passing:
        file = ""
        if isinstance(scenario, Scenario):
            path = passing.resolve() / f"{run_name(scenario)}.toml"
            write_table(with_maps(_named(scenario), path.parent), path)
            file = str(path)
            recipe = Recipe(name=file, passing=str(path.parent))
        else:
            recipe = Recipe(name=os.fspath(scenario))
        order = {
            "recipe": recipe.to_json(),
            "out": "" if out is None else os.fspath(out),
            "host": host,
            "port": port,
            "browser": browser,
        }
        problem = _show(order)
    if problem:
        # Who made the scenario in Python knows nothing of the file.
        raise AmorsimError(re.sub(rf"{re.escape(str(file))}(:\d+)?: ", "", problem) if file else problem)


def _show(order: dict[str, Any]) -> str:
    """Let a process serve the window, and print its output here, until Ctrl-C; returns the fault, or nothing.

    A process of its own: the server's loop and signals are not for a script, and still less for a notebook.
    """
    problem = ""
    with subprocess.Popen(
        python_for("amorsim.ui.simulator.show"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        start_new_session=True,  # Ctrl-C in the terminal is for this process alone
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(json.dumps(order) + "\n")
            process.stdin.flush()
            for line in process.stdout:
                kind, text = json.loads(line)
                if kind == "error":
                    problem = text
                else:
                    stream = sys.stdout if kind == "say" else sys.stderr
                    stream.write(text + "\n")
                    stream.flush()
        except KeyboardInterrupt:
            with contextlib.suppress(OSError):
                process.stdin.close()  # which it takes as its end
            for line in process.stdout:
                sys.stdout.write(json.loads(line)[1] + "\n")
        finally:
            with contextlib.suppress(OSError):
                process.stdin.close()
    return problem


def _named(scenario: Scenario) -> Scenario:
    """The scenario with the files and names of the controllers, estimators and motions that were given as objects.

    Raises
    ------
    ScenarioError
        With a fault for each that stands at the top of no file.
    """
    faults: list[Fault] = []

    def named(path: str, own: Any) -> Any:
        if not isinstance(own, UserCode) or own.source:
            return own
        source = reference_to(own.function)
        if not source:
            name = getattr(own.function, "__qualname__", repr(own.function))
            message = (
                f"{name} stands at the top of no file, so the window's process cannot find it; define it with def or "
                f"class at the top of a .py file: this script, or one that it imports"
            )
            faults.append(Fault(file="", path=path, message=message))
        return attrs.evolve(own, source=source)

    def named_robot(robot: Robot) -> Robot:
        at = f"robots.{robot.name}"
        estimators = {name: named(f"{at}.estimators.{name}", own) for name, own in robot.estimators.items()}
        return attrs.evolve(robot, controller=named(f"{at}.controller", robot.controller), estimators=estimators)

    robots = list(map(named_robot, scenario.robots))
    obstacles = [
        attrs.evolve(obstacle, motion=named(f"obstacles.{obstacle.name}.motion", obstacle.motion))
        for obstacle in scenario.obstacles
    ]
    if faults:
        raise ScenarioError(faults)
    return attrs.evolve(scenario, robots=robots, obstacles=obstacles)
