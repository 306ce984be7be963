"""A run: a scenario simulated from beginning to end, and recorded."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from amorsim.core.arguments import checked
from amorsim.core.execution.interrupt import Interrupt
from amorsim.core.execution.progress import progress_shown
from amorsim.kernels.cache_folder import mark_warm
from amorsim.runs.folder import new_folder
from amorsim.runs.session import RunSession, RunSummary, steps_of
from amorsim.scenario.reading.read import load
from amorsim.scenario.spec import Scenario
from amorsim.simulation.simulation import Simulation

__all__ = ["RunSummary", "new_folder", "run"]


@checked
def run(
    scenario: Scenario | str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    *,
    seed: int | None = None,
    replicas: int | Sequence[int] = 1,
    duration: float | None = None,
    progress: bool | Callable[[float], None] | None = True,
    simulation: Simulation | None = None,
) -> RunSummary:
    """Simulate `scenario` and write its files into `folder`, which must not exist or be empty.

    Ctrl-C ends the run after the present
    step with its files whole, and the summary states that it is not complete. A second one raises `KeyboardInterrupt`;
    so does the first where a controller or plugin does not return.

    Parameters
    ----------
    scenario
        The scenario to simulate, or its file, or the name of a bundled one.
    folder
        New or empty; without it, ``amorsim-runs/<scenario>-<number>``.
    seed, replicas
        As for `Simulation`.
    duration
        In place of the scenario's [s].
    progress
        Whether a bar is shown after two seconds, in a terminal or a notebook; or a function that is called after every
        step with the share done, between 0 and 1.
    simulation
        The simulation to step, instead of a new one.

    Raises
    ------
    RunError
        If the folder cannot be made or holds something, or a file cannot be written.
    ScenarioError
        If the scenario cannot be simulated; nothing is written then.
    """
    if isinstance(scenario, str | os.PathLike):
        scenario = load(scenario)
    if simulation is None:
        simulation = Simulation(scenario, seed=seed, replicas=replicas)
    duration = simulation.scenario.duration if duration is None else duration
    steps = steps_of(simulation, duration)
    with (
        Interrupt() as interrupt,
        RunSession(simulation, folder, duration=duration) as session,
        progress_shown(progress, "simulating", float) as show,
    ):
        for done in range(1, steps + 1):
            interrupt.call(simulation.step)
            session.keep()
            if done == 1:
                mark_warm()
            if show is not None:
                show(done / steps)
            if interrupt.is_wanted:
                return session.close("finished" if done == steps else "interrupted")
    return session.summary
